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

/// An even sample of a stream of points, in memory for twice as many as it keeps.
///
/// Space is divided into voxels, cubes whose sides are a power of two. In each voxel the point with
/// the lowest hash is kept. When there are too many voxels, their sides double. The sample depends
/// on the points alone, neither on their order nor on their division into chunks.
///
/// ```
/// use neurbs::{DVec3, cloud::EvenSample};
/// let points: Vec<DVec3> = (0..90_000_u32)
///     .map(|i| DVec3::new(f64::from(i % 300), f64::from(i / 300), 0.0))
///     .collect();
/// let mut sample = EvenSample::new(1000);
/// points.chunks(777).for_each(|chunk| sample.extend(chunk));
/// assert!((250..=1000).contains(&sample.indices().len()));
/// ```
#[derive(Clone, Debug)]
pub struct EvenSample {
    most: usize,
    seen: u64,
    /// Side of a voxel; 0 while all points are kept.
    side: f64,
    voxels: Voxels,
    /// All points, while there are few enough to keep them.
    first: Vec<Chosen>,
}

/// A point of a stream with its hash.
#[derive(Clone, Copy, Debug)]
struct Chosen {
    point: DVec3,
    index: u64,
    hash: u64,
}

impl Chosen {
    fn new(point: DVec3, index: u64) -> Self {
        Self { point, index, hash: hash(point) }
    }

    /// The sort key by which the lowest point is kept. Equal points differ by their index.
    fn rank(&self) -> (u64, [u64; 3], u64) {
        (self.hash, bits(self.point), self.index)
    }
}

/// The integer coordinates of the voxel with this side that contains a point.
fn voxel(point: DVec3, side: f64) -> [i64; 3] {
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
type Voxels = HashMap<[i64; 3], Chosen, Fixed>;

impl EvenSample {
    /// An empty sample that will keep at most `most` points, but at least one.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { most: most.max(1), seen: 0, side: 0.0, voxels: Voxels::default(), first: Vec::new() }
    }

    /// Adds the next points of the stream.
    pub fn extend(&mut self, points: &[DVec3]) {
        // This closure never stops it.
        let _never = self.extend_interruptible(points, &mut || Ok(()));
    }

    /// As [`Self::extend`], but `check_interrupt` may stop it. A stopped sample is incomplete.
    pub(crate) fn extend_interruptible(
        &mut self,
        points: &[DVec3],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<()> {
        for &point in points {
            self.add_point(Chosen::new(point, self.seen), check_interrupt)?;
        }
        Ok(())
    }

    /// Adds a point, and doubles the voxels while there are too many.
    fn add_point(
        &mut self,
        chosen: Chosen,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<()> {
        self.seen += 1;
        if self.side > 0.0 {
            prefer(&mut self.voxels, self.side, chosen);
            while self.voxels.len() > self.most {
                self.side *= 2.0;
                let chosen = std::mem::take(&mut self.voxels).into_values();
                self.fill(chosen, check_interrupt)?;
            }
        } else {
            self.first.push(chosen);
            if self.first.len() > self.most {
                self.divide(check_interrupt)?;
            }
        }
        Ok(())
    }

    /// Sorts the first points into the smallest voxels that suffice.
    fn divide(&mut self, check_interrupt: &mut InterruptCheck<'_>) -> Result<()> {
        let points: Vec<DVec3> = self.first.iter().map(|chosen| chosen.point).collect();
        let Some(side) = side(&points, self.most, 1, check_interrupt)? else {
            // All points are copies of one.
            self.first.truncate(1);
            return Ok(());
        };
        self.side = side;
        let first = std::mem::take(&mut self.first).into_iter();
        self.fill(first, check_interrupt)
    }

    /// Puts points into empty voxels.
    fn fill(
        &mut self,
        chosen: impl ExactSizeIterator<Item = Chosen>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<()> {
        self.voxels.reserve(self.most.min(chosen.len()));
        for (k, chosen) in chosen.enumerate() {
            if k % POINTS_PER_REPORT == 0 {
                check_interrupt()?;
            }
            prefer(&mut self.voxels, self.side, chosen);
        }
        Ok(())
    }

    /// The kept points, in the order of the stream.
    fn chosen(&self) -> Vec<Chosen> {
        let mut chosen: Vec<Chosen> =
            self.first.iter().chain(self.voxels.values()).copied().collect();
        chosen.sort_unstable_by_key(|chosen| chosen.index);
        chosen
    }

    /// The kept points, in the order of the stream.
    #[must_use]
    pub fn points(&self) -> Vec<DVec3> {
        self.chosen().iter().map(|chosen| chosen.point).collect()
    }

    /// Their indices in the stream, ascending.
    #[must_use]
    pub fn indices(&self) -> Vec<u64> {
        self.chosen().iter().map(|chosen| chosen.index).collect()
    }

    /// The numbers that, with the kept points and their indices, are the whole state: most points
    /// to keep, points seen, and side of a voxel.
    #[must_use]
    pub fn limits(&self) -> (usize, u64, f64) {
        (self.most, self.seen, self.side)
    }

    /// A sample that goes on from the state of another.
    #[must_use]
    pub fn resumed(
        (most, seen, side): (usize, u64, f64),
        points: &[DVec3],
        indices: &[u64],
    ) -> Self {
        let mut sample = Self { seen, side, ..Self::new(most) };
        let chosen = points.iter().zip(indices).map(|(&point, &index)| Chosen::new(point, index));
        if side > 0.0 {
            chosen.for_each(|chosen| prefer(&mut sample.voxels, side, chosen));
        } else {
            sample.first = chosen.collect();
        }
        sample
    }

    /// The number of points in the stream so far.
    #[must_use]
    pub fn seen(&self) -> u64 {
        self.seen
    }
}

/// The side of the smallest voxels of which at most `most` contain points. `steps` sizes are tried
/// for each doubling. `None` if all points are copies of one.
fn side(
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
/// Space is divided into voxels as by [`EvenSample`], but in finer steps. On a surface, at least
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
fn prefer(voxels: &mut Voxels, side: f64, chosen: Chosen) {
    let kept = voxels.entry(voxel(chosen.point, side)).or_insert(chosen);
    if chosen.rank() < kept.rank() {
        *kept = chosen;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::index;

    fn cloud() -> Vec<DVec3> {
        // A spiral that is a hundred times denser in the middle, far from the origin.
        let place = |i: u32| {
            let (angle, radius) = (f64::from(i) * 2.4, (f64::from(i) / 40_000.0).powi(3));
            DVec3::new(5e6 + radius * angle.cos(), radius * angle.sin(), 0.1 * radius)
        };
        (0..40_000).map(place).collect()
    }

    #[test]
    fn the_sample_does_not_depend_on_chunks_and_order() {
        let points = cloud();
        let sample = |points: &[DVec3], chunk: usize| {
            let mut sample = EvenSample::new(2000);
            points.chunks(chunk).for_each(|chunk| sample.extend(chunk));
            sample
        };
        let whole = sample(&points, points.len());
        assert!(whole.points().len() > 500);
        assert_eq!(whole.points(), sample(&points, 1).points());
        assert_eq!(whole.indices(), sample(&points, 999).indices());
        let mut turned: Vec<DVec3> = points.iter().rev().copied().collect();
        turned = sample(&turned, 100).points();
        turned.reverse();
        assert_eq!(whole.points(), turned);
    }

    #[test]
    fn voxels_are_as_small_as_the_limit_allows() {
        for center in [DVec3::ZERO, DVec3::new(700.0, -0.3, 1e3)] {
            let place = |i: u32| center - 0.5 + f64::from(i) * DVec3::new(0.754_9, 0.569_8, 0.131);
            let points: Vec<DVec3> =
                (0..3001).map(|i| center + (place(i) - center).fract()).collect();
            let mut sample = EvenSample::new(3000);
            sample.extend(&points);
            let count = |side: f64| {
                let places = points.iter().map(|&point| voxel(point, side));
                places.collect::<HashSet<_>>().len()
            };
            assert!(count(sample.side) <= 3000 && count(0.5 * sample.side) > 3000);
            assert_eq!(count(sample.side), sample.points().len());
        }
    }

    #[test]
    fn dense_regions_get_no_more_points_than_others() {
        let mut sample = EvenSample::new(2000);
        sample.extend(&cloud());
        let inner = sample.points().iter().filter(|p| (p.x - 5e6).hypot(p.y) < 0.5).count();
        // A quarter of the disc's area, five sixths of the points.
        assert!(inner * 3 < sample.points().len(), "{inner} of {}", sample.points().len());
    }

    #[test]
    fn even_samples_are_nearly_full_and_the_same_in_any_order() {
        let points: Vec<DVec3> = cloud().into_iter().step_by(7).collect();
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

    #[test]
    fn few_points_and_copies_are_kept_as_they_are() {
        let mut sample = EvenSample::new(10);
        sample.extend(&[DVec3::X, DVec3::X, DVec3::Y]);
        assert_eq!(sample.points(), [DVec3::X, DVec3::X, DVec3::Y]);
        sample.extend(&[DVec3::X; 100]);
        assert_eq!(sample.seen(), 103);
        assert!(sample.points().contains(&DVec3::Y));
    }
}
