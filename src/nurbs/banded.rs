//! Solvers for banded linear systems, open and cyclic, with many right-hand sides.
//!
//! Elimination without pivoting is stable here: collocation matrices of B-splines are totally
//! positive, and their normal matrices are positive definite (C. de Boor, *A Practical Guide to
//! Splines*, chapter XIII). Zeros outside the band stay zero.

use glam::DVec4;

use super::work_blocks::row_ranges;
use crate::error::Result;
use crate::progress::InterruptCheck;

/// A matrix is singular if a pivot is smaller than this fraction of its largest entry.
const SINGULAR_PIVOT: f64 = 1e-14;

/// A square matrix whose entries lie at most `half_bandwidth` columns from the diagonal.
#[derive(Clone, Debug)]
pub(super) struct BandedMatrix {
    size: usize,
    half_bandwidth: usize,
    /// Row i stores the columns from `i - half_bandwidth` to `i + half_bandwidth`.
    entries: Vec<f64>,
}

impl BandedMatrix {
    /// A matrix of zeros.
    pub(super) fn new(size: usize, half_bandwidth: usize) -> Self {
        Self { size, half_bandwidth, entries: vec![0.0; size * (2 * half_bandwidth + 1)] }
    }

    fn at(&self, i: usize, j: usize) -> usize {
        i * (2 * self.half_bandwidth + 1) + j + self.half_bandwidth - i
    }

    /// Adds a value to the entry in row i and column j.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let at = self.at(i, j);
        self.entries[at] += value;
    }

    /// Solves in place for `width` right-hand sides, stored row by row in `rows`.
    ///
    /// Costs O(size · b · (b + width)) for half bandwidth b. Returns `Ok(false)` if the matrix is
    /// singular.
    pub(super) fn solve(
        mut self,
        rows: &mut [DVec4],
        width: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<bool> {
        let largest = self.entries.iter().fold(0.0_f64, |max, entry| max.max(entry.abs()));
        let (n, half_bandwidth) = (self.size, self.half_bandwidth);
        for range in row_ranges(n, width) {
            check_interrupt()?;
            for k in range {
                let pivot = self.entries[self.at(k, k)];
                if pivot.is_nan() || pivot.abs() <= SINGULAR_PIVOT * largest {
                    return Ok(false);
                }
                for i in k + 1..n.min(k + half_bandwidth + 1) {
                    let factor = self.entries[self.at(i, k)] / pivot;
                    if factor == 0.0 {
                        continue;
                    }
                    for j in k + 1..n.min(k + half_bandwidth + 1) {
                        self.add(i, j, -factor * self.entries[self.at(k, j)]);
                    }
                    subtract(rows, width, i, k, factor);
                }
            }
        }
        for range in row_ranges(n, width) {
            check_interrupt()?;
            for k in range.map(|behind| n - 1 - behind) {
                for j in k + 1..n.min(k + half_bandwidth + 1) {
                    subtract(rows, width, k, j, self.entries[self.at(k, j)]);
                }
                let scale = self.entries[self.at(k, k)].recip();
                rows[k * width..(k + 1) * width].iter_mut().for_each(|value| *value *= scale);
            }
        }
        Ok(true)
    }
}

/// Subtracts `factor` times row `row` from row `from`.
fn subtract(rows: &mut [DVec4], width: usize, from: usize, row: usize, factor: f64) {
    let (low, high) = rows.split_at_mut(from.max(row) * width);
    let (target, source) = if from > row {
        (&mut high[..width], &low[row * width..][..width])
    } else {
        (&mut low[from * width..][..width], &high[..width])
    };
    for (target, source) in target.iter_mut().zip(source) {
        *target -= factor * *source;
    }
}

/// A square matrix whose band wraps around from the last column to the first.
///
/// The last `half_bandwidth` unknowns are eliminated by their Schur complement; the rest is banded.
#[derive(Clone, Debug)]
pub(super) struct CyclicBandedMatrix {
    size: usize,
    half_bandwidth: usize,
    /// (row, column, value); entries at the same place are added.
    entries: Vec<(usize, usize, f64)>,
}

impl CyclicBandedMatrix {
    /// A matrix of zeros.
    pub(super) fn new(size: usize, half_bandwidth: usize) -> Self {
        Self { size, half_bandwidth, entries: Vec::new() }
    }

    /// Adds a value to the entry in row i and column j.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        self.entries.push((i % self.size, j % self.size, value));
    }

    /// Solves in place; see [`BandedMatrix::solve`].
    pub(super) fn solve(
        self,
        rows: &mut [DVec4],
        width: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<bool> {
        let corner = self.half_bandwidth.min(self.size);
        let inner = self.size - corner;
        let mut band = BandedMatrix::new(inner, self.half_bandwidth);
        // The columns of the corner block are extra right-hand sides, four to a vector.
        let extra = corner.div_ceil(4);
        let mut sides = vec![DVec4::ZERO; inner * (width + extra)];
        for range in row_ranges(inner, width) {
            check_interrupt()?;
            for i in range {
                let side = &mut sides[i * (width + extra)..][..width];
                side.copy_from_slice(&rows[i * width..][..width]);
            }
        }
        let mut below = vec![0.0; corner * self.size];
        for (i, j, value) in self.entries {
            match (i < inner, j < inner) {
                (true, true) => band.add(i, j, value),
                (true, false) => {
                    let column = j - inner;
                    sides[i * (width + extra) + width + column / 4][column % 4] += value;
                }
                (false, _) => below[(i - inner) * self.size + j] += value,
            }
        }
        if !band.solve(&mut sides, width + extra, check_interrupt)? {
            return Ok(false);
        }
        let side = |i: usize| &sides[i * (width + extra)..][..width + extra];
        // The Schur complement of the inner unknowns.
        let mut small = BandedMatrix::new(corner, corner);
        let mut last = rows[inner * width..].to_vec();
        for row in 0..corner {
            check_interrupt()?;
            let below = &below[row * self.size..][..self.size];
            for column in 0..corner {
                let inside: f64 =
                    (0..inner).map(|i| below[i] * side(i)[width + column / 4][column % 4]).sum();
                small.add(row, column, below[inner + column] - inside);
            }
            for (i, factor) in below[..inner].iter().enumerate().filter(|(_, f)| **f != 0.0) {
                for (value, inside) in last[row * width..].iter_mut().zip(&side(i)[..width]) {
                    *value -= *factor * *inside;
                }
            }
        }
        if !small.solve(&mut last, width, check_interrupt)? {
            return Ok(false);
        }
        for range in row_ranges(inner, width) {
            check_interrupt()?;
            for i in range {
                let row = &mut rows[i * width..][..width];
                row.copy_from_slice(&side(i)[..width]);
                for column in 0..corner {
                    let factor = side(i)[width + column / 4][column % 4];
                    for (value, known) in row.iter_mut().zip(&last[column * width..]) {
                        *value -= factor * *known;
                    }
                }
            }
        }
        rows[inner * width..].copy_from_slice(&last);
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_open_and_cyclic_systems() {
        let (size, half_bandwidth, width) = (17, 3, 2);
        let entry = |i: usize, j: usize| if i == j { 9.0 } else { (1 + (3 * i + j) % 4) as f64 };
        let expected: Vec<DVec4> =
            (0..size * width).map(|i| DVec4::new(i as f64, 1.0, -(i as f64).sin(), 0.0)).collect();
        for wrapped in [false, true] {
            let (mut open, mut cyclic) = (
                BandedMatrix::new(size, half_bandwidth),
                CyclicBandedMatrix::new(size, half_bandwidth),
            );
            let mut rows = vec![DVec4::ZERO; size * width];
            for i in 0..size {
                for j in i + size - half_bandwidth..=i + size + half_bandwidth {
                    if !wrapped && !(size..2 * size).contains(&j) {
                        continue;
                    }
                    let column = j % size;
                    cyclic.add(i, j, entry(i, column));
                    if !wrapped {
                        open.add(i, column, entry(i, column));
                    }
                    for c in 0..width {
                        rows[i * width + c] += entry(i, column) * expected[column * width + c];
                    }
                }
            }
            let check = |solved: &[DVec4]| {
                let error = solved.iter().zip(&expected).map(|(a, b)| a.distance(*b));
                assert!(error.fold(0.0, f64::max) < 1e-12);
            };
            let mut solved = rows.clone();
            assert!(cyclic.solve(&mut solved, width, &mut || Ok(())).unwrap());
            check(&solved);
            if !wrapped {
                assert!(open.solve(&mut rows, width, &mut || Ok(())).unwrap());
                check(&rows);
            }
        }
    }

    #[test]
    fn singular_matrices_are_detected() {
        let mut matrix = BandedMatrix::new(3, 1);
        matrix.add(0, 0, 1.0);
        matrix.add(2, 2, 1.0);
        assert!(!matrix.solve(&mut [DVec4::ONE; 3], 1, &mut || Ok(())).unwrap());
    }
}
