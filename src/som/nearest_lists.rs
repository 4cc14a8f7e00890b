//! Nearest-node search for many points: an octree whose boxes list the nodes that can be nearest to
//! a point inside.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

use super::octree::{MAX_LEVELS, Octree};
use crate::error::Result;
use crate::progress::InterruptCheck;
use crate::worker_pool;

/// Each level halves a box along each axis.
const CHILDREN: usize = 8;

/// A list up to this length is scanned, because dividing it further costs more than it saves.
const MAX_LEAF_LENGTH: usize = 8;

/// Dividing a list of this length takes about a millisecond.
const MIN_LONG_LENGTH: usize = 1 << 17;

/// Boxes are limited to a base number plus this many per node. Points that fill a volume would
/// otherwise get one box each.
const MAX_BOXES_PER_NODE: usize = 32;

/// The base number of boxes.
const BASE_MAX_BOXES: usize = 1 << 12;

/// A tree with more boxes is deallocated on another thread.
const MAX_DROPPED_INLINE: usize = 1 << 14;

/// Boxes are widened by this share of their size, so that a point moved across a face by rounding
/// stays inside.
const BOX_WIDENING: f64 = 1e-9;

/// Relative rounding error of squared distances: a few hundred units in the last place.
const ROUNDING_SHARE: f64 = 1e-13;

/// Finds the exact nearest node of points in the root box. Boxes are built when the first point
/// falls into them, so empty space costs nothing. Near the lattice a search compares about five
/// nodes after O(log m) steps down the tree.
pub(super) struct NearestLists<'a> {
    nodes: &'a [DVec3],
    boxes: Octree,
    /// Widening of boxes against rounding of distant nodes, in the unit of length.
    slack: f64,
    /// Number of nearest nodes that each list must contain: one or two.
    k_nearest: usize,
    root: TreeBox,
    /// Number of boxes built so far.
    box_count: AtomicUsize,
}

impl Drop for NearestLists<'_> {
    fn drop(&mut self) {
        if *self.box_count.get_mut() > MAX_DROPPED_INLINE {
            let root = std::mem::replace(&mut self.root, TreeBox::of_list(&[]));
            worker_pool::spawn(move || drop(root));
        }
    }
}

/// A box and its list of candidate nodes, ascending.
#[derive(Debug)]
struct TreeBox {
    list: Box<[u32]>,
    children: OnceLock<Box<[OnceLock<TreeBox>; CHILDREN]>>,
}

impl TreeBox {
    fn of_list(list: &[u32]) -> Self {
        Self { list: list.into(), children: OnceLock::new() }
    }

    fn children(&self) -> &[OnceLock<Self>; CHILDREN] {
        self.children.get_or_init(Box::default)
    }
}

impl<'a> NearestLists<'a> {
    /// Prepares the search for the `k_nearest` (one or two) nearest of `nodes`.
    pub(super) fn new(
        nodes: &'a [DVec3],
        boxes: Octree,
        k_nearest: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let far = boxes.low.abs().max((boxes.low + boxes.size).abs());
        let far = nodes.iter().fold(far, |far, node| far.max(node.abs())).max_element();
        let all: Vec<u32> = (0..u32::try_from(nodes.len()).unwrap_or(u32::MAX)).collect();
        let root = TreeBox::of_list(&all);
        let (slack, box_count) = (4.0 * f64::EPSILON * far, AtomicUsize::new(0));
        let tree = Self { nodes, boxes, slack, k_nearest, root, box_count };
        // Long lists are divided here, where the caller can interrupt.
        let (mut long, mut scratch) = (vec![(&tree.root, [0; 3], boxes.levels)], all);
        while let Some((part, [x, y, z], level)) = long.pop() {
            if part.list.len() < MIN_LONG_LENGTH || level == 0 {
                continue;
            }
            let level = level - 1;
            for (number, child) in (0..).zip(part.children()) {
                check_interrupt()?;
                let place = [
                    x | ((number >> 2) << level),
                    y | (((number >> 1) & 1) << level),
                    z | ((number & 1) << level),
                ];
                let child = child.get_or_init(|| tree.divide(part, place, level, &mut scratch));
                long.push((child, place, level));
            }
        }
        Ok(tree)
    }

    /// Starts a series of searches.
    pub(super) fn lookup(&self) -> Lookup<'_> {
        Lookup {
            tree: self,
            path: [&self.root; MAX_LEVELS + 1],
            place: [0; 3],
            depth: 0,
            scratch: Vec::new(),
        }
    }

    /// The child box at `level` that contains cell `place`, with the candidates of `parent` that
    /// can be nearest there.
    ///
    /// A node is dropped when another node is nearer to every point of the box. The difference of
    /// two squared distances is linear in the point, so its minimum over the box is exact.
    #[cold]
    fn divide(
        &self,
        parent: &TreeBox,
        place: [u32; 3],
        level: usize,
        scratch: &mut Vec<u32>,
    ) -> TreeBox {
        let Octree { low, size, levels, .. } = self.boxes;
        let number = place.map(|along| f64::from(along >> level));
        let size = size / f64::from(1_u32 << (levels - level));
        let half = 0.5 * size * (1.0 + BOX_WIDENING) + self.slack;
        let center = low + (DVec3::from_array(number) + 0.5) * size;
        let node = |node: u32| self.nodes[node as usize];
        let nearest =
            nearest_two(parent.list.iter().map(|&n| (n, node(n).distance_squared(center))));
        // A node that is nearer than the second-nearest candidate everywhere is itself among the
        // two nearest.
        let rivals = &nearest[..self.k_nearest];
        let last = rivals[self.k_nearest - 1].1;
        scratch.clear();
        scratch.extend(parent.list.iter().copied().filter(|&candidate| {
            let place = node(candidate);
            let distance = place.distance_squared(center);
            let rounding = ROUNDING_SHARE * (distance + last + half.length_squared());
            rivals.iter().any(|&(rival, nearest)| {
                let apart = place - node(rival);
                distance - nearest - 2.0 * half.dot(apart.abs()) <= rounding
            })
        }));
        TreeBox::of_list(scratch)
    }
}

/// A series of searches. Consecutive points close to each other are found faster.
pub(super) struct Lookup<'t> {
    tree: &'t NearestLists<'t>,
    /// The boxes around the last point, from the root down to `depth`.
    path: [&'t TreeBox; MAX_LEVELS + 1],
    place: [u32; 3],
    depth: usize,
    scratch: Vec<u32>,
}

impl Lookup<'_> {
    /// The node nearest to a point of the root box, and its squared distance. Ties go to the lowest
    /// index.
    #[inline]
    pub(super) fn nearest(&mut self, point: DVec3) -> (usize, f64) {
        self.descend_to(point);
        let mut best = (0, f64::INFINITY);
        for &node in &self.path[self.depth].list {
            let squared = self.tree.nodes[node as usize].distance_squared(point);
            if squared < best.1 {
                best = (node, squared);
            }
        }
        (best.0 as usize, best.1)
    }

    /// The two nodes nearest to a point of the root box, nearest first. Ties go to the lower index.
    /// Needs `k_nearest` of two.
    pub(super) fn nearest_two(&mut self, point: DVec3) -> [usize; 2] {
        self.descend_to(point);
        let squared = |node: u32| self.tree.nodes[node as usize].distance_squared(point);
        let list = self.path[self.depth].list.iter();
        nearest_two(list.map(|&node| (node, squared(node)))).map(|(node, _)| node as usize)
    }

    /// Descends to the smallest box around a point.
    #[inline]
    fn descend_to(&mut self, point: DVec3) {
        let levels = self.tree.boxes.levels;
        let place = self.tree.boxes.cell_of(point);
        let differ = place.into_iter().zip(self.place).fold(0, |bits, (a, b)| bits | (a ^ b));
        let common = levels - (u32::BITS - differ.leading_zeros()) as usize;
        self.place = place;
        self.depth = self.depth.min(common);
        let ended =
            |depth: usize, part: &TreeBox| depth == levels || part.list.len() <= MAX_LEAF_LENGTH;
        while !ended(self.depth, self.path[self.depth]) && self.descend() {}
    }

    /// Descends to the child around `place`. Returns false if it is missing and the limit of boxes
    /// is reached.
    fn descend(&mut self) -> bool {
        let part = self.path[self.depth];
        let level = self.tree.boxes.levels - self.depth - 1;
        let [x, y, z] = self.place.map(|along| (along >> level) as usize & 1);
        let number = (x << 2) | (y << 1) | z;
        let exists = part.children.get().is_some_and(|children| children[number].get().is_some());
        let max_boxes = BASE_MAX_BOXES + MAX_BOXES_PER_NODE * self.tree.nodes.len();
        if !exists && self.tree.box_count.load(Ordering::Relaxed) >= max_boxes {
            return false;
        }
        self.depth += 1;
        self.path[self.depth] = part.children()[number].get_or_init(|| {
            self.tree.box_count.fetch_add(1, Ordering::Relaxed);
            self.tree.divide(part, self.place, level, &mut self.scratch)
        });
        true
    }
}

/// The two nodes with the smallest squared distances, nearest first. Ties go to the earlier node.
#[inline]
fn nearest_two(nodes: impl Iterator<Item = (u32, f64)>) -> [(u32, f64); 2] {
    let (mut first, mut second) = ((0, f64::INFINITY), (0, f64::INFINITY));
    for node in nodes {
        if node.1 < first.1 {
            second = first;
            first = node;
        } else if node.1 < second.1 {
            second = node;
        }
    }
    [first, second]
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use crate::cloud::Bounds;

    fn brute(nodes: &[DVec3], point: DVec3) -> [usize; 2] {
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        order.sort_by(|&a, &b| {
            let squared = |i: usize| nodes[i].distance_squared(point);
            squared(a).total_cmp(&squared(b)).then(a.cmp(&b))
        });
        [order[0], order[1]]
    }

    fn compare(nodes: &[DVec3], points: &[DVec3]) {
        let bounds = Bounds::of(points);
        for assumed_points in [points.len(), 1_000_000] {
            let boxes = Octree::new(&bounds, assumed_points, nodes.len());
            let tree =
                |k_nearest| NearestLists::new(nodes, boxes, k_nearest, &mut || Ok(())).unwrap();
            let (one, two) = (tree(1), tree(2));
            let (mut one, mut two) = (one.lookup(), two.lookup());
            for &p in points {
                let expected = brute(nodes, p);
                let least = nodes[expected[0]].distance_squared(p);
                assert_eq!(one.nearest(p), (expected[0], least));
                assert_eq!(two.nearest_two(p), expected);
            }
        }
    }

    #[test]
    fn agrees_with_brute_force_including_ties() {
        let mut random = Random::new(3);
        // Few distinct coordinates, so that ties and points on faces are frequent.
        let mut grid = |max_index: usize| {
            let mut coordinate = || random.index(max_index) as f64;
            DVec3::new(coordinate(), coordinate(), coordinate())
        };
        for (nodes, max_index) in [(4, 3), (40, 4), (300, 9)] {
            let nodes: Vec<DVec3> = (0..nodes).map(|_| grid(max_index)).collect();
            let points: Vec<DVec3> = (0..300).map(|_| grid(2 * max_index) * 0.5).collect();
            compare(&nodes, &points);
        }
    }

    #[test]
    fn agrees_with_brute_force_for_flat_points_and_far_or_coincident_nodes() {
        let mut random = Random::new(4);
        let mut unit = || random.unit();
        let points: Vec<DVec3> = (0..300).map(|_| DVec3::new(unit(), unit(), 0.25)).collect();
        let near: Vec<DVec3> = (0..200).map(|_| DVec3::new(unit(), unit(), unit())).collect();
        let far: Vec<DVec3> = near.iter().map(|&p| DVec3::new(1e7, -3e6, 5.0) + p).collect();
        compare(&near, &points);
        compare(&far, &points);
        compare(&[DVec3::ONE; 50], &points);
    }
}
