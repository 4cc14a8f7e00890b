//! What an epoch of batch training remembers of the points: sums for each winner.

use glam::DVec3;

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

    /// Adds a point, in the frame's coordinates.
    #[inline]
    pub(super) fn add(&mut self, winner: usize, point: DVec3, distance: f64, grains: f64) {
        let node = &mut self.nodes[winner];
        node.count += 1;
        for (sum, coordinate) in node.grains.iter_mut().zip(point.to_array()) {
            *sum += whole(coordinate * grains);
        }
        self.distance += whole(distance * grains);
    }

    /// Adds the sums over other points.
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
    #[must_use]
    pub fn hits(&self) -> Vec<u64> {
        self.nodes.iter().map(|node| node.count).collect()
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.nodes.iter().map(|node| node.count).sum()
    }

    /// Mean distance from a point to its winner, in the points' unit; NaN of no points.
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

/// A number of grains, rounded towards zero. Points in reach of the frame stay under 2⁶² of them.
#[expect(clippy::cast_possible_truncation, reason = "see above")]
fn whole(grains: f64) -> i128 {
    i128::from(grains as i64)
}
