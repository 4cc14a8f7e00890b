//! The curve in space of a curve in (u, v).

use glam::DVec3;

use crate::error::Result;
use crate::nurbs::{Direction, KnotVector, NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// Halvings of a span of the curve at most, if the surface has a kink below it.
const MAX_HALVINGS: u32 = 20;

/// Share of a span between its end and the place where its velocity is taken: at a knot the
/// derivative is that of the next span.
const INSET: f64 = 1e-9;

/// Shares of a span where the error of its cubic is measured.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// The curve on the surface over a curve in (u, v), with the same parameter.
///
/// Over a straight line of constant u or v it is exact. Else it is a piecewise cubic with the right
/// tangents, halved until its distance from the surface's curve is at most `tolerance`.
pub(super) fn edge_curve(
    surface: &NurbsSurface,
    curve: &NurbsCurve,
    tolerance: f64,
) -> Result<NurbsCurve> {
    match isocurve(surface, curve)? {
        Some(exact) => Ok(exact),
        None => hermite(surface, curve, tolerance),
    }
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

/// A point of the curve on the surface, with its derivative.
#[derive(Clone, Copy)]
struct Node {
    at: f64,
    point: DVec3,
    velocity: DVec3,
}

/// The node at a parameter of the curve.
fn node(surface: &NurbsSurface, curve: &NurbsCurve, at: f64) -> Node {
    let (uv, along) = (curve.point(at), curve.velocity(at));
    let [point, by_u, by_v] = surface.tangents(uv.x, uv.y);
    Node { at, point, velocity: along.x * by_u + along.y * by_v }
}

/// The piecewise cubic over a curve in (u, v).
fn hermite(surface: &NurbsSurface, curve: &NurbsCurve, tolerance: f64) -> Result<NurbsCurve> {
    let breaks = curve.knots().breaks();
    let mut spans: Vec<[Node; 2]> = vec![];
    for ends in breaks.windows(2) {
        // Just inside the span: the curve's velocity may jump at a knot.
        let inset = |at: f64, toward: f64| Node {
            velocity: node(surface, curve, at + INSET * (toward - at)).velocity,
            ..node(surface, curve, at)
        };
        let (start, end) = (inset(ends[0], ends[1]), inset(ends[1], ends[0]));
        divide(surface, curve, [start, end], (tolerance, MAX_HALVINGS), &mut spans);
    }
    let mut points = vec![spans[0][0].point];
    let mut inner = vec![];
    for (k, [start, end]) in spans.iter().enumerate() {
        let third = (end.at - start.at) / 3.0;
        points.push(start.point + third * start.velocity);
        points.push(end.point - third * end.velocity);
        points.push(end.point);
        if k + 1 < spans.len() {
            inner.extend([end.at; 3]);
        }
    }
    let ends = (breaks[0], breaks[breaks.len() - 1]);
    NurbsCurve::new(points, None, KnotVector::clamped(3, ends, inner)?)
}

/// Appends the cubics of a span, halved until they meet the tolerance.
fn divide(
    surface: &NurbsSurface,
    curve: &NurbsCurve,
    [start, end]: [Node; 2],
    (tolerance, halvings): (f64, u32),
    spans: &mut Vec<[Node; 2]>,
) {
    let length = end.at - start.at;
    let mut error = 0.0_f64;
    for share in SHARES {
        let exact = node(surface, curve, start.at + share * length).point;
        error = error.max(exact.distance(cubic([start, end], share)));
    }
    if error <= tolerance || halvings == 0 {
        spans.push([start, end]);
        return;
    }
    let middle = node(surface, curve, start.at + 0.5 * length);
    divide(surface, curve, [start, middle], (tolerance, halvings - 1), spans);
    divide(surface, curve, [middle, end], (tolerance, halvings - 1), spans);
}

/// The point of a span's cubic at a share of it.
fn cubic([start, end]: [Node; 2], share: f64) -> DVec3 {
    let third = (end.at - start.at) / 3.0;
    let (a, b) = (start.point, end.point);
    let (c, d) = (a + third * start.velocity, b - third * end.velocity);
    let (s, t) = (1.0 - share, share);
    s.powi(3) * a + 3.0 * s * s * t * c + 3.0 * s * t * t * d + t.powi(3) * b
}
