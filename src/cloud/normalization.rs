//! Normalization of coordinates: a centered and scaled frame.

use glam::DVec3;

use super::bounds::Bounds;

/// A frame in which the cloud's box is centered on the origin. Its longest side lies in `(1/2, 1]`.
///
/// Large coordinates with small details keep their digits. The scale is a power of two, because
/// multiplying by it is exact. Only the shift of the center rounds, once in each direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normalization {
    /// The point that becomes the origin, in the points' unit.
    pub center: DVec3,
    /// Length in this frame of one unit of the points.
    pub scale: f64,
}

impl Normalization {
    /// The frame of these points, which have passed [`check`](super::check).
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::Normalization};
    /// let points = [DVec3::splat(5e6), DVec3::splat(5e6 + 0.001)];
    /// let frame = Normalization::of(&points);
    /// let p = frame.apply(points[1]);
    /// assert!(p.max_element() <= 0.5);
    /// assert_eq!(frame.undo(p), points[1]);
    /// ```
    #[must_use]
    pub fn of(points: &[DVec3]) -> Self {
        Self::within(&Bounds::of(points))
    }

    /// The frame of points with these bounds.
    pub(crate) fn within(bounds: &Bounds) -> Self {
        Self { center: bounds.center(), scale: (-bounds.extent().log2().ceil()).exp2() }
    }

    /// From the points' frame to the normalized one.
    #[must_use]
    pub fn apply(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.scale
    }

    /// From the normalized frame back to the points' own.
    #[must_use]
    pub fn undo(&self, point: DVec3) -> DVec3 {
        point / self.scale + self.center
    }
}
