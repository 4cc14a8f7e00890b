//! Where a surface ends.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use crate::point_cloud::{KdTree, Neighbor, Plane};

/// Neighbours that must lie all around a point inside the surface.
const AROUND: usize = 16;

/// Largest angle that they leave open there. On a random scatter one point in two hundred has more;
/// at a straight border it is a half turn.
const OPEN: f64 = 5.0 / 6.0 * PI;

/// Deviation of neighbours from their plane, as a share of that along it, above which the points
/// scatter in space and show no border: noise is larger than spacing.
const ROUGH: f64 = 0.3;

/// Share of points inside a surface that look as if they were on its border.
const FEIGNED: f64 = 0.006;

/// How many points lie on the border; `None` if they scatter too much to show one.
pub(super) fn count(points: &[DVec3]) -> Option<f64> {
    let seen = seen(points);
    let count = |of: fn(&&(bool, bool)) -> bool| seen.iter().filter(of).count() as f64;
    let all = points.len() as f64;
    let smooth = count(|(_, rough)| *rough) < 0.5 * all;
    smooth.then(|| (count(|(on_border, _)| *on_border) - FEIGNED * all).max(0.0))
}

/// Which points look as if they were on the border.
pub(super) fn open(points: &[DVec3]) -> Vec<bool> {
    seen(points).into_iter().map(|(open, _)| open).collect()
}

fn seen(points: &[DVec3]) -> Vec<(bool, bool)> {
    let tree = KdTree::new(points);
    let indices: Vec<u32> = (0..).zip(points).map(|(index, _)| index).collect();
    indices.par_iter().map(|&index| look(&tree, index)).collect()
}

/// Whether a point is on the border, and whether its neighbours scatter in space.
fn look(tree: &KdTree<'_>, index: u32) -> (bool, bool) {
    let (points, mut found) = (tree.points(), Vec::new());
    tree.nearest_to(index, AROUND, &mut found);
    let own = points[index as usize];
    let plane = Plane::of(found.iter().map(|n| points[n.index as usize]));
    let angle = |n: &Neighbor| {
        let apart = points[n.index as usize] - own;
        plane.axes[1].dot(apart).atan2(plane.axes[0].dot(apart))
    };
    let mut angles: Vec<f64> = found.iter().map(angle).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles.first().zip(angles.last()).map_or(TAU, |(first, last)| first + TAU - last);
    let widest = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    (widest > OPEN, plane.deviations[2] > ROUGH * plane.deviations[1])
}
