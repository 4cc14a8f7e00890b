//! Axes that look as if they had different units.

use std::fmt;

use glam::DVec3;

use crate::cloud::Bounds;

/// From this ratio on of the largest side of the bounding box to the second, points are rather in
/// different units than on so narrow a strip.
pub(crate) const UNEVEN: f64 = 100.0;

/// Sides of a bounding box that differ so much that the axes may have different units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnevenExtents {
    /// The sides of the box.
    pub extents: DVec3,
}

impl fmt::Display for UnevenExtents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.extents;
        write!(
            f,
            "the points extend {x:.4} × {y:.4} × {z:.4}: if the axes have different units, bring \
             them to one, because distances count alike in all directions"
        )
    }
}

/// Whether one side of the points' box is more than a hundred times each of the others. (That the
/// third is small is no sign: flat sheets are.)
///
/// ```
/// use neurbs::{DVec3, validate::uneven_extents};
/// let points = [DVec3::ZERO, DVec3::new(1.0, 2000.0, 0.5)];
/// assert!(uneven_extents(&points).unwrap().to_string().contains("1.0000 × 2000.0000 × 0.5000"));
/// ```
#[must_use]
pub fn uneven_extents(points: &[DVec3]) -> Option<UnevenExtents> {
    let bounds = Bounds::of(points);
    let extents = bounds.max - bounds.min;
    let mut sides = extents.to_array();
    sides.sort_by(f64::total_cmp);
    (sides[2] > UNEVEN * sides[1]).then_some(UnevenExtents { extents })
}
