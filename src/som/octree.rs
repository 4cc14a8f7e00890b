//! An octree over a bounding box, and the order of points along its boxes (Morton order).

use glam::DVec3;

use crate::cloud::Bounds;

/// A box is divided while it is expected to contain more points of a surface than this. Fewer
/// points would not repay the cost of the division.
const MAX_POINTS_PER_BOX: usize = 32;

/// Levels of the tree, at most.
pub(super) const MAX_LEVELS: usize = 20;

/// Levels of the Morton order, at most.
const MAX_SORT_LEVELS: usize = 8;

/// Key bits per pass of the radix sort: the counters fit into a core's cache.
const RADIX_BITS: usize = 12;

/// The root box and the number of its levels. The smallest boxes are called cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octree {
    pub(super) low: DVec3,
    pub(super) size: DVec3,
    /// Cells per unit of length along each axis.
    resolution: DVec3,
    pub(super) levels: usize,
}

impl Octree {
    /// The tree to find the nearest of `nodes` nodes for `points` points within `bounds`. It has
    /// about as many cells along a surface as there are nodes. Smaller cells cost more to build
    /// than they save.
    pub(super) fn new(bounds: &Bounds, points: usize, nodes: usize) -> Self {
        let mut levels = 0;
        // A surface passes through about four of the eight children of a box.
        let worthwhile = |levels: usize| {
            let boxes = 1 << (2 * levels);
            points / boxes > MAX_POINTS_PER_BOX && boxes < nodes
        };
        while levels < MAX_LEVELS && worthwhile(levels) {
            levels += 1;
        }
        let size = bounds.max - bounds.min;
        let cells = (1_u64 << levels) as f64;
        let per_unit = |side: f64| if side > 0.0 { cells / side } else { 0.0 };
        let resolution = DVec3::new(per_unit(size.x), per_unit(size.y), per_unit(size.z));
        Self { low: bounds.min, size, resolution, levels }
    }

    /// The indices of the cell of a point, clamped to the box.
    #[inline]
    pub(super) fn cell_of(&self, point: DVec3) -> [u32; 3] {
        let cell = (point - self.low) * self.resolution;
        let max_cell = (1_u32 << self.levels) - 1;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cell of the box; beyond its faces the cast saturates"
        )]
        cell.to_array().map(|along| (along as u32).min(max_cell))
    }

    /// The indices of the points in Morton order: points of one box follow one another, on every
    /// level.
    pub(super) fn morton_order(
        &self,
        points: impl ExactSizeIterator<Item = DVec3>,
    ) -> impl ExactSizeIterator<Item = usize> {
        let levels = self.levels.min(MAX_SORT_LEVELS);
        let shift = self.levels - levels;
        let key = |point: DVec3| {
            let [x, y, z] = self.cell_of(point).map(|along| SPREAD_BITS[(along >> shift) as usize]);
            (x << 2) | (y << 1) | z
        };
        let mut entries: Vec<(u32, u32)> = points.map(key).zip(0..).collect();
        let mut sorted = vec![(0, 0); entries.len()];
        for digit in 0..(3 * levels).div_ceil(RADIX_BITS) {
            let bucket =
                |key: u32| (key >> (RADIX_BITS * digit)) as usize & ((1 << RADIX_BITS) - 1);
            let mut next = [0_u32; 1 << RADIX_BITS];
            for &(key, _) in &entries {
                next[bucket(key)] += 1;
            }
            let mut before = 0;
            for place in &mut next {
                (*place, before) = (before, before + *place);
            }
            for &entry in &entries {
                let place = &mut next[bucket(entry.0)];
                sorted[*place as usize] = entry;
                *place += 1;
            }
            std::mem::swap(&mut entries, &mut sorted);
        }
        entries.into_iter().map(|(_, point)| point as usize)
    }

    /// The rank of each point in the Morton order.
    pub(super) fn morton_ranks(
        &self,
        points: impl ExactSizeIterator<Item = DVec3>,
        ranks: &mut [u32],
    ) {
        for (rank, point) in (0..).zip(self.morton_order(points)) {
            ranks[point] = rank;
        }
    }
}

/// Numbers below 2^[`MAX_SORT_LEVELS`] with two zeros inserted after each bit.
const SPREAD_BITS: [u32; 1 << MAX_SORT_LEVELS] = {
    let mut table = [0; 1 << MAX_SORT_LEVELS];
    let mut number: u32 = 0;
    while number < 1 << MAX_SORT_LEVELS {
        let mut bit = 0;
        while bit < MAX_SORT_LEVELS {
            table[number as usize] |= ((number >> bit) & 1) << (3 * bit);
            bit += 1;
        }
        number += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    #[test]
    fn morton_order_keeps_the_points_of_each_box_together() {
        let mut random = Random::new(6);
        let mut unit = || random.unit();
        let points: Vec<DVec3> = (0..5000).map(|_| DVec3::new(unit(), unit(), unit())).collect();
        let boxes = Octree::new(&Bounds::of(&points), 1 << 30, 1 << 20);
        let order: Vec<usize> = boxes.morton_order(points.iter().copied()).collect();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..5000));
        for level in [1, 3, 8] {
            let of = |&point: &usize| {
                boxes.cell_of(points[point]).map(|along| along >> (boxes.levels - level))
            };
            let mut visited: Vec<[u32; 3]> = order.iter().map(of).collect();
            visited.dedup();
            let runs = visited.len();
            visited.sort_unstable();
            visited.dedup();
            assert_eq!(visited.len(), runs);
        }
    }
}
