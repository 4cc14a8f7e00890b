//! Piecewise cubics along smooth curves, within a tolerance.

use glam::DVec3;

use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsCurve};

/// Halvings of a span at most, where the curve has a kink.
const MAX_HALVINGS: u32 = 20;

/// Share of a span between its end and the place where its velocity is taken: at a knot the
/// derivative is that of the next span.
pub(super) const INSET: f64 = 1e-9;

/// Relative jump of the velocity that makes a break a kink. Without one, velocities on both sides
/// differ by little more than the inset.
const JUMP: f64 = 1e-7;

/// Shares of a span where the error of its cubic is measured.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// A point of a curve, with its derivative.
#[derive(Clone, Copy)]
pub(super) struct Node {
    pub at: f64,
    pub point: DVec3,
    pub velocity: DVec3,
}

/// A curve that a cubic can follow.
pub(super) trait Traced {
    /// The node at a parameter, with the velocity of the span toward another parameter.
    fn node(&self, at: f64, toward: f64) -> Node;

    /// The distance in space that a point of the cubic may not exceed.
    fn distance(&self, at: f64, point: DVec3) -> f64;
}

/// The piecewise cubic along a curve that is smooth between breaks.
///
/// It has the curve's points and velocities at its knots. Spans are halved until the distance at
/// three places in each is at most `tolerance`.
pub(super) fn piecewise_cubic(
    curve: &impl Traced,
    breaks: &[f64],
    tolerance: f64,
) -> Result<NurbsCurve> {
    let mut spans: Vec<[Node; 2]> = vec![];
    for ends in breaks.windows(2) {
        let nodes = [curve.node(ends[0], ends[1]), curve.node(ends[1], ends[0])];
        divide(curve, nodes, (tolerance, MAX_HALVINGS), &mut spans);
    }
    let mut points = vec![spans[0][0].point];
    let mut inner = vec![];
    for (k, [start, end]) in spans.iter().enumerate() {
        let third = (end.at - start.at) / 3.0;
        points.push(start.point + third * start.velocity);
        points.push(end.point - third * end.velocity);
        let Some([next, _]) = spans.get(k + 1) else {
            points.push(end.point);
            break;
        };
        let jump = end.velocity.distance(next.velocity);
        if jump > JUMP * end.velocity.length().max(next.velocity.length()) {
            points.push(end.point);
            inner.push(end.at);
        }
        // With a double knot the velocity is continuous.
        inner.extend([end.at; 2]);
    }
    let ends = (breaks[0], breaks[breaks.len() - 1]);
    NurbsCurve::new(points, None, KnotVector::clamped(3, ends, inner)?)
}

/// Appends the cubics of a span, halved until they meet the tolerance.
fn divide(
    curve: &impl Traced,
    [start, end]: [Node; 2],
    (tolerance, halvings): (f64, u32),
    spans: &mut Vec<[Node; 2]>,
) {
    let length = end.at - start.at;
    let near = |share: f64| {
        let error = curve.distance(start.at + share * length, cubic([start, end], share));
        error <= tolerance
    };
    if halvings == 0 || SHARES.into_iter().all(near) {
        spans.push([start, end]);
        return;
    }
    let at = start.at + 0.5 * length;
    let middle = curve.node(at, at);
    divide(curve, [start, middle], (tolerance, halvings - 1), spans);
    divide(curve, [middle, end], (tolerance, halvings - 1), spans);
}

/// The point of a span's cubic at a share of it.
fn cubic([start, end]: [Node; 2], share: f64) -> DVec3 {
    let third = (end.at - start.at) / 3.0;
    let (a, b) = (start.point, end.point);
    let (c, d) = (a + third * start.velocity, b - third * end.velocity);
    let (s, t) = (1.0 - share, share);
    s.powi(3) * a + 3.0 * s * s * t * c + 3.0 * s * t * t * d + t.powi(3) * b
}
