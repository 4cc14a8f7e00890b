//! Closed polygons: loops of curves by samples.

use glam::DVec2;

use crate::nurbs::NurbsCurve;

/// Twice the area inside a closed loop, from samples; positive if it is counter-clockwise.
pub(super) fn signed_area(curves: &[NurbsCurve]) -> f64 {
    polygon_area(&sampled(curves))
}

/// Twice the signed area of a polygon.
fn polygon_area(polygon: &[DVec2]) -> f64 {
    let origin = polygon[0];
    let count = polygon.len();
    (0..count).map(|k| (polygon[k] - origin).perp_dot(polygon[(k + 1) % count] - origin)).sum()
}

/// Points along a closed loop: some for each control point.
pub(super) fn sampled(curves: &[NurbsCurve]) -> Vec<DVec2> {
    let points = |curve: &NurbsCurve| {
        let (from, to) = curve.knots().domain();
        let count = if curve.knots().degree() == 1 { 1 } else { 4 * curve.control_points().len() };
        let step = (to - from) / count as f64;
        (0..count).map(|k| curve.point(from + step * k as f64).truncate()).collect::<Vec<_>>()
    };
    curves.iter().flat_map(points).collect()
}

/// Whether a point is inside a polygon, by even and odd crossings.
pub(super) fn is_inside(polygon: &[DVec2], at: DVec2) -> bool {
    let mut inside = false;
    for k in 0..polygon.len() {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        if (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// Whether sides of two polygons cross.
pub(super) fn polygons_cross(a: &[DVec2], b: &[DVec2]) -> bool {
    let low = b.iter().copied().reduce(DVec2::min).unwrap_or_default();
    let high = b.iter().copied().reduce(DVec2::max).unwrap_or_default();
    let near = |(p, q): &(DVec2, DVec2)| p.min(*q).cmple(high).all() && p.max(*q).cmpge(low).all();
    sides(a).filter(near).any(|(p, q)| {
        sides(b).any(|(r, s)| {
            let side = |at: DVec2| (q - p).perp_dot(at - p) > 0.0;
            let other = |at: DVec2| (s - r).perp_dot(at - r) > 0.0;
            side(r) != side(s) && other(p) != other(q)
        })
    })
}

/// The sides of a closed polygon.
fn sides(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]))
}
