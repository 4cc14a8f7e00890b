//! Bézier pieces of a curve between its knots, in homogeneous coordinates.

use glam::{DVec3, DVec4};

use super::basis::{Row, with_capacity};
use super::bezier_patch::{bernstein, halve};
use super::control_net::bounds;
use super::curve::NurbsCurve;
use crate::error::Result;

/// A piece of a curve: a Bézier curve over an interval of the curve's parameter.
#[derive(Clone, Debug)]
pub(crate) struct BezierCurve {
    points: Vec<DVec4>,
    /// The interval of the curve's parameter.
    domain: (f64, f64),
}

impl BezierCurve {
    /// The pieces of a curve between its distinct knots.
    pub(crate) fn of(curve: &NurbsCurve) -> Result<Vec<Self>> {
        let form = curve.family().bezier_form(&mut || Ok(()))?;
        let (degree, breaks) = (curve.knots().degree(), form.knots.breaks());
        let piece = |(k, ends): (usize, &[f64])| Self {
            points: form.points[k * degree..=(k + 1) * degree].to_vec(),
            domain: (ends[0], ends[1]),
        };
        Ok(breaks.windows(2).enumerate().map(piece).collect())
    }

    /// A straight line over [0, 1].
    pub(crate) fn line(from: DVec3, to: DVec3) -> Self {
        Self { points: vec![from.extend(1.0), to.extend(1.0)], domain: (0.0, 1.0) }
    }

    /// The interval of the curve's parameter.
    pub(crate) fn domain(&self) -> (f64, f64) {
        self.domain
    }

    /// The control points. Their convex hull contains the piece.
    pub(crate) fn control_points(&self) -> impl ExactSizeIterator<Item = DVec3> + Clone + '_ {
        self.points.iter().map(|h| h.project())
    }

    /// The first point.
    pub(crate) fn start(&self) -> DVec3 {
        self.points[0].project()
    }

    /// The last point.
    pub(crate) fn end(&self) -> DVec3 {
        self.points[self.points.len() - 1].project()
    }

    /// Two opposite corners of the box around the control points.
    pub(crate) fn net_box(&self) -> (DVec3, DVec3) {
        bounds(self.control_points())
    }

    /// The parameter of the curve at a share of the piece.
    pub(crate) fn parameter(&self, share: f64) -> f64 {
        let (start, end) = self.domain;
        if share == 1.0 { end } else { start + share * (end - start) }
    }

    /// The point and the first two derivatives with respect to the share of the piece.
    pub(crate) fn derivatives(&self, share: f64) -> [DVec3; 3] {
        let degree = self.points.len() - 1;
        with_capacity!(degree, CAPACITY => self.derivatives_by(bernstein::<CAPACITY>(degree, share)))
    }

    /// The point and the first two derivatives, from the Bernstein polynomials.
    fn derivatives_by<const CAPACITY: usize>(&self, rows: [Row<CAPACITY>; 3]) -> [DVec3; 3] {
        let sum = |row: &[f64]| self.points.iter().zip(row).map(|(h, b)| *b * *h).sum::<DVec4>();
        let [value, first, second] = [sum(&rows[0]), sum(&rows[1]), sum(&rows[2])];
        let point = value.project();
        let velocity = (first.truncate() - first.w * point) / value.w;
        let bend = second.truncate() - second.w * point - 2.0 * first.w * velocity;
        [point, velocity, bend / value.w]
    }

    /// The part between two shares of the piece.
    pub(crate) fn part(&self, from: f64, to: f64) -> Self {
        let degree = self.points.len() - 1;
        let mut points = self.points.clone();
        for level in 1..=degree {
            for k in 0..=degree - level {
                points[k] = points[k].lerp(points[k + 1], from);
            }
        }
        let share = if from < 1.0 { (to - from) / (1.0 - from) } else { 1.0 };
        for level in 1..=degree {
            for k in (level..=degree).rev() {
                points[k] = points[k - 1].lerp(points[k], share);
            }
        }
        Self { points, domain: (self.parameter(from), self.parameter(to)) }
    }

    /// The halves of the piece.
    pub(crate) fn halves(&self) -> [Self; 2] {
        let (mut first, mut second) = (self.points.clone(), self.points.clone());
        halve(&mut first, &mut second, self.points.len() - 1, 1, [0]);
        let middle = self.parameter(0.5);
        [
            Self { points: first, domain: (self.domain.0, middle) },
            Self { points: second, domain: (middle, self.domain.1) },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_the_points_of_the_piece() {
        let circle = NurbsCurve::arc(DVec3::ONE, DVec3::X, DVec3::Y, 1.5).unwrap();
        let piece = &BezierCurve::of(&circle).unwrap()[0];
        let part = piece.part(0.25, 0.75);
        for share in [0.0, 0.3, 1.0] {
            let expected = piece.derivatives(0.25 + 0.5 * share)[0];
            assert!(part.derivatives(share)[0].distance(expected) < 1e-15);
        }
    }

    #[test]
    fn pieces_and_their_halves_agree_with_the_curve() {
        let circle = NurbsCurve::arc(DVec3::ONE, DVec3::X, DVec3::Y, 5.0).unwrap();
        let pieces = BezierCurve::of(&circle).unwrap();
        assert_eq!(pieces.len(), circle.knots().spans());
        for piece in
            pieces.iter().flat_map(|piece| [vec![piece.clone()], piece.halves().into()].concat())
        {
            for share in [0.0, 0.3, 0.75] {
                let [point, velocity, bend] = piece.derivatives(share);
                let (from, to) = piece.domain();
                let mut expected = [DVec3::ZERO; 3];
                let at = [piece.parameter(share)];
                let (outside, observer) =
                    (super::super::Outside::Refuse, &mut crate::progress::Silent);
                circle.derivatives(&at, 2, &mut expected, outside, observer).unwrap();
                assert!(point.distance(expected[0]) < 1e-14);
                assert!(velocity.distance((to - from) * expected[1]) < 1e-13);
                assert!(bend.distance((to - from).powi(2) * expected[2]) < 1e-12);
            }
        }
    }
}
