//! Solution of band systems: forward and back substitution with a Cholesky factor.

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::band_matrix::{BandMatrix, ROWS};
use crate::nurbs::window;

impl BandMatrix {
    /// Solves L Lᵀ x = b for `WIDTH` right-hand sides, where this is the factor L.
    pub(super) fn solve<const WIDTH: usize>(&self, x: &mut [[f64; WIDTH]]) {
        debug_assert_eq!(x.len(), self.size());
        // As long as the tiles.
        let mut whole = vec![[0.0; WIDTH]; self.columns() * self.side()];
        whole[..self.size()].copy_from_slice(x);
        Arch::new().dispatch(Substitution { factor: self, x: &mut whole });
        x.copy_from_slice(&whole[..self.size()]);
    }

    /// The solution for points whose coordinates are coupled, three rows for each.
    pub(super) fn solved_together(&self, right: &[[f64; 3]]) -> Vec<DVec3> {
        let mut x: Vec<[f64; 1]> = right.as_flattened().iter().map(|&value| [value]).collect();
        self.solve(&mut x);
        x.as_flattened().as_chunks().0.iter().copied().map(DVec3::from_array).collect()
    }
}

/// A substitution in whole tiles.
struct Substitution<'a, const WIDTH: usize> {
    factor: &'a BandMatrix,
    x: &'a mut [[f64; WIDTH]],
}

impl<const WIDTH: usize> WithSimd for Substitution<'_, WIDTH> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { factor, x } = self;
        let (side, columns) = (factor.side(), factor.columns());
        let inside = |below: usize| factor.rows_inside(below).next_multiple_of(ROWS);
        // L y = b.
        for col in 0..columns {
            let (own, later) = x[col * side..].split_at_mut(side);
            let mut tiles = factor.tiles(col).enumerate();
            let Some((_, diagonal)) = tiles.next() else { break };
            for (j, column) in diagonal.chunks(side).enumerate() {
                own[j] = own[j].map(|value| value / column[j]);
                let (known, below) = own[j..].split_at_mut(1);
                for (x, value) in below.iter_mut().zip(&column[j + 1..]) {
                    (0..WIDTH).for_each(|k| x[k] -= value * known[0][k]);
                }
            }
            for (below, tile) in tiles {
                let target = &mut later[(below - 1) * side..][..inside(below)];
                subtract_product(tile, own, target);
            }
        }
        // Lᵀ x = y: the tiles of a column from below, the diagonal one last.
        for col in (0..columns).rev() {
            let (own, later) = x[col * side..].split_at_mut(side);
            let tiles: Vec<&[f64]> = factor.tiles(col).collect();
            for (below, tile) in tiles.iter().enumerate().skip(1).rev() {
                let known = &later[(below - 1) * side..][..inside(below)];
                for (x, column) in own.iter_mut().zip(tile.chunks(side)) {
                    let sum = product(&column[..known.len()], known);
                    (0..WIDTH).for_each(|k| x[k] -= sum[k]);
                }
            }
            for (j, column) in tiles[0].chunks(side).enumerate().rev() {
                let sum = product(&column[j + 1..], &own[j + 1..]);
                own[j] = std::array::from_fn(|k| (own[j][k] - sum[k]) / column[j]);
            }
        }
    }
}

/// Subtracts the product of a tile's first rows with vectors.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn subtract_product<const WIDTH: usize>(
    tile: &[f64],
    known: &[[f64; WIDTH]],
    target: &mut [[f64; WIDTH]],
) {
    for (number, target) in target.as_chunks_mut::<ROWS>().0.iter_mut().enumerate() {
        let mut left = *target;
        for (column, known) in tile.chunks(known.len()).zip(known) {
            let column: &[f64; ROWS] = window(column, number * ROWS);
            for (left, value) in left.iter_mut().zip(column) {
                (0..WIDTH).for_each(|k| left[k] -= value * known[k]);
            }
        }
        *target = left;
    }
}

/// The sum of numbers times vectors, in four independent parts.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn product<const WIDTH: usize>(numbers: &[f64], vectors: &[[f64; WIDTH]]) -> [f64; WIDTH] {
    let mut sums = [[0.0; WIDTH]; 4];
    let ((numbers, rest), (vectors, others)) = (numbers.as_chunks::<4>(), vectors.as_chunks::<4>());
    for (numbers, vectors) in numbers.iter().zip(vectors) {
        for ((sum, number), vector) in sums.iter_mut().zip(numbers).zip(vectors) {
            (0..WIDTH).for_each(|k| sum[k] += number * vector[k]);
        }
    }
    for ((sum, number), vector) in sums.iter_mut().zip(rest).zip(others) {
        (0..WIDTH).for_each(|k| sum[k] += number * vector[k]);
    }
    std::array::from_fn(|k| sums.iter().map(|sum| sum[k]).sum())
}
