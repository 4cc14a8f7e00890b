//! A few points, evenly over space, from as many as there are.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, DefaultHasher};

use glam::DVec3;

use super::bounds::{Bounds, POINTS_PER_REPORT};
use crate::error::Result;
use crate::progress::Listen;

/// Doublings of the smallest voxels until one holds all points.
const DOUBLINGS: i32 = 20;

/// Sizes of voxels between two doublings that [`even_sample`] tries: on a surface it takes seven
/// tenths of the points that it may take, at least.
const STEPS: i32 = 4;

/// Chooses points evenly over space from a stream, in memory for twice as many as it keeps.
///
/// Space is cut into voxels, cubes whose sides are a power of two. Of each voxel the point with the
/// lowest hash is kept; when there are too many voxels, their sides double. So what is kept depends
/// on the points alone: neither on their order nor on how they were cut into chunks.
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
    /// Side of a voxel; 0 before there are more points than may be kept.
    side: f64,
    voxels: Voxels,
    /// The first points, as long as there are not too many.
    first: Vec<Chosen>,
}

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

    /// In which order points are preferred; equal points by their place in the stream.
    fn rank(&self) -> (u64, [u64; 3], u64) {
        (self.hash, bits(self.point), self.index)
    }
}

/// The place of the voxel of this side that a point lies in.
fn voxel(point: DVec3, side: f64) -> [i64; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "sides are chosen for numbers that fit")]
    (point / side).to_array().map(|along| along.floor() as i64)
}

/// A number that scatters whatever points do, and depends on nothing else.
fn hash(point: DVec3) -> u64 {
    bits(point).into_iter().fold(0, |hash, bits| mix(hash ^ bits))
}

/// The bits of a point, by which equal ones are known.
fn bits(point: DVec3) -> [u64; 3] {
    // Both zeros are one number.
    (point + 0.0).to_array().map(f64::to_bits)
}

/// A bijection that scatters (`SplitMix64`: G. Steele, D. Lea, C. Flood, 2014).
fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The same numbers in each run, unlike those of a hash map by default.
type Fixed = BuildHasherDefault<DefaultHasher>;

/// The points kept by voxel.
type Voxels = HashMap<[i64; 3], Chosen, Fixed>;

impl EvenSample {
    /// Nothing yet; `most` points at most, one at least.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { most: most.max(1), seen: 0, side: 0.0, voxels: Voxels::default(), first: Vec::new() }
    }

    /// Looks at the next points of the stream.
    pub fn extend(&mut self, points: &[DVec3]) {
        // Only who listens may stop it.
        let _never = self.look_at(points, &mut || Ok(()));
    }

    /// The same, which may be stopped; it is of no use then.
    pub(crate) fn look_at(&mut self, points: &[DVec3], listen: &mut Listen<'_>) -> Result<()> {
        for &point in points {
            self.look_at_one(Chosen::new(point, self.seen), listen)?;
        }
        Ok(())
    }

    fn look_at_one(&mut self, chosen: Chosen, listen: &mut Listen<'_>) -> Result<()> {
        self.seen += 1;
        if self.side > 0.0 {
            prefer(&mut self.voxels, self.side, chosen);
            while self.voxels.len() > self.most {
                self.side *= 2.0;
                let chosen = std::mem::take(&mut self.voxels).into_values();
                self.fill(chosen, listen)?;
            }
        } else {
            self.first.push(chosen);
            if self.first.len() > self.most {
                self.divide(listen)?;
            }
        }
        Ok(())
    }

    /// The first voxels.
    fn divide(&mut self, listen: &mut Listen<'_>) -> Result<()> {
        let points: Vec<DVec3> = self.first.iter().map(|chosen| chosen.point).collect();
        let Some(side) = side(&points, self.most, 1, listen)? else {
            // Copies of one point: one is as good as all.
            self.first.truncate(1);
            return Ok(());
        };
        self.side = side;
        let first = std::mem::take(&mut self.first).into_iter();
        self.fill(first, listen)
    }

    /// Puts points into empty voxels.
    fn fill(
        &mut self,
        chosen: impl ExactSizeIterator<Item = Chosen>,
        listen: &mut Listen<'_>,
    ) -> Result<()> {
        self.voxels.reserve(self.most.min(chosen.len()));
        for (k, chosen) in chosen.enumerate() {
            if k % POINTS_PER_REPORT == 0 {
                listen()?;
            }
            prefer(&mut self.voxels, self.side, chosen);
        }
        Ok(())
    }

    fn chosen(&self) -> Vec<Chosen> {
        let mut chosen: Vec<Chosen> =
            self.first.iter().chain(self.voxels.values()).copied().collect();
        chosen.sort_unstable_by_key(|chosen| chosen.index);
        chosen
    }

    /// The points kept, in the order of the stream.
    #[must_use]
    pub fn points(&self) -> Vec<DVec3> {
        self.chosen().iter().map(|chosen| chosen.point).collect()
    }

    /// Their places in the stream, ascending.
    #[must_use]
    pub fn indices(&self) -> Vec<u64> {
        self.chosen().iter().map(|chosen| chosen.index).collect()
    }

    /// How many points came.
    #[must_use]
    pub fn seen(&self) -> u64 {
        self.seen
    }
}

/// The side of the smallest voxels of which at most so many hold points, of this many sizes for each
/// doubling; `None` of copies of one point.
fn side(points: &[DVec3], most: usize, steps: i32, listen: &mut Listen<'_>) -> Result<Option<f64>> {
    let Bounds { min, max } = Bounds::of(points);
    let extent = (max - min).max_element();
    if extent == 0.0 {
        return Ok(None);
    }
    // Numbers of voxels stay far within 64 bits.
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
                listen()?;
            }
            voxels.insert(voxel(point, side));
            if voxels.len() > most {
                return Ok(false);
            }
        }
        Ok(true)
    };
    let (mut small, mut large) = (-DOUBLINGS * steps, 0);
    while !fit(large)? {
        (small, large) = (large, large + steps);
    }
    while large - small > 1 {
        let middle = small.midpoint(large);
        *(if fit(middle)? { &mut large } else { &mut small }) = middle;
    }
    Ok(Some(size(large)))
}

/// The items at these places.
pub(crate) fn items_at<T: Copy>(items: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| items[index as usize]).collect()
}

/// Places of `most` points of a cloud, any of them: as densely in some places as compared with others
/// as all points lie. They depend on the points alone, not on their order.
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

/// The indices, ascending, of at most so many points, evenly over space.
///
/// Space is cut into voxels as by [`EvenSample`], but in finer steps: on a surface at least seven
/// tenths of `most` are chosen, if there are as many points. The choice does not depend on the
/// points' order. O(n log n).
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
    // Nobody listens, so that nothing fails.
    let found = side(points, most.max(1), STEPS, &mut || Ok(()));
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

/// Keeps the better one of a voxel's point and another.
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
    fn chunks_and_order_do_not_matter() {
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
    fn voxels_are_as_small_as_there_is_room_for() {
        for centre in [DVec3::ZERO, DVec3::new(700.0, -0.3, 1e3)] {
            let place = |i: u32| centre - 0.5 + f64::from(i) * DVec3::new(0.754_9, 0.569_8, 0.131);
            let points: Vec<DVec3> =
                (0..3001).map(|i| centre + (place(i) - centre).fract()).collect();
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
    fn crowded_places_get_no_more_than_others() {
        let mut sample = EvenSample::new(2000);
        sample.extend(&cloud());
        let inner = sample.points().iter().filter(|p| (p.x - 5e6).hypot(p.y) < 0.5).count();
        // A quarter of the disc's area, five sixths of the points.
        assert!(inner * 3 < sample.points().len(), "{inner} of {}", sample.points().len());
    }

    #[test]
    fn even_samples_are_full_and_the_same_in_any_order() {
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
