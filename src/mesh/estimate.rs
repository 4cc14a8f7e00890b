//! An estimate of the number of cells, from the curvature of a sample of patches.
//!
//! It determines the size of blocks and refuses a tolerance that is far too small.

use super::options::Limits;
use crate::nurbs::{Bending, PatchNets};

/// Cells after subdivision by halving, for each cell of the ideal size, on average.
const HALVING_OVERHEAD: f64 = 1.4;

/// Triangles for each cell: two, and those for the corners of neighbors.
const TRIANGLES_PER_CELL: f64 = 2.5;

/// The estimated size of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// Cells along u and v, on average.
    pub along: (f64, f64),
    /// Triangles of the whole mesh.
    pub triangles: f64,
}

impl Estimate {
    /// Estimates from the bending of patches, which limits the length and the area of triangles.
    pub(super) fn of(nets: &PatchNets, limits: &Limits) -> Self {
        let mut sums = [0.0; 3];
        for (at, bending) in nets.sampled_patches().zip(nets.sampled_bending()) {
            let counts = cells_of_patch(nets, at, *bending, limits);
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let mean = sums.map(|sum| sum / nets.sampled_bending().len() as f64);
        let (rows, cols) = ((nets.u.len() - 1) as f64, (nets.v.len() - 1) as f64);
        Self {
            along: (mean[0] * rows, mean[1] * cols),
            triangles: TRIANGLES_PER_CELL * mean[2] * rows * cols,
        }
    }
}

/// Estimated cells of a patch along u, along v and in total.
fn cells_of_patch(
    nets: &PatchNets,
    (row, col): (usize, usize),
    bending: Bending,
    limits: &Limits,
) -> [f64; 3] {
    let (p, q) = nets.degrees;
    let corner = |(i, j): (usize, usize)| {
        nets.point(((row + i) * p, &[1.0]), ((col + j) * q, &[1.0])).project()
    };
    let along = |bend: f64, chords: [[(usize, usize); 2]; 2]| {
        let mut count = (bend.abs() / (8.0 * limits.tolerance)).sqrt();
        let length = || {
            let [a, b] = chords.map(|[from, to]| corner(from).distance(corner(to)));
            a.max(b)
        };
        if let Some(edge) = limits.edge {
            count = count.max(length() / edge);
        }
        if let Some(cosine) = limits.cosine {
            let turn = bend.abs() / length() / cosine.acos();
            count = if turn.is_finite() { count.max(turn) } else { count };
        }
        if count.is_finite() { count } else { 0.0 }
    };
    let n_u = along(bending.uu, [[(0, 0), (1, 0)], [(0, 1), (1, 1)]]);
    let n_v = along(bending.vv, [[(0, 0), (0, 1)], [(1, 0), (1, 1)]]);
    // Where both directions bend to the same side, their sags add up.
    let bowl = if bending.uu * bending.vv > 0.0 { 2.0 } else { 1.0 };
    let twist = bending.uv.abs() / (4.0 * limits.tolerance);
    let twist = if twist.is_finite() { twist } else { 0.0 };
    let cells = HALVING_OVERHEAD * (bowl * n_u.max(1.0) * n_v.max(1.0)).max(twist);
    // Twist limits the area of a cell only: cells are taken as squares.
    [n_u.max(twist.sqrt()), n_v.max(twist.sqrt()), cells]
}
