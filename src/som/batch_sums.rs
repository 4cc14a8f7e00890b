//! Sums over the points of each node in an epoch of batch training.

use glam::DVec3;

use super::frame::Frame;
use crate::bytes::{Reader, Writer, read_saved};
use crate::error::{Error, Result};

/// For each node, the number of points nearest to it and the sum of their positions.
///
/// Coordinates are rounded to a quantum, 2⁻⁵² of the points' extent, and summed as integers. The
/// sums are therefore exact: they have the same bits in any order and for any split into merged
/// parts. See [`SelfOrganizingMap::sums`](super::SelfOrganizingMap::sums).
#[derive(Clone, Debug, PartialEq)]
pub struct BatchSums {
    pub(super) frame: Frame,
    /// Steps of the map when the sums were taken. Sums belong to one state of the map.
    pub(super) step: u64,
    nodes: Vec<NodeSum>,
    /// Sum of the distances from points to their nearest nodes, in quanta.
    distance: i128,
    /// Number of points on the lattice, within `reach` of a node.
    pub(super) reached: u64,
}

/// The first bytes of saved sums: the kind of data and the version of the layout.
const MAGIC: &[u8; 13] = b"neurbs-sums-1";

/// The sum of one node's points, in quanta, and their number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct NodeSum {
    quanta: [i128; 3],
    count: u64,
}

impl BatchSums {
    /// The sums of no points.
    pub(super) fn new(frame: Frame, nodes: usize, step: u64) -> Self {
        let nodes = vec![NodeSum::default(); nodes];
        Self { frame, step, nodes, distance: 0, reached: 0 }
    }

    /// Adds the sums of one task.
    pub(super) fn absorb(&mut self, part: &PartSums) {
        for (node, [high, low]) in self.nodes.iter_mut().zip(&part.nodes) {
            node.count += whole(high[3] / part.split).cast_unsigned();
            for (axis, sum) in node.quanta.iter_mut().enumerate() {
                let (high, low) = (high[axis] / part.split, low[axis] / part.quantum);
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
    /// [`Error::Parameter`] if `other` belongs to another map or to another state of this map.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        self.check(&other.frame, other.nodes.len(), other.step)?;
        for (sum, part) in self.nodes.iter_mut().zip(&other.nodes) {
            sum.count += part.count;
            for (sum, part) in sum.quanta.iter_mut().zip(part.quanta) {
                *sum += part;
            }
        }
        self.distance += other.distance;
        self.reached += other.reached;
        Ok(())
    }

    /// Checks that the sums belong to this state of the map.
    pub(super) fn check(&self, frame: &Frame, nodes: usize, step: u64) -> Result<()> {
        if (self.frame, self.nodes.len(), self.step) == (*frame, nodes, step) {
            return Ok(());
        }
        let state = |nodes, step| format!("{nodes} nodes after {step} steps");
        let must = format!("of the same map and state, {}", state(nodes, step));
        Err(Error::parameter("sums", must, state(self.nodes.len(), self.step)))
    }

    /// Number of points nearest to each node.
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

    /// Mean distance from a point to its nearest node, in the points' unit; NaN if there are no
    /// points.
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

    /// For each node `[count, x, y, z]`: the number of points and the sum of their coordinates in
    /// the frame.
    pub(super) fn channels(&self) -> Vec<[f64; 4]> {
        let channel = |node: &NodeSum| {
            let [x, y, z] = node.quanta.map(|quanta| self.frame.length(quanta));
            [node.count as f64, x, y, z]
        };
        self.nodes.iter().map(channel).collect()
    }
}

impl BatchSums {
    /// The sums as bytes for [`Self::from_bytes`], to save or send a part of an epoch.
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
        out.quanta(self.distance);
        out.count(self.nodes.len() as u64);
        for node in &self.nodes {
            node.quanta.iter().for_each(|&quanta| out.quanta(quanta));
            out.count(node.count);
        }
        out.0
    }

    /// Reads sums that [`Self::to_bytes`] wrote.
    ///
    /// ```
    /// use neurbs::som::BatchSums;
    /// let message = BatchSums::from_bytes(b"others").unwrap_err().to_string();
    /// assert_eq!(message, "sums must be the complete bytes of saved sums, got 6 other bytes");
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the bytes are not complete sums.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        read_saved(bytes, MAGIC, "sums", "saved sums", Self::read)
    }

    fn read(from: &mut Reader<'_>) -> Option<Self> {
        let (frame, step, reached) = (from.frame()?, from.count()?, from.count()?);
        let distance = from.quanta()?;
        let count = from.length(size_of::<[i128; 3]>() + size_of::<u64>())?;
        let mut node = || {
            let quanta = [from.quanta()?, from.quanta()?, from.quanta()?];
            Some(NodeSum { quanta, count: from.count()? })
        };
        let nodes = (0..count).map(|_| node()).collect::<Option<_>>()?;
        Some(Self { frame, step, nodes, distance, reached })
    }
}

/// Coordinates are split into two parts at this many bits above the quantum. Each part is an
/// integer multiple of its unit, so that `f64` sums stay exact up to [`PartSums::capacity`] points.
const SPLIT_BITS: u32 = 26;

/// Adding and subtracting this number of units rounds an `f64` to whole units.
const ROUNDER: f64 = 1.5 * (1_u64 << 52) as f64;

/// The sums of one task: exact as [`BatchSums`] are and faster to add to, for a limited number of
/// points.
pub(super) struct PartSums {
    quantum: f64,
    /// Unit of the upper parts of coordinates, in the points' unit.
    split: f64,
    quanta_per_unit: f64,
    /// Per node: the upper parts of x, y, z and the number of points; the lower parts of x, y, z.
    nodes: Vec<[[f64; 4]; 2]>,
    distance: i128,
    reached: u64,
}

impl PartSums {
    /// The sums of no points.
    pub(super) fn new(frame: &Frame, nodes: usize) -> Self {
        let quanta_per_unit = frame.quanta_per_unit();
        let quantum = quanta_per_unit.recip();
        let split = quantum * f64::from(1_u32 << SPLIT_BITS);
        let nodes = vec![[[0.0; 4]; 2]; nodes];
        Self { quantum, split, quanta_per_unit, nodes, distance: 0, reached: 0 }
    }

    /// Number of points with coordinates up to `farthest` that can be added without rounding.
    pub(super) fn capacity(frame: &Frame, farthest: f64) -> usize {
        let units = farthest * frame.quanta_per_unit() / f64::from(1_u32 << SPLIT_BITS) + 1.0;
        let lower = f64::from(1_u32 << (SPLIT_BITS - 1)) + 1.0;
        usize::try_from(whole((1_u64 << 53) as f64 / units.max(lower))).unwrap_or(usize::MAX)
    }

    /// Adds a point in the frame's coordinates.
    #[inline]
    pub(super) fn add(&mut self, winner: usize, point: DVec3, distance: f64, reached: bool) {
        let value = [point.x, point.y, point.z, self.split];
        let rounded = |value: f64, unit: f64| (value + ROUNDER * unit) - ROUNDER * unit;
        let [high, low] = &mut self.nodes[winner];
        for axis in 0..4 {
            let upper = rounded(value[axis], self.split);
            high[axis] += upper;
            low[axis] += rounded(value[axis] - upper, self.quantum);
        }
        self.distance += i128::from(whole(distance * self.quanta_per_unit));
        self.reached += u64::from(reached);
    }
}

/// The integer part of a number below 2⁶², which all sums within the frame's limits are.
#[expect(clippy::cast_possible_truncation, reason = "below 2⁶²")]
fn whole(units: f64) -> i64 {
    units as i64
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use crate::cloud::Bounds;

    #[test]
    fn part_sums_are_exact_far_from_the_center() {
        let frame = Frame::of(&Bounds { min: DVec3::splat(-0.4), max: DVec3::splat(0.6) });
        for farthest in [0.5, 400.0] {
            assert!(PartSums::capacity(&frame, farthest) >= 1 << 18);
            let mut random = Random::new(9);
            let mut part = PartSums::new(&frame, 1);
            let mut expected = [0_i128; 3];
            for _ in 0..10_000 {
                let mut coordinate = || farthest * (2.0 * random.unit() - 1.0);
                // Whole quanta, so that the sums are not rounded.
                let quantum = frame.quanta_per_unit();
                let point = DVec3::new(coordinate(), coordinate(), coordinate());
                let point = (point * quantum).round() / quantum;
                part.add(0, point, 0.0, false);
                for (sum, value) in expected.iter_mut().zip(point.to_array()) {
                    *sum += i128::from(whole(value * quantum));
                }
            }
            let mut sums = BatchSums::new(frame, 1, 0);
            sums.absorb(&part);
            assert_eq!((sums.nodes[0].quanta, sums.nodes[0].count), (expected, 10_000));
        }
    }
}
