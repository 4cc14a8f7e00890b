//! The curve in space of a curve in (u, v).

use glam::DVec3;

use super::affine::{AffineMap, rounding};
use super::piecewise_cubic::{INSET, Node, Traced, piecewise_cubic};
use crate::error::Result;
use crate::nurbs::{Direction, NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// The curve on the surface over a curve in (u, v), with the same parameter.
///
/// Over a straight line of constant u or v, and on a parallelogram, it is exact. Else it is a piecewise cubic with the right
/// tangents, halved until its distance from the surface's curve is at most `tolerance`.
pub(super) fn edge_curve(
    surface: &NurbsSurface,
    curve: &NurbsCurve,
    tolerance: f64,
) -> Result<NurbsCurve> {
    if let Some(exact) = isocurve(surface, curve)? {
        return Ok(exact);
    }
    if let Some(map) = AffineMap::of(surface) {
        return map.in_space(curve);
    }
    let breaks = curve.knots().breaks();
    piecewise_cubic(&OnSurface { surface, curve }, &breaks, tolerance.max(rounding(surface)))
}

/// The exact curve over a straight line of constant u or v; `None` over other curves.
fn isocurve(surface: &NurbsSurface, curve: &NurbsCurve) -> Result<Option<NurbsCurve>> {
    let &[from, to] = curve.control_points() else { return Ok(None) };
    if curve.weights().is_some() {
        return Ok(None);
    }
    let (direction, at, ends) = if from.x == to.x && from.y != to.y {
        (Direction::U, from.x, (from.y, to.y))
    } else if from.y == to.y && from.x != to.x {
        (Direction::V, from.y, (from.x, to.x))
    } else {
        return Ok(None);
    };
    let inside = |value: f64, direction| {
        let (start, end) = surface.knots(direction).domain();
        value.clamp(start, end)
    };
    let whole = surface.isocurve(direction, inside(at, direction))?;
    let (start, end) = whole.knots().domain();
    let (low, high) = (ends.0.min(ends.1).max(start), ends.0.max(ends.1).min(end));
    if low >= high {
        return Ok(None);
    }
    let mut part = whole;
    if (low, high) != (start, end) {
        part = part.sub_curve(low, high, &mut Silent)?;
    }
    if ends.0 > ends.1 {
        part = part.reversed(&mut Silent)?;
    }
    let (start, end) = curve.knots().domain();
    Ok(Some(if part.knots().domain() == (start, end) {
        part
    } else {
        part.with_domain(start, end)?
    }))
}

/// The curve on a surface over a curve in (u, v).
struct OnSurface<'a> {
    surface: &'a NurbsSurface,
    curve: &'a NurbsCurve,
}

impl Traced for OnSurface<'_> {
    fn node(&self, at: f64, toward: f64) -> Node {
        let inside = at + INSET * (toward - at);
        let along = self.curve.velocity(inside);
        let uv = self.curve.point(inside);
        let [point, by_u, by_v] = self.surface.tangents(uv.x, uv.y);
        let velocity = along.x * by_u + along.y * by_v;
        if inside == at {
            return Node { at, point, velocity };
        }
        let uv = self.curve.point(at);
        Node { at, point: self.surface.point(uv.x, uv.y), velocity }
    }

    fn distance(&self, at: f64, point: DVec3) -> f64 {
        let uv = self.curve.point(at);
        self.surface.point(uv.x, uv.y).distance(point)
    }
}
