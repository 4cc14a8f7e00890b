//! The nearest node of many points: a tree of boxes, each with the few nodes that can be nearest
//! to anything in it.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

use super::boxes::{Boxes, MOST_LEVELS};
use crate::error::Result;
use crate::progress::Listen;

/// Each level cuts a box in two along each axis.
const CHILDREN: usize = 8;

/// A list as short as this is looked through rather than divided: that costs less than to make and
/// find shorter ones.
const SHORT: usize = 8;

/// A list as long as this takes a millisecond to divide.
const LONG: usize = 1 << 17;

/// Boxes made for each node at most, with a first few: points that fill a volume would have a box
/// each.
const MOST_PER_NODE: usize = 32;
const FIRST_BOXES: usize = 1 << 12;

/// A tree of more boxes than this is taken down by another thread, while the caller goes on.
const SMALL: usize = 1 << 14;

/// Boxes are widened by this share of their size, so that a point that rounding moves over a wall
/// is still inside.
const WIDENING: f64 = 1e-9;

/// Share of squared distances that rounding may change, a few hundred units in the last place.
const ROUNDING: f64 = 1e-13;

/// Finds exactly the nearest node of points in a box. Building is left to the first point that
/// comes to a part of the space, so that empty space costs nothing. A search looks at about five
/// nodes when the points lie near the lattice, and takes O(log m) steps to find them.
pub(super) struct Candidates<'a> {
    nodes: &'a [DVec3],
    boxes: Boxes,
    /// Widening of boxes for the rounding of nodes far away.
    slack: f64,
    /// How many of the nearest nodes a list must hold.
    wanted: usize,
    root: Part,
    /// How many boxes have been made.
    made: AtomicUsize,
}

impl Drop for Candidates<'_> {
    fn drop(&mut self) {
        if *self.made.get_mut() > SMALL {
            let root = std::mem::replace(&mut self.root, Part::of_list(&[]));
            rayon::spawn(move || drop(root));
        }
    }
}

/// A box with its candidates, in ascending order.
#[derive(Debug)]
struct Part {
    list: Box<[u32]>,
    children: OnceLock<Box<[OnceLock<Part>; CHILDREN]>>,
}

impl Part {
    fn of_list(list: &[u32]) -> Self {
        Self { list: list.into(), children: OnceLock::new() }
    }

    fn children(&self) -> &[OnceLock<Self>; CHILDREN] {
        self.children.get_or_init(Box::default)
    }
}

impl<'a> Candidates<'a> {
    /// Prepares to find the `wanted` (one or two) nearest of `nodes`.
    pub(super) fn new(
        nodes: &'a [DVec3],
        boxes: Boxes,
        wanted: usize,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let far = boxes.low.abs().max((boxes.low + boxes.size).abs());
        let far = nodes.iter().fold(far, |far, node| far.max(node.abs())).max_element();
        let all: Vec<u32> = (0..u32::try_from(nodes.len()).unwrap_or(u32::MAX)).collect();
        let root = Part::of_list(&all);
        let (slack, made) = (4.0 * f64::EPSILON * far, AtomicUsize::new(0));
        let tree = Self { nodes, boxes, slack, wanted, root, made };
        // Long lists are divided here, where somebody listens.
        let (mut long, mut scratch) = (vec![(&tree.root, [0; 3], boxes.levels)], all);
        while let Some((part, [x, y, z], level)) = long.pop() {
            if part.list.len() < LONG || level == 0 {
                continue;
            }
            let level = level - 1;
            for (number, child) in (0..).zip(part.children()) {
                listen()?;
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

    /// Begins to look up points.
    pub(super) fn walk(&self) -> Walk<'_> {
        Walk {
            tree: self,
            path: [&self.root; MOST_LEVELS + 1],
            place: [0; 3],
            depth: 0,
            scratch: Vec::new(),
        }
    }

    /// The part of a box around a place at a level: which of its candidates can be nearest there.
    ///
    /// A node is out when another is nearer to every point of the part. The difference of two
    /// squared distances is linear in the point, so that its extremes over a box are known exactly.
    #[cold]
    fn divide(&self, parent: &Part, place: [u32; 3], level: usize, scratch: &mut Vec<u32>) -> Part {
        let Boxes { low, size, levels, .. } = self.boxes;
        let number = place.map(|along| f64::from(along >> level));
        let size = size / f64::from(1_u32 << (levels - level));
        let half = 0.5 * size * (1.0 + WIDENING) + self.slack;
        let centre = low + (DVec3::from_array(number) + 0.5) * size;
        let node = |node: u32| self.nodes[node as usize];
        let nearest =
            nearest_two(parent.list.iter().map(|&n| (n, node(n).distance_squared(centre))));
        // What beats a node that only has to be second must itself be second.
        let judges = &nearest[..self.wanted];
        let last = judges[self.wanted - 1].1;
        scratch.clear();
        scratch.extend(parent.list.iter().copied().filter(|&candidate| {
            let place = node(candidate);
            let distance = place.distance_squared(centre);
            let rounding = ROUNDING * (distance + last + half.length_squared());
            judges.iter().any(|&(judge, nearest)| {
                let apart = place - node(judge);
                distance - nearest - 2.0 * half.dot(apart.abs()) <= rounding
            })
        }));
        Part::of_list(scratch)
    }
}

/// Looks up points, one after the other: quick when each lies near the one before.
pub(super) struct Walk<'t> {
    tree: &'t Candidates<'t>,
    /// The boxes around the last point, from the root down to `depth`.
    path: [&'t Part; MOST_LEVELS + 1],
    place: [u32; 3],
    depth: usize,
    scratch: Vec<u32>,
}

impl Walk<'_> {
    /// The node nearest to a point of the box, the lowest among equals, and the square of its
    /// distance.
    #[inline]
    pub(super) fn nearest(&mut self, point: DVec3) -> (usize, f64) {
        self.turn_to(point);
        let mut best = (0, f64::INFINITY);
        for &node in &self.path[self.depth].list {
            let squared = self.tree.nodes[node as usize].distance_squared(point);
            if squared < best.1 {
                best = (node, squared);
            }
        }
        (best.0 as usize, best.1)
    }

    /// The two nodes nearest to a point of the box, nearest first, lower ones first among equals.
    /// For trees that want two.
    pub(super) fn nearest_two(&mut self, point: DVec3) -> [usize; 2] {
        self.turn_to(point);
        let squared = |node: u32| self.tree.nodes[node as usize].distance_squared(point);
        let list = self.path[self.depth].list.iter();
        nearest_two(list.map(|&node| (node, squared(node)))).map(|(node, _)| node as usize)
    }

    /// Goes to the smallest box of a point.
    #[inline]
    fn turn_to(&mut self, point: DVec3) {
        let levels = self.tree.boxes.levels;
        let place = self.tree.boxes.place(point);
        let differ = place.into_iter().zip(self.place).fold(0, |bits, (a, b)| bits | (a ^ b));
        let common = levels - (u32::BITS - differ.leading_zeros()) as usize;
        self.place = place;
        self.depth = self.depth.min(common);
        let ended = |depth: usize, part: &Part| depth == levels || part.list.len() <= SHORT;
        while !ended(self.depth, self.path[self.depth]) && self.step_down() {}
    }

    /// Goes to the part around the place; says whether there is one, or could still be made.
    fn step_down(&mut self) -> bool {
        let part = self.path[self.depth];
        let level = self.tree.boxes.levels - self.depth - 1;
        let [x, y, z] = self.place.map(|along| (along >> level) as usize & 1);
        let number = (x << 2) | (y << 1) | z;
        let there = part.children.get().is_some_and(|children| children[number].get().is_some());
        let most = FIRST_BOXES + MOST_PER_NODE * self.tree.nodes.len();
        if !there && self.tree.made.load(Ordering::Relaxed) >= most {
            return false;
        }
        self.depth += 1;
        self.path[self.depth] = part.children()[number].get_or_init(|| {
            self.tree.made.fetch_add(1, Ordering::Relaxed);
            self.tree.divide(part, self.place, level, &mut self.scratch)
        });
        true
    }
}

/// The two nearest of nodes with the squares of their distances, nearest first, earlier ones first
/// among equals.
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
        for pretended in [points.len(), 1_000_000] {
            let boxes = Boxes::new(&bounds, pretended, nodes.len());
            let tree = |wanted| Candidates::new(nodes, boxes, wanted, &mut || Ok(())).unwrap();
            let (one, two) = (tree(1), tree(2));
            let (mut one, mut two) = (one.walk(), two.walk());
            for &p in points {
                let expected = brute(nodes, p);
                let least = nodes[expected[0]].distance_squared(p);
                assert_eq!(one.nearest(p), (expected[0], least));
                assert_eq!(two.nearest_two(p), expected);
            }
        }
    }

    #[test]
    fn it_finds_what_brute_force_finds_ties_included() {
        let mut random = Random::new(3);
        // Few distinct coordinates, so that ties and points on walls are frequent.
        let mut grid = |most: usize| {
            let mut coordinate = || random.index(most) as f64;
            DVec3::new(coordinate(), coordinate(), coordinate())
        };
        for (nodes, most) in [(4, 3), (40, 4), (300, 9)] {
            let nodes: Vec<DVec3> = (0..nodes).map(|_| grid(most)).collect();
            let points: Vec<DVec3> = (0..300).map(|_| grid(2 * most) * 0.5).collect();
            compare(&nodes, &points);
        }
    }

    #[test]
    fn flat_points_far_nodes_and_coincident_nodes() {
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
