//! What a cloud of points is before anything is learned from it: its bounds, its centroid, the
//! frame in which the work is done, and whether it can be a surface at all.

mod clean;
mod even_sample;
mod hull;
mod kd_tree;
mod lines;
mod neighbor_graph;
mod neighborhoods;
mod no_data;
mod pieces;
mod plane;
mod quadric;
mod roads;

use glam::DVec3;
use rayon::prelude::*;

pub use self::clean::{Cleaning, Fate, clean};
pub use self::even_sample::EvenSample;
pub(crate) use self::even_sample::{any_of, even_sample, own_sample, rough_sample};
pub(crate) use self::hull::{area, hull, least_rectangle, turned};
pub use self::kd_tree::{KdTree, Neighbor};
pub(crate) use self::lines::across_lines;
pub(crate) use self::neighbor_graph::Front;
pub use self::neighbor_graph::{Edge, NeighborGraph};
pub(crate) use self::neighborhoods::{NEIGHBORS, Neighborhoods};
pub use self::no_data::{NoData, no_data};
pub use self::pieces::{Pieces, pieces};
pub(crate) use self::pieces::{hang_together, pieces_across};
pub use self::plane::Plane;
pub(crate) use self::plane::upward;
pub(crate) use self::roads::Roads;
use crate::error::{Error, Result};
use crate::progress::{self, Listen, Observer, Stage};

/// A bicubic Bézier patch or its linear ancestor needs four corners.
const LEAST_DISTINCT: usize = 4;

/// Largest sides of a bounding box for which neither squared distances nor squares of areas, as
/// normals need them, overflow or vanish.
const EXTENT_RANGE: (f64, f64) = (1e-70, 1e70);

/// Points count as collinear when their distance from a line is under this share of their
/// extent: rounding in single precision, which points often have been stored in.
const COLLINEAR_WIDTH: f64 = 4.0 * f32::EPSILON as f64;

/// Points looked at between two reports: a few milliseconds, even on a busy machine.
const POINTS_PER_REPORT: usize = 1 << 18;

/// The axis-aligned box around points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The box around `points`; of none at all, an empty one (`min` above `max`).
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::Bounds};
    /// let bounds = Bounds::of(&[DVec3::ZERO, DVec3::new(2.0, 3.0, 6.0)]);
    /// assert_eq!(bounds.diagonal(), 7.0);
    /// ```
    #[must_use]
    pub fn of(points: &[DVec3]) -> Self {
        points.par_iter().map(|&p| Self { min: p, max: p }).reduce(Self::empty, Self::join)
    }

    fn empty() -> Self {
        Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }

    fn join(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Length of the diagonal, in the points' unit.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// The middle of the box.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        // Halved first: the sum of two large coordinates may overflow.
        0.5 * self.min + 0.5 * self.max
    }

    /// The longest side, in the points' unit.
    #[must_use]
    pub fn extent(&self) -> f64 {
        (self.max - self.min).max_element()
    }
}

/// The mean of the points, summed about the first one so that large offsets keep their digits.
///
/// # Panics
///
/// If there are no points.
#[must_use]
pub fn centroid(points: &[DVec3]) -> DVec3 {
    // Nothing interrupts it.
    listened_centroid(points, &mut || Ok(())).unwrap_or(points[0])
}

/// As [`centroid`], in portions.
pub(crate) fn listened_centroid(points: &[DVec3], listen: &mut Listen<'_>) -> Result<DVec3> {
    let origin = points[0];
    let mut sum = DVec3::ZERO;
    for portion in portions(points, listen) {
        portion?.iter().for_each(|&p| sum += p - origin);
    }
    Ok(origin + sum / points.len() as f64)
}

/// The points in portions that take a few milliseconds to look at, each after listening.
pub(crate) fn portions<'a>(
    points: &'a [DVec3],
    listen: &'a mut Listen<'_>,
) -> impl Iterator<Item = Result<&'a [DVec3]>> {
    points.chunks(POINTS_PER_REPORT).map(move |portion| listen().map(|()| portion))
}

/// Checks that the points can be a surface: finite, at least four distinct ones, neither in one
/// place nor on one line.
///
/// # Errors
///
/// [`Error::NotFinite`], [`Error::AllEqual`], [`Error::TooFewPoints`], [`Error::Extent`],
/// [`Error::Collinear`].
pub fn check(points: &[DVec3]) -> Result<()> {
    checked_bounds(points, &mut progress::Silent).map(|_| ())
}

/// The bounds of points that pass [`check`].
pub(crate) fn checked_bounds(points: &[DVec3], observer: &mut dyn Observer) -> Result<Bounds> {
    let mut listen = progress::listener(observer, Stage::Checking, points.len());
    let bounds = finite_bounds(points, &mut listen)?;
    let given = points.len();
    match count_distinct(points) {
        1 if given > 1 => return Err(Error::AllEqual { given, point: points[0] }),
        LEAST_DISTINCT => {}
        distinct => {
            return Err(Error::TooFewPoints { needed: LEAST_DISTINCT, distinct, given });
        }
    }
    let (least, most) = EXTENT_RANGE;
    let extent = bounds.extent();
    if !(least..=most).contains(&extent) {
        return Err(Error::Extent { extent, least, most });
    }
    check_width(points, &bounds, &mut listen)?;
    Ok(bounds)
}

/// The bounds of points whose coordinates are all finite numbers.
///
/// # Errors
///
/// [`Error::NotFinite`] with the first that is not.
pub(crate) fn finite_bounds(points: &[DVec3], listen: &mut Listen<'_>) -> Result<Bounds> {
    let mut bounds = Bounds::empty();
    for (number, portion) in portions(points, listen).enumerate() {
        let portion = portion?;
        check_finite(portion).map_err(|error| match error {
            Error::NotFinite { index, point } => {
                Error::NotFinite { index: number * POINTS_PER_REPORT + index, point }
            }
            other => other,
        })?;
        bounds = bounds.join(Bounds::of(portion));
    }
    Ok(bounds)
}

/// Checks that all coordinates are finite numbers.
///
/// # Errors
///
/// [`Error::NotFinite`] with the first that is not.
pub fn check_finite(points: &[DVec3]) -> Result<()> {
    match points.par_iter().position_first(|p| !p.is_finite()) {
        Some(index) => Err(Error::NotFinite { index, point: points[index] }),
        None => Ok(()),
    }
}

/// Counts distinct points, but no further than needed.
fn count_distinct(points: &[DVec3]) -> usize {
    let mut seen: Vec<DVec3> = Vec::with_capacity(LEAST_DISTINCT);
    for &p in points {
        if !seen.contains(&p) {
            seen.push(p);
            if seen.len() == LEAST_DISTINCT {
                break;
            }
        }
    }
    seen.len()
}

/// Refuses points on one line: the one through the first point and the point farthest from it.
fn check_width(points: &[DVec3], bounds: &Bounds, listen: &mut Listen<'_>) -> Result<()> {
    let frame = Normalization::within(bounds);
    let first = frame.apply(points[0]);
    let mut along = DVec3::ZERO;
    let farther = |a: DVec3, b: DVec3| if b.length_squared() > a.length_squared() { b } else { a };
    for portion in portions(points, listen) {
        let local = portion?.par_iter().map(|&p| frame.apply(p) - first);
        along = farther(along, local.reduce(|| DVec3::ZERO, farther));
    }
    let (length, mut width) = (along.length(), 0.0_f64);
    for portion in portions(points, listen) {
        let aside = |&p: &DVec3| (frame.apply(p) - first).cross(along).length() / length;
        width = width.max(portion?.par_iter().map(aside).reduce(|| 0.0, f64::max));
    }
    // Coordinates far from the origin carry rounding of their own size, not of the extent's.
    let magnitude = bounds.min.abs().max(bounds.max.abs()).max_element();
    let rounding = 8.0 * f64::EPSILON * frame.scale * magnitude;
    if width > COLLINEAR_WIDTH.max(rounding) {
        return Ok(());
    }
    let (length, width) = (length / frame.scale, width / frame.scale);
    Err(Error::Collinear { given: points.len(), length, width })
}

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
    /// The frame of these points, which have passed [`check`].
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

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn far_away_millimetres_are_not_a_line() {
        let corner = DVec3::new(5e6, 7.8e6, 120.0);
        let square = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE].map(|d| corner + 0.001 * d);
        assert!(check(&square).is_ok());
    }

    #[test]
    fn rounding_does_not_widen_a_line() {
        let from = DVec3::new(5e6, 7.8e6, 120.0);
        let line: Vec<DVec3> =
            (0..100).map(|i| from + f64::from(i) * DVec3::new(0.1, 0.3, 0.7)).collect();
        assert!(matches!(check(&line), Err(Error::Collinear { .. })));
    }

    #[test]
    fn single_precision_does_not_widen_a_line() {
        let thirds = |i: u16| f32::from(i) / 3.0;
        let line: Vec<DVec3> = (0..100)
            .map(|i| Vec3::new(0.1, 0.3, 0.7) * thirds(i) + Vec3::splat(11.0))
            .map(DVec3::from)
            .collect();
        assert!(matches!(check(&line), Err(Error::Collinear { .. })));
        let bent: Vec<DVec3> = line.iter().map(|p| *p + DVec3::Z * (1e-4 * p.x * p.x)).collect();
        assert!(check(&bent).is_ok());
    }

    #[test]
    fn no_points_are_too_few() {
        assert!(matches!(check(&[]), Err(Error::TooFewPoints { distinct: 0, given: 0, .. })));
        assert!(matches!(check(&[DVec3::X]), Err(Error::TooFewPoints { distinct: 1, .. })));
    }

    #[test]
    fn centroid_keeps_the_digits_of_large_offsets() {
        let offset = DVec3::splat(1e9);
        let points: Vec<DVec3> =
            (0..1000).map(|i| offset + DVec3::X * (f64::from(i) / 1024.0)).collect();
        assert_eq!(centroid(&points), offset + DVec3::X * (999.0 / 2048.0));
    }
}
