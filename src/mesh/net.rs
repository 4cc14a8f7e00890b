//! The control net of a rectangle of Bézier patches.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec2, DVec4};

/// Homogeneous control points of patches, row by row; neighboring patches share theirs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Net<'a> {
    pub points: &'a [DVec4],
    /// Numbers of patches along u and v.
    pub patches: (usize, usize),
    /// Degrees in u and v.
    pub degrees: (usize, usize),
}

impl<'a> Net<'a> {
    /// The net of one patch.
    pub(super) fn single(points: &'a [DVec4], degrees: (usize, usize)) -> Self {
        Self { points, patches: (1, 1), degrees }
    }

    /// Whether it has one patch.
    #[inline(always)]
    pub(super) fn is_single(&self) -> bool {
        self.patches == (1, 1)
    }

    /// Number of control points in a row.
    #[inline(always)]
    fn width(&self) -> usize {
        self.patches.1 * self.degrees.1 + 1
    }

    /// The row and column of each patch, and its rectangle, starting in the middle of the net.
    ///
    /// `low` and `high` are the corners of the rectangle of the whole net.
    #[inline(always)]
    pub(super) fn rectangles(
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

    /// The control points of the patch in this row and column; `copy` holds them if they are
    /// scattered.
    #[inline(always)]
    pub(super) fn patch<'b>(
        &self,
        (row, col): (usize, usize),
        copy: &'b mut Vec<DVec4>,
    ) -> &'b [DVec4]
    where
        'a: 'b,
    {
        if self.is_single() {
            return self.points;
        }
        let ((p, q), width) = (self.degrees, self.width());
        copy.clear();
        for i in row * p..=(row + 1) * p {
            copy.extend_from_slice(&self.points[i * width + col * q..][..=q]);
        }
        copy
    }

    /// The control points on the side of the unit square that contains this segment.
    #[inline(always)]
    pub(super) fn side(&self, (from, to): (DVec2, DVec2)) -> NetSide {
        let ((p, q), (rows, cols), width) = (self.degrees, self.patches, self.width());
        if from.x == to.x {
            let start = if from.x == 0.0 { 0 } else { rows * p * width };
            NetSide { start, stride: 1, patches: cols, degree: q }
        } else {
            let start = if from.y == 0.0 { 0 } else { width - 1 };
            NetSide { start, stride: width, patches: rows, degree: p }
        }
    }

    /// The control points along a side, optionally without those at its ends.
    #[inline(always)]
    pub(super) fn on_side(
        &self,
        side: NetSide,
        without_ends: bool,
    ) -> impl Iterator<Item = &'a DVec4> + use<'a> {
        let (NetSide { start, stride, .. }, points) = (side, self.points);
        let (last, skip) = (side.patches * side.degree, usize::from(without_ends));
        (skip..=last - skip).map(move |k| &points[start + k * stride])
    }

    /// Replaces `out` by the control points of one patch along a side.
    #[inline(always)]
    pub(super) fn side_of_patch(&self, side: NetSide, patch: usize, out: &mut Vec<DVec4>) {
        let NetSide { start, stride, degree, .. } = side;
        let (start, count) = (start + patch * degree * stride, degree + 1);
        out.clear();
        if stride == 1 {
            out.extend_from_slice(&self.points[start..][..count]);
        } else {
            out.extend((0..count).map(|k| self.points[start + k * stride]));
        }
    }
}

/// The indices of the control points along a side of a net.
#[derive(Clone, Copy, Debug)]
pub(super) struct NetSide {
    start: usize,
    stride: usize,
    /// Number of patches along the side.
    pub patches: usize,
    /// Degree along the side.
    pub degree: usize,
}
