//! How many pieces a tessellation will have: what decides how the work is divided, and whether it
//! is begun at all.

use super::options::Limits;
use crate::nurbs::{Bending, PatchNets};

/// Pieces that halving makes for each that the curvature asks for, on the average.
const HALVING: f64 = 1.4;

/// Triangles for each piece: two, and those for the corners of neighbours.
const TRIANGLES_PER_PIECE: f64 = 2.5;

/// What the curvature of a surface asks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    /// Pieces along u and v, on the average.
    pub along: (f64, f64),
    /// Triangles of the whole mesh.
    pub triangles: f64,
}

impl Estimate {
    /// From how the patches bend: from that follows how far a chord may reach, and the area that a
    /// triangle may have.
    pub(super) fn of(nets: &PatchNets, limits: &Limits) -> Self {
        let mut sums = [0.0; 3];
        for (at, bending) in nets.sampled_patches().zip(nets.sampled_bending()) {
            let counts = counts(nets, at, *bending, limits);
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let mean = sums.map(|sum| sum / nets.sampled_bending().len() as f64);
        let (rows, cols) = ((nets.u.len() - 1) as f64, (nets.v.len() - 1) as f64);
        Self {
            along: (mean[0] * rows, mean[1] * cols),
            triangles: TRIANGLES_PER_PIECE * mean[2] * rows * cols,
        }
    }
}

/// Pieces that a patch asks for along u, along v and in all.
fn counts(
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
    let cells = HALVING * (bowl * n_u.max(1.0) * n_v.max(1.0)).max(twist);
    // Twist asks for pieces of a certain area; as squares, as long as nothing else is known.
    [n_u.max(twist.sqrt()), n_v.max(twist.sqrt()), cells]
}
