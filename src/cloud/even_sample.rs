//! A few points, evenly over space, from as many as there are.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::DVec3;
use rayon::prelude::*;

use super::plane::Plane;
use crate::error::Result;
use crate::progress::Listen;

/// Smallest voxels, as a share of the first points' extent: so small that none holds two, so large
/// that a place among them is a number of `PLACES` bits, even rounded down to a power of two.
const LEAST_VOXEL: f64 = 2e-6;
const PLACES: usize = 21;

/// Sizes of voxels between two doublings that are tried for a cloud's own sample: it has seven tenths of the
/// points that it may have, at least.
const STEPS: usize = 4;

/// How far the axes of a cloud run from the sides of voxels: rounding must not say in which points on an axis
/// lie.
const ASIDE: DVec3 = DVec3::new(0.381_966, 0.276_393, 0.175_571);

/// Side of the cells of space that say the hash of a place, as a share of the cloud's first principal deviation.
const DISTINCT: f64 = 1e-3;

/// Points that are put into voxels between two looks at the observer.
const POINTS_PER_LOOK: usize = 1 << 15;

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
pub(crate) fn hash(point: DVec3) -> u64 {
    bits(point).into_iter().fold(0, |hash, bits| mix(hash ^ bits))
}

/// About so many points, any of the cloud: unlike those of an even sample, they lie as densely in some places
/// as compared with others as all do.
pub(crate) fn any_of(points: &[DVec3], count: usize) -> Vec<DVec3> {
    let share = count as f64 / points.len() as f64;
    let chosen = |point: &&DVec3| hash(**point) as f64 <= share * u64::MAX as f64;
    points.iter().filter(chosen).copied().collect()
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

/// The points kept by voxel, found by scattered numbers: nobody chooses points so that they collide.
type Voxels = HashMap<[i64; 3], Chosen, BuildHasherDefault<Scatter>>;

#[derive(Clone, Copy, Debug, Default)]
struct Scatter(u64);

impl Hasher for Scatter {
    fn write(&mut self, bytes: &[u8]) {
        for bytes in bytes.as_chunks::<8>().0 {
            self.0 = mix(self.0 ^ u64::from_le_bytes(*bytes));
        }
    }

    fn write_usize(&mut self, _: usize) {
        // Voxels have three numbers all.
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

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
        let division = Division::of(&self.first, |chosen| chosen.point, self.most);
        let Some(Division { side, .. }) = division else {
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
            if k % POINTS_PER_LOOK == 0 {
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

/// Voxels in which points lie.
struct Division {
    side: f64,
    /// How many hold points.
    voxels: usize,
}

impl Division {
    /// Into as many as are allowed at most; `None` of copies of one point.
    fn of<T: Sync>(points: &[T], place: impl Fn(&T) -> DVec3 + Sync, most: usize) -> Option<Self> {
        let low = points.iter().map(&place).fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().map(&place).fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element();
        if extent == 0.0 {
            return None;
        }
        // Numbers of voxels stay far within 64 bits.
        let far = low.abs().max(high.abs()).max_element();
        let least = (extent * LEAST_VOXEL).max(far * f64::EPSILON).log2().floor().exp2();
        // Where a voxel of every size begins.
        let origin = voxel(low, least).map(|lowest| lowest >> (PLACES - 1) << (PLACES - 1));
        let code = |point: &T| {
            let voxel = voxel(place(point), least);
            interleaved([0, 1, 2].map(|axis| voxel[axis].abs_diff(origin[axis])))
        };
        let mut codes: Vec<u64> = points.par_iter().map(code).collect();
        codes.par_sort_unstable();
        // In this order the points of a voxel of any size follow one another; the highest bit in
        // which neighbours differ says up to which size they lie apart.
        let mut apart = [0; PLACES + 1];
        for pair in codes.windows(2) {
            let differing = u64::BITS - (pair[0] ^ pair[1]).leading_zeros();
            apart[differing.div_ceil(3) as usize] += 1;
        }
        let (mut voxels, mut doublings) = (1 + apart[1..].iter().sum::<usize>(), 0);
        while voxels > most {
            doublings += 1;
            voxels -= apart[doublings];
        }
        Some(Self { side: least * (doublings as f64).exp2(), voxels })
    }
}

/// At most so many of the points, as [`EvenSample`] chooses them.
pub(crate) fn even_sample(points: &[DVec3], most: usize) -> Vec<DVec3> {
    if points.len() <= most {
        return points.to_vec();
    }
    let division = Division::of(points, |point| *point, most);
    let Some(Division { side, .. }) = division else { return vec![points[0]] };
    let chosen = (0..).zip(points).map(|(index, &point)| Chosen::new(point, index));
    of_each_voxel(chosen, side, points)
}

/// The points that are preferred of those in each voxel of this side, in their own order.
fn of_each_voxel(chosen: impl Iterator<Item = Chosen>, side: f64, points: &[DVec3]) -> Vec<DVec3> {
    let mut voxels = Voxels::default();
    chosen.for_each(|chosen| prefer(&mut voxels, side, chosen));
    let mut kept: Vec<u64> = voxels.into_values().map(|chosen| chosen.index).collect();
    kept.sort_unstable();
    let kept = kept.into_iter().filter_map(|index| usize::try_from(index).ok());
    kept.map(|index| points[index]).collect()
}

/// At most so many points, evenly over space, and hardly fewer if there are as many: the same however the
/// cloud is turned, moved and scaled, and in which order its points come.
pub(crate) fn own_sample(points: &[DVec3], most: usize) -> Vec<DVec3> {
    fullest(points, most, STEPS)
}

/// As [`own_sample`], but perhaps a quarter as many, in a fraction of the time.
pub(crate) fn rough_sample(points: &[DVec3], most: usize) -> Vec<DVec3> {
    fullest(points, most, 1)
}

/// The fullest of even samples of the cloud in a frame of its own, at this many scales: voxels that double leave
/// a quarter of those on a surface in the worst case.
fn fullest(points: &[DVec3], most: usize, steps: usize) -> Vec<DVec3> {
    if points.len() <= most {
        return points.to_vec();
    }
    let plane = Plane::of(points.iter().copied());
    let size = plane.deviations[0].max(f64::MIN_POSITIVE);
    let places: Vec<DVec3> = points.iter().map(|&point| plane.local(point) / size).collect();
    // Axes have no sense but the one in which the cloud reaches farther.
    let sense = places.iter().map(|&place| place * place * place).sum::<DVec3>().signum();
    // Rounding must not say which point of a voxel is chosen either.
    let hashed = |place: DVec3| (sense * place, hash((sense * place / DISTINCT).round()));
    let places: Vec<(DVec3, u64)> = places.into_iter().map(hashed).collect();
    let scale = |step: usize| (step as f64 / steps as f64).exp2();
    let scaled = |step: usize, place: DVec3| scale(step) * place + ASIDE;
    let division = |step: usize| {
        let division = Division::of(&places, |(place, _)| scaled(step, *place), most);
        division.map(|division| (step, division))
    };
    let found: Vec<(usize, Division)> = (0..steps).into_par_iter().filter_map(division).collect();
    let fullest = found.into_iter().max_by_key(|(_, division)| division.voxels);
    let Some((step, Division { side, .. })) = fullest else { return vec![points[0]] };
    let chosen = (0..).zip(&places).map(|(index, &(place, hash))| Chosen {
        point: scaled(step, place),
        index,
        hash,
    });
    of_each_voxel(chosen, side, points)
}

/// The bits of a voxel's place, taken in turns from its three numbers (G. M. Morton, 1966).
fn interleaved(place: [u64; 3]) -> u64 {
    let spread = |along: u64| {
        let steps = [
            (32, 0x1f_0000_0000_ffff),
            (16, 0x1f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ];
        steps.iter().fold(along, |bits, (shift, mask)| (bits | bits << shift) & mask)
    };
    let [x, y, z] = place.map(spread);
    x | y << 1 | z << 2
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
    use std::collections::HashSet;

    use glam::DMat3;

    use super::*;

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
    fn samples_of_their_own_frame_go_with_their_points_in_any_order() {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let moved = |point: DVec3| 1e-3 * (turn * (point - DVec3::X * 5e6)) + DVec3::Y;
        let points: Vec<DVec3> = cloud().into_iter().step_by(7).collect();
        let elsewhere: Vec<DVec3> = points.iter().map(|&point| moved(point)).collect();
        for most in [100, 1000, 4000] {
            let (sample, there) = (own_sample(&points, most), own_sample(&elsewhere, most));
            assert!((7 * most / 10..=most).contains(&sample.len()), "{most}: {}", sample.len());
            assert!(sample.iter().map(|&point| moved(point)).eq(there), "{most}");
            let backwards: Vec<DVec3> = points.iter().rev().copied().collect();
            let mut there = own_sample(&backwards, most);
            there.reverse();
            assert_eq!(sample, there, "{most}");
        }
        assert_eq!(own_sample(&points, points.len()), points);
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
