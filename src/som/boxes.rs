//! Space cut into boxes, each in eight, and points in the order of their boxes.

use glam::DVec3;

use crate::cloud::Bounds;

/// A box is divided while it can be expected to hold more than this many points of a surface; its
/// parts then have some points each to share what the division costs.
const POINTS_PER_BOX: usize = 32;

/// Coordinates are cut into at most 2^20 boxes along each axis.
pub(super) const MOST_LEVELS: usize = 20;

/// Points are sorted by their boxes on at most this level: 2^24 boxes.
const SORTED_LEVELS: usize = 8;

/// Boxes sorted by in one go, as a power of two: their counters fit into a core's own cache.
const DIGIT: usize = 12;

/// A box and the smallest boxes that it is divided into, by their numbers along each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    pub(super) low: DVec3,
    pub(super) size: DVec3,
    /// Smallest boxes in one unit of length, along each axis.
    resolution: DVec3,
    pub(super) levels: usize,
}

impl Boxes {
    /// Boxes for looking up the nearest of `nodes` nodes for `points` points within `bounds`: as
    /// many as nodes, if both lie on a surface. Smaller ones have shorter lists, but cost more to
    /// make than they save.
    pub(super) fn new(bounds: &Bounds, points: usize, nodes: usize) -> Self {
        let mut levels = 0;
        // A surface passes through four of the eight parts of a box.
        let worth = |levels: usize| {
            let boxes = 1 << (2 * levels);
            points / boxes > POINTS_PER_BOX && boxes < nodes
        };
        while levels < MOST_LEVELS && worth(levels) {
            levels += 1;
        }
        let size = bounds.max - bounds.min;
        let cells = (1_u64 << levels) as f64;
        let per_unit = |side: f64| if side > 0.0 { cells / side } else { 0.0 };
        let resolution = DVec3::new(per_unit(size.x), per_unit(size.y), per_unit(size.z));
        Self { low: bounds.min, size, resolution, levels }
    }

    /// The smallest box of a point.
    #[inline]
    pub(super) fn place(&self, point: DVec3) -> [u32; 3] {
        let place = (point - self.low) * self.resolution;
        let most = (1_u32 << self.levels) - 1;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place in the box; beyond its walls the cast saturates"
        )]
        place.to_array().map(|along| (along as u32).min(most))
    }

    /// The numbers of the points in an order in which those of the same box follow one another, on
    /// every level: sorted by the interleaved bits of their places.
    pub(super) fn order(
        &self,
        points: impl ExactSizeIterator<Item = DVec3>,
    ) -> impl ExactSizeIterator<Item = usize> {
        let levels = self.levels.min(SORTED_LEVELS);
        let shift = self.levels - levels;
        let key = |point: DVec3| {
            let [x, y, z] = self.place(point).map(|along| INTERLEAVED[(along >> shift) as usize]);
            (x << 2) | (y << 1) | z
        };
        let mut entries: Vec<(u32, u32)> = points.map(key).zip(0..).collect();
        let mut sorted = vec![(0, 0); entries.len()];
        for digit in 0..(3 * levels).div_ceil(DIGIT) {
            let bucket = |key: u32| (key >> (DIGIT * digit)) as usize & ((1 << DIGIT) - 1);
            let mut next = [0_u32; 1 << DIGIT];
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

    /// Each point's place in that order.
    pub(super) fn rank(&self, points: impl ExactSizeIterator<Item = DVec3>, ranks: &mut [u32]) {
        for (rank, point) in (0..).zip(self.order(points)) {
            ranks[point] = rank;
        }
    }
}

/// Numbers up to 2^[`SORTED_LEVELS`] with two zeros between any two bits.
const INTERLEAVED: [u32; 1 << SORTED_LEVELS] = {
    let mut table = [0; 1 << SORTED_LEVELS];
    let mut number: u32 = 0;
    while number < 1 << SORTED_LEVELS {
        let mut bit = 0;
        while bit < SORTED_LEVELS {
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
    fn an_order_keeps_each_box_together() {
        let mut random = Random::new(6);
        let mut unit = || random.unit();
        let points: Vec<DVec3> = (0..5000).map(|_| DVec3::new(unit(), unit(), unit())).collect();
        let boxes = Boxes::new(&Bounds::of(&points), 1 << 30, 1 << 20);
        let order: Vec<usize> = boxes.order(points.iter().copied()).collect();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..5000));
        for level in [1, 3, 8] {
            let of = |&point: &usize| {
                boxes.place(points[point]).map(|along| along >> (boxes.levels - level))
            };
            let mut met: Vec<[u32; 3]> = order.iter().map(of).collect();
            met.dedup();
            let visited = met.len();
            met.sort_unstable();
            met.dedup();
            assert_eq!(met.len(), visited);
        }
    }
}
