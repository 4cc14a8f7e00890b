//! Tangents, curvature and bounding box of a curve.

use glam::DVec3;

use super::bezier_curve::BezierCurve;
use super::control_net::bounds;
use super::curve::NurbsCurve;
use super::parameter_checks::{Outside, check_length};
use crate::error::Result;
use crate::progress::Observer;

/// A derivative is zero up to rounding if it is shorter than this fraction of the curve's size,
/// divided by the length of the domain.
const ZERO_DERIVATIVE: f64 = 1e-13;

/// Distance of the bounding box from the curve at most, as a fraction of the curve's size.
const BOX_TOLERANCE: f64 = 1e-10;

/// Halvings of a piece between knots at most.
const MAX_HALVINGS: usize = 50;

impl NurbsCurve {
    /// Computes the unit tangent at each parameter, in the direction of the derivative.
    ///
    /// Where the derivative vanishes (a cusp, coincident control points), it is the limit from
    /// larger parameters, at the end that from smaller ones; zero if there is none.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, Outside}, progress::Silent};
    /// let circle = NurbsCurve::arc(DVec3::ZERO, DVec3::X, DVec3::Y, std::f64::consts::TAU)?;
    /// let mut tangents = [DVec3::ZERO; 2];
    /// circle.tangents(&[0.0, 0.25], &mut tangents, Outside::Refuse, &mut Silent)?;
    /// assert!(tangents[0].distance(DVec3::Y) < 1e-15 && tangents[1].distance(-DVec3::X) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`NurbsCurve::derivatives`].
    pub fn tangents(
        &self,
        u: &[f64],
        out: &mut [DVec3],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_length(out.len(), u.len())?;
        let derivatives = self.two_derivatives(u, outside, observer)?;
        let (start, end) = self.knots().domain();
        let zero = self.zero_derivative();
        for ((&u, table), out) in u.iter().zip(derivatives.chunks_exact(3)).zip(out) {
            // Before a cusp the derivative is opposite to the second one, behind it parallel.
            let side = if u >= end && end > start { -1.0 } else { 1.0 };
            *out = if table[1].length() > zero {
                table[1].normalize()
            } else if table[2].length() * (end - start) > zero {
                side * table[2].normalize()
            } else {
                DVec3::ZERO
            };
        }
        Ok(())
    }

    /// For each parameter the point and the first two derivatives.
    fn two_derivatives(
        &self,
        u: &[f64],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<Vec<DVec3>> {
        let mut derivatives = vec![DVec3::ZERO; 3 * u.len()];
        self.derivatives(u, 2, &mut derivatives, outside, observer)?;
        Ok(derivatives)
    }

    /// Computes the curvature at each parameter, in 1 / unit: the inverse of the radius of the
    /// circle that fits best there.
    ///
    /// It is NaN where the derivative vanishes.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, Outside}, progress::Silent};
    /// let circle = NurbsCurve::arc(DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y, 3.0)?;
    /// let mut curvatures = [0.0];
    /// circle.curvatures(&[0.3], &mut curvatures, Outside::Refuse, &mut Silent)?;
    /// assert!((curvatures[0] - 0.5).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`NurbsCurve::derivatives`].
    pub fn curvatures(
        &self,
        u: &[f64],
        out: &mut [f64],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_length(out.len(), u.len())?;
        let derivatives = self.two_derivatives(u, outside, observer)?;
        let zero = self.zero_derivative();
        for (table, out) in derivatives.chunks_exact(3).zip(out) {
            let speed = table[1].length();
            *out = if speed > zero {
                table[1].cross(table[2]).length() / speed.powi(3)
            } else {
                f64::NAN
            };
        }
        Ok(())
    }

    /// Returns the smallest and largest coordinates of the control points; this box contains the
    /// curve.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert_eq!(arch.net_box(), (DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn net_box(&self) -> (DVec3, DVec3) {
        bounds(self.control_points().iter().copied())
    }

    /// Returns the smallest and largest coordinates of the curve itself, up to 1e-10 of its size.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// let (low, high) = arch.bounding_box()?;
    /// assert!(low == DVec3::ZERO && high.distance(DVec3::new(2.0, 0.5, 0.5)) < 1e-9);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`](crate::Error::Net) if weights differ so much that a piece has no finite
    /// control points.
    pub fn bounding_box(&self) -> Result<(DVec3, DVec3)> {
        let (low, high) = self.net_box();
        let tolerance = BOX_TOLERANCE * low.distance(high);
        let pieces = BezierCurve::of(self)?;
        let farthest = |direction| farthest(&pieces, direction, tolerance);
        let low =
            DVec3::new(-farthest(DVec3::NEG_X), -farthest(DVec3::NEG_Y), -farthest(DVec3::NEG_Z));
        Ok((low, DVec3::new(farthest(DVec3::X), farthest(DVec3::Y), farthest(DVec3::Z))))
    }

    /// Length below which a derivative counts as zero.
    fn zero_derivative(&self) -> f64 {
        let ((low, high), (start, end)) = (self.net_box(), self.knots().domain());
        ZERO_DERIVATIVE * low.distance(high) / (end - start)
    }
}

/// The largest coordinate in a direction: halves pieces whose control points lie beyond the
/// farthest known point.
fn farthest(pieces: &[BezierCurve], direction: DVec3, tolerance: f64) -> f64 {
    let ends = pieces.iter().flat_map(|piece| [piece.start(), piece.end()]);
    let mut reached = ends.map(|end| end.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
    let mut waiting: Vec<(BezierCurve, usize)> =
        pieces.iter().map(|piece| (piece.clone(), MAX_HALVINGS)).collect();
    while let Some((piece, halvings)) = waiting.pop() {
        let places = piece.control_points().map(|point| point.dot(direction));
        if halvings > 0 && places.fold(f64::NEG_INFINITY, f64::max) > reached + tolerance {
            for half in piece.halves() {
                reached = reached.max(half.start().dot(direction)).max(half.end().dot(direction));
                waiting.push((half, halvings - 1));
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn a_cusp_has_the_tangent_behind_it() {
        // (t³, t²) for t from -1 to 1 has a cusp at 0.
        let points = [(-1.0, 1.0), (1.0, -1.0 / 3.0), (-1.0, -1.0 / 3.0), (1.0, 1.0)];
        let points = points.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        let cusp = NurbsCurve::clamped(points, 3).unwrap();
        let (mut tangents, mut curvatures) = ([DVec3::ZERO; 2], [0.0; 2]);
        let u = [0.5, 0.25];
        cusp.tangents(&u, &mut tangents, Outside::Refuse, &mut Silent).unwrap();
        cusp.curvatures(&u, &mut curvatures, Outside::Refuse, &mut Silent).unwrap();
        assert!(tangents[0].distance(DVec3::Y) < 1e-12, "{tangents:?}");
        assert!((tangents[1].length() - 1.0).abs() < 1e-15);
        assert!(curvatures[0].is_nan() && curvatures[1] > 0.0, "{curvatures:?}");
    }

    #[test]
    fn boxes_of_circles_are_exact() {
        let circle = NurbsCurve::arc(DVec3::ONE, DVec3::X, DVec3::Y, 5.0).unwrap();
        let (low, high) = circle.bounding_box().unwrap();
        assert!(low.distance(DVec3::new(0.0, 0.0, 1.0)) < 1e-9, "{low}");
        assert!(high.distance(DVec3::new(2.0, 2.0, 1.0)) < 1e-9, "{high}");
    }
}
