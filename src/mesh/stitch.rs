//! How blocks fit together: the vertices on their borders, and the outlines of their pieces.

use super::lattice::Lattice;
use super::piece::{Block, PATCH, Piece};

/// A place in a block.
pub(super) type Place = (u32, u32);

/// The inner vertices of every border between two blocks (or of one block), sorted; borders that a
/// closed direction joins are one.
#[derive(Debug)]
pub(super) struct Borders {
    /// Those at constant u: (line, column) as row by row.
    pub across_u: Vec<Vec<u32>>,
    /// Those at constant v: (row, line) as row by row.
    pub across_v: Vec<Vec<u32>>,
    shape: (usize, usize),
    closed: (bool, bool),
}

/// A block's border in the order of [`Borders::around`].
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    /// At constant u; the index of the border.
    U(usize),
    /// At constant v.
    V(usize),
}

impl Borders {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let (rows, cols) = lattice.shape();
        Self {
            across_u: vec![vec![]; (rows + 1) * cols],
            across_v: vec![vec![]; rows * (cols + 1)],
            shape: (rows, cols),
            closed: lattice.closed,
        }
    }

    /// The borders of a block: at the start and the end in u, at the start and the end in v.
    pub(super) fn around(&self, block: usize) -> [Side; 4] {
        let (i, j) = (block / self.shape.1, block % self.shape.1);
        [self.line_u(i, j), self.line_u(i + 1, j), self.line_v(i, j), self.line_v(i, j + 1)]
    }

    /// The border at a cut in u, in a column of blocks.
    pub(super) fn line_u(&self, line: usize, col: usize) -> Side {
        let line = if self.closed.0 { line % self.shape.0 } else { line };
        Side::U(line * self.shape.1 + col)
    }

    /// The border at a cut in v, in a row of blocks.
    pub(super) fn line_v(&self, row: usize, line: usize) -> Side {
        let line = if self.closed.1 { line % self.shape.1 } else { line };
        Side::V(row * (self.shape.1 + 1) + line)
    }

    pub(super) fn at(&self, side: Side) -> &[u32] {
        match side {
            Side::U(index) => &self.across_u[index],
            Side::V(index) => &self.across_v[index],
        }
    }

    /// Adds a block's own vertices on a border; whether there was a new one.
    pub(super) fn add(&mut self, side: Side, places: &[u32]) -> bool {
        let border = match side {
            Side::U(index) => &mut self.across_u[index],
            Side::V(index) => &mut self.across_v[index],
        };
        let before = border.len();
        border.extend_from_slice(places);
        border.sort_unstable();
        border.dedup();
        border.len() > before
    }
}

/// The inner vertices that a block's pieces put on its four borders.
pub(super) fn own_borders(block: Block, pieces: &[Piece]) -> [Vec<u32>; 4] {
    let whole = Piece::of(block);
    let mut sides: [Vec<u32>; 4] = Default::default();
    for piece in pieces {
        // One end of each piece is enough: the other one is its neighbour's.
        let ends = [
            (piece.u.0 == whole.u.0, piece.v.1, whole.v.1),
            (piece.u.1 == whole.u.1, piece.v.1, whole.v.1),
            (piece.v.0 == whole.v.0, piece.u.1, whole.u.1),
            (piece.v.1 == whole.v.1, piece.u.1, whole.u.1),
        ];
        for (side, (touches, place, end)) in sides.iter_mut().zip(ends) {
            if touches && place != end {
                side.push(place);
            }
        }
    }
    sides
}

/// The vertices of a block, to be found by the lines that they lie on.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    /// (u, v) of each, in order.
    by_u: Vec<(u32, u32)>,
    /// (v, u) of each in order, and its rank in `by_u`.
    by_v: Vec<(u32, u32, u32)>,
}

impl Vertices {
    /// Of the pieces of a block and its neighbours' vertices on its borders.
    pub(super) fn collect(&mut self, block: Block, pieces: &[Piece], borders: [&[u32]; 4]) {
        let whole = Piece::of(block);
        self.by_u.clear();
        self.by_u.extend([(whole.u.0, whole.v.0), (whole.u.0, whole.v.1), (whole.u.1, whole.v.0)]);
        // Every other vertex is the last corner of a piece, or on a border.
        self.by_u.extend(pieces.iter().map(|piece| (piece.u.1, piece.v.1)));
        self.by_u.extend(pieces.iter().map(|piece| (piece.u.0, piece.v.1)));
        self.by_u.extend(pieces.iter().map(|piece| (piece.u.1, piece.v.0)));
        self.by_u.extend(borders[0].iter().map(|&v| (whole.u.0, v)));
        self.by_u.extend(borders[1].iter().map(|&v| (whole.u.1, v)));
        self.by_u.extend(borders[2].iter().map(|&u| (u, whole.v.0)));
        self.by_u.extend(borders[3].iter().map(|&u| (u, whole.v.1)));
        self.by_u.sort_unstable();
        self.by_u.dedup();
        let ranked = self.by_u.iter().zip(0..).map(|(&(u, v), rank)| (v, u, rank));
        self.by_v.clear();
        self.by_v.extend(ranked);
        self.by_v.sort_unstable();
    }

    /// All vertices, sorted by u, then v.
    pub(super) fn places(&self) -> &[Place] {
        &self.by_u
    }

    /// The ranks and places of the vertices around a piece, counter-clockwise from its first
    /// corner, appended to `out`.
    pub(super) fn outline(&self, piece: &Piece, out: &mut Vec<(u32, Place)>) {
        let Piece { u: (u0, u1), v: (v0, v1), .. } = *piece;
        let in_u = |v: u32| {
            let from = self.by_v.partition_point(|&(at, u, _)| (at, u) < (v, u0));
            let row = self.by_v[from..].iter().take_while(move |&&(at, u, _)| (at, u) <= (v, u1));
            row.map(|&(v, u, rank)| (rank, (u, v)))
        };
        let in_v = |u: u32| {
            let from = self.by_u.partition_point(|&at| at < (u, v0));
            let row = self.by_u[from..].iter().zip(from..);
            let row = row.take_while(move |&(&at, _)| at <= (u, v1));
            #[expect(clippy::cast_possible_truncation, reason = "places are 32 bits")]
            row.map(|(&place, rank)| (rank as u32, place))
        };
        // The last vertex of each side is the first of the next one.
        out.extend(in_u(v0));
        out.pop();
        out.extend(in_v(u1));
        out.pop();
        let from = out.len();
        out.extend(in_u(v1));
        out[from..].reverse();
        out.pop();
        let from = out.len();
        out.extend(in_v(u0));
        out[from..].reverse();
        out.pop();
    }
}

/// The parameter of a place in a range of patches.
pub(super) fn parameter(cuts: &[f64], first: usize, place: u32) -> f64 {
    let patch = first + (place / PATCH) as usize;
    let rest = place % PATCH;
    if rest == 0 {
        return cuts[patch];
    }
    let share = f64::from(rest) / f64::from(PATCH);
    cuts[patch] + share * (cuts[patch + 1] - cuts[patch])
}
