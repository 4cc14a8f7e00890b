//! Disjoint sets of points (union-find), and the shortest links between them.

use rayon::prelude::*;

use super::kd_tree::{KdTree, Neighbor};
use crate::numeric::index;

/// The label of a point that belongs to no set.
pub(super) const NO_SET: u32 = u32::MAX;

/// A disjoint-set forest. Of two united sets, the lower root becomes the root.
pub(super) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// Each of `count` points is a set of its own.
    pub(super) fn new(count: usize) -> Self {
        Self { parents: (0..).take(count).collect() }
    }

    /// The root of a point's set: its first point.
    pub(super) fn root(&mut self, mut point: u32) -> u32 {
        while self.parents[point as usize] != point {
            // Path halving.
            let parent = self.parents[self.parents[point as usize] as usize];
            self.parents[point as usize] = parent;
            point = parent;
        }
        point
    }

    /// Unites the sets of two points.
    pub(super) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// The root of each point's set.
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

/// Finds the shortest link from each set but the largest to another set. `labels` gives the set of
/// each point of the tree, or [`NO_SET`].
pub(super) fn shortest_links(tree: &KdTree<'_>, labels: &[u32]) -> Vec<Link> {
    let mut sets: Vec<Vec<u32>> = vec![Vec::new(); labels.len()];
    let labeled = (0..).zip(labels).filter(|(_, label)| **label != NO_SET);
    labeled.for_each(|(point, label)| sets[*label as usize].push(point));
    let largest = (0..sets.len()).rev().max_by_key(|&set| sets[set].len());
    let shortest = |set: &[u32]| -> Option<Link> {
        let own = labels[set[0] as usize];
        let foreign = |to: u32| ![own, NO_SET].contains(&labels[to as usize]);
        let (mut best, mut found) = (None, Vec::new());
        let mut length = f64::INFINITY;
        for &from in set {
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
    let others = sets.par_iter().enumerate();
    let others = others.filter(|(set, points)| Some(*set) != largest && !points.is_empty());
    others.filter_map(|(_, set)| shortest(set)).collect()
}
