//! The lattice of blocks that a surface is tessellated in, and who owns which border.

use std::sync::Arc;

use glam::DVec3;

use super::estimate::Estimate;
use super::piece::{Block, MOST_PATCHES};
use super::stitch::Side;
use crate::nurbs::{KnotVector, NurbsSurface, PatchNets};

/// Pieces along the side of a block that are aimed at: few enough that all threads have work, many
/// enough that borders do not matter.
const PIECES_PER_SIDE: f64 = 8.0;

/// The same for large meshes.
const MANY_PIECES_PER_SIDE: f64 = 32.0;

/// Triangles from which a mesh is large.
const LARGE: f64 = 1e5;

/// Pieces around a closed direction at least: with fewer, triangles would share two edges.
const LEAST_AROUND: usize = 3;

/// Share of the size within which the points of a border are one: a pole.
const POLE: f64 = 1e-12;

/// Blocks in rows and columns, numbered row by row.
#[derive(Debug)]
pub(super) struct Lattice {
    pub nets: Arc<PatchNets>,
    /// Cuts between blocks, as numbers of cuts between patches.
    pub u: Vec<usize>,
    pub v: Vec<usize>,
    /// Whether the surface closes in u and v.
    pub closed: (bool, bool),
    /// Whether the first and the last border in u are poles.
    pub poles_u: [bool; 2],
    /// The same in v.
    pub poles_v: [bool; 2],
}

impl Lattice {
    /// Of a surface, the nets of its patches, and how many pieces it is about to have.
    pub(super) fn new(
        surface: &NurbsSurface,
        mut nets: Arc<PatchNets>,
        estimate: Estimate,
    ) -> Self {
        let closed = surface.closed();
        let side = if estimate.triangles > LARGE { MANY_PIECES_PER_SIDE } else { PIECES_PER_SIDE };
        let more = |knots: &KnotVector, along: f64, closed: bool| {
            let least = if closed { LEAST_AROUND as f64 } else { 1.0 };
            cuts(knots, (along / side).max(least))
        };
        let (more_u, block_u) = more(surface.knots_u(), estimate.along.0, closed.0);
        let (more_v, block_v) = more(surface.knots_v(), estimate.along.1, closed.1);
        if !(more_u.is_empty() && more_v.is_empty()) {
            nets = Arc::new(PatchNets::new(surface, &more_u, &more_v));
        }
        let lines = |cuts: &[f64], patches: usize, knots: &KnotVector| {
            let crease = |&i: &usize| knots.multiplicity(cuts[i]) >= knots.degree();
            let mut lines = vec![0];
            for i in 1..cuts.len() {
                let full = i - lines[lines.len() - 1] >= patches;
                if full || crease(&i) || i == cuts.len() - 1 {
                    lines.push(i);
                }
            }
            lines
        };
        let u = lines(&nets.u, block_u, surface.knots_u());
        let v = lines(&nets.v, block_v, surface.knots_v());
        let small = POLE * surface.size();
        let (rows, cols) = (nets.u.len() - 1, nets.v.len() - 1);
        let (last_u, last_v) = (rows * nets.degrees.0, cols * nets.degrees.1);
        let point = |i: usize, j: usize| nets.point((i, &[1.0]), (j, &[1.0])).project();
        let poles_u = [0, last_u].map(|i| is_one((0..=last_v).map(|j| point(i, j)), small));
        let poles_v = [0, last_v].map(|j| is_one((0..=last_u).map(|i| point(i, j)), small));
        Self { nets, u, v, closed, poles_u, poles_v }
    }

    /// How many blocks there are along u and v.
    pub(super) fn shape(&self) -> (usize, usize) {
        (self.u.len() - 1, self.v.len() - 1)
    }

    pub(super) fn blocks(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// The row and the column of a block.
    pub(super) fn at(&self, index: usize) -> (usize, usize) {
        (index / self.shape().1, index % self.shape().1)
    }

    pub(super) fn block(&self, index: usize) -> Block {
        let (i, j) = self.at(index);
        Block { rows: (self.u[i], self.u[i + 1]), cols: (self.v[j], self.v[j + 1]) }
    }
}

impl Lattice {
    /// The blocks on both sides of a border.
    pub(super) fn beside(&self, side: Side) -> Vec<usize> {
        let (rows, cols) = self.shape();
        let both = |line: usize, count: usize, closed: bool| {
            let before = if line == 0 && closed { Some(count - 1) } else { line.checked_sub(1) };
            before.into_iter().chain((line < count).then_some(line))
        };
        match side {
            Side::U(index) => {
                let (line, col) = (index / cols, index % cols);
                both(line, rows, self.closed.0).map(|row| row * cols + col).collect()
            }
            Side::V(index) => {
                let (row, line) = (index / (cols + 1), index % (cols + 1));
                both(line, cols, self.closed.1).map(|col| row * cols + col).collect()
            }
        }
    }

    /// Whether the border at this cut in u is a pole.
    pub(super) fn is_pole_u(&self, line: usize) -> bool {
        (line == 0 && self.poles_u[0]) || (line == self.shape().0 && self.poles_u[1])
    }

    /// Whether the border at this cut in v is a pole.
    pub(super) fn is_pole_v(&self, line: usize) -> bool {
        (line == 0 && self.poles_v[0]) || (line == self.shape().1 && self.poles_v[1])
    }

    /// The corner of blocks that is the same vertex as this one and comes first.
    pub(super) fn owner(&self, (i, j): (usize, usize), closed: (bool, bool)) -> (usize, usize) {
        let (rows, cols) = self.shape();
        let mut owner = (i, j);
        if owner.0 == rows && closed.0 {
            owner.0 = 0;
        }
        if owner.1 == cols && closed.1 {
            owner.1 = 0;
        }
        if self.is_pole_u(owner.0) {
            owner.1 = 0;
        }
        if self.is_pole_v(owner.1) {
            owner.0 = 0;
        }
        owner
    }
}

/// Where to cut, besides the knots, so that there are at least `blocks`; and the patches along a
/// side of a block.
fn cuts(knots: &KnotVector, blocks: f64) -> (Vec<f64>, usize) {
    let breaks = knots.breaks();
    let spans = (breaks.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1")]
    if blocks <= spans {
        return (vec![], ((spans / blocks) as usize).min(MOST_PATCHES));
    }
    let mut parts = 2;
    while spans * f64::from(parts) < blocks {
        parts *= 2;
    }
    let inside = |pair: &[f64]| {
        let (from, to) = (pair[0], pair[1]);
        (1..parts).map(move |k| from + f64::from(k) / f64::from(parts) * (to - from))
    };
    (breaks.windows(2).flat_map(inside).collect(), 1)
}

/// Whether all points are within a small distance of the first one.
fn is_one(mut points: impl Iterator<Item = DVec3>, small: f64) -> bool {
    points.next().is_none_or(|first| points.all(|point| point.distance(first) <= small))
}
