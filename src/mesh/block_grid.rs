//! The grid of blocks that a surface is tessellated in.

use std::sync::Arc;

use glam::DVec3;

use super::block::{Block, MAX_PATCHES};
use super::estimate::Estimate;
use crate::nurbs::{KnotVector, NurbsSurface, PatchNets};

/// Target number of cells along the side of a block.
///
/// Few enough that all threads have work, many enough that little work goes into block edges.
const CELLS_PER_SIDE: f64 = 8.0;

/// Target number of cells along the side of a block of a large mesh.
const CELLS_PER_SIDE_OF_LARGE: f64 = 32.0;

/// Estimated triangles above which a mesh is large.
const LARGE_TRIANGLES: f64 = 1e5;

/// Blocks around a closed direction at least: with fewer, two triangles would share two edges.
const MIN_BLOCKS_AROUND: usize = 3;

/// Distance within which all points of a boundary curve are one pole, relative to the surface's
/// size.
const POLE_TOLERANCE: f64 = 1e-12;

/// Blocks in rows and columns, indexed row by row.
#[derive(Debug)]
pub(super) struct BlockGrid {
    /// The Bézier patches of the surface.
    pub nets: Arc<PatchNets>,
    /// Lines between blocks in u, as indices of lines between patches, ends included.
    pub u: Vec<usize>,
    /// Lines between blocks in v.
    pub v: Vec<usize>,
    /// Whether the surface closes in u and v.
    pub closed: (bool, bool),
    /// Whether the first and the last line in u are poles.
    poles_u: [bool; 2],
    /// Whether the first and the last line in v are poles.
    poles_v: [bool; 2],
}

impl BlockGrid {
    /// Groups the patches of a surface into blocks; `estimate` determines their size.
    pub(super) fn new(
        surface: &NurbsSurface,
        mut nets: Arc<PatchNets>,
        estimate: Estimate,
    ) -> Self {
        let closed = surface.closed();
        let side = if estimate.triangles > LARGE_TRIANGLES {
            CELLS_PER_SIDE_OF_LARGE
        } else {
            CELLS_PER_SIDE
        };
        let more = |knots: &KnotVector, along: f64, closed: bool| {
            let least = if closed { MIN_BLOCKS_AROUND as f64 } else { 1.0 };
            extra_breaks(knots, (along / side).max(least))
        };
        let (more_u, block_u) = more(surface.knots_u(), estimate.along.0, closed.0);
        let (more_v, block_v) = more(surface.knots_v(), estimate.along.1, closed.1);
        if !(more_u.is_empty() && more_v.is_empty()) {
            nets = Arc::new(surface.patch_nets_cut_at(&more_u, &more_v));
        }
        let lines = |breaks: &[f64], patches: usize, knots: &KnotVector| {
            let crease = |&i: &usize| knots.multiplicity(breaks[i]) >= knots.degree();
            let mut lines = vec![0];
            for i in 1..breaks.len() {
                let full = i - lines[lines.len() - 1] >= patches;
                if full || crease(&i) || i == breaks.len() - 1 {
                    lines.push(i);
                }
            }
            lines
        };
        let u = lines(&nets.u, block_u, surface.knots_u());
        let v = lines(&nets.v, block_v, surface.knots_v());
        let small = POLE_TOLERANCE * surface.size();
        let (rows, cols) = (nets.u.len() - 1, nets.v.len() - 1);
        let (last_u, last_v) = (rows * nets.degrees.0, cols * nets.degrees.1);
        let point = |i: usize, j: usize| nets.point((i, &[1.0]), (j, &[1.0])).project();
        let poles_u = [0, last_u].map(|i| coincide((0..=last_v).map(|j| point(i, j)), small));
        let poles_v = [0, last_v].map(|j| coincide((0..=last_u).map(|i| point(i, j)), small));
        Self { nets, u, v, closed, poles_u, poles_v }
    }

    /// Number of blocks along u and v.
    pub(super) fn shape(&self) -> (usize, usize) {
        (self.u.len() - 1, self.v.len() - 1)
    }

    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// The row and the column of a block.
    pub(super) fn at(&self, index: usize) -> (usize, usize) {
        (index / self.shape().1, index % self.shape().1)
    }

    /// The block of an index.
    pub(super) fn block(&self, index: usize) -> Block {
        let (i, j) = self.at(index);
        Block { rows: (self.u[i], self.u[i + 1]), cols: (self.v[j], self.v[j + 1]) }
    }

    /// Whether this line in u is a pole.
    pub(super) fn is_pole_u(&self, line: usize) -> bool {
        (line == 0 && self.poles_u[0]) || (line == self.shape().0 && self.poles_u[1])
    }

    /// Whether this line in v is a pole.
    pub(super) fn is_pole_v(&self, line: usize) -> bool {
        (line == 0 && self.poles_v[0]) || (line == self.shape().1 && self.poles_v[1])
    }

    /// The first block corner that is the same vertex as this one.
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

/// Parameters at which to split the spans so that there are at least `blocks` patches, and the
/// number of patches along the side of a block.
fn extra_breaks(knots: &KnotVector, blocks: f64) -> (Vec<f64>, usize) {
    let breaks = knots.breaks();
    let spans = (breaks.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1")]
    if blocks <= spans {
        return (vec![], ((spans / blocks) as usize).min(MAX_PATCHES));
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

/// Whether all points lie within the distance `small` of the first one.
fn coincide(mut points: impl Iterator<Item = DVec3>, small: f64) -> bool {
    points.next().is_none_or(|first| points.all(|point| point.distance(first) <= small))
}
