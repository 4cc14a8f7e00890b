//! Samples of a cloud: even over space, by voxels, or random, by hashes.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, DefaultHasher};

use glam::DVec3;

use super::bounds::{Bounds, POINTS_PER_REPORT};
use super::settings::SampleSettings;
use crate::error::Result;
use crate::numeric::mix;
use crate::progress::InterruptCheck;

const SETTINGS: SampleSettings = SampleSettings::STANDARD;

/// A point of a stream with its hash.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen {
    pub(super) point: DVec3,
    pub(super) index: u64,
    hash: u64,
}

impl Chosen {
    pub(super) fn new(point: DVec3, index: u64) -> Self {
        Self { point, index, hash: hash(point) }
    }

    /// The sort key by which the lowest point is kept. Equal points differ by their index.
    fn rank(&self) -> (u64, [u64; 3], u64) {
        (self.hash, bits(self.point), self.index)
    }
}

/// The integer coordinates of the voxel with this side that contains a point.
pub(super) fn voxel(point: DVec3, side: f64) -> [i64; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "sides are chosen for numbers that fit")]
    (point / side).to_array().map(|along| along.floor() as i64)
}

/// A hash of the coordinates: it scatters evenly, whatever the points.
fn hash(point: DVec3) -> u64 {
    bits(point).into_iter().fold(0, |hash, bits| mix(hash ^ bits))
}

/// The bits of a point's coordinates; equal points have equal bits.
fn bits(point: DVec3) -> [u64; 3] {
    // Adding 0 turns -0 into 0.
    (point + 0.0).to_array().map(f64::to_bits)
}

/// A hasher that is the same in each run, unlike the default of hash maps.
type Fixed = BuildHasherDefault<DefaultHasher>;

/// The kept point of each voxel.
pub(super) type Voxels = HashMap<[i64; 3], Chosen, Fixed>;

/// The side of the smallest voxels of which at most `most` contain points. `steps` sizes are tried
/// for each doubling. `None` if all points are copies of one.
pub(super) fn side(
    points: &[DVec3],
    most: usize,
    steps: i32,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Option<f64>> {
    let Bounds { min, max } = Bounds::of(points);
    let extent = (max - min).max_element();
    if extent == 0.0 {
        return Ok(None);
    }
    // Voxels below the rounding of coordinates are not tried, so that their numbers fit in 64 bits.
    let far = min.abs().max(max.abs()).max_element();
    let unit = extent.log2().ceil().exp2();
    let size = |step: i32| unit * (f64::from(step) / f64::from(steps)).exp2();
    let mut fit = |step: i32| -> Result<bool> {
        let side = size(step);
        let mut voxels: HashSet<[i64; 3], Fixed> = HashSet::default();
        if side <= far * f64::EPSILON {
            return Ok(false);
        }
        for (k, &point) in points.iter().enumerate() {
            if k % POINTS_PER_REPORT == 0 {
                check_interrupt()?;
            }
            voxels.insert(voxel(point, side));
            if voxels.len() > most {
                return Ok(false);
            }
        }
        Ok(true)
    };
    let (mut small, mut large) = (-SETTINGS.doublings * steps, 0);
    while !fit(large)? {
        (small, large) = (large, large + steps);
    }
    while large - small > 1 {
        let middle = small.midpoint(large);
        *(if fit(middle)? { &mut large } else { &mut small }) = middle;
    }
    Ok(Some(size(large)))
}

/// The items with these indices.
pub(crate) fn items_at<T: Copy>(items: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| items[index as usize]).collect()
}

/// Indices of a random sample of `most` points, ascending. Its density follows that of the cloud.
/// It depends on the points alone, not on their order.
#[must_use]
pub fn random_sample(points: &[DVec3], most: usize) -> Vec<u32> {
    let mut keyed: Vec<(u64, u32)> = (0..).zip(points).map(|(i, p)| (hash(*p), i)).collect();
    if most < keyed.len() {
        keyed.select_nth_unstable(most);
        keyed.truncate(most);
    }
    let mut kept: Vec<u32> = keyed.into_iter().map(|(_, index)| index).collect();
    kept.sort_unstable();
    kept
}

/// Indices of an even sample of at most `most` points, ascending.
///
/// Space is divided into voxels as by [`EvenSample`](super::EvenSample), but in finer steps. On a surface, at least
/// seven tenths of `most` points are chosen, if there are as many. The sample does not depend on
/// the points' order. O(n log n).
///
/// ```
/// use neurbs::{DVec3, cloud::even_sample};
/// let points: Vec<DVec3> = (0..90_000_u32)
///     .map(|i| DVec3::new(f64::from(i % 300), f64::from(i / 300), 0.0))
///     .collect();
/// assert!((700..=1000).contains(&even_sample(&points, 1000).len()));
/// ```
#[must_use]
pub fn even_sample(points: &[DVec3], most: usize) -> Vec<u32> {
    if points.len() <= most {
        return (0..).take(points.len()).collect();
    }
    // This closure never stops it.
    let found = side(points, most.max(1), SETTINGS.sizes_per_doubling, &mut || Ok(()));
    let Ok(Some(side)) = found else { return vec![0] };
    let mut voxels = Voxels::default();
    for (index, &point) in (0..).zip(points) {
        prefer(&mut voxels, side, Chosen::new(point, index));
    }
    let kept = voxels.into_values().filter_map(|chosen| u32::try_from(chosen.index).ok());
    let mut kept: Vec<u32> = kept.collect();
    kept.sort_unstable();
    kept
}

/// Keeps the lower one of a voxel's point and another.
pub(super) fn prefer(voxels: &mut Voxels, side: f64, chosen: Chosen) {
    let kept = voxels.entry(voxel(chosen.point, side)).or_insert(chosen);
    if chosen.rank() < kept.rank() {
        *kept = chosen;
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_points::spiral;
    use super::*;
    use crate::numeric::index;

    #[test]
    fn even_samples_are_nearly_full_and_the_same_in_any_order() {
        let points: Vec<DVec3> = spiral().into_iter().step_by(7).collect();
        let backwards: Vec<DVec3> = points.iter().rev().copied().collect();
        for most in [100, 1000, 4000] {
            let sample = even_sample(&points, most);
            assert!((7 * most / 10..=most).contains(&sample.len()), "{most}: {}", sample.len());
            let last = index(points.len() - 1);
            let there = even_sample(&backwards, most).into_iter().rev().map(|i| last - i);
            assert!(there.eq(sample), "{most}");
        }
        assert_eq!(even_sample(&points, points.len()).len(), points.len());
    }
}
