//! An even sample of a stream of points, mergeable over the parts of the stream.

use glam::DVec3;

use super::bounds::POINTS_PER_REPORT;
use super::sampling::{Chosen, Voxels, prefer, side};
use crate::bytes::{Reader, Writer, read_saved};
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

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
        // If all points are copies of one, any voxel holds them; small ones separate later points.
        let found = side(&points, self.most, 1, check_interrupt)?;
        self.side = found.unwrap_or_else(|| smallest_side(points[0]));
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

    /// Adds the sample of the points that follow in the stream. The result is the sample of the
    /// whole stream, wherever it was cut.
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::EvenSample};
    /// let points: Vec<DVec3> = (0..900).map(|i| DVec3::X * f64::from(i)).collect();
    /// let [mut whole, mut first, mut second] = [(); 3].map(|()| EvenSample::new(100));
    /// whole.extend(&points);
    /// first.extend(&points[..300]);
    /// second.extend(&points[300..]);
    /// first.merge(&second)?;
    /// assert_eq!(first.indices(), whole.indices());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the samples keep different numbers of points.
    pub fn merge(&mut self, next: &Self) -> Result<()> {
        if self.most != next.most {
            return Err(Error::parameter("sample", format!("of {} points", self.most), next.most));
        }
        let before = self.seen;
        if next.side > self.side {
            self.widen(next.side)?;
        }
        for chosen in next.chosen() {
            let chosen = Chosen::new(chosen.point, before + chosen.index);
            self.add_point(chosen, &mut || Ok(()))?;
        }
        self.seen = before + next.seen;
        Ok(())
    }

    /// Divides space into voxels with this side, larger than before.
    fn widen(&mut self, side: f64) -> Result<()> {
        let chosen = self.chosen().into_iter();
        (self.side, self.voxels, self.first) = (side, Voxels::default(), Vec::new());
        self.fill(chosen, &mut || Ok(()))
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

    /// The number of points in the stream so far.
    #[must_use]
    pub fn seen(&self) -> u64 {
        self.seen
    }
}

/// The first bytes of a saved sample: the kind of data and the version of the layout.
const MAGIC: &[u8; 15] = b"neurbs-sample-1";

impl EvenSample {
    /// The sample as bytes for [`Self::from_bytes`].
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::EvenSample};
    /// let mut sample = EvenSample::new(2);
    /// sample.extend(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
    /// let copy = EvenSample::from_bytes(&sample.to_bytes())?;
    /// assert_eq!((copy.points(), copy.seen()), (sample.points(), 3));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.count(self.most as u64);
        out.count(self.seen);
        out.real(self.side);
        out.points(&self.points());
        self.indices().into_iter().for_each(|index| out.count(index));
        out.0
    }

    /// Reads a sample that [`Self::to_bytes`] wrote.
    ///
    /// ```
    /// let message = neurbs::cloud::EvenSample::from_bytes(b"x").unwrap_err().to_string();
    /// assert_eq!(message, "sample must be the complete bytes of a saved sample, got 1 other bytes");
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the bytes are not a complete sample.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        read_saved(bytes, MAGIC, "sample", "a saved sample", Self::read)
    }

    fn read(from: &mut Reader<'_>) -> Option<Self> {
        let mut sample = Self::new(from.size()?);
        sample.seen = from.count()?;
        sample.side = from.real().filter(|side| *side >= 0.0 && side.is_finite())?;
        for point in from.points()? {
            let chosen = Chosen::new(point, from.count()?);
            if sample.side > 0.0 {
                prefer(&mut sample.voxels, sample.side, chosen);
            } else {
                sample.first.push(chosen);
            }
        }
        Some(sample)
    }
}

/// The smallest side with which the number of a point's voxel fits in 64 bits.
fn smallest_side(point: DVec3) -> f64 {
    let far = point.abs().max_element();
    if far > 0.0 { 2.0 * far * f64::EPSILON } else { f64::MIN_POSITIVE }.log2().ceil().exp2()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::super::sampling::voxel;
    use super::super::test_points::spiral;
    use super::*;

    #[test]
    fn the_sample_does_not_depend_on_chunks_and_order() {
        let points = spiral();
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
        sample.extend(&spiral());
        let inner = sample.points().iter().filter(|p| (p.x - 5e6).hypot(p.y) < 0.5).count();
        // A quarter of the disc's area, five sixths of the points.
        assert!(inner * 3 < sample.points().len(), "{inner} of {}", sample.points().len());
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

    #[test]
    fn merged_samples_are_those_of_the_whole_stream() {
        let mut points = spiral();
        // A no-data point at the origin, and copies, wherever the stream is cut.
        points.insert(0, DVec3::ZERO);
        points.extend(vec![points[17]; 3000]);
        let sample = |points: &[DVec3]| {
            let mut sample = EvenSample::new(2000);
            sample.extend(points);
            sample
        };
        let whole = sample(&points);
        assert!(whole.points().len() > 500);
        for size in [1, 1999, 7000, 42_000] {
            let mut parts: Vec<EvenSample> = points.chunks(size.max(500)).map(sample).collect();
            // Merged in pairs of neighbors, as a tree.
            while parts.len() > 1 {
                let pair = |pair: &[EvenSample]| {
                    let mut first = pair[0].clone();
                    pair[1..].iter().for_each(|second| first.merge(second).unwrap());
                    first
                };
                parts = parts.chunks(2).map(pair).collect();
            }
            assert_eq!(parts[0].indices(), whole.indices(), "{size}");
            assert_eq!(parts[0].seen(), points.len() as u64);
        }
    }

    #[test]
    fn a_point_far_away_leaves_the_others_apart() {
        let mut sample = EvenSample::new(1000);
        sample.extend(&[DVec3::ZERO]);
        sample.extend(&spiral());
        assert!(sample.points().len() > 250, "{}", sample.points().len());
    }

    #[test]
    fn copies_of_one_point_separate_from_later_points() {
        for first in [DVec3::ZERO, DVec3::splat(5e6)] {
            let mut sample = EvenSample::new(10);
            sample.extend(&[first; 100]);
            assert_eq!(sample.indices(), [0]);
            sample.extend(&[first + DVec3::X, first]);
            assert_eq!(sample.indices(), [0, 100]);
        }
    }
}
