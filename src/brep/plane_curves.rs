//! Bézier pieces of curves in (u, v): boxes, crossings with lines, winding numbers.

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::nurbs::{BezierCurve, NurbsCurve};

/// Size of a piece, as a share of its curve's coordinates, below which a point in its box is on the
/// curve. Halving further only meets rounding.
const ON_CURVE: f64 = 1e-13;

/// Number of halvings until a root of a piece is known to the last bits.
const ROOT_HALVINGS: u32 = 52;

/// A Bézier piece of a curve in (u, v), with the box around its control points.
#[derive(Clone, Debug)]
pub(crate) struct PlanePiece {
    pub curve: BezierCurve,
    pub low: DVec2,
    pub high: DVec2,
}

impl PlanePiece {
    fn new(curve: BezierCurve) -> Self {
        let (low, high) = curve.net_box();
        Self { curve, low: low.truncate(), high: high.truncate() }
    }

    /// The pieces of curves, in order.
    pub(crate) fn of<'a>(curves: impl IntoIterator<Item = &'a NurbsCurve>) -> Result<Vec<Self>> {
        let pieces: Result<Vec<Vec<BezierCurve>>> =
            curves.into_iter().map(BezierCurve::of).collect();
        Ok(pieces?.into_iter().flatten().map(Self::new).collect())
    }

    pub(crate) fn start(&self) -> DVec2 {
        self.curve.start().truncate()
    }

    pub(crate) fn end(&self) -> DVec2 {
        self.curve.end().truncate()
    }

    /// The control points.
    pub(crate) fn control_points(&self) -> impl ExactSizeIterator<Item = DVec2> + Clone + '_ {
        self.curve.control_points().map(DVec3::truncate)
    }

    pub(crate) fn halves(&self) -> [Self; 2] {
        self.curve.halves().map(Self::new)
    }

    /// The length of the box's diagonal.
    pub(crate) fn size(&self) -> f64 {
        self.low.distance(self.high)
    }

    /// Whether a rectangle lies outside the box, or on one side of a strip along the chord that
    /// contains the control points; `margin` widens both.
    pub(crate) fn misses(&self, low: DVec2, high: DVec2, margin: f64) -> bool {
        if (self.low - margin).cmpgt(high).any() || low.cmpgt(self.high + margin).any() {
            return true;
        }
        let start = self.start();
        let across = (self.end() - start).perp();
        let heights = self.control_points().map(|point| (point - start).dot(across));
        let (lowest, highest) = heights.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
        let height = (low.midpoint(high) - start).dot(across);
        let reach = across.abs().dot((high - low) / 2.0) + margin * across.length();
        height + reach < lowest || height - reach > highest
    }

    /// Whether the piece passes through a rectangle or touches it.
    pub(crate) fn meets(&self, low: DVec2, high: DVec2) -> bool {
        if self.misses(low, high, 0.0) {
            return false;
        }
        let inside = |point: DVec2| low.cmple(point).all() && point.cmple(high).all();
        inside(self.start())
            || inside(self.end())
            || self.size() <= ON_CURVE * self.high.abs().max(self.low.abs()).max_element()
            || self.halves().iter().any(|half| half.meets(low, high))
    }
}

/// How many times closed curves wind around a point, counter-clockwise; `None` if the point is on
/// a curve.
///
/// A piece whose hull does not contain the point winds around it as its chord does. Other pieces
/// are halved.
pub(crate) fn winding_number(pieces: &[PlanePiece], point: DVec2) -> Option<i32> {
    pieces.iter().try_fold(0, |sum, piece| Some(sum + crossings(piece, point)?))
}

/// The signed crossings of a piece with the ray from a point along +u; `None` if the point is on
/// the piece.
pub(crate) fn crossings(piece: &PlanePiece, point: DVec2) -> Option<i32> {
    let (a, b) = (piece.start(), piece.end());
    let rounding = ON_CURVE * point.abs().max(piece.high.abs()).max_element();
    if piece.misses(point, point, rounding) {
        return Some(chord_crossings([a, b], point));
    }
    if piece.size() <= rounding || point == a {
        return None;
    }
    let [first, second] = piece.halves();
    Some(crossings(&first, point)? + crossings(&second, point)?)
}

/// The signed crossings of a chord with the ray from a point along +u.
pub(crate) fn chord_crossings([a, b]: [DVec2; 2], point: DVec2) -> i32 {
    let side = (b - a).perp_dot(point - a);
    match (a.y <= point.y, b.y <= point.y) {
        (true, false) if side > 0.0 => 1,
        (false, true) if side < 0.0 => -1,
        _ => 0,
    }
}

/// The area enclosed by closed curves, by Green's theorem; positive if they run counter-clockwise.
/// Exact up to rounding for their sign; curves are sampled.
pub(crate) fn signed_area(pieces: &[PlanePiece]) -> f64 {
    const SAMPLES: u32 = 16;
    let origin = pieces[0].start();
    let area = |piece: &PlanePiece| {
        let point = |k: u32| {
            let share = f64::from(k) / f64::from(SAMPLES);
            piece.curve.derivatives(share)[0].truncate() - origin
        };
        (0..SAMPLES).map(|k| point(k).perp_dot(point(k + 1)) / 2.0).sum::<f64>()
    };
    pieces.iter().map(area).sum()
}

/// The parameters, in order, at which a curve in (u, v) crosses the line `axis · (u, v) = value`.
pub(crate) fn crossings_with_line(curve: &NurbsCurve, axis: DVec2, value: f64) -> Result<Vec<f64>> {
    let mut found = vec![];
    for piece in BezierCurve::of(curve)? {
        let ends = [piece.start(), piece.end()].map(|point| point.truncate().dot(axis) - value);
        roots(&piece, axis, value, ROOT_HALVINGS, &mut found);
        // Ends are crossings only together with the neighboring piece.
        if ends[1] == 0.0 {
            found.push(piece.domain().1);
        }
    }
    let (start, end) = curve.knots().domain();
    let near = 1e-12 * (end - start);
    found.retain(|&at| at - start > near && end - at > near);
    found.dedup_by(|a, b| (*a - *b).abs() <= near);
    Ok(found)
}

/// Appends the roots inside a piece.
fn roots(piece: &BezierCurve, axis: DVec2, value: f64, halvings: u32, found: &mut Vec<f64>) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for point in piece.control_points() {
        let height = point.truncate().dot(axis) - value;
        (low, high) = (low.min(height), high.max(height));
    }
    if low >= 0.0 || high <= 0.0 {
        return;
    }
    if halvings == 0 {
        found.push(piece.parameter(0.5));
        return;
    }
    let halves = piece.halves();
    roots(&halves[0], axis, value, halvings - 1, found);
    if halves[0].end().truncate().dot(axis) == value {
        found.push(halves[0].domain().1);
    }
    roots(&halves[1], axis, value, halvings - 1, found);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    fn circle() -> NurbsCurve {
        NurbsCurve::arc(DVec3::new(2.0, 1.0, 0.0), DVec3::X, DVec3::Y, TAU).unwrap()
    }

    #[test]
    fn circles_wind_once_around_the_points_inside() {
        let pieces = PlanePiece::of([&circle()]).unwrap();
        assert!((signed_area(&pieces) / PI - 1.0).abs() < 1e-2);
        for k in 0..5000 {
            let k = f64::from(k);
            let point = DVec2::new(2.0, 1.0) + 1e-3 * (0.3 * k) * DVec2::from_angle(k);
            let inside = point.distance(DVec2::new(2.0, 1.0)) < 1.0;
            assert_eq!(winding_number(&pieces, point), Some(i32::from(inside)), "{point}");
        }
        assert_eq!(winding_number(&pieces, DVec2::new(3.0, 1.0)), None);
    }

    #[test]
    fn lines_are_crossed_at_the_roots() {
        let found = crossings_with_line(&circle(), DVec2::X, 2.5).unwrap();
        assert_eq!(found.len(), 2);
        for at in &found {
            assert!((circle().point(*at).x - 2.5).abs() < 1e-14);
        }
        // The line through the knots at a quarter and three quarters.
        assert_eq!(crossings_with_line(&circle(), DVec2::X, 2.0).unwrap(), [0.25, 0.75]);
    }
}
