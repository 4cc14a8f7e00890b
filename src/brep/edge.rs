//! Edges: curves in space that bound faces.

use crate::nurbs::NurbsCurve;

/// A curve in space where faces end or meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The curve. It has the parameter of the first use's curve in (u, v), if that use is forward;
    /// else the reversed one on the same domain.
    pub curve: NurbsCurve,
    /// The indices of the vertices at its start and end; equal for a closed edge.
    pub vertices: [usize; 2],
    /// The places in the loops that use the edge: one (a border) or two.
    pub uses: Vec<EdgeUse>,
}

impl Edge {
    /// Whether only one loop uses the edge.
    #[must_use]
    pub fn is_border(&self) -> bool {
        self.uses.len() == 1
    }
}

/// A place in a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeUse {
    /// The index of the face in the shell.
    pub face: usize,
    /// The index of the loop in the face; 0 is the outer one.
    pub in_loop: usize,
    /// The index in the loop.
    pub place: usize,
}
