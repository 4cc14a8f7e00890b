//! Bézier coefficients on a triangle.
//!
//! They stand row by row: by how often the first corner counts, then the second.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use pulp::Simd;

use super::bernstein::binomial;
use super::cost::{Cost, OCTET, Octet, costliest_of};
use super::means::Means;

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
pub(super) fn count(degree: usize) -> usize {
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

/// The maps from the coefficients on a triangle to those on its halves, cut from its first corner to
/// the middle of the opposite side (de Casteljau's algorithm along the rows). Their first corner is
/// that middle, so that their next cut goes to another side.
pub(super) fn halves(degree: usize) -> [Means; 2] {
    let none = || vec![vec![]; count(degree)];
    let (mut first, mut second) = (none(), none());
    let mut from = 0;
    for apex in 0..=degree {
        // The middle counts `level` times, the first corner `apex` times.
        let (n, mut at) = (degree - apex, apex);
        for level in 0..=n {
            let share = |k: usize| binomial(level, k) / 2.0_f64.powf(level as f64);
            first[at] = (0..=level).map(|k| (from + k, share(k))).collect();
            second[at] = (0..=level).map(|k| (from + n - level + k, share(k))).collect();
            at += degree + 1 - level;
        }
        from += n + 1;
    }
    [Means::new(&first), Means::new(&second)]
}

/// The largest cost of a function's coefficients, or anything above the limit if a value costs more
/// than it. The cost is convex, so no value costs more than all coefficients. Where they leave doubt,
/// those of parts are looked at. The coefficients stand first in `room`, behind which there is room for
/// as many at each halving.
#[inline(always)]
pub(super) fn largest<S: Simd>(
    simd: S,
    room: &mut [Octet],
    halves: &[Means; 2],
    Doubt { limit, near, halvings }: Doubt,
    cost: &impl Cost,
) -> f64 {
    let size = halves[0].octets();
    // How many halves have been looked at of the triangles around the one being looked at.
    let (mut most, mut level, mut seen) = (0.0, 0, [0; MOST_HALVINGS]);
    loop {
        let found = costliest_of(simd, cost, &room[level * size..][..size]);
        if found <= limit {
            most = larger(most, found);
            while level > 0 && seen[level - 1] == 2 {
                level -= 1;
            }
            if level == 0 {
                return most;
            }
        } else if found > near || level == halvings.min(MOST_HALVINGS) {
            return found;
        } else {
            seen[level] = 0;
            level += 1;
        }
        let (around, half) = room.split_at_mut(level * size);
        let around = &around[(level - 1) * size..];
        halves[seen[level - 1]].of(simd, |k| point(around, k), &mut half[..size]);
        seen[level - 1] += 1;
    }
}

/// One of some points side by side.
#[inline(always)]
fn point(octets: &[Octet], k: usize) -> [f64; 4] {
    let ([x, y, z, w], lane) = (&octets[k / OCTET], k % OCTET);
    [x.0[lane], y.0[lane], z.0[lane], w.0[lane]]
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::super::cost::Eight;
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
            let mut room = cubic();
            room.resize(9 * room.len(), [Eight::default(); 4]);
            largest(simd, &mut room, &halves(3), self.0, &Height)
        }
    }

    /// The coefficients of the cubic function's halves.
    struct Halved;

    impl WithSimd for Halved {
        type Output = [Vec<Octet>; 2];

        fn with_simd<S: Simd>(self, simd: S) -> [Vec<Octet>; 2] {
            let of = cubic();
            halves(3).map(|half| {
                let mut out = cubic();
                half.of(simd, |k| point(&of, k), &mut out);
                out
            })
        }
    }

    /// A coefficient of a cubic function.
    fn height(k: usize) -> f64 {
        (1.7 * k as f64).sin()
    }

    /// All of them, of weight one; the last one again where they end.
    fn cubic() -> Vec<Octet> {
        let last = count(3) - 1;
        let heights =
            |octet: usize| std::array::from_fn(|lane| height((octet * OCTET + lane).min(last)));
        let none = Eight::default();
        (0..2).map(|octet| [none, none, Eight(heights(octet)), Eight([1.0; OCTET])]).collect()
    }

    #[test]
    fn halves_meet_in_the_middle_of_a_side() {
        let middle = (height(0) + 3.0 * height(1) + 3.0 * height(2) + height(3)) / 8.0;
        let parts = Arch::new().dispatch(Halved);
        for (half, other) in parts.iter().zip([0, 3]) {
            let heights = [0, 3, 9].map(|k| point(half, k)[2]);
            assert!((heights[2] - middle).abs() < 1e-15);
            let (first, second) = if other == 0 { (0, 9) } else { (3, 9) };
            assert_eq!((heights[0], heights[1]), (height(first), height(second)));
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
            let terms = triples(3).into_iter().enumerate();
            let value: f64 = terms.map(|(k, of)| ways(&of) * powers(&of) * height(k)).sum();
            most = most.max(value.abs());
        }
        let (rough, fine) = (looked(f64::MAX, 0), looked(1.01 * most, 8));
        assert!(most <= fine && fine < rough, "{most} {fine} {rough}");
        assert!(fine <= 1.01 * most);
    }
}
