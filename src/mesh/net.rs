//! The control points of a rectangle of patches.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::{DVec2, DVec4};

/// Homogeneous control points of patches, row by row; neighbours share their border.
#[derive(Clone, Copy, Debug)]
pub(super) struct Net<'a> {
    pub points: &'a [DVec4],
    /// How many patches there are along u and v.
    pub patches: (usize, usize),
    pub degrees: (usize, usize),
}

impl<'a> Net<'a> {
    /// Of one patch.
    pub(super) fn single(points: &'a [DVec4], degrees: (usize, usize)) -> Self {
        Self { points, patches: (1, 1), degrees }
    }

    #[inline(always)]
    pub(super) fn is_single(&self) -> bool {
        self.patches == (1, 1)
    }

    /// Control points of a row.
    #[inline(always)]
    fn width(&self) -> usize {
        self.patches.1 * self.degrees.1 + 1
    }

    /// The patches with their rectangles of the unit square, given which part of that the net is; those
    /// in the middle first.
    #[inline(always)]
    pub(super) fn places(
        &self,
        (low, high): (DVec2, DVec2),
    ) -> impl Iterator<Item = ((usize, usize), (DVec2, DVec2))> + use<> {
        let (rows, cols) = self.patches;
        let size = DVec2::new(rows as f64, cols as f64);
        (0..rows * cols).map(move |k| {
            if rows * cols == 1 {
                return ((0, 0), (low, high));
            }
            let k = (k + rows / 2 * cols + cols / 2) % (rows * cols);
            let (row, col) = (k / cols, k % cols);
            let corner = |row: usize, col: usize| {
                let share = DVec2::new(row as f64, col as f64) / size;
                (DVec2::ONE - share) * low + share * high
            };
            ((row, col), (corner(row, col), corner(row + 1, col + 1)))
        })
    }

    /// The control points of the patch in this row and column; `room` is where they are copied to.
    #[inline(always)]
    pub(super) fn patch<'b>(
        &self,
        (row, col): (usize, usize),
        room: &'b mut Vec<DVec4>,
    ) -> &'b [DVec4]
    where
        'a: 'b,
    {
        if self.is_single() {
            return self.points;
        }
        let ((p, q), width) = (self.degrees, self.width());
        room.clear();
        for i in row * p..=(row + 1) * p {
            room.extend_from_slice(&self.points[i * width + col * q..][..=q]);
        }
        room
    }

    /// Which control points lie on the side of the unit square that this is a segment of: the first
    /// one, how they follow one another, and how many patches they are of.
    #[inline(always)]
    pub(super) fn side(&self, (from, to): (DVec2, DVec2)) -> Side {
        let ((p, q), (rows, cols), width) = (self.degrees, self.patches, self.width());
        if from.x == to.x {
            let start = if from.x == 0.0 { 0 } else { rows * p * width };
            Side { start, stride: 1, patches: cols, degree: q }
        } else {
            let start = if from.y == 0.0 { 0 } else { width - 1 };
            Side { start, stride: width, patches: rows, degree: p }
        }
    }

    /// The control points along a side, without those at its ends if these are known to be fine.
    #[inline(always)]
    pub(super) fn on_side(
        &self,
        side: Side,
        without_ends: bool,
    ) -> impl Iterator<Item = &'a DVec4> + use<'a> {
        let (Side { start, stride, .. }, points) = (side, self.points);
        let (last, out) = (side.patches * side.degree, usize::from(without_ends));
        (out..=last - out).map(move |k| &points[start + k * stride])
    }

    /// Makes the control points of a patch along a side the only ones in `out`.
    #[inline(always)]
    pub(super) fn line(&self, side: Side, patch: usize, out: &mut Vec<DVec4>) {
        let Side { start, stride, degree, .. } = side;
        let (start, count) = (start + patch * degree * stride, degree + 1);
        out.clear();
        if stride == 1 {
            out.extend_from_slice(&self.points[start..][..count]);
        } else {
            out.extend((0..count).map(|k| self.points[start + k * stride]));
        }
    }
}

/// Where the control points of a side stand in a net.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    start: usize,
    stride: usize,
    pub patches: usize,
    pub degree: usize,
}
