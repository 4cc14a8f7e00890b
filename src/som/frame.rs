//! The frame in which a map works: about the middle of the points, with a grain for exact sums.

use glam::DVec3;

use crate::cloud::Bounds;
use crate::error::{Error, Result};

/// Grains in the extent of the points: one grain is finer than the last bit of most of their
/// coordinates.
const GRAINS: f64 = (1_u64 << 52) as f64;

/// How far points that come later may lie outside, in extents of the first points. Beyond, their
/// grains would not fit into 63 bits.
const ROOM: f64 = 512.0;

/// Coordinates about a centre, and a grain: lengths rounded to whole grains add up without
/// rounding, so that sums over points are the same in any order and any split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    centre: DVec3,
    /// The extent of the points that made the frame, in their unit, as a power of two.
    size: f64,
}

impl Frame {
    /// The frame of points with these bounds.
    pub(super) fn of(bounds: &Bounds) -> Self {
        Self::from_parts(bounds.center(), bounds.extent().log2().ceil().exp2())
    }

    pub(super) fn from_parts(centre: DVec3, size: f64) -> Self {
        Self { centre, size }
    }

    pub(super) fn parts(&self) -> (DVec3, f64) {
        (self.centre, self.size)
    }

    /// From the points' coordinates to the frame's; lengths keep their unit.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        point - self.centre
    }

    /// Back to the points' coordinates.
    pub(super) fn undo(&self, local: DVec3) -> DVec3 {
        local + self.centre
    }

    /// Largest distance of a coordinate from the centre.
    pub(super) fn farthest(&self, bounds: &Bounds) -> f64 {
        let (low, high) = (self.apply(bounds.min), self.apply(bounds.max));
        low.abs().max(high.abs()).max_element()
    }

    /// Refuses points that are too far outside for exact sums.
    pub(super) fn check(&self, bounds: &Bounds) -> Result<()> {
        let farthest = self.farthest(bounds);
        if farthest <= ROOM * self.size {
            return Ok(());
        }
        let must = format!("at most {:e} from where the first points lay", ROOM * self.size);
        Err(Error::parameter("points", must, format!("a coordinate {farthest:e} away")))
    }

    /// Grains in one unit of length.
    pub(super) fn grains_per_unit(&self) -> f64 {
        GRAINS / self.size
    }

    /// Length of a sum of grains.
    pub(super) fn length(&self, grains: i128) -> f64 {
        // The size alone may be too small for its grain to be a normal number.
        grains as f64 / GRAINS * self.size
    }
}
