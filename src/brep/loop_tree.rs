//! A tree over the curves of a face's loops: which places of (u, v) are on the face.
//!
//! Each node is a chain of consecutive pieces, or a group of whole loops. Like a single piece, it
//! winds around a point outside its box as its chord does.

use glam::DVec2;

use super::loops::{Loop, bridged};
use super::plane_curves::{PlanePiece, chord_crossings, crossings};
use crate::error::Result;
use crate::nurbs::{Cover, ParameterRegion};

/// Halvings of a piece at most until its control points are close to the chord.
const MAX_HALVINGS: u32 = 6;

/// Distance of the control points from the chord at most, as a share of its length. Places as close
/// as this to the border take longer.
const FLATNESS: f64 = 0.02;

/// The region inside the outer loop and outside the inner ones.
#[derive(Debug)]
pub(super) struct LoopTree {
    root: Node,
}

/// A chain of pieces or a group of loops.
#[derive(Debug)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// The ends of a chain; equal for closed loops.
    ends: [DVec2; 2],
    content: Content,
}

#[derive(Debug)]
enum Content {
    Pair(Box<[Node; 2]>),
    Piece(Box<PlanePiece>),
}

impl LoopTree {
    /// Prepares the loops of a face. Gaps between consecutive curves are closed by straight lines.
    pub(super) fn new(loops: &[Loop]) -> Result<Self> {
        let mut chains = vec![];
        for of_loop in loops {
            let mut pieces = vec![];
            for piece in PlanePiece::of(&bridged(of_loop)?)? {
                flatten(piece, MAX_HALVINGS, &mut pieces);
            }
            chains.push(joined(pieces.into_iter().map(Node::of_piece).collect()));
        }
        Ok(Self { root: grouped(chains) })
    }

    /// How many times the loops wind around a point; `None` if the point is on a loop.
    pub(super) fn winding_number(&self, point: DVec2) -> Option<i32> {
        self.root.crossings(point)
    }

    /// Whether a loop passes through a rectangle or touches it.
    pub(super) fn meets(&self, low: DVec2, high: DVec2) -> bool {
        self.root.meets(low, high)
    }
}

impl ParameterRegion for LoopTree {
    fn cover(&self, low: DVec2, high: DVec2) -> Cover {
        if self.meets(low, high) {
            Cover::Cut
        } else if self.contains(low.midpoint(high)) {
            Cover::Inside
        } else {
            Cover::Outside
        }
    }

    fn contains(&self, uv: DVec2) -> bool {
        self.winding_number(uv) != Some(0)
    }
}

impl Node {
    fn of_piece(piece: PlanePiece) -> Self {
        let (low, high, ends) = (piece.low, piece.high, [piece.start(), piece.end()]);
        Self { low, high, ends, content: Content::Piece(Box::new(piece)) }
    }

    fn around(nodes: [Self; 2]) -> Self {
        let [a, b] = &nodes;
        let (low, high, ends) = (a.low.min(b.low), a.high.max(b.high), [a.ends[0], b.ends[1]]);
        Self { low, high, ends, content: Content::Pair(Box::new(nodes)) }
    }

    fn crossings(&self, point: DVec2) -> Option<i32> {
        if self.low.cmpgt(point).any() || point.cmpgt(self.high).any() {
            return Some(chord_crossings(self.ends, point));
        }
        match &self.content {
            Content::Pair(nodes) => Some(nodes[0].crossings(point)? + nodes[1].crossings(point)?),
            Content::Piece(piece) => crossings(piece, point),
        }
    }

    fn meets(&self, low: DVec2, high: DVec2) -> bool {
        if self.low.cmpgt(high).any() || low.cmpgt(self.high).any() {
            return false;
        }
        match &self.content {
            Content::Pair(nodes) => nodes.iter().any(|node| node.meets(low, high)),
            Content::Piece(piece) => piece.meets(low, high),
        }
    }
}

/// Appends the parts of a piece that are flat.
fn flatten(piece: PlanePiece, halvings: u32, flat: &mut Vec<PlanePiece>) {
    let (start, chord) = (piece.start(), piece.end() - piece.start());
    let square = chord.length_squared();
    let is_near = |point: DVec2| {
        let share = ((point - start).dot(chord) / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (point - start - share * chord).length_squared() <= FLATNESS * FLATNESS * square
    };
    if halvings == 0 || piece.control_points().all(is_near) {
        return flat.push(piece);
    }
    for half in piece.halves() {
        flatten(half, halvings - 1, flat);
    }
}

/// The tree over a chain of nodes in their order.
fn joined(mut chain: Vec<Node>) -> Node {
    if chain.len() == 1 {
        return chain.remove(0);
    }
    let second = chain.split_off(chain.len() / 2);
    Node::around([joined(chain), joined(second)])
}

/// The tree over closed loops, halved across their longer extent.
fn grouped(mut loops: Vec<Node>) -> Node {
    if loops.len() == 1 {
        return loops.remove(0);
    }
    let middle = |node: &Node| node.low.midpoint(node.high);
    let middles = || loops.iter().map(middle);
    let low = middles().fold(DVec2::INFINITY, DVec2::min);
    let extent = middles().fold(DVec2::NEG_INFINITY, DVec2::max) - low;
    let axis = usize::from(extent.y > extent.x);
    loops.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let second = loops.split_off(loops.len() / 2);
    let mut pair = Node::around([grouped(loops), grouped(second)]);
    // The chord from one loop to another has no meaning.
    pair.ends[1] = pair.ends[0];
    pair
}
