//! A centred and scaled frame.

use glam::DVec3;

use super::bounds::Bounds;

/// The frame in which the work is done: the cloud's box centred on the origin, and scaled by a
/// power of two so that its longest side lies in `(1/2, 1]`.
///
/// Coordinates of 5,000,000 with details of a millimetre thus keep their digits. The scale is a
/// power of two because multiplying by it is exact: only moving the centre rounds, once each way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normalization {
    /// What becomes the origin, in the points' unit.
    pub centre: DVec3,
    /// Normalized length of one unit of the points.
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
        Self { centre: bounds.centre(), scale: (-bounds.extent().log2().ceil()).exp2() }
    }

    /// From the points' frame to the normalized one.
    #[must_use]
    pub fn apply(&self, point: DVec3) -> DVec3 {
        (point - self.centre) * self.scale
    }

    /// From the normalized frame back to the points' own.
    #[must_use]
    pub fn undo(&self, point: DVec3) -> DVec3 {
        point / self.scale + self.centre
    }
}
