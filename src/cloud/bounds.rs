//! The bounding box of points, and their mean.

use glam::DVec3;

use crate::error::Result;
use crate::progress::InterruptCheck;

/// Points that are processed between two reports: about ten milliseconds of neighbor searches.
pub(super) const POINTS_PER_REPORT: usize = 1 << 14;

/// The axis-aligned bounding box of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box around `points`. Without points it is empty: `min` is above `max`.
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::Bounds};
    /// let bounds = Bounds::of(&[DVec3::ZERO, DVec3::new(2.0, 3.0, 6.0)]);
    /// assert_eq!(bounds.diagonal(), 7.0);
    /// ```
    #[must_use]
    pub fn of(points: &[DVec3]) -> Self {
        points.iter().map(|&p| Self { min: p, max: p }).fold(Self::empty(), Self::join)
    }

    /// The box without points: `min` is above `max`.
    pub(super) fn empty() -> Self {
        Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }

    /// The box around both.
    pub(super) fn join(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Length of the diagonal, in the points' unit.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// The center of the box.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        // Halved first: the sum of two large coordinates may overflow.
        0.5 * self.min + 0.5 * self.max
    }

    /// The longest side, in the points' unit.
    #[must_use]
    pub fn extent(&self) -> f64 {
        (self.max - self.min).max_element()
    }
}

/// The mean of the points. The sum is taken relative to the first point, so that large offsets lose
/// no digits.
///
/// # Panics
///
/// If there are no points.
#[must_use]
pub fn centroid(points: &[DVec3]) -> DVec3 {
    // This closure never stops it.
    interruptible_centroid(points, &mut || Ok(())).unwrap_or(points[0])
}

/// As [`centroid`], but `check_interrupt` may stop it.
pub(crate) fn interruptible_centroid(
    points: &[DVec3],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<DVec3> {
    let origin = points[0];
    let mut sum = DVec3::ZERO;
    for batch in batches(points, check_interrupt) {
        batch?.iter().for_each(|&p| sum += p - origin);
    }
    Ok(origin + sum / points.len() as f64)
}

/// The points in batches of a few milliseconds of work. `check_interrupt` is called before each.
pub(crate) fn batches<'a>(
    points: &'a [DVec3],
    check_interrupt: &'a mut InterruptCheck<'_>,
) -> impl Iterator<Item = Result<&'a [DVec3]>> {
    points.chunks(POINTS_PER_REPORT).map(move |batch| check_interrupt().map(|()| batch))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centroid_keeps_the_digits_of_large_offsets() {
        let offset = DVec3::splat(1e9);
        let points: Vec<DVec3> =
            (0..1000).map(|i| offset + DVec3::X * (f64::from(i) / 1024.0)).collect();
        assert_eq!(centroid(&points), offset + DVec3::X * (999.0 / 2048.0));
    }
}
