//! Sparse matrices that turn Bézier points into others, eight rows at a time.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use std::collections::BTreeMap;

use pulp::Simd;

use super::lanes::{BATCH, Batch};

/// A sparse matrix whose rows are stored in batches of eight with common columns.
#[derive(Clone, Debug, Default)]
pub(super) struct SparseMatrix {
    /// The columns with an entry in a batch of rows, batch by batch.
    columns: Vec<u32>,
    /// The eight entries of each of these columns.
    entries: Vec<Batch>,
    /// The end of each batch in `columns`.
    ends: Vec<usize>,
}

impl SparseMatrix {
    /// A matrix with these rows of (column, entry); entries of the same column are added.
    ///
    /// The last row is repeated to complete the last batch.
    pub(super) fn new(rows: &[Vec<(usize, f64)>]) -> Self {
        let mut this = Self::default();
        for rows in rows.chunks(BATCH) {
            let mut columns: BTreeMap<usize, Batch> = BTreeMap::new();
            for lane in 0..BATCH {
                let row = rows[lane.min(rows.len() - 1)].iter();
                for &(column, entry) in row.filter(|(_, entry)| *entry != 0.0) {
                    columns.entry(column).or_default().0[lane] += entry;
                }
            }
            this.columns
                .extend(columns.keys().map(|&column| u32::try_from(column).unwrap_or(u32::MAX)));
            this.entries.extend(columns.into_values());
            this.ends.push(this.columns.len());
        }
        this
    }

    /// Number of batches of rows.
    pub(super) fn batches(&self) -> usize {
        self.ends.len()
    }

    /// Multiplies the matrix with points; writes the first N coordinates of the products.
    #[inline(always)]
    pub(super) fn multiply<S: Simd, const N: usize>(
        &self,
        simd: S,
        point: impl Fn(usize) -> [f64; 4],
        out: &mut [[Batch; N]],
    ) {
        let mut from = 0;
        for (out, &end) in out.iter_mut().zip(&self.ends) {
            let terms = (&self.columns[from..end], &self.entries[from..end]);
            if S::F64_LANES == BATCH {
                multiply_batch::<S, N, 1>(simd, terms, &point, (out, 0));
            } else {
                for first in (0..BATCH / S::F64_LANES).step_by(2) {
                    multiply_batch::<S, N, 2>(simd, terms, &point, (out, first));
                }
            }
            from = end;
        }
    }
}

/// Writes `K` registers of the products of one batch of rows, starting with register `first`.
///
/// Each point is loaded once for all of them.
#[inline(always)]
fn multiply_batch<S: Simd, const N: usize, const K: usize>(
    simd: S,
    (columns, entries): (&[u32], &[Batch]),
    point: &impl Fn(usize) -> [f64; 4],
    (out, first): (&mut [Batch; N], usize),
) {
    let mut sums = [[simd.splat_f64s(0.0); N]; K];
    for (&column, entries) in columns.iter().zip(entries) {
        let (point, entries) = (point(column as usize), S::as_simd_f64s(&entries.0).0);
        for axis in 0..N {
            let coordinate = simd.splat_f64s(point[axis]);
            for (sums, entries) in sums.iter_mut().zip(&entries[first..first + K]) {
                sums[axis] = simd.mul_add_e_f64s(*entries, coordinate, sums[axis]);
            }
        }
    }
    for (k, sums) in sums.iter().enumerate() {
        for (out, sum) in out.iter_mut().zip(sums) {
            S::as_mut_simd_f64s(&mut out.0).0[first + k] = *sum;
        }
    }
}
