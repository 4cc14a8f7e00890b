//! The nearest node of many points: a tree of boxes, each with the few nodes that can be nearest
//! to anything in it.

use std::sync::OnceLock;

use glam::DVec3;

use super::frame::Frame;
use crate::point_cloud::Bounds;

/// Each level cuts a box into four along each axis.
const BITS: u32 = 2;
const CHILDREN: usize = 1 << (3 * BITS);

/// A list as short as this is looked through rather than divided.
const SHORT: usize = 6;

/// A box is divided while it can be expected to hold more than this many points of a surface; its
/// parts then have at least four each to share what the division costs.
const POINTS_PER_BOX: usize = 64;

/// Points are brought in order by their boxes on this level: 4096 boxes, a few dozen of which a
/// core's own cache holds.
const ORDER_LEVELS: u32 = 2;

/// Boxes are divided until there are this many of them for each node, if both lie on a surface.
/// Smaller ones would have hardly shorter lists, and take memory.
const BOXES_PER_NODE: usize = 4;

/// Coordinates are cut into at most 2^20 boxes along each axis.
const MOST_LEVELS: u32 = 10;

/// Boxes are widened by this share of their size, so that a point that rounding moves over a wall
/// is still inside.
const WIDENING: f64 = 1e-9;

/// Share of squared distances that rounding may change, a few hundred units in the last place.
const ROUNDING: f64 = 1e-13;

/// Finds exactly the nearest node of points in a box. Building is left to the first point that
/// comes to a part of the space, so that empty space costs nothing. A search looks at about ten
/// nodes when the points lie near the lattice, and takes O(log m) steps to find them.
pub(super) struct Candidates<'a> {
    nodes: &'a [DVec3],
    low: DVec3,
    /// Smallest boxes in one unit of length, along each axis.
    resolution: DVec3,
    levels: u32,
    /// Widening of boxes for the rounding of nodes far away.
    slack: f64,
    /// How many of the nearest nodes a list must hold.
    wanted: usize,
    root: Part,
}

/// A box with its candidates, in ascending order.
struct Part {
    list: Box<[u32]>,
    children: OnceLock<Box<[OnceLock<Part>; CHILDREN]>>,
}

impl<'a> Candidates<'a> {
    /// Prepares to find the `wanted` (one or two) nearest of `nodes` for `points` points within
    /// `bounds`.
    pub(super) fn new(nodes: &'a [DVec3], bounds: &Bounds, points: usize, wanted: usize) -> Self {
        let mut levels = 0;
        // A surface passes through 16 of the 64 parts of a box.
        let worth = |levels: u32| {
            let boxes = 1 << (2 * BITS * levels);
            points / boxes > POINTS_PER_BOX && boxes < BOXES_PER_NODE * nodes.len()
        };
        while levels < MOST_LEVELS && worth(levels) {
            levels += 1;
        }
        let size = bounds.max - bounds.min;
        let cells = f64::from(1_u32 << (BITS * levels));
        let per_unit = |side: f64| if side > 0.0 { cells / side } else { 0.0 };
        let resolution = DVec3::new(per_unit(size.x), per_unit(size.y), per_unit(size.z));
        let far = nodes.iter().fold(DVec3::ZERO, |far, node| far.max(node.abs())).max_element();
        let far = far.max(bounds.min.abs().max(bounds.max.abs()).max_element());
        let all = u32::try_from(nodes.len()).unwrap_or(u32::MAX);
        let root = Part { list: (0..all).collect(), children: OnceLock::new() };
        let slack = 4.0 * f64::EPSILON * far;
        Self { nodes, low: bounds.min, resolution, levels, slack, wanted, root }
    }

    /// The node nearest to a point of the box, the lowest among equals, and the square of its
    /// distance.
    #[inline]
    pub(super) fn nearest(&self, point: DVec3) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for &node in self.list(point) {
            let squared = self.nodes[node as usize].distance_squared(point);
            if squared < best.1 {
                best = (node as usize, squared);
            }
        }
        best
    }

    /// The two nodes nearest to a point of the box, nearest first, lower ones first among equals.
    /// For trees that want two.
    pub(super) fn nearest_two(&self, point: DVec3) -> [usize; 2] {
        let (mut first, mut second) = ((0, f64::INFINITY), (0, f64::INFINITY));
        for &node in self.list(point) {
            let squared = self.nodes[node as usize].distance_squared(point);
            if squared < first.1 {
                second = first;
                first = (node as usize, squared);
            } else if squared < second.1 {
                second = (node as usize, squared);
            }
        }
        [first.0, second.0]
    }

    /// The numbers of the points in an order that keeps those of the same part of the space
    /// together, so that one after the other they find the same lists in the cache.
    pub(super) fn order(&self, points: &[DVec3], frame: &Frame) -> Vec<u32> {
        let levels = self.levels.min(ORDER_LEVELS);
        let shift = BITS * (self.levels - levels);
        let bits = BITS * levels;
        let bucket = |point: &DVec3| {
            let [x, y, z] = self.place(frame.apply(*point)).map(|along| along >> shift);
            ((((x << bits) | y) << bits) | z) as usize
        };
        let buckets: Vec<usize> = points.iter().map(bucket).collect();
        let mut next = vec![0_u32; 1 << (3 * bits)];
        for &bucket in &buckets {
            next[bucket] += 1;
        }
        let mut before = 0;
        for place in &mut next {
            (*place, before) = (before, before + *place);
        }
        let mut order = vec![0; points.len()];
        for (point, &bucket) in (0_u32..).zip(&buckets) {
            order[next[bucket] as usize] = point;
            next[bucket] += 1;
        }
        order
    }

    /// The smallest box of a point, by its number along each axis.
    #[inline]
    fn place(&self, point: DVec3) -> [u32; 3] {
        let place = (point - self.low) * self.resolution;
        let most = (1_u32 << (BITS * self.levels)) - 1;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place in the box; beyond its walls the cast saturates"
        )]
        place.to_array().map(|along| (along as u32).min(most))
    }

    /// The candidates for a point.
    #[inline]
    fn list(&self, point: DVec3) -> &[u32] {
        let place = self.place(point);
        let (mut part, mut level) = (&self.root, self.levels);
        while level > 0 && part.list.len() > SHORT {
            level -= 1;
            let children =
                part.children.get_or_init(|| Box::new(std::array::from_fn(|_| OnceLock::new())));
            let digit = |along: u32| (along >> (BITS * level)) as usize & ((1 << BITS) - 1);
            let [x, y, z] = place.map(digit);
            let child = &children[(((x << BITS) | y) << BITS) | z];
            part = child.get_or_init(|| self.divide(part, place, level));
        }
        &part.list
    }

    /// The part of a box around a place at a level: which of its candidates can be nearest there.
    ///
    /// A node is out when another is nearer to every point of the part. The difference of two
    /// squared distances is linear in the point, so that its extremes over a box are known exactly.
    #[cold]
    fn divide(&self, parent: &Part, place: [u32; 3], level: u32) -> Part {
        let count = f64::from(1_u32 << (BITS * level));
        let number = place.map(|along| f64::from(along >> (BITS * level)));
        let size = count / self.resolution;
        // A flat box has no size across, and all of it lies in the first part.
        let size = DVec3::select(self.resolution.cmpgt(DVec3::ZERO), size, DVec3::ZERO);
        let half = 0.5 * size * (1.0 + WIDENING) + self.slack;
        let centre = self.low + (DVec3::from_array(number) + 0.5) * size;
        let squared = |node: u32| self.nodes[node as usize].distance_squared(centre);
        let (mut first, mut second) = ((0, f64::INFINITY), (0, f64::INFINITY));
        for &node in &parent.list {
            let distance = squared(node);
            if distance < first.1 {
                second = first;
                first = (node, distance);
            } else if distance < second.1 {
                second = (node, distance);
            }
        }
        // What beats a node that only has to be second must itself be second.
        let judge = if self.wanted == 1 { first } else { second };
        let judges = if self.wanted == 1 { [first, first] } else { [first, second] };
        let stays = |node: &u32| {
            let distance = squared(*node);
            let rounding = ROUNDING * (distance + judge.1 + half.length_squared());
            judges.iter().any(|&(judge, nearest)| {
                let apart = self.nodes[*node as usize] - self.nodes[judge as usize];
                distance - nearest - 2.0 * half.dot(apart.abs()) <= rounding
            })
        };
        let list: Box<[u32]> = parent.list.iter().copied().filter(stays).collect();
        Part { list, children: OnceLock::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

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
            let one = Candidates::new(nodes, &bounds, pretended, 1);
            let two = Candidates::new(nodes, &bounds, pretended, 2);
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
