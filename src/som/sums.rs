//! What an epoch of batch training remembers of the points: sums for each winner.

use glam::DVec3;

use super::bytes::{Reader, Writer};
use super::frame::Frame;
use crate::error::{Error, Result};

/// For each node, how many points it has won and the sum of their places.
///
/// Sums are kept in whole grains, 2⁻⁵² of the points' extent, and so are exact: over the same
/// points they are the same bits in any order and by any split into parts that are merged.
/// See [`SelfOrganizingMap::sums`](super::SelfOrganizingMap::sums).
#[derive(Clone, Debug, PartialEq)]
pub struct BatchSums {
    pub(super) frame: Frame,
    /// The map's number of steps when they were taken: sums belong to one state of the lattice.
    pub(super) step: u64,
    nodes: Vec<NodeSum>,
    /// Sum of the distances from points to their winners, in grains.
    distance: i128,
    /// How many points lie on the lattice.
    pub(super) reached: u64,
}

/// The first bytes of saved sums: what they are, and the version of the layout.
const MAGIC: &[u8; 13] = b"neurbs-sums-1";

/// The sum of one node's points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct NodeSum {
    grains: [i128; 3],
    count: u64,
}

impl BatchSums {
    /// Of no points.
    pub(super) fn new(frame: Frame, nodes: usize, step: u64) -> Self {
        let nodes = vec![NodeSum::default(); nodes];
        Self { frame, step, nodes, distance: 0, reached: 0 }
    }

    /// Adds a part's sums.
    pub(super) fn absorb(&mut self, part: &PartSums) {
        for (node, [high, low]) in self.nodes.iter_mut().zip(&part.nodes) {
            node.count += whole(high[3] / part.split).cast_unsigned();
            for (axis, sum) in node.grains.iter_mut().enumerate() {
                let (high, low) = (high[axis] / part.split, low[axis] / part.grain);
                *sum += (i128::from(whole(high)) << SPLIT_BITS) + i128::from(whole(low));
            }
        }
        self.distance += part.distance;
        self.reached += part.reached;
    }

    /// Adds the sums over other points.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// let mut sums = som.sums(&points[..150], &mut Silent)?;
    /// sums.merge(&som.sums(&points[150..], &mut Silent)?)?;
    /// assert_eq!(sums, som.sums(&points, &mut Silent)?);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if they belong to another map, or to another state of it.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        self.check(&other.frame, other.nodes.len(), other.step)?;
        for (sum, part) in self.nodes.iter_mut().zip(&other.nodes) {
            sum.count += part.count;
            for (sum, part) in sum.grains.iter_mut().zip(part.grains) {
                *sum += part;
            }
        }
        self.distance += other.distance;
        self.reached += other.reached;
        Ok(())
    }

    /// Checks that they belong to this state of a map.
    pub(super) fn check(&self, frame: &Frame, nodes: usize, step: u64) -> Result<()> {
        if (self.frame, self.nodes.len(), self.step) == (*frame, nodes, step) {
            return Ok(());
        }
        let state = |nodes, step| format!("{nodes} nodes after {step} steps");
        let must = format!("of the same map and state, {}", state(nodes, step));
        Err(Error::parameter("sums", must, state(self.nodes.len(), self.step)))
    }

    /// How many points each node has won.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.sums(&points, &mut Silent)?.hits(), som.hits(&points, &mut Silent)?);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn hits(&self) -> Vec<u64> {
        self.nodes.iter().map(|node| node.count).collect()
    }

    /// Number of points.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.sums(&points[..150], &mut Silent)?.points(), 150);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn points(&self) -> u64 {
        self.nodes.iter().map(|node| node.count).sum()
    }

    /// Mean distance from a point to its winner, in the points' unit; NaN of no points.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// let error = som.quantization_error(&points, &mut Silent)?;
    /// assert!((som.sums(&points, &mut Silent)?.mean_distance() - error).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn mean_distance(&self) -> f64 {
        self.frame.length(self.distance) / self.points() as f64
    }

    /// For each node the number of points and the sum of their coordinates in the frame, in its
    /// size: `[count, x, y, z]`.
    pub(super) fn channels(&self) -> Vec<[f64; 4]> {
        let channel = |node: &NodeSum| {
            let [x, y, z] = node.grains.map(|grains| self.frame.length(grains));
            [node.count as f64, x, y, z]
        };
        self.nodes.iter().map(channel).collect()
    }
}

impl BatchSums {
    /// The sums as bytes for [`Self::from_bytes`]: half an epoch can be saved, and go on elsewhere.
    ///
    /// ```
    /// use neurbs::{DVec3, progress::Silent};
    /// use neurbs::som::{BatchSums, Lattice, SelfOrganizingMap, SomOptions};
    /// let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5)];
    /// let (lattice, options) = (Lattice::quad(4, 4)?, SomOptions::default());
    /// let som = SelfOrganizingMap::new(&points, lattice, &options, &mut Silent)?;
    /// let sums = som.sums(&points[..3], &mut Silent)?;
    /// assert_eq!(BatchSums::from_bytes(&sums.to_bytes())?, sums);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.frame(&self.frame);
        out.count(self.step);
        out.count(self.reached);
        out.grains(self.distance);
        out.count(self.nodes.len() as u64);
        for node in &self.nodes {
            node.grains.iter().for_each(|&grains| out.grains(grains));
            out.count(node.count);
        }
        out.0
    }

    /// The sums that [`Self::to_bytes`] has written.
    ///
    /// ```
    /// use neurbs::som::BatchSums;
    /// let message = BatchSums::from_bytes(b"others").unwrap_err().to_string();
    /// assert_eq!(message, "sums must be the bytes of saved sums, all of them, got 6 other bytes");
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the bytes are not those of sums, or cut off.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        Self::read(bytes).ok_or_else(|| {
            let got = format!("{} other bytes", bytes.len());
            Error::parameter("sums", "the bytes of saved sums, all of them", got)
        })
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let mut from = Reader(bytes.strip_prefix(MAGIC)?);
        let (frame, step, reached) = (from.frame()?, from.count()?, from.count()?);
        let distance = from.grains()?;
        let count = from.length(size_of::<[i128; 3]>() + size_of::<u64>())?;
        let mut node = || {
            let grains = [from.grains()?, from.grains()?, from.grains()?];
            Some(NodeSum { grains, count: from.count()? })
        };
        let nodes = (0..count).map(|_| node()).collect::<Option<_>>()?;
        from.0.is_empty().then_some(Self { frame, step, nodes, distance, reached })
    }
}

/// Coordinates are cut at this many bits above the grain: both parts then add up exactly in
/// ordinary numbers, for a while.
const SPLIT_BITS: u32 = 26;

/// Adding and subtracting this many units rounds a number to whole ones.
const ROUNDER: f64 = 1.5 * (1_u64 << 52) as f64;

/// The sums of a task: as exact as [`BatchSums`], but quicker to add to, and only for so many
/// points.
pub(super) struct PartSums {
    grain: f64,
    /// Unit of the upper parts of coordinates.
    split: f64,
    grains_per_unit: f64,
    /// The upper parts of x, y, z and the number of points; then the lower parts of x, y, z.
    nodes: Vec<[[f64; 4]; 2]>,
    distance: i128,
    reached: u64,
}

impl PartSums {
    /// Of no points.
    pub(super) fn new(frame: &Frame, nodes: usize) -> Self {
        let grains_per_unit = frame.grains_per_unit();
        let grain = grains_per_unit.recip();
        let split = grain * f64::from(1_u32 << SPLIT_BITS);
        let nodes = vec![[[0.0; 4]; 2]; nodes];
        Self { grain, split, grains_per_unit, nodes, distance: 0, reached: 0 }
    }

    /// How many points with coordinates up to `farthest` can be added.
    pub(super) fn capacity(frame: &Frame, farthest: f64) -> usize {
        let units = farthest * frame.grains_per_unit() / f64::from(1_u32 << SPLIT_BITS) + 1.0;
        let lower = f64::from(1_u32 << (SPLIT_BITS - 1)) + 1.0;
        usize::try_from(whole((1_u64 << 53) as f64 / units.max(lower))).unwrap_or(usize::MAX)
    }

    /// Adds a point, in the frame's coordinates.
    #[inline]
    pub(super) fn add(&mut self, winner: usize, point: DVec3, distance: f64, reached: bool) {
        let value = [point.x, point.y, point.z, self.split];
        let rounded = |value: f64, unit: f64| (value + ROUNDER * unit) - ROUNDER * unit;
        let [high, low] = &mut self.nodes[winner];
        for axis in 0..4 {
            let upper = rounded(value[axis], self.split);
            high[axis] += upper;
            low[axis] += rounded(value[axis] - upper, self.grain);
        }
        self.distance += i128::from(whole(distance * self.grains_per_unit));
        self.reached += u64::from(reached);
    }
}

/// The whole part of a number; of units in reach of the frame there are less than 2⁶².
#[expect(clippy::cast_possible_truncation, reason = "see above")]
fn whole(units: f64) -> i64 {
    units as i64
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use crate::cloud::Bounds;

    #[test]
    fn parts_are_exact_far_outside_too() {
        let frame = Frame::of(&Bounds { min: DVec3::splat(-0.4), max: DVec3::splat(0.6) });
        for farthest in [0.5, 400.0] {
            assert!(PartSums::capacity(&frame, farthest) >= 1 << 18);
            let mut random = Random::new(9);
            let mut part = PartSums::new(&frame, 1);
            let mut expected = [0_i128; 3];
            for _ in 0..10_000 {
                let mut coordinate = || farthest * (2.0 * random.unit() - 1.0);
                // Whole grains, so that nothing is rounded.
                let grain = frame.grains_per_unit();
                let point = DVec3::new(coordinate(), coordinate(), coordinate());
                let point = (point * grain).round() / grain;
                part.add(0, point, 0.0, false);
                for (sum, value) in expected.iter_mut().zip(point.to_array()) {
                    *sum += i128::from(whole(value * grain));
                }
            }
            let mut sums = BatchSums::new(frame, 1, 0);
            sums.absorb(&part);
            assert_eq!((sums.nodes[0].grains, sums.nodes[0].count), (expected, 10_000));
        }
    }
}
