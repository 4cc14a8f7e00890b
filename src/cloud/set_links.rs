//! The shortest links between sets of points.

use rayon::prelude::*;

use super::kd_tree::{KdTree, Neighbor};

/// The label of a point that belongs to no set.
pub(super) const NO_SET: u32 = u32::MAX;

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
