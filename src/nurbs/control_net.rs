//! Conversion of control nets to and from homogeneous coordinates, their bounding boxes and
//! distances.

use glam::{DVec3, DVec4};

use super::work_blocks::{collect_in_steps, row_ranges};
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

/// A homogeneous point (w x, w y, w z, w) as an array, which the compiler vectorizes.
pub(super) type HomogeneousPoint = [f64; 4];

/// Two ends of a net coincide if their distance is below this fraction of the net's size.
const COINCIDENCE: f64 = 1e-10;

/// Rounding error of a sum of control points with equal weights, as a fraction of the largest
/// coordinate. It matters for small nets far from the origin.
const ROUNDING: f64 = 1e-14;

/// Returns the homogeneous control points (w x, w y, w z, w); without weights all are 1.
///
/// `name` returns the label of a control point for the error message.
///
/// # Errors
///
/// [`Error::Net`] if one of these holds:
///
/// - The numbers of points and weights differ.
/// - A point is not finite, or a weight is not positive and finite.
/// - The product of a point and its weight overflows or underflows.
pub(super) fn to_homogeneous(
    points: &[DVec3],
    weights: Option<&[f64]>,
    name: impl Fn(usize) -> String,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec4>> {
    let fail = |must, got| Err(Error::Net { must, got });
    if let Some(weights) = weights.filter(|weights| weights.len() != points.len()) {
        let got = format!("{} weights were given for {} points", weights.len(), points.len());
        return fail("have one weight for each control point", got);
    }
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let mut homogeneous = Vec::with_capacity(points.len());
    for range in row_ranges(points.len(), 1) {
        check_interrupt()?;
        if let Some(i) = range.clone().find(|&i| !points[i].is_finite()) {
            return fail("be finite", format!("control point {} is {}", name(i), points[i]));
        }
        if let Some(i) = range.clone().find(|&i| !(weight(i) > 0.0 && weight(i).is_finite())) {
            let got = format!("weight {} is {}", name(i), weight(i));
            return fail("have positive, finite weights", got);
        }
        homogeneous.extend(range.clone().map(|i| (points[i] * weight(i)).extend(weight(i))));
        let usable = |h: &DVec4| h.is_finite() && h.w.is_normal();
        if let Some(i) = range.clone().find(|&i| !usable(&homogeneous[i])) {
            let got = format!("control point {} with its weight is {}", name(i), homogeneous[i]);
            return fail(
                "have finite products of points and weights, and no subnormal weights",
                got,
            );
        }
    }
    Ok(homogeneous)
}

/// Returns the control points in space and, for a rational net, the weights.
pub(super) fn dehomogenize(
    net: &[DVec4],
    rational: bool,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<(Vec<DVec3>, Option<Vec<f64>>)> {
    let all = (net.len(), 1);
    let points = collect_in_steps(all, check_interrupt, |part| {
        net[part].iter().map(|h| h.truncate() / h.w)
    })?;
    if !rational {
        return Ok((points, None));
    }
    Ok((
        points,
        Some(collect_in_steps(all, check_interrupt, |part| net[part].iter().map(|h| h.w))?),
    ))
}

/// Transposes a net with this many columns.
pub(super) fn transpose<T: Copy>(
    net: &[T],
    cols: usize,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<T>> {
    collect_in_steps((cols, net.len() / cols), check_interrupt, |columns| {
        columns.flat_map(|j| net.iter().skip(j).step_by(cols).copied())
    })
}

/// Returns the smallest and largest coordinates.
pub(super) fn bounds(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let grow = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), grow)
}

/// Returns the distance below which ends of a net with this bounding box coincide.
///
/// The ratio of the weights amplifies rounding: points of large weight affect those of small
/// weight.
pub(super) fn coincidence_tolerance((low, high): (DVec3, DVec3), weights: Option<&[f64]>) -> f64 {
    let farthest = low.abs().max(high.abs()).max_element();
    let weights = weights.unwrap_or(&[1.0]).iter();
    let max_weight = weights.clone().copied().fold(0.0, f64::max);
    let min_weight = weights.copied().fold(f64::INFINITY, f64::min);
    COINCIDENCE * low.distance(high) + ROUNDING * farthest * (max_weight / min_weight)
}

/// Bounds the distance between two curves or surfaces with the same knots, from their homogeneous
/// control points.
///
/// With A = w P relative to the center of the net, two rational points differ by a mean of
/// `ΔA - R Δw`, divided by the weights of the second.
pub(super) fn distance_bound(a: &[DVec4], b: &[DVec4]) -> f64 {
    let place = |h: &DVec4| h.truncate() / h.w;
    let first = place(&a[0]);
    let (low, high) =
        a.iter().fold((first, first), |(low, high), h| (low.min(place(h)), high.max(place(h))));
    let (middle, radius) = (low.midpoint(high), low.distance(high) / 2.0);
    let around = |h: &DVec4| -> DVec3 { h.truncate() - h.w * middle };
    let change =
        |(a, b): (&DVec4, &DVec4)| around(a).distance(around(b)) + radius * (a.w - b.w).abs();
    let max_change = a.iter().zip(b).map(change).fold(0.0, f64::max);
    let min_weight = b.iter().map(|h| h.w).fold(f64::INFINITY, f64::min);
    if min_weight > 0.0 { max_change / min_weight } else { f64::INFINITY }
}

/// Whether two rows of homogeneous points describe the same curve, within a tolerance.
pub(super) fn rows_coincide(a: &[DVec4], b: &[DVec4], tolerance: f64) -> bool {
    // Most rows that differ already differ in the first point.
    if a[0].project().distance(b[0].project()) > tolerance {
        return false;
    }
    // A common factor of all weights does not change the curve.
    let factor = a[0].w / b[0].w;
    let b: Vec<DVec4> = b.iter().map(|point| *point * factor).collect();
    distance_bound(a, &b) <= tolerance
}
