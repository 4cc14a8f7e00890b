//! Symmetric positive definite band matrices in square tiles: Cholesky factorization, and the
//! inverse within the band.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve as triangular;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::sizes::POINTS_PER_TASK;
use crate::nurbs::window;

/// Sides of tiles for narrow and for wide bands. Small tiles store fewer zeros, large ones use the
/// processor better.
const TILES: [usize; 2] = [32, 64];

/// Half bandwidth from which on tiles are large, and threads share the updates of a column.
const WIDE: usize = 256;

/// Rows that stay in registers. Reading and writing them for each column takes several times as
/// long.
pub(super) const ROWS: usize = 8;

/// The lower half of a symmetric band matrix, or its Cholesky factor.
#[derive(Clone, Debug)]
pub(super) struct BandMatrix {
    size: usize,
    /// Half bandwidth: the largest distance of an entry from the diagonal.
    width: usize,
    /// Side of a tile, a power of two.
    side: usize,
    /// Tiles in a column: the diagonal one and those below it.
    column_tiles: usize,
    /// Tiles down each column; tiles are column-major.
    values: Vec<f64>,
}

impl BandMatrix {
    /// A zero matrix whose entries (i, j) will have `|i - j| <= width`. It reuses the memory of
    /// `spare`, since allocation takes a quarter of the time of the factorization.
    pub(super) fn new(size: usize, width: usize, spare: Option<Self>) -> Self {
        let side = TILES[usize::from(width >= WIDE)];
        let columns = size.div_ceil(side);
        let column_tiles = (1 + width.div_ceil(side)).min(columns);
        let length = columns * column_tiles * side * side;
        let mut values = spare.map_or_else(Vec::new, |spare| spare.values);
        if values.capacity() < length {
            values = Vec::with_capacity(length);
        }
        values.clear();
        values.resize(length, 0.0);
        let mut band = Self { size, width, side, column_tiles, values };
        band.set_padding();
        band
    }

    /// Sets the diagonal beyond the matrix to 1, so that the last tile needs no special case.
    fn set_padding(&mut self) {
        for i in self.size..self.columns() * self.side {
            let at = self.index(i, i);
            self.values[at] = 1.0;
        }
    }

    pub(super) fn size(&self) -> usize {
        self.size
    }

    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// Columns of tiles.
    pub(super) fn columns(&self) -> usize {
        self.size.div_ceil(self.side)
    }

    /// The tiles of a column, from the diagonal one down.
    pub(super) fn tiles(&self, col: usize) -> impl Iterator<Item = &[f64]> {
        let tiles =
            self.values[col * self.column_tiles * self.tile_len()..].chunks(self.tile_len());
        tiles.take(self.column_tiles.min(self.columns() - col))
    }

    fn tile_len(&self) -> usize {
        self.side * self.side
    }

    /// The rows within the band, of the tile `below` tiles under the diagonal one.
    pub(super) fn rows_inside(&self, below: usize) -> usize {
        (self.width + self.side).saturating_sub(below * self.side).min(self.side)
    }

    /// The index of an entry on or below the diagonal.
    #[inline]
    fn index(&self, row: usize, col: usize) -> usize {
        // Shifts instead of divisions halve the time of filling a matrix.
        let (shift, mask) = (self.side.trailing_zeros(), self.side - 1);
        let (tile_row, tile_col) = (row >> shift, col >> shift);
        let tile = tile_col * self.column_tiles + tile_row - tile_col;
        (((tile << shift) + (col & mask)) << shift) + (row & mask)
    }

    /// Adds to the entries (i, j) and (j, i).
    #[inline]
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        let at = self.index(i.max(j), i.min(j));
        self.values[at] += value;
    }

    /// The entry (i, j).
    #[inline]
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        self.values[self.index(i.max(j), i.min(j))]
    }

    /// Adds a symmetric block to the rows from 3 i and the columns from 3 j on, and its transpose.
    /// Values are those of the pairs 00, 01, 02, 11, 12 and 22.
    #[inline]
    pub(super) fn add_block(&mut self, i: usize, j: usize, [a, b, c, d, e, f]: [f64; 6]) {
        let (row, col) = (3 * i.max(j), 3 * i.min(j));
        let columns = [[a, b, c], [b, d, e], [c, e, f]];
        let last = self.side - columns.len();
        let inside = |at: usize| (at & (self.side - 1)) <= last;
        if i != j && inside(row) && inside(col) {
            // Most blocks lie in one tile.
            let at = self.index(row, col);
            for (k, column) in columns.iter().enumerate() {
                let sums = &mut self.values[at + k * self.side..][..3];
                sums.iter_mut().zip(column).for_each(|(sum, value)| *sum += value);
            }
            return;
        }
        for (col, column) in (col..).zip(columns) {
            // On the diagonal, only the lower half is stored.
            let first = row.max(col);
            let (at, left) = (self.index(first, col), self.side - (first & (self.side - 1)));
            for (k, value) in column.iter().skip(first - row).enumerate() {
                let at = if k < left { at + k } else { self.index(first + k, col) };
                self.values[at] += value;
            }
        }
    }

    /// Adds `factor` times another matrix of the same size and width.
    pub(super) fn add_scaled(&mut self, factor: f64, other: &Self) {
        debug_assert_eq!(self.values.len(), other.values.len());
        self.values
            .par_iter_mut()
            .with_min_len(POINTS_PER_TASK)
            .zip(&other.values)
            .for_each(|(sum, value)| *sum += factor * value);
        self.set_padding();
    }

    /// The entries that are not 0, with their indices in a matrix like `other` of three coordinates
    /// for each row, once for each coordinate.
    pub(super) fn for_each_axis(&self, other: &Self) -> Vec<(usize, f64)> {
        let mut entries = Vec::new();
        for col in 0..self.size {
            for row in col..self.end_of_column(col) {
                let value = self.values[self.index(row, col)];
                if value != 0.0 {
                    let at = |axis| other.index(3 * row + axis, 3 * col + axis);
                    entries.extend((0..3).map(|axis| (at(axis), value)));
                }
            }
        }
        entries
    }

    /// Adds `factor` times entries at their indices.
    pub(super) fn add_entries(&mut self, factor: f64, entries: &[(usize, f64)]) {
        for (at, value) in entries {
            self.values[*at] += factor * value;
        }
    }

    /// The row after the last one in the tiles of a column.
    fn end_of_column(&self, col: usize) -> usize {
        ((col / self.side + self.column_tiles) * self.side).min(self.size)
    }

    pub(super) fn trace(&self) -> f64 {
        (0..self.size).map(|i| self.values[self.index(i, i)]).sum()
    }

    /// Adds a share of the mean diagonal entry to the diagonal.
    pub(super) fn add_ridge(&mut self, share: f64) {
        let ridge = share * self.trace() / self.size as f64;
        (0..self.size).for_each(|i| self.add(i, i, ridge));
    }

    /// The sum of the products of all entries with those of another matrix: the trace of the
    /// product. The diagonal tiles of `other` contain only the lower half.
    pub(super) fn inner_product(&self, other: &Self) -> f64 {
        let (tile, side) = (self.tile_len(), self.side);
        let tiles = self.values.chunks(tile).zip(other.values.chunks(tile)).enumerate();
        let products = tiles.map(|(number, (a, b))| {
            let (col, below) = (number / self.column_tiles, number % self.column_tiles);
            let inside = (self.size.saturating_sub(col * side)).min(side);
            let twice = 2.0 * dot(&a[..inside * side], &b[..inside * side]);
            let diagonal = (0..inside).map(|j| j * side + j).filter(|_| below == 0);
            twice - diagonal.map(|at| a[at] * b[at]).sum::<f64>()
        });
        products.sum()
    }

    /// Replaces the matrix by its Cholesky factor, tile by tile (right-looking). `check` is called
    /// before each column of tiles and may stop it. `Ok(false)` if the matrix is not positive
    /// definite. Each tile is computed by one task, so the number of threads does not change a bit.
    pub(super) fn factor<E>(
        &mut self,
        check: &mut dyn FnMut() -> Result<(), E>,
    ) -> Result<bool, E> {
        let (side, column_tiles, tile, columns) =
            (self.side, self.column_tiles, self.tile_len(), self.columns());
        let inside: Vec<usize> = (1..column_tiles).map(|below| self.rows_inside(below)).collect();
        for j in 0..columns {
            check()?;
            let (own, later) =
                self.values[j * column_tiles * tile..].split_at_mut(column_tiles * tile);
            let (diagonal, panel) = own.split_at_mut(tile);
            if !Arch::new().dispatch(TileFactor { values: &mut *diagonal, side }) {
                return Ok(false);
            }
            let below = (columns - 1 - j).min(column_tiles - 1);
            let panel = &mut panel[..below * tile];
            let lower = MatRef::from_column_major_slice(diagonal, side, side);
            let solve = |(row, panel): (usize, &mut [f64])| {
                // X Lᵀ = A is L Xᵀ = Aᵀ.
                let panel = MatMut::from_column_major_slice_mut(panel, side, side);
                let panel = panel.subrows_mut(0, inside[row]);
                triangular::solve_lower_triangular_in_place(lower, panel.transpose_mut(), Par::Seq);
            };
            let panel_ref: &[f64];
            let update = |(number, target): (usize, &mut [f64]), panel: &[f64]| {
                // Tile (row, col), relative to the next column.
                let (col, row) =
                    (number / column_tiles, number / column_tiles + number % column_tiles);
                if row < below {
                    let at = |k: usize| {
                        let panel = &panel[k * tile..][..tile];
                        MatRef::from_column_major_slice(panel, side, side).subrows(0, inside[k])
                    };
                    let target = MatMut::from_column_major_slice_mut(target, side, side);
                    let target = target.submatrix_mut(0, 0, inside[row], inside[col]);
                    matmul(target, Accum::Add, at(row), at(col).transpose(), -1.0, Par::Seq);
                }
            };
            let later = &mut later[..below * column_tiles * tile];
            if below * side >= WIDE {
                panel.par_chunks_mut(tile).enumerate().for_each(solve);
                panel_ref = panel;
                let tiles = later.par_chunks_mut(tile).enumerate();
                tiles.for_each(|target| update(target, panel_ref));
            } else {
                panel.chunks_mut(tile).enumerate().for_each(solve);
                panel_ref = panel;
                later.chunks_mut(tile).enumerate().for_each(|target| update(target, panel_ref));
            }
        }
        Ok(true)
    }

    /// The entries of the inverse within the band, from this factor (K. Takahashi, J. Fagan, M.
    /// Chin, *Formation of a sparse bus impedance matrix*, 1973; for smoothing splines M.
    /// Hutchinson and F. de Hoog, *Smoothing noisy data with spline functions*, 1985).
    pub(super) fn inverse(&self) -> Self {
        let (side, column_tiles, tile, columns) =
            (self.side, self.column_tiles, self.tile_len(), self.columns());
        let mut inverse = Self { values: vec![0.0; self.values.len()], ..*self };
        let mut scaled = vec![0.0; column_tiles * tile];
        let inside: Vec<usize> = (1..column_tiles).map(|below| self.rows_inside(below)).collect();
        for j in (0..columns).rev() {
            let column = &self.values[j * column_tiles * tile..][..column_tiles * tile];
            let lower = MatRef::from_column_major_slice(&column[..tile], side, side);
            let below = (columns - 1 - j).min(column_tiles - 1);
            let (own, later) =
                inverse.values[j * column_tiles * tile..].split_at_mut(column_tiles * tile);
            let (diagonal, panel) = own.split_at_mut(tile);
            // W = L(i, j) L(j, j)⁻¹, by its transpose.
            for i in 0..below {
                let w = &mut scaled[i * tile..][..tile];
                w.copy_from_slice(&column[(i + 1) * tile..][..tile]);
                let w = MatMut::from_column_major_slice_mut(w, side, side);
                let w = w.subrows_mut(0, inside[i]).transpose_mut();
                triangular::solve_upper_triangular_in_place(lower.transpose(), w, Par::Seq);
            }
            let w = |i: usize| {
                let w = &scaled[i * tile..][..tile];
                MatRef::from_column_major_slice(w, side, side).subrows(0, inside[i])
            };
            for i in 0..below {
                let target = &mut panel[i * tile..][..tile];
                for l in 0..below {
                    let (row, col) = (i.max(l), i.min(l));
                    let known = &later[(col * column_tiles + row - col) * tile..][..tile];
                    let known = MatRef::from_column_major_slice(known, side, side);
                    let known = if i >= l { known } else { known.transpose() };
                    let known = known.submatrix(0, 0, inside[i], inside[l]);
                    let target = MatMut::from_column_major_slice_mut(&mut *target, side, side);
                    let target = target.subrows_mut(0, inside[i]);
                    matmul(target, Accum::Add, known, w(l), -1.0, Par::Seq);
                }
            }
            for k in 0..side {
                diagonal[k * side + k] = 1.0;
            }
            let mut target = MatMut::from_column_major_slice_mut(diagonal, side, side);
            triangular::solve_lower_triangular_in_place(lower, target.as_mut(), Par::Seq);
            triangular::solve_upper_triangular_in_place(
                lower.transpose(),
                target.as_mut(),
                Par::Seq,
            );
            for i in 0..below {
                let known = MatRef::from_column_major_slice(&panel[i * tile..][..tile], side, side);
                let known = known.subrows(0, inside[i]);
                matmul(target.as_mut(), Accum::Add, known.transpose(), w(i), -1.0, Par::Seq);
            }
        }
        inverse
    }
}

/// The scalar product.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; ROWS];
    for (a, b) in a.as_chunks::<ROWS>().0.iter().zip(b.as_chunks::<ROWS>().0) {
        (0..ROWS).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum()
}

/// Replaces one tile by its Cholesky factor, with zeros above the diagonal. False if it is not
/// positive definite.
struct TileFactor<'a> {
    values: &'a mut [f64],
    side: usize,
}

impl WithSimd for TileFactor<'_> {
    type Output = bool;

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { values, side } = self;
        for j in 0..side {
            let (before, rest) = values.split_at_mut(j * side);
            let column = &mut rest[..side];
            // Several rows at a time stay in registers. Those above the diagonal become zero.
            let above = j - j % ROWS;
            for (number, rows) in column[above..].as_chunks_mut::<ROWS>().0.iter_mut().enumerate() {
                let mut left = *rows;
                for known in before.chunks(side) {
                    let (factor, known) = (known[j], window(known, above + number * ROWS));
                    for (value, known) in left.iter_mut().zip::<&[f64; ROWS]>(known) {
                        *value -= factor * known;
                    }
                }
                *rows = left;
            }
            column[..j].fill(0.0);
            let pivot = column[j];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            let scale = pivot.sqrt();
            column[j..].iter_mut().for_each(|value| *value /= scale);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonally dominant, thus positive definite, band matrix.
    fn matrix(size: usize, width: usize) -> BandMatrix {
        let mut band = BandMatrix::new(size, width, None);
        for i in 0..size {
            band.add(i, i, 2.0 * width as f64);
            for j in i.saturating_sub(width)..i {
                band.add(i, j, ((i * 7 + j * 3) as f64).sin());
            }
        }
        band
    }

    /// The matrix times vectors.
    fn times<const WIDTH: usize>(band: &BandMatrix, x: &[[f64; WIDTH]]) -> Vec<[f64; WIDTH]> {
        let mut result = vec![[0.0; WIDTH]; band.size];
        for col in 0..band.size {
            for row in col..band.end_of_column(col) {
                let value = band.values[band.index(row, col)];
                for k in 0..WIDTH {
                    result[row][k] += value * x[col][k];
                    if row != col {
                        result[col][k] += value * x[row][k];
                    }
                }
            }
        }
        result
    }

    fn factored(size: usize, width: usize) -> BandMatrix {
        let mut factor = matrix(size, width);
        assert!(factor.factor::<()>(&mut || Ok(())).unwrap());
        factor
    }

    #[test]
    fn solutions_satisfy_the_system() {
        for (size, width) in [(5, 4), (100, 17), (300, 120), (700, 300)] {
            let x: Vec<[f64; 2]> = (0..size).map(|i| [(i as f64).cos(), (i % 7) as f64]).collect();
            let mut got = times(&matrix(size, width), &x);
            factored(size, width).solve(&mut got);
            for (got, x) in got.iter().zip(&x) {
                assert!((got[0] - x[0]).abs() < 1e-12 && (got[1] - x[1]).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn the_inverse_in_the_band_matches_solutions_for_unit_vectors() {
        for (size, width) in [(7, 3), (150, 40)] {
            let factor = factored(size, width);
            let inverse = factor.inverse();
            for col in [0, size / 2, size - 1] {
                let mut unit = vec![[0.0]; size];
                unit[col] = [1.0];
                factor.solve(&mut unit);
                for (row, value) in unit.iter().enumerate() {
                    if row.abs_diff(col) <= width {
                        let got = inverse.values[inverse.index(row.max(col), row.min(col))];
                        assert!((got - value[0]).abs() < 1e-14, "{row} {col}");
                    }
                }
            }
            let trace = inverse.inner_product(&matrix(size, width));
            assert!((trace - size as f64).abs() < 1e-9, "{trace}");
        }
    }

    #[test]
    fn blocks_equal_their_entries() {
        let metric = [[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]];
        let (mut by_blocks, mut by_entries) =
            (BandMatrix::new(120, 50, None), BandMatrix::new(120, 50, None));
        for (i, j) in [(0, 0), (10, 10), (10, 13), (21, 10), (39, 39)] {
            by_blocks.add_block(i, j, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
            for (r, s) in (0..9).map(|k| (k / 3, k % 3)).filter(|(r, s)| i != j || r >= s) {
                by_entries.add(3 * i + r, 3 * j + s, metric[r][s]);
            }
        }
        assert_eq!(by_blocks.values, by_entries.values);
    }

    #[test]
    fn indefinite_matrices_are_refused() {
        let mut band = matrix(40, 5);
        band.add(20, 20, -30.0);
        assert!(!band.factor::<()>(&mut || Ok(())).unwrap());
    }
}
