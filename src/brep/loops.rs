//! Loops: closed chains of curves in (u, v) around a face or a hole of it.

use crate::error::Result;
use crate::nurbs::NurbsCurve;

/// A closed chain of curves in (u, v), with z = 0. The face lies to the left: an outer loop is
/// counter-clockwise, an inner one clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    curves: Vec<NurbsCurve>,
}

impl Loop {
    /// A chain that has been checked.
    pub(super) fn new(curves: Vec<NurbsCurve>) -> Self {
        Self { curves }
    }

    /// The curves. Each begins where the one before ends; the first, where the last ends.
    #[must_use]
    pub fn curves(&self) -> &[NurbsCurve] {
        &self.curves
    }
}

/// The curves of a loop, with straight lines where consecutive curves leave a gap.
pub(super) fn bridged(of_loop: &Loop) -> Result<Vec<NurbsCurve>> {
    let curves = of_loop.curves();
    let mut all = vec![];
    for (k, curve) in curves.iter().enumerate() {
        all.push(curve.clone());
        let (points, next) =
            (curve.control_points(), curves[(k + 1) % curves.len()].control_points());
        let (end, start) = (points[points.len() - 1], next[0]);
        if end != start {
            all.push(NurbsCurve::line(end, start)?);
        }
    }
    Ok(all)
}

/// A curve of a loop in a shell, with the edge that it follows.
///
/// It is a whole curve of the face's loop, or a part of one that is divided where other faces meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Coedge {
    /// The curve in (u, v), in the direction of the loop.
    pub curve: NurbsCurve,
    /// The index of the edge; `None` where the curve is one point in space (a pole).
    pub edge: Option<usize>,
    /// Whether the curve runs in the direction of the edge's curve.
    pub forward: bool,
    /// The index of the vertex at its start.
    pub vertex: usize,
}
