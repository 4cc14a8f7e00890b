//! How blocks fit together: the vertices on their borders, and the outlines of their pieces.

use std::ops::Range;

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
    /// The key of (u, v) of each, in order.
    by_u: Vec<u64>,
    /// The key of (v, u) of each, in order.
    by_v: Vec<u64>,
}

/// Both numbers in one, of which the first counts first.
fn key(first: u32, second: u32) -> u64 {
    u64::from(first) << 32 | u64::from(second)
}

#[expect(clippy::cast_possible_truncation, reason = "the lower half of a key")]
fn second(key: u64) -> u32 {
    key as u32
}

fn first(key: u64) -> u32 {
    (key >> 32) as u32
}

impl Vertices {
    /// Of the pieces of a block and its neighbours' vertices on its borders.
    pub(super) fn collect(&mut self, block: Block, pieces: &[Piece], borders: [&[u32]; 4]) {
        let Piece { u: (u0, u1), v: (v0, v1), .. } = Piece::of(block);
        let on_borders = borders.iter().map(|border| border.len()).sum::<usize>();
        self.by_u.clear();
        self.by_u.reserve(3 + 3 * pieces.len() + on_borders);
        self.by_u.extend([key(u0, v0), key(u0, v1), key(u1, v0)]);
        // Every other vertex is a corner, not the first, of a piece, or on a border.
        for Piece { u, v, .. } in pieces {
            self.by_u.extend([key(u.1, v.1), key(u.0, v.1), key(u.1, v.0)]);
        }
        self.by_u.extend(borders[0].iter().map(|&v| key(u0, v)));
        self.by_u.extend(borders[1].iter().map(|&v| key(u1, v)));
        self.by_u.extend(borders[2].iter().map(|&u| key(u, v0)));
        self.by_u.extend(borders[3].iter().map(|&u| key(u, v1)));
        self.by_u.sort_unstable();
        self.by_u.dedup();
        self.by_v.clear();
        self.by_v.extend(self.by_u.iter().map(|key| key.rotate_left(32)));
        self.by_v.sort_unstable();
    }

    /// All vertices, sorted by u, then v.
    pub(super) fn places(&self) -> impl Iterator<Item = Place> + '_ {
        (0..self.by_u.len()).map(|rank| self.place(rank))
    }

    /// The vertex with this place among all.
    pub(super) fn place(&self, rank: usize) -> Place {
        (first(self.by_u[rank]), second(self.by_u[rank]))
    }

    /// The places among all of the vertices around a piece, counter-clockwise from its first corner,
    /// appended to `out`.
    pub(super) fn outline(&self, piece: &Piece, out: &mut Vec<usize>) {
        let Piece { u: (u0, u1), v: (v0, v1), .. } = *piece;
        let (before, behind) = (line(&self.by_u, u0, (v0, v1)), line(&self.by_u, u1, (v0, v1)));
        let between = |v: u32| {
            let line = &self.by_v[line(&self.by_v, v, (u0, u1))];
            line[1..line.len() - 1].iter().map(|key| rank(&self.by_u, key.rotate_left(32)))
        };
        out.push(before.start);
        out.extend(between(v0));
        out.extend(behind);
        out.extend(between(v1).rev());
        out.extend((before.start + 1..before.end).rev());
    }
}

/// Where a key stands among others.
fn rank(keys: &[u64], key: u64) -> usize {
    keys.partition_point(|&other| other < key)
}

/// Where the keys stand that begin with this number and go on with one from `from` to `to`, which
/// are among them.
fn line(keys: &[u64], at: u32, (from, to): (u32, u32)) -> Range<usize> {
    let (start, last) = (rank(keys, key(at, from)), key(at, to));
    let inner = keys[start..].iter().take_while(|&&other| other < last).count();
    start..start + inner + 1
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
