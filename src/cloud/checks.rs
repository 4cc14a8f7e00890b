//! Checks that points can be a surface.

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::{Bounds, POINTS_PER_REPORT, batches};
use super::normalization::Normalization;
use super::settings::CheckSettings;
use crate::error::{Error, Result};
use crate::progress::{self, InterruptCheck, Observer, Stage};
use crate::worker_pool::install;

const SETTINGS: CheckSettings = CheckSettings::STANDARD;

/// Checks that the points can be a surface: finite, enough distinct ones, not all at one place and
/// not on one line.
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
    let bounds = checked_extent(points, observer)?;
    let mut check_interrupt = progress::interrupt_check(observer, Stage::Checking, points.len());
    check_width(points, &bounds, &mut check_interrupt)?;
    Ok(bounds)
}

/// The bounds of points that pass [`check`], except that they may lie on one line. One outlier far
/// away makes any points look like that.
pub(crate) fn checked_extent(points: &[DVec3], observer: &mut dyn Observer) -> Result<Bounds> {
    let mut check_interrupt = progress::interrupt_check(observer, Stage::Checking, points.len());
    let bounds = finite_bounds(points, &mut check_interrupt)?;
    let given = points.len();
    match count_distinct(points) {
        1 if given > 1 => return Err(Error::AllEqual { given, point: points[0] }),
        distinct if distinct < SETTINGS.min_distinct => {
            return Err(Error::TooFewPoints { needed: SETTINGS.min_distinct, distinct, given });
        }
        _ => {}
    }
    let (least, most) = (SETTINGS.min_extent, SETTINGS.max_extent);
    let extent = bounds.extent();
    if !(least..=most).contains(&extent) {
        return Err(Error::Extent { extent, least, most });
    }
    Ok(bounds)
}

/// The bounds of points whose coordinates are all finite numbers.
///
/// # Errors
///
/// [`Error::NotFinite`] with the first point that is not.
pub(crate) fn finite_bounds(
    points: &[DVec3],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Bounds> {
    let mut bounds = Bounds::empty();
    for (number, batch) in batches(points, check_interrupt).enumerate() {
        let batch = batch?;
        check_finite(batch).map_err(|error| match error {
            Error::NotFinite { index, point } => {
                Error::NotFinite { index: number * POINTS_PER_REPORT + index, point }
            }
            other => other,
        })?;
        bounds = bounds.join(Bounds::of(batch));
    }
    Ok(bounds)
}

/// Checks that all coordinates are finite numbers.
///
/// # Errors
///
/// [`Error::NotFinite`] with the first point that is not.
pub fn check_finite(points: &[DVec3]) -> Result<()> {
    match points.iter().position(|p| !p.is_finite()) {
        Some(index) => Err(Error::NotFinite { index, point: points[index] }),
        None => Ok(()),
    }
}

/// Counts distinct points up to the number that is needed.
fn count_distinct(points: &[DVec3]) -> usize {
    let mut seen: Vec<DVec3> = Vec::with_capacity(SETTINGS.min_distinct);
    for &p in points {
        if !seen.contains(&p) {
            seen.push(p);
            if seen.len() == SETTINGS.min_distinct {
                break;
            }
        }
    }
    seen.len()
}

/// Refuses collinear points. The line passes through the first point and the one farthest from it.
fn check_width(
    points: &[DVec3],
    bounds: &Bounds,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<()> {
    let frame = Normalization::within(bounds);
    let first = frame.apply(points[0]);
    let mut along = DVec3::ZERO;
    let farther = |a: DVec3, b: DVec3| if b.length_squared() > a.length_squared() { b } else { a };
    for batch in batches(points, check_interrupt) {
        let local = batch?.par_iter().map(|&p| frame.apply(p) - first);
        along = farther(along, install(|| local.reduce(|| DVec3::ZERO, farther)));
    }
    let (length, mut width) = (along.length(), 0.0_f64);
    for batch in batches(points, check_interrupt) {
        let aside = |&p: &DVec3| (frame.apply(p) - first).cross(along).length() / length;
        let widths = batch?.par_iter().map(aside);
        width = width.max(install(|| widths.reduce(|| 0.0, f64::max)));
    }
    // Rounding errors of coordinates are relative to their size, not to the extent.
    let magnitude = bounds.min.abs().max(bounds.max.abs()).max_element();
    let rounding = SETTINGS.line_rounding * f64::EPSILON * frame.scale * magnitude;
    if width > SETTINGS.max_line_width.max(rounding) {
        return Ok(());
    }
    let (length, width) = (length / frame.scale, width / frame.scale);
    Err(Error::Collinear { given: points.len(), length, width })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_small_square_far_from_the_origin_is_not_a_line() {
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
}
