//! Cells: rectangles of the parameter domain that become two triangles or a few more.

use std::ops::Range;

use glam::DVec2;

use super::block::{Block, GridPoint, PATCH_STEPS};
use super::triangulation::Triangulation;

/// Patches in one [`PatchRange`] at most.
const MAX_RANGE_PATCHES: usize = 16;

/// A rectangle of a block's integer coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    /// Start and end in u.
    pub u: (u32, u32),
    /// Start and end in v.
    pub v: (u32, u32),
    /// The triangles that the cell was last certified with.
    pub triangulation: Triangulation,
}

/// A rectangle of patches of a block, and the part of a cell inside it.
pub(super) struct PatchRange {
    /// Rows of patches in the block.
    pub rows: Range<usize>,
    /// Columns of patches in the block.
    pub cols: Range<usize>,
    /// The interval of the cell in u, in the unit square of the patches.
    ///
    /// It is (0, 1) where the range has several patches in this direction. The same holds for `v`.
    pub u: (f64, f64),
    /// The interval of the cell in v, in the unit square of the patches.
    pub v: (f64, f64),
    /// The lower corner of the patches, in the unit square of the cell.
    pub low: DVec2,
    /// The upper corner of the patches, in the unit square of the cell.
    pub high: DVec2,
}

/// A direction of the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    U,
    V,
}

impl Cell {
    /// The cell that covers a whole block.
    pub(super) fn of(block: Block) -> Self {
        let end = |(from, to): (usize, usize)| u32::try_from(to - from).unwrap_or(0) * PATCH_STEPS;
        let triangulation = Triangulation::default();
        Self { u: (0, end(block.rows)), v: (0, end(block.cols)), triangulation }
    }

    /// The corners, counter-clockwise.
    pub(super) fn corners(&self) -> [GridPoint; 4] {
        let Self { u, v, .. } = self;
        [(u.0, v.0), (u.1, v.0), (u.1, v.1), (u.0, v.1)]
    }

    /// The indices of the corners in an outline that runs counter-clockwise from the first one.
    pub(super) fn corner_indices(&self, outline: impl Iterator<Item = GridPoint>) -> [usize; 4] {
        let (corners, mut indices, mut found) = (self.corners(), [0; 4], 0);
        for (k, at) in outline.enumerate() {
            if corners.get(found) == Some(&at) {
                indices[found] = k;
                found += 1;
            }
        }
        indices
    }

    /// Whether the cell lies in one patch.
    pub(super) fn is_single(&self) -> bool {
        let single = |(from, to): (u32, u32)| from / PATCH_STEPS == (to - 1) / PATCH_STEPS;
        single(self.u) && single(self.v)
    }

    /// Splits the cell into ranges of a few patches each, starting in the middle of the cell.
    pub(super) fn patch_ranges(self) -> impl Iterator<Item = PatchRange> {
        let ends = |(from, to): (u32, u32)| {
            ((from / PATCH_STEPS) as usize, to.div_ceil(PATCH_STEPS) as usize)
        };
        let (rows, cols) = (ends(self.u), ends(self.v));
        let wide = (cols.1 - cols.0).min(MAX_RANGE_PATCHES);
        let high = (rows.1 - rows.0).min(MAX_RANGE_PATCHES / wide);
        let (down, along) = ((rows.1 - rows.0).div_ceil(high), (cols.1 - cols.0).div_ceil(wide));
        let all = down * along;
        (0..all).map(move |k| {
            let k = (k + down / 2 * along + along / 2) % all;
            let range =
                |(from, to): (u32, u32), (first, end): (usize, usize), size: usize, k: usize| {
                    let patches = first + k * size..end.min(first + (k + 1) * size);
                    let step = |patch: usize| u32::try_from(patch).unwrap_or(0) * PATCH_STEPS;
                    let (start, stop) = (step(patches.start), step(patches.end));
                    let (low, high) = (from.max(start), to.min(stop));
                    let of_patches = |x: u32| f64::from(x - start) / f64::from(stop - start);
                    let of_cell = |x: u32| f64::from(x - from) / f64::from(to - from);
                    (patches, (of_patches(low), of_patches(high)), (of_cell(low), of_cell(high)))
                };
            let (rows, u, x) = range(self.u, rows, high, k / along);
            let (cols, v, y) = range(self.v, cols, wide, k % along);
            let (low, high) = (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1));
            PatchRange { rows, cols, u, v, low, high }
        })
    }

    /// Splits the cell into halves; a cell of several patches is split between patches.
    pub(super) fn halves(self, direction: Direction) -> [Self; 2] {
        let middle = |(from, to): (u32, u32)| {
            let middle = from + (to - from) / 2;
            if to - from > PATCH_STEPS { middle / PATCH_STEPS * PATCH_STEPS } else { middle }
        };
        let new = Self { triangulation: Triangulation::default(), ..self };
        match direction {
            Direction::U => {
                let at = middle(self.u);
                [Self { u: (self.u.0, at), ..new }, Self { u: (at, self.u.1), ..new }]
            }
            Direction::V => {
                let at = middle(self.v);
                [Self { v: (self.v.0, at), ..new }, Self { v: (at, self.v.1), ..new }]
            }
        }
    }

    /// Whether the integer coordinates are fine enough to split the cell.
    pub(super) fn divisible(&self) -> bool {
        self.u.1 - self.u.0 > 1 && self.v.1 - self.v.0 > 1
    }
}
