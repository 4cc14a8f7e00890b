//! Bézier triangles: the order of their coefficients, and bounds by repeated halving.
//!
//! Coefficients are sorted by their multi-index: its first entry, then its second.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use pulp::Simd;

use super::bernstein::binomial;
use super::distance_bound::{DistanceBound, max_bound_of_batches};
use super::lanes::{PointBatch, larger, point};
use super::sparse_matrix::SparseMatrix;

/// The largest number of halvings that a [`Refinement`] may use.
const MAX_HALVINGS: usize = 8;

/// All multi-indices (i, j, k) with i + j + k = degree, in the order of coefficients.
pub(super) fn multi_indices(degree: usize) -> Vec<[usize; 3]> {
    let pairs = (0..=degree).flat_map(|a| (0..=degree - a).map(move |b| (a, b)));
    pairs.map(|(a, b)| [a, b, degree - a - b]).collect()
}

/// The place of a multi-index among [`multi_indices`] of its degree.
pub(super) fn coefficient_index([a, b, c]: [usize; 3]) -> usize {
    let degree = a + b + c;
    a * (2 * degree + 3 - a) / 2 + b
}

/// Number of coefficients.
pub(super) fn coefficient_count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// When a bound by a triangle's coefficients is refined by halving the triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refinement {
    /// Bounds up to this one need no refinement.
    pub limit: f64,
    /// Bounds above this one are not refined.
    pub max_refined: f64,
    /// How often a triangle is halved at most.
    pub halvings: usize,
}

/// The matrices from a triangle's coefficients to those of its halves.
///
/// The cut goes from the first corner to the midpoint of the opposite side (de Casteljau's
/// algorithm along the rows). The first corner of each half is that midpoint, so the next cut meets
/// another side.
pub(super) fn halving_matrices(degree: usize) -> [SparseMatrix; 2] {
    let none = || vec![vec![]; coefficient_count(degree)];
    let (mut first, mut second) = (none(), none());
    let mut from = 0;
    for apex in 0..=degree {
        // The midpoint has multiplicity `level`, the first corner multiplicity `apex`.
        let (n, mut at) = (degree - apex, apex);
        for level in 0..=n {
            let share = |k: usize| binomial(level, k) / 2.0_f64.powf(level as f64);
            first[at] = (0..=level).map(|k| (from + k, share(k))).collect();
            second[at] = (0..=level).map(|k| (from + n - level + k, share(k))).collect();
            at += degree + 1 - level;
        }
        from += n + 1;
    }
    [SparseMatrix::new(&first), SparseMatrix::new(&second)]
}

/// An upper bound of the distance of a Bézier triangle.
///
/// A result above `limit` means only that the limit could not be certified.
///
/// The bound is convex, so the largest bound of the coefficients holds for all points. If it
/// exceeds the limit by little, the triangle is halved. `coefficients` starts with those of the
/// triangle, followed by space for as many at each halving.
#[inline(always)]
pub(super) fn max_bound_by_halving<S: Simd>(
    simd: S,
    coefficients: &mut [PointBatch],
    halves: &[SparseMatrix; 2],
    Refinement { limit, max_refined, halvings }: Refinement,
    bound: &impl DistanceBound,
) -> f64 {
    let size = halves[0].batches();
    // seen[k]: visited halves of the enclosing triangle at level k.
    let (mut most, mut level, mut seen) = (0.0, 0, [0; MAX_HALVINGS]);
    loop {
        let found = max_bound_of_batches(simd, bound, &coefficients[level * size..][..size]);
        if found <= limit {
            most = larger(most, found);
            while level > 0 && seen[level - 1] == 2 {
                level -= 1;
            }
            if level == 0 {
                return most;
            }
        } else if found > max_refined || level == halvings.min(MAX_HALVINGS) {
            return found;
        } else {
            seen[level] = 0;
            level += 1;
        }
        let (parent, half) = coefficients.split_at_mut(level * size);
        let parent = &parent[(level - 1) * size..];
        halves[seen[level - 1]].multiply(simd, |k| point(parent, k), &mut half[..size]);
        seen[level - 1] += 1;
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::super::lanes::{BATCH, Batch};
    use super::*;

    /// The distance from the plane z = 0.
    struct Height;

    impl DistanceBound for Height {
        fn squared<S: Simd>(&self, simd: S, [_, _, z]: [S::f64s; 3]) -> S::f64s {
            simd.mul_f64s(z, z)
        }
    }

    /// A bound of the height of the cubic function.
    struct MaxHeight(Refinement);

    impl WithSimd for MaxHeight {
        type Output = f64;

        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            let mut all = cubic();
            all.resize(9 * all.len(), [Batch::default(); 4]);
            max_bound_by_halving(simd, &mut all, &halving_matrices(3), self.0, &Height)
        }
    }

    /// The coefficients of the cubic function's halves.
    struct Halves;

    impl WithSimd for Halves {
        type Output = [Vec<PointBatch>; 2];

        fn with_simd<S: Simd>(self, simd: S) -> [Vec<PointBatch>; 2] {
            let of = cubic();
            halving_matrices(3).map(|half| {
                let mut out = cubic();
                half.multiply(simd, |k| point(&of, k), &mut out);
                out
            })
        }
    }

    /// A coefficient of a cubic function.
    fn height(k: usize) -> f64 {
        (1.7 * k as f64).sin()
    }

    /// All coefficients, of weight one; the last one is repeated to complete the last batch.
    fn cubic() -> Vec<PointBatch> {
        let last = coefficient_count(3) - 1;
        let heights =
            |batch: usize| std::array::from_fn(|lane| height((batch * BATCH + lane).min(last)));
        let zero = Batch::default();
        (0..2).map(|batch| [zero, zero, Batch(heights(batch)), Batch([1.0; BATCH])]).collect()
    }

    #[test]
    fn indices_of_coefficients_follow_their_order() {
        for degree in [0, 1, 5, 50] {
            for (place, index) in multi_indices(degree).into_iter().enumerate() {
                assert_eq!(coefficient_index(index), place);
            }
        }
    }

    #[test]
    fn halves_share_the_midpoint_of_a_side() {
        let middle = (height(0) + 3.0 * height(1) + 3.0 * height(2) + height(3)) / 8.0;
        let parts = Arch::new().dispatch(Halves);
        for (half, other) in parts.iter().zip([0, 3]) {
            let heights = [0, 3, 9].map(|k| point(half, k)[2]);
            assert!((heights[2] - middle).abs() < 1e-15);
            let (first, second) = if other == 0 { (0, 9) } else { (3, 9) };
            assert_eq!((heights[0], heights[1]), (height(first), height(second)));
        }
    }

    #[test]
    fn halving_lowers_the_bound_towards_the_maximum() {
        let max_height = |limit: f64, halvings: usize| {
            Arch::new().dispatch(MaxHeight(Refinement { limit, max_refined: 9.0, halvings }))
        };
        // The maximum, sampled on a fine grid.
        let mut most = 0.0_f64;
        for (i, j) in (0..=60).flat_map(|i| (0..=60 - i).map(move |j| (i, j))) {
            let at = [i, j, 60 - i - j].map(|n| f64::from(n) / 60.0);
            let ways = |of: &[usize; 3]| match of.iter().max() {
                Some(3) => 1.0,
                Some(2) => 3.0,
                _ => 6.0,
            };
            let powers =
                |of: &[usize; 3]| (0..3).map(|k| at[k].powf(of[k] as f64)).product::<f64>();
            let terms = multi_indices(3).into_iter().enumerate();
            let value: f64 = terms.map(|(k, of)| ways(&of) * powers(&of) * height(k)).sum();
            most = most.max(value.abs());
        }
        let (rough, fine) = (max_height(f64::MAX, 0), max_height(1.01 * most, 8));
        assert!(most <= fine && fine < rough, "{most} {fine} {rough}");
        assert!(fine <= 1.01 * most);
    }
}
