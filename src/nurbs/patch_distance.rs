//! The largest distance between two surfaces or curves at the same parameters, by branch and bound
//! over their Bézier patches.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::bezier_patch::BezierPatch;
use super::control_net::distance_bound;
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

/// Relative accuracy of the largest distance.
const ACCURACY: f64 = 1e-3;

/// Pieces that are halved at most. Beyond, the bound of the control points counts.
const MAX_PIECES: usize = 200_000;

/// Parts of two patches over the same parameters.
struct Pair {
    /// An upper bound of their distance.
    bound: f64,
    patches: [BezierPatch; 2],
}

impl Pair {
    fn new(patches: [BezierPatch; 2]) -> Self {
        let [first, second] = &patches;
        Self { bound: distance_bound(first.net(), second.net()), patches }
    }

    /// The largest distance between corners, a lower bound of that between the patches.
    fn reached(&self) -> f64 {
        let [first, second] = &self.patches;
        let (p, q) = first.degrees();
        let distance = |(i, j)| first.control(i, j).distance(second.control(i, j));
        [(0, 0), (0, q), (p, 0), (p, q)].into_iter().map(distance).fold(0.0, f64::max)
    }

    /// The halves along the direction in which the two differ more.
    fn halves(&self) -> [Self; 2] {
        let [first, second] = &self.patches;
        let (p, q) = first.degrees();
        let change = |i: usize, j: usize| second.homogeneous(i, j) - first.homogeneous(i, j);
        let step =
            |(i, j): (usize, usize), (k, l): (usize, usize)| (change(k, l) - change(i, j)).length();
        let pairs = || (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j)));
        let along_u = pairs().filter(|at| at.0 < p).map(|at| step(at, (at.0 + 1, at.1)));
        let along_v = pairs().filter(|at| at.1 < q).map(|at| step(at, (at.0, at.1 + 1)));
        let (along_u, along_v) = (along_u.fold(0.0, f64::max), along_v.fold(0.0, f64::max));
        let halve = if along_u * p as f64 >= along_v * q as f64 {
            BezierPatch::halves_u
        } else {
            BezierPatch::halves_v
        };
        let (a, b) = halve(first);
        let (c, d) = halve(second);
        [Self::new([a, c]), Self::new([b, d])]
    }
}

impl PartialEq for Pair {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Pair {}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// Checks that no point of the first patches is farther than `tolerance` from that of the second at
/// the same parameters. The patches of a pair have the same degrees and parameters.
///
/// # Errors
///
/// [`Error::Parameter`] with the largest distance, to 0.1 %: a tolerance that would hold.
pub(super) fn check_distance(
    pairs: impl Iterator<Item = (BezierPatch, BezierPatch)>,
    tolerance: f64,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<()> {
    let mut waiting: BinaryHeap<Pair> = pairs.map(|(a, b)| Pair::new([a, b])).collect();
    let mut reached = waiting.iter().map(Pair::reached).fold(0.0, f64::max);
    for count in 0.. {
        check_interrupt()?;
        let Some(largest) = waiting.pop() else { return Ok(()) };
        // NaN must not pass.
        if largest.bound <= tolerance {
            return Ok(());
        }
        let is_known = reached > tolerance && largest.bound <= (1.0 + ACCURACY) * reached;
        if is_known || count >= MAX_PIECES || !largest.bound.is_finite() {
            let must = format!("at least {:e} for this degree reduction", largest.bound);
            return Err(Error::parameter("tolerance", must, tolerance));
        }
        for half in largest.halves() {
            reached = reached.max(half.reached());
            waiting.push(half);
        }
    }
    Ok(())
}
