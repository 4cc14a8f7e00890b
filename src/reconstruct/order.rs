//! An order of the points that does not depend on how they came.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use crate::point_cloud::{self, Normalization};

/// The order of the points by their distance from the centroid, the farthest first: equal steps in
/// it are spread evenly over the cloud, and depend neither on how the points were ordered nor on how
/// they lie in space.
pub(super) fn outwards(points: &[DVec3], frame: &Normalization) -> Vec<u32> {
    let centre = point_cloud::centroid(points);
    let key = |(index, point): (u32, &DVec3)| {
        let local = frame.scale * (*point - centre);
        (local.length_squared(), index)
    };
    let mut keyed: Vec<(f64, u32)> = (0..).zip(points).map(key).collect();
    let coordinates = |index: u32| points[index as usize].to_array();
    keyed.par_sort_unstable_by(|a, b| {
        let [x, y] = [a, b].map(|key| coordinates(key.1));
        let places = x.iter().zip(&y).map(|(x, y)| x.total_cmp(y));
        let equal = b.0.total_cmp(&a.0);
        places.fold(equal, Ordering::then).then(a.1.cmp(&b.1))
    });
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Brings what belongs to points in an order back into that of the points.
pub(super) fn restored<T: Copy + Default>(values: &[T], order: &[u32]) -> Vec<T> {
    let mut restored = vec![T::default(); values.len()];
    for (value, &index) in values.iter().zip(order) {
        restored[index as usize] = *value;
    }
    restored
}

/// At most `count` items at equal steps.
pub(super) fn every<T>(items: &[T], count: usize) -> impl Iterator<Item = &T> {
    let taken = items.len().min(count);
    (0..taken).map(move |i| &items[i * items.len() / taken])
}
