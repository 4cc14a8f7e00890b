//! Pieces: the rectangles of the parameters that become two triangles, or a few more.

use std::ops::Range;

use glam::DVec2;

use super::outline::Zip;
use super::stitch::Place;

/// Halvings of a patch in each direction at most.
const HALVINGS: u32 = 22;

/// Parameters of a patch from end to end: places inside a block are whole numbers.
pub(super) const PATCH: u32 = 1 << HALVINGS;

/// Patches of a block in each direction at most, so that its places fit into 32 bits.
pub(super) const MOST_PATCHES: usize = 1 << (31 - HALVINGS);

/// A rectangle of a block's places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    pub u: (u32, u32),
    pub v: (u32, u32),
    /// The triangles that it has last been certified with.
    pub cut: Zip,
}

/// A rectangle of patches: ranges of rows and columns of the nets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub rows: (usize, usize),
    pub cols: (usize, usize),
}

/// Patches of a part at most.
const PATCHES_OF_PART: usize = 16;

/// What a piece has of a rectangle of patches of a block.
pub(super) struct Part {
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// The rectangle in the unit square of these patches: all of it, if they are several in this
    /// direction.
    pub u: (f64, f64),
    pub v: (f64, f64),
    /// The rectangle in the unit square of the piece.
    pub low: DVec2,
    pub high: DVec2,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    U,
    V,
}

impl Piece {
    /// The whole block.
    pub(super) fn of(block: Block) -> Self {
        let end = |(from, to): (usize, usize)| u32::try_from(to - from).unwrap_or(0) * PATCH;
        Self { u: (0, end(block.rows)), v: (0, end(block.cols)), cut: Zip::default() }
    }

    /// The places of its corners, counter-clockwise.
    pub(super) fn corners(&self) -> [Place; 4] {
        let Self { u, v, .. } = self;
        [(u.0, v.0), (u.1, v.0), (u.1, v.1), (u.0, v.1)]
    }

    /// Where its corners stand in an outline, counter-clockwise from the first one.
    pub(super) fn ends(&self, outline: impl Iterator<Item = Place>) -> [usize; 4] {
        let (corners, mut ends, mut found) = (self.corners(), [0; 4], 0);
        for (k, at) in outline.enumerate() {
            if corners.get(found) == Some(&at) {
                ends[found] = k;
                found += 1;
            }
        }
        ends
    }

    /// Whether it lies in one patch.
    pub(super) fn is_single(&self) -> bool {
        let single = |(from, to): (u32, u32)| from / PATCH == (to - 1) / PATCH;
        single(self.u) && single(self.v)
    }

    /// Its parts of a few patches each, of which those in the middle come first.
    pub(super) fn parts(self) -> impl Iterator<Item = Part> {
        let ends = |(from, to): (u32, u32)| ((from / PATCH) as usize, to.div_ceil(PATCH) as usize);
        let (rows, cols) = (ends(self.u), ends(self.v));
        let wide = (cols.1 - cols.0).min(PATCHES_OF_PART);
        let high = (rows.1 - rows.0).min(PATCHES_OF_PART / wide);
        let (down, along) = ((rows.1 - rows.0).div_ceil(high), (cols.1 - cols.0).div_ceil(wide));
        let all = down * along;
        (0..all).map(move |k| {
            let k = (k + down / 2 * along + along / 2) % all;
            let share =
                |(from, to): (u32, u32), (first, end): (usize, usize), size: usize, k: usize| {
                    let patches = first + k * size..end.min(first + (k + 1) * size);
                    let place = |patch: usize| u32::try_from(patch).unwrap_or(0) * PATCH;
                    let (start, stop) = (place(patches.start), place(patches.end));
                    let (low, high) = (from.max(start), to.min(stop));
                    let of_patches = |x: u32| f64::from(x - start) / f64::from(stop - start);
                    let of_piece = |x: u32| f64::from(x - from) / f64::from(to - from);
                    (patches, (of_patches(low), of_patches(high)), (of_piece(low), of_piece(high)))
                };
            let (rows, u, x) = share(self.u, rows, high, k / along);
            let (cols, v, y) = share(self.v, cols, wide, k % along);
            let (low, high) = (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1));
            Part { rows, cols, u, v, low, high }
        })
    }

    /// The halves; those of several patches between patches.
    pub(super) fn halves(self, direction: Direction) -> [Self; 2] {
        let middle = |(from, to): (u32, u32)| {
            let middle = from + (to - from) / 2;
            if to - from > PATCH { middle / PATCH * PATCH } else { middle }
        };
        let uncut = Self { cut: Zip::default(), ..self };
        match direction {
            Direction::U => {
                let at = middle(self.u);
                [Self { u: (self.u.0, at), ..uncut }, Self { u: (at, self.u.1), ..uncut }]
            }
            Direction::V => {
                let at = middle(self.v);
                [Self { v: (self.v.0, at), ..uncut }, Self { v: (at, self.v.1), ..uncut }]
            }
        }
    }

    /// Whether there is a place between its ends in both directions.
    pub(super) fn divisible(&self) -> bool {
        self.u.1 - self.u.0 > 1 && self.v.1 - self.v.0 > 1
    }
}
