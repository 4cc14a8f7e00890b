//! Bézier coefficients on a triangle.
//!
//! They stand row by row: by how often the first corner counts, then the second.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::DVec4;
use pulp::Simd;

use super::cost::{Cost, costliest};

/// How often a triangle is halved at the very most.
const MOST_HALVINGS: usize = 8;

/// All triples of counts with this sum, in the order of coefficients.
pub(super) fn triples(sum: usize) -> Vec<[usize; 3]> {
    let pairs = (0..=sum).flat_map(|a| (0..=sum - a).map(move |b| (a, b)));
    pairs.map(|(a, b)| [a, b, sum - a - b]).collect()
}

/// The larger of two numbers, of which only the second may be NaN; unlike `f64::max` one instruction.
#[inline(always)]
pub(super) fn larger(most: f64, x: f64) -> f64 {
    if x > most { x } else { most }
}

/// How many coefficients there are.
fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// When a triangle's coefficients, whose largest cost bounds that of its points, are worth cutting.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// Costs up to this one are no doubt.
    pub limit: f64,
    /// Those from this one on leave none either.
    pub near: f64,
    /// How often a triangle is halved at most.
    pub halvings: usize,
}

/// The largest cost of a function's coefficients, or anything above the limit if a value costs more
/// than it. The cost is convex, so no value costs more than all coefficients. Where they leave doubt,
/// those of parts are looked at. The stack holds nothing but the coefficients.
#[inline(always)]
pub(super) fn largest<S: Simd>(
    simd: S,
    stack: &mut Vec<DVec4>,
    degree: usize,
    Doubt { limit, near, halvings }: Doubt,
    cost: &impl Cost,
) -> f64 {
    let size = count(degree);
    let (mut most, mut left) = (0.0, [0; MOST_HALVINGS + 1]);
    left[0] = halvings.min(MOST_HALVINGS);
    while let Some(start) = stack.len().checked_sub(size) {
        let triangle = &stack[start..];
        let found = costliest(simd, cost, triangle);
        let level = start / size;
        if found <= limit {
            most = larger(most, found);
            stack.truncate(start);
            continue;
        }
        let corners = [0, degree, size - 1].map(|k| triangle[k]);
        if found > near || left[level] == 0 || costliest(simd, cost, &corners) > limit {
            return found;
        }
        let less = left[level] - 1;
        (left[level], left[level + 1]) = (less, less);
        halve(stack, degree);
    }
    most
}

/// Replaces the coefficients of the stack's last triangle by those of its halves, cut from its first
/// corner to the middle of the opposite side (de Casteljau's algorithm along the rows). Their first
/// corner is that middle, so that their next cut goes to another side.
#[inline(always)]
fn halve(stack: &mut Vec<DVec4>, degree: usize) {
    let size = count(degree);
    let start = stack.len() - size;
    stack.resize(start + 3 * size + degree + 1, DVec4::ZERO);
    let (of, halves) = stack[start..].split_at_mut(size);
    let (second, halves) = halves.split_at_mut(size);
    let (first, row) = halves.split_at_mut(size);
    let mut from = 0;
    for apex in 0..=degree {
        let n = degree - apex;
        let row = &mut row[..=n];
        row.copy_from_slice(&of[from..=from + n]);
        from += n + 1;
        // The middle counts `level` times, the first corner `apex` times.
        let mut at = apex;
        for level in 0..=n {
            first[at] = row[0];
            second[at] = row[n - level];
            at += degree + 1 - level;
            for k in 0..n - level {
                row[k] = 0.5 * (row[k] + row[k + 1]);
            }
        }
    }
    stack.copy_within(start + size..start + 3 * size, start);
    stack.truncate(start + 2 * size);
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::*;

    /// Distance from z = 0.
    struct Height;

    impl Cost for Height {
        fn squared<S: Simd>(&self, simd: S, [_, _, z]: [S::f64s; 3]) -> S::f64s {
            simd.mul_f64s(z, z)
        }
    }

    /// The largest height of the cubic function.
    struct Looked(Doubt);

    impl WithSimd for Looked {
        type Output = f64;

        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            largest(simd, &mut cubic(), 3, self.0, &Height)
        }
    }

    /// A cubic function, of weight one.
    fn cubic() -> Vec<DVec4> {
        (0..count(3)).map(|k| DVec4::new(0.0, 0.0, (1.7 * k as f64).sin(), 1.0)).collect()
    }

    #[test]
    fn halves_meet_in_the_middle_of_a_side() {
        let of = cubic();
        let middle = (of[0] + 3.0 * of[1] + 3.0 * of[2] + of[3]) / 8.0;
        let mut stack = of.clone();
        halve(&mut stack, 3);
        for (half, other) in stack.chunks_exact(10).zip([of[3], of[0]]) {
            assert!(half[9].distance(middle) < 1e-15);
            assert_eq!((half[0], half[3]), (other, of[9]));
        }
    }

    #[test]
    fn halving_comes_closer_from_above() {
        let looked = |limit: f64, halvings: usize| {
            Arch::new().dispatch(Looked(Doubt { limit, near: 9.0, halvings }))
        };
        // The largest value is found at places of a fine grid.
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
            let terms = triples(3).into_iter().zip(cubic());
            let value: f64 = terms.map(|(of, c)| ways(&of) * powers(&of) * c.z).sum();
            most = most.max(value.abs());
        }
        let (rough, fine) = (looked(f64::MAX, 0), looked(1.01 * most, 8));
        assert!(most <= fine && fine < rough, "{most} {fine} {rough}");
        assert!(fine <= 1.01 * most);
    }
}
