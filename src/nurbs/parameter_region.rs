//! Regions of the (u, v) plane to which searches on a surface are restricted.

use std::fmt::Debug;

use glam::DVec2;

/// How a region covers a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cover {
    /// The rectangle lies inside the region.
    Inside,
    /// The rectangle lies outside the region.
    Outside,
    /// The region's border passes through the rectangle or touches it.
    Cut,
}

/// A closed region of the (u, v) plane.
pub(crate) trait ParameterRegion: Debug + Send + Sync {
    /// How the region covers the closed rectangle with these opposite corners.
    fn cover(&self, low: DVec2, high: DVec2) -> Cover;

    /// Whether a place is in the region. The border counts.
    fn contains(&self, uv: DVec2) -> bool;
}
