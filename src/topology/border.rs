//! Where a surface ends.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::cloud::{KdTree, Neighbor, Plane};

/// Neighbours that must lie all around a point inside the surface.
const AROUND: usize = 16;

/// Square of the cosine of the largest angle that they leave open there, 150 degrees. On a random scatter one point in
/// two hundred has more; at a straight border it is a half turn.
const OPEN: f64 = 0.75;

/// Deviation of neighbours from their plane, as a share of that along it, above which the points
/// scatter in space and show no border: noise is larger than spacing.
const ROUGH: f64 = 0.3;

/// Points that are looked at, at equal steps, to count those on the border: among them are enough of these.
const COUNTED: usize = 1000;

/// Share of points inside a surface that look as if they were on its border.
const FEIGNED: f64 = 0.006;

/// How many points lie on the border; `None` if they scatter too much to show one.
pub(super) fn count(points: &[DVec3]) -> Option<f64> {
    let step = (points.len() / COUNTED).max(1);
    let seen = seen(points, step);
    let count = |of: fn(&&(bool, bool)) -> bool| (step * seen.iter().filter(of).count()) as f64;
    let all = points.len() as f64;
    let smooth = count(|(_, rough)| *rough) < 0.5 * all;
    smooth.then(|| (count(|(on_border, _)| *on_border) - FEIGNED * all).max(0.0))
}

/// Which points look as if they were on the border.
pub(super) fn open(points: &[DVec3]) -> Vec<bool> {
    seen(points, 1).into_iter().map(|(open, _)| open).collect()
}

/// What the first point and those at equal steps behind it look like.
fn seen(points: &[DVec3], step: usize) -> Vec<(bool, bool)> {
    let tree = KdTree::new(points);
    let indices: Vec<u32> = (0..).zip(points).map(|(index, _)| index).step_by(step).collect();
    indices.par_iter().map(|&index| look(&tree, index)).collect()
}

/// Whether a point is on the border, and whether its neighbours scatter in space.
fn look(tree: &KdTree<'_>, index: u32) -> (bool, bool) {
    let (points, mut found) = (tree.points(), Vec::new());
    tree.nearest_to(index, AROUND, &mut found);
    let own = points[index as usize];
    let plane = Plane::of(found.iter().map(|n| points[n.index as usize]));
    let way = |n: &Neighbor| {
        let apart = points[n.index as usize] - own;
        let way = DVec2::new(plane.axes[0].dot(apart), plane.axes[1].dot(apart));
        (quarters(way), way)
    };
    let mut ways: Vec<(f64, DVec2)> = found.iter().map(way).collect();
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    let around = ways.first().zip(ways.last());
    let is_open = around.is_none_or(|(&(first, to), &last)| is_wide(last, (first + 4.0, to)))
        || ways.windows(2).any(|pair| is_wide(pair[0], pair[1]));
    (is_open, plane.deviations[2] > ROUGH * plane.deviations[1])
}

/// A number from 0 to 4 that grows with a direction's angle as quarters of a turn do, and is theirs at the whole ones.
fn quarters(way: DVec2) -> f64 {
    let size = way.x.abs() + way.y.abs();
    if size == 0.0 {
        return 0.0;
    }
    let along = way.x / size;
    if way.y >= 0.0 { 1.0 - along } else { 3.0 + along }
}

/// Whether the angle from one direction on to another is wide open.
fn is_wide((from, a): (f64, DVec2), (to, b): (f64, DVec2)) -> bool {
    let (quarters, cosine) = (to - from, a.dot(b));
    quarters > 2.0
        || quarters > 1.0
            && cosine < 0.0
            && cosine.powi(2) > OPEN * a.length_squared() * b.length_squared()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn angles_are_wide_from_150_degrees_on() {
        for start in (0..51).map(|i| 7.0 * f64::from(i)) {
            for wide in (1..51).map(|i| 7.0 * f64::from(i)) {
                let [a, b] = [start, start + wide]
                    .map(|degrees| (1.0 + degrees) * DVec2::from_angle(TAU * degrees / 360.0));
                let (from, to) = (quarters(a), quarters(b));
                let to = if to < from { to + 4.0 } else { to };
                assert_eq!(is_wide((from, a), (to, b)), wide > 150.0, "{start} {wide}");
            }
        }
        let one = DVec2::new(3.0, 4.0);
        assert!(is_wide((quarters(one), one), (quarters(one) + 4.0, one)));
    }
}
