//! Outliers that only the surface shows.

use glam::DVec3;

use crate::cloud::{KdTree, Neighbor};
use crate::error::Result;
use crate::fit::{EXACT, biweight, diameter, reach};
use crate::progress::Observer;

/// Points around each whose distances from the surface say what is usual there: where a surface
/// cannot follow a feature, all of them are far from it, and none is an outlier.
const AROUND: usize = 16;

/// Medians of all distances within which a point's weight is hardly less than 1, whatever is usual
/// around it: five of six points of normal noise.
const NEAR: f64 = 2.0;

/// Share of the way to the farthest of those around an outlier that it may lie off a surface without
/// having changed its shape.
const SLIGHT: f64 = 0.1;

/// How many times farther off than all others an outlier is that is none by chance, and one that is none because
/// a surface that must not fold cannot follow it.
const FARTHER: f64 = 1.5;
const ASTRAY: f64 = 4.0;

/// What a surface says of the points that it was fitted to.
pub(super) struct Robust {
    pub(super) weights: Vec<f64>,
    /// Whether all outliers are so near that they have not changed its shape.
    pub(super) slight: bool,
}

impl Robust {
    /// Whether one of the points that count is an outlier, and no other comes near to being so far off.
    pub(super) fn has_another(&self, distances: &[f64], counts: impl Fn(usize) -> bool) -> bool {
        self.has_one_so_far(FARTHER, distances, counts)
    }

    /// Whether one of them is, where a surface may be off some points because it cannot follow them.
    pub(super) fn has_stray(&self, distances: &[f64], counts: impl Fn(usize) -> bool) -> bool {
        self.has_one_so_far(ASTRAY, distances, counts)
    }

    fn has_one_so_far(
        &self,
        factor: f64,
        distances: &[f64],
        counts: impl Fn(usize) -> bool,
    ) -> bool {
        let (mut outlier, mut other) = (0.0_f64, 0.0_f64);
        for (i, (weight, distance)) in self.weights.iter().zip(distances).enumerate() {
            if *weight > 0.0 {
                other = other.max(distance.abs());
            } else if counts(i) {
                outlier = outlier.max(distance.abs());
            }
        }
        outlier > factor * other
    }
}

/// Weights by Tukey's biweight (see [`biweights`](crate::fit::biweights)), where what is usual is
/// the median of the distances around a point, or of all if that is more, or what could be seen; `None` if
/// no point is an outlier. The tree over the points is made when it is needed first.
pub(super) fn weights<'a>(
    points: &'a [DVec3],
    distances: &[f64],
    tree: &mut Option<KdTree<'a>>,
    observer: &mut dyn Observer,
) -> Result<Option<Robust>> {
    let usual = usual(points, distances);
    let reach = reach(usual);
    if distances.iter().all(|distance| *distance <= reach) {
        return Ok(None);
    }
    let tree = match tree {
        Some(tree) => tree,
        None => tree.insert(KdTree::over(points, observer)?),
    };
    let found = tree.map(observer, |index, found| {
        let distance = distances[index as usize];
        if distance <= NEAR * usual {
            return (biweight(distance, usual), true);
        }
        tree.nearest_to(index, AROUND, found);
        let mut around: Vec<f64> = found.iter().map(|n| distances[n.index as usize]).collect();
        let weight = biweight(distance, median(&mut around).max(usual));
        let way = found.last().map_or(0.0, Neighbor::distance);
        (weight, weight > 0.0 || distance <= SLIGHT * way)
    })?;
    let slight = found.iter().all(|(_, slight)| *slight);
    let weights: Vec<f64> = found.into_iter().map(|(weight, _)| weight).collect();
    Ok(weights.contains(&0.0).then_some(Robust { weights, slight }))
}

/// Whether there may be a point so far off as [`Robust::has_stray`] says, as far as can be told without looking at what
/// is usual around each.
pub(super) fn may_stray(points: &[DVec3], distances: &[f64]) -> bool {
    let reach = reach(usual(points, distances));
    let farthest = |distances: &mut dyn Iterator<Item = f64>| distances.fold(0.0, f64::max);
    let mut near = distances.iter().copied().filter(|distance| *distance < reach);
    farthest(&mut distances.iter().copied()) > ASTRAY * farthest(&mut near)
}

/// The median of the distances, or what could be seen, if that is more.
fn usual(points: &[DVec3], distances: &[f64]) -> f64 {
    median(&mut distances.to_vec()).max(EXACT * diameter(points))
}

/// The upper median; 0 of nothing.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
