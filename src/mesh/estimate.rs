//! How many pieces a tessellation will have: what decides how the work is divided, and whether it
//! is begun at all.

use rayon::prelude::*;

use super::options::Limits;
use crate::nurbs::NurbsSurface;

/// Patches from which one sample each is enough.
const MANY_PATCHES: usize = 64;

/// Patches along each direction that are looked at, at most about.
const MOST_LINES: usize = 12;

/// Samples along each side of a patch if there are few.
const SAMPLES: usize = 4;

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
    /// From the curvature at samples of each patch: from the second fundamental form follows how
    /// far a chord may reach, and the area that a triangle may have.
    pub(super) fn of(surface: &NurbsSurface, limits: &Limits) -> Self {
        let (u, v) = (surface.knots_u().breaks(), surface.knots_v().breaks());
        let (rows, cols) = (u.len() - 1, v.len() - 1);
        let samples = if rows * cols >= MANY_PATCHES { 1 } else { SAMPLES };
        // Of many, those in the middle of as many equal parts.
        let (some_rows, some_cols) = (rows.min(MOST_LINES), cols.min(MOST_LINES));
        let middle = |k: usize, some: usize, all: usize| (2 * k + 1) * all / (2 * some);
        let counts = (0..some_rows * some_cols).into_par_iter().map(|k| {
            let i = middle(k / some_cols, some_rows, rows);
            let j = middle(k % some_cols, some_cols, cols);
            let (h, k) = (u[i + 1] - u[i], v[j + 1] - v[j]);
            let mut sums = [0.0; 3];
            for s in 0..samples * samples {
                let share = |s: usize| (s as f64 + 0.5) / samples as f64;
                let (at_u, at_v) = (u[i] + share(s / samples) * h, v[j] + share(s % samples) * k);
                let counts = counts(surface, (at_u, at_v), (h, k), limits);
                sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
            sums.map(|sum| sum / (samples * samples) as f64)
        });
        let counts: Vec<[f64; 3]> = counts.collect();
        let mean =
            |k: usize| counts.iter().map(|counts| counts[k]).sum::<f64>() / counts.len() as f64;
        let (rows, cols) = (rows as f64, cols as f64);
        Self {
            along: (mean(0) * rows, mean(1) * cols),
            triangles: TRIANGLES_PER_PIECE * mean(2) * rows * cols,
        }
    }
}

/// Pieces that a patch with these sides asks for along u, along v and in all, if all of it bends
/// as it does at one place.
fn counts(
    surface: &NurbsSurface,
    (u, v): (f64, f64),
    (h, k): (f64, f64),
    limits: &Limits,
) -> [f64; 3] {
    let forms = surface.fundamental_forms(u, v);
    let (first, second) = (forms.first, forms.second);
    let along = |bend: f64, speed: f64, step: f64| {
        let mut count = (bend.abs() * step * step / (8.0 * limits.tolerance)).sqrt();
        let length = speed.sqrt() * step;
        if let Some(edge) = limits.edge {
            count = count.max(length / edge);
        }
        if let (Some(cosine), true) = (limits.cosine, speed > 0.0) {
            count = count.max(bend.abs() / speed * length / cosine.acos());
        }
        if count.is_finite() { count } else { 0.0 }
    };
    let (n_u, n_v) = (along(second[0][0], first[0][0], h), along(second[1][1], first[1][1], k));
    // Where both directions bend to the same side, their sags add up.
    let bowl = if second[0][0] * second[1][1] > 0.0 { 2.0 } else { 1.0 };
    let twist = second[0][1].abs() * h * k / (4.0 * limits.tolerance);
    let twist = if twist.is_finite() { twist } else { 0.0 };
    let cells = HALVING * (bowl * n_u.max(1.0) * n_v.max(1.0)).max(twist);
    // Twist asks for pieces of a certain area; as squares, as long as nothing else is known.
    [n_u.max(twist.sqrt()), n_v.max(twist.sqrt()), cells]
}
