//! A division of points into disjoint parts, and the shortest links between the parts.

use rayon::prelude::*;

use super::kd_tree::{KdTree, Neighbor};
use crate::numeric::index;

/// The label of a point that belongs to no part.
pub(super) const NO_PART: u32 = u32::MAX;

/// Points in parts that grow together (disjoint-set forest, united by the lower index).
pub(super) struct Partition {
    parents: Vec<u32>,
}

impl Partition {
    /// Each of `count` points is a part of its own.
    pub(super) fn new(count: usize) -> Self {
        Self { parents: (0..).take(count).collect() }
    }

    /// The first point of the part that a point belongs to.
    pub(super) fn root(&mut self, mut point: u32) -> u32 {
        while self.parents[point as usize] != point {
            // Paths to the root are halved.
            let parent = self.parents[self.parents[point as usize] as usize];
            self.parents[point as usize] = parent;
            point = parent;
        }
        point
    }

    pub(super) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// For each point the first of its part.
    pub(super) fn roots(&mut self) -> Vec<u32> {
        (0..self.parents.len()).map(|point| self.root(index(point))).collect()
    }
}

/// A straight connection of two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) length: f64,
}

/// From each part, except for the largest, the shortest link to another one. Labels are those of the
/// points of the tree, below their number or [`NO_PART`].
pub(super) fn shortest_links(tree: &KdTree<'_>, labels: &[u32]) -> Vec<Link> {
    let mut parts: Vec<Vec<u32>> = vec![Vec::new(); labels.len()];
    let labelled = (0..).zip(labels).filter(|(_, label)| **label != NO_PART);
    labelled.for_each(|(point, label)| parts[*label as usize].push(point));
    let largest = (0..parts.len()).rev().max_by_key(|&part| parts[part].len());
    let shortest = |part: &[u32]| -> Option<Link> {
        let own = labels[part[0] as usize];
        let foreign = |to: u32| ![own, NO_PART].contains(&labels[to as usize]);
        let (mut best, mut found) = (None, Vec::new());
        let mut length = f64::INFINITY;
        for &from in part {
            let place = tree.points()[from as usize];
            tree.nearest_where(place, 1, length, &mut found, foreign);
            // Links of equal length do not replace one another.
            if let Some(near) = found.first().map(Neighbor::distance).filter(|near| *near < length)
            {
                length = near;
                best = Some(Link { from, to: found[0].index, length });
            }
        }
        best
    };
    let others = parts.par_iter().enumerate();
    let others = others.filter(|(part, points)| Some(*part) != largest && !points.is_empty());
    others.filter_map(|(_, part)| shortest(part)).collect()
}
