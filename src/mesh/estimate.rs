//! How many pieces a tessellation will have: what decides how the work is divided, and whether it
//! is begun at all.

use glam::DVec3;

use super::options::Limits;
use super::outline::Bending;
use crate::nurbs::PatchNets;

/// Patches along each direction that are looked at, at most about.
const MOST_LINES: usize = 12;

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
        let (rows, cols) = (nets.u.len() - 1, nets.v.len() - 1);
        // Of many, those in the middle of as many equal parts.
        let (some_rows, some_cols) = (rows.min(MOST_LINES), cols.min(MOST_LINES));
        let middle = |k: usize, some: usize, all: usize| (2 * k + 1) * all / (2 * some);
        let (mut points, mut sums) = (vec![], [0.0; 3]);
        for (i, j) in (0..some_rows).flat_map(|i| (0..some_cols).map(move |j| (i, j))) {
            let (row, col) = (middle(i, some_rows, rows), middle(j, some_cols, cols));
            points.clear();
            for row in nets.rows(row..row + 1, col..col + 1) {
                points.extend(row.iter().map(|h| h.w.recip() * h.truncate()));
            }
            let counts = counts(&points, nets.degrees, limits);
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let mean = sums.map(|sum| sum / (some_rows * some_cols) as f64);
        let (rows, cols) = (rows as f64, cols as f64);
        Self {
            along: (mean[0] * rows, mean[1] * cols),
            triangles: TRIANGLES_PER_PIECE * mean[2] * rows * cols,
        }
    }
}

/// Pieces that a patch asks for along u, along v and in all.
fn counts(points: &[DVec3], (p, q): (usize, usize), limits: &Limits) -> [f64; 3] {
    let bending = Bending::of(points, (p, q));
    let (width, last) = (q + 1, points.len() - 1);
    let along = |bend: f64, length: f64| {
        let mut count = (bend.abs() / (8.0 * limits.tolerance)).sqrt();
        if let Some(edge) = limits.edge {
            count = count.max(length / edge);
        }
        if let (Some(cosine), true) = (limits.cosine, length > 0.0) {
            count = count.max(bend.abs() / length / cosine.acos());
        }
        if count.is_finite() { count } else { 0.0 }
    };
    let chord = |a: usize, b: usize| points[a].distance(points[b]);
    let (row, column) = (p * width, q);
    let n_u = along(bending.uu, chord(0, row).max(chord(column, last)));
    let n_v = along(bending.vv, chord(0, column).max(chord(row, last)));
    // Where both directions bend to the same side, their sags add up.
    let bowl = if bending.uu * bending.vv > 0.0 { 2.0 } else { 1.0 };
    let twist = bending.uv.abs() / (4.0 * limits.tolerance);
    let twist = if twist.is_finite() { twist } else { 0.0 };
    let cells = HALVING * (bowl * n_u.max(1.0) * n_v.max(1.0)).max(twist);
    // Twist asks for pieces of a certain area; as squares, as long as nothing else is known.
    [n_u.max(twist.sqrt()), n_v.max(twist.sqrt()), cells]
}
