//! What a thread reviews at a time: neighbouring pieces of a block, and what becomes of them.

use super::adaptive::Tessellation;
use super::desk::Desk;
use super::piece::Piece;
use super::stitch::{Place, Vertices};

/// Memory of a thread.
#[derive(Default)]
pub(super) struct Room {
    vertices: Vertices,
    /// Numbers of vertices around a piece.
    outline: Vec<usize>,
    places: Vec<Place>,
}

/// Pieces of a block, one behind the other.
pub(super) struct Run<'a> {
    pub block: usize,
    /// The number of the first one.
    pub first: usize,
    pub pieces: &'a mut [Piece],
    /// The vertices of the block, if it has more pieces than these.
    pub vertices: Option<&'a Vertices>,
}

/// Pieces of a block that have been divided, in order.
pub(super) struct Divided {
    pub block: usize,
    /// The number of each, and where its parts end.
    ends: Vec<(usize, usize)>,
    parts: Vec<Piece>,
}

impl Divided {
    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// How many parts they have become.
    pub(super) fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Puts the parts in the places of the pieces.
    pub(super) fn replace(all: &[Self], pieces: &mut Vec<Piece>) {
        let more = all.iter().map(|divided| divided.parts.len() - divided.ends.len());
        let mut new = Vec::with_capacity(pieces.len() + more.sum::<usize>());
        let mut kept = 0;
        for Self { ends, parts, .. } in all {
            let mut start = 0;
            for &(number, end) in ends {
                new.extend_from_slice(&pieces[kept..number]);
                new.extend_from_slice(&parts[start..end]);
                (kept, start) = (number + 1, end);
            }
        }
        new.extend_from_slice(&pieces[kept..]);
        *pieces = new;
    }
}

impl Tessellation<'_> {
    /// Looks at the pieces that have got vertices on their sides, and divides those that are unfit.
    pub(super) fn review(&self, desk: &mut Desk, room: &mut Room, run: Run<'_>) -> Divided {
        let Run { block: index, first, pieces, vertices } = run;
        let (block, divider) = (self.lattice.block(index), self.divider());
        let Room { vertices: own, outline, places } = room;
        let vertices = vertices.unwrap_or_else(|| {
            own.collect(block, pieces, self.sides(index));
            own
        });
        let mut divided = Divided { block: index, ends: vec![], parts: vec![] };
        for (k, piece) in pieces.iter_mut().enumerate() {
            outline.clear();
            vertices.outline(piece, outline);
            if outline.len() <= piece.cut.corners() {
                continue;
            }
            places.clear();
            places.extend(outline.iter().map(|&rank| vertices.place(rank)));
            if let Some(direction) = divider.check(block, piece, places, desk) {
                let Divided { ends, parts, .. } = &mut divided;
                divider.redivide(block, (*piece, direction), desk, parts);
                ends.push((first + k, parts.len()));
            }
        }
        divided
    }
}
