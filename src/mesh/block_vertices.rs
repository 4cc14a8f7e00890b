//! The vertices of a block, searchable by the lines that they lie on.

use std::ops::Range;

use super::block::{Block, GridPoint};
use super::cell::Cell;

/// The vertices of a block, sorted by u and by v. The rank of a vertex is its index by u.
#[derive(Debug, Default)]
pub(super) struct BlockVertices {
    /// Sorted keys of (u, v).
    by_u: Vec<u64>,
    /// Sorted keys of (v, u).
    by_v: Vec<u64>,
}

/// Two coordinates in one number that sorts by the first, then by the second.
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

impl BlockVertices {
    /// Replaces the vertices by the corners of a block's cells and the vertices on its edges.
    pub(super) fn collect(&mut self, block: Block, cells: &[Cell], edges: [&[u32]; 4]) {
        let Cell { u: (u0, u1), v: (v0, v1), .. } = Cell::of(block);
        let on_edges = edges.iter().map(|edge| edge.len()).sum::<usize>();
        self.by_u.clear();
        self.by_u.reserve(3 + 3 * cells.len() + on_edges);
        self.by_u.extend([key(u0, v0), key(u0, v1), key(u1, v0)]);
        // Every other vertex is on an edge of the block, or a corner of a cell other than its
        // first.
        for Cell { u, v, .. } in cells {
            self.by_u.extend([key(u.1, v.1), key(u.0, v.1), key(u.1, v.0)]);
        }
        self.by_u.extend(edges[0].iter().map(|&v| key(u0, v)));
        self.by_u.extend(edges[1].iter().map(|&v| key(u1, v)));
        self.by_u.extend(edges[2].iter().map(|&u| key(u, v0)));
        self.by_u.extend(edges[3].iter().map(|&u| key(u, v1)));
        self.by_u.sort_unstable();
        self.by_u.dedup();
        self.by_v.clear();
        self.by_v.extend(self.by_u.iter().map(|key| key.rotate_left(32)));
        self.by_v.sort_unstable();
    }

    /// All vertices in order of their ranks.
    pub(super) fn points(&self) -> impl Iterator<Item = GridPoint> + '_ {
        (0..self.by_u.len()).map(|rank| self.point(rank))
    }

    /// The vertex of a rank.
    pub(super) fn point(&self, rank: usize) -> GridPoint {
        (first(self.by_u[rank]), second(self.by_u[rank]))
    }

    /// Appends the ranks of the vertices around a cell, counter-clockwise from its first corner.
    pub(super) fn outline(&self, cell: &Cell, out: &mut Vec<usize>) {
        let Cell { u: (u0, u1), v: (v0, v1), .. } = *cell;
        let (at_start, at_end) = (line(&self.by_u, u0, (v0, v1)), line(&self.by_u, u1, (v0, v1)));
        let between = |v: u32| {
            let line = &self.by_v[line(&self.by_v, v, (u0, u1))];
            line[1..line.len() - 1].iter().map(|key| rank(&self.by_u, key.rotate_left(32)))
        };
        out.push(at_start.start);
        out.extend(between(v0));
        out.extend(at_end);
        out.extend(between(v1).rev());
        out.extend((at_start.start + 1..at_start.end).rev());
    }
}

/// The index of a key in a sorted list.
fn rank(keys: &[u64], key: u64) -> usize {
    keys.partition_point(|&other| other < key)
}

/// The indices of the keys from (at, from) to (at, to), both of which the list contains.
fn line(keys: &[u64], at: u32, (from, to): (u32, u32)) -> Range<usize> {
    let (start, last) = (rank(keys, key(at, from)), key(at, to));
    let inner = keys[start..].iter().take_while(|&&other| other < last).count();
    start..start + inner + 1
}
