//! Gaussian-weighted sums on a quadrilateral grid, as one pass over rows and one over columns.

use std::ops::Range;

use super::gaussian::{SideWeights, gaussian_weights};
use super::lattice::Lattice;
use super::node_sums::by_rows;
use crate::error::Result;
use crate::progress::InterruptCheck;

/// The weights along a side of the lattice, multiplied by the signed distance to the power 0, 1 and
/// 2.
struct SideMoments {
    count: usize,
    /// By index difference `other - node`, from `1 - count` up.
    powers: [Vec<f64>; 3],
    /// The index range of the non-zero weights.
    range: Range<usize>,
}

impl SideMoments {
    fn new(count: usize, closed: bool, radius: f64) -> Self {
        let (mut weights, mut side_weights) = (vec![0.0; count], SideWeights::new(count, closed));
        gaussian_weights(radius, &mut weights);
        side_weights.set(&weights);
        let weight = |place: usize, power: i32| {
            let mut apart = place as f64 - (count - 1) as f64;
            let distance = place.abs_diff(count - 1);
            if closed && 2 * distance > count {
                apart -= (count as f64).copysign(apart);
            } else if closed && 2 * distance == count && power == 1 {
                // Opposite nodes on the ring have the same distance both ways, so the signed
                // distance cancels.
                return 0.0;
            }
            side_weights.values()[place] * apart.powi(power)
        };
        let powers: [Vec<f64>; 3] =
            [0, 1, 2].map(|power| (0..2 * count - 1).map(|at| weight(at, power)).collect());
        let [first, ..] = &powers;
        let used = |weight: &f64| *weight != 0.0;
        let from = first.iter().position(used).unwrap_or(0);
        let to = first.iter().rposition(used).unwrap_or(0) + 1;
        Self { count, powers, range: from..to }
    }

    /// The first node with a non-zero weight around `node`, and the weights from there on.
    fn around(&self, node: usize, power: usize) -> (usize, &[f64]) {
        let shift = self.count - 1 - node;
        let from = self.range.start.max(shift);
        let to = self.range.end.min(shift + self.count);
        (from - shift, &self.powers[power][from..to])
    }
}

/// The Gaussian around each node of a quadrilateral grid, as a product of two one-dimensional ones.
pub(super) struct GaussianSums {
    rows: SideMoments,
    cols: SideMoments,
}

impl GaussianSums {
    pub(super) fn new(lattice: &Lattice, radius: f64) -> Self {
        let (rows, cols) = lattice.shape();
        let (closed_u, closed_v) = lattice.topology().closed();
        Self {
            rows: SideMoments::new(rows, closed_u, radius),
            cols: SideMoments::new(cols, closed_v, radius),
        }
    }

    /// Weighted sums along u: row `to` of the result is Σ weight(to, from) · row `from`.
    pub(super) fn over_rows<const N: usize>(
        &self,
        power: usize,
        sums: &[[f64; N]],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Vec<[f64; N]>> {
        let (rows, cols) = (&self.rows, self.cols.count);
        by_rows(
            cols,
            vec![[0.0; N]; sums.len()],
            rows.count,
            check_interrupt,
            |to, row: &mut [[f64; N]]| {
                let (first, weights) = rows.around(to, power);
                for (&weight, from) in weights.iter().zip(sums[first * cols..].chunks(cols)) {
                    if weight != 0.0 {
                        let (row, from) = (row.as_flattened_mut(), from.as_flattened());
                        row.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
                    }
                }
            },
        )
    }

    /// Weighted sums along v.
    pub(super) fn over_cols<const N: usize>(
        &self,
        power: usize,
        sums: &[[f64; N]],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Vec<[f64; N]>> {
        let cols = &self.cols;
        by_rows(
            cols.count,
            vec![[0.0; N]; sums.len()],
            cols.count,
            check_interrupt,
            |row, totals: &mut [[f64; N]]| {
                let sums: &[[f64; N]] = &sums[row * cols.count..][..cols.count];
                for (node, total) in totals.iter_mut().enumerate() {
                    let (first, weights) = cols.around(node, power);
                    for (&weight, from) in weights.iter().zip(&sums[first..]) {
                        for (total, value) in total.iter_mut().zip(from) {
                            *total += weight * value;
                        }
                    }
                }
            },
        )
    }
}
