//! The points near each point of a cloud, and the planes that they lie in.

use glam::DVec3;
use rayon::prelude::*;

use super::kd_tree::{KdTree, Neighbor};
use super::plane::Plane;
use crate::error::Result;
use crate::progress::Observer;

/// Neighbours that tell how points lie around one.
pub(crate) const NEIGHBORS: usize = 8;

/// For each point those nearest to it, and the plane nearest to it and them.
#[derive(Clone, Debug)]
pub(crate) struct Neighborhoods {
    /// Nearest first.
    pub(super) near: Vec<Vec<Neighbor>>,
    pub(super) planes: Vec<Plane>,
}

impl Neighborhoods {
    /// Of `count` neighbours of each of a tree's points.
    pub(super) fn of(tree: &KdTree<'_>, count: usize, observer: &mut dyn Observer) -> Result<Self> {
        let near = tree.map(observer, |index, found| {
            tree.nearest_to(index, count, found);
            found.clone()
        })?;
        let points = tree.points();
        let plane = |(&own, near): (&DVec3, &Vec<Neighbor>)| {
            let around = near.iter().map(|near| points[near.index as usize]);
            Plane::of(std::iter::once(own).chain(around))
        };
        let planes = points.par_iter().zip(&near).map(plane).collect();
        Ok(Self { near, planes })
    }
}
