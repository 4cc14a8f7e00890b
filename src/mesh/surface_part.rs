//! A part of a cell's surface with its control net.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec2;

use super::net::Net;

/// The surface over a rectangle of a cell's unit square.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePart<'a> {
    /// The corner of the rectangle with the smallest coordinates.
    pub low: DVec2,
    /// The corner of the rectangle with the largest coordinates.
    pub high: DVec2,
    /// The control net of the surface over the rectangle.
    pub net: Net<'a>,
}

impl<'a> SurfacePart<'a> {
    /// The whole cell.
    pub(super) fn whole(net: Net<'a>) -> Self {
        Self { low: DVec2::ZERO, high: DVec2::ONE, net }
    }

    /// Whether the part is the whole cell.
    pub(super) fn is_whole(&self) -> bool {
        (self.low, self.high) == (DVec2::ZERO, DVec2::ONE)
    }

    /// The portion inside the part of a segment on a side of the cell.
    ///
    /// The segment is in the unit square of the cell, the portion in that of the part.
    #[inline(always)]
    pub(super) fn clip(&self, (a, b): (DVec2, DVec2)) -> Option<(DVec2, DVec2)> {
        let (from, to) = (a.min(b).max(self.low), a.max(b).min(self.high));
        let inside = |at: DVec2| (at - self.low) / (self.high - self.low);
        (from.cmple(to).all() && from != to).then(|| (inside(from), inside(to)))
    }
}
