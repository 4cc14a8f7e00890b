//! The map's local frame: centered on the points, with a length quantum for exact sums.

use glam::DVec3;

use crate::cloud::Bounds;
use crate::error::{Error, Result};

/// Quanta per extent of the points. A quantum is smaller than the last bit of most coordinates.
const QUANTA_PER_EXTENT: f64 = (1_u64 << 52) as f64;

/// Largest distance of later points from the center, in extents of the first points. Farther
/// coordinates would exceed 63 bits of quanta.
const MAX_EXTENTS_AWAY: f64 = 512.0;

/// A center, and a quantum of length. Lengths rounded to whole quanta add up without rounding, so
/// that sums over points have the same bits in any order and for any split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    center: DVec3,
    /// The extent of the first points rounded up to a power of two, in their unit.
    size: f64,
}

impl Frame {
    /// The frame for points with these bounds.
    pub(super) fn of(bounds: &Bounds) -> Self {
        Self::from_parts(bounds.center(), bounds.extent().log2().ceil().exp2())
    }

    pub(super) fn from_parts(center: DVec3, size: f64) -> Self {
        Self { center, size }
    }

    pub(super) fn parts(&self) -> (DVec3, f64) {
        (self.center, self.size)
    }

    /// Converts a point to the frame's coordinates, which keep the unit of length.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        point - self.center
    }

    /// Converts back to the points' coordinates.
    pub(super) fn undo(&self, local: DVec3) -> DVec3 {
        local + self.center
    }

    /// Largest absolute coordinate within `bounds`, in the frame.
    pub(super) fn farthest(&self, bounds: &Bounds) -> f64 {
        let (low, high) = (self.apply(bounds.min), self.apply(bounds.max));
        low.abs().max(high.abs()).max_element()
    }

    /// Refuses points too far from the center for exact sums.
    pub(super) fn check(&self, bounds: &Bounds) -> Result<()> {
        let farthest = self.farthest(bounds);
        if farthest <= MAX_EXTENTS_AWAY * self.size {
            return Ok(());
        }
        let must = format!(
            "at most {:e} from the center of the first points",
            MAX_EXTENTS_AWAY * self.size
        );
        Err(Error::parameter("points", must, format!("a coordinate {farthest:e} away")))
    }

    /// Quanta per unit of length.
    pub(super) fn quanta_per_unit(&self) -> f64 {
        QUANTA_PER_EXTENT / self.size
    }

    /// Converts a sum of quanta to a length.
    pub(super) fn length(&self, quanta: i128) -> f64 {
        // In this order, because `size / QUANTA_PER_EXTENT` alone may be subnormal.
        quanta as f64 / QUANTA_PER_EXTENT * self.size
    }
}
