//! Control points and their weights, apart and together.

use glam::{DVec3, DVec4};

use super::work_blocks::{in_steps, steps};
use crate::error::{Error, Result};
use crate::progress::Listen;

/// Ends that lie within this share of the size of each other are the same place.
const SAME_PLACE: f64 = 1e-10;

/// Share of the largest coordinate by which sums of control points may differ from rounding alone, if
/// their weights are equal: what counts for small things far from the origin.
const ROUNDING: f64 = 1e-14;

/// The homogeneous control points, (w x, w y, w z, w), of points and weights; without weights all
/// are 1. `name` says which one it is, for the error.
///
/// # Errors
///
/// [`Error::Net`] if the numbers of points and weights differ, a point is not finite, a weight not
/// positive and finite, or their product not a number to work with.
pub(super) fn lift(
    points: &[DVec3],
    weights: Option<&[f64]>,
    name: impl Fn(usize) -> String,
    listen: &mut Listen<'_>,
) -> Result<Vec<DVec4>> {
    let fail = |must, got| Err(Error::Net { must, got });
    if let Some(weights) = weights.filter(|weights| weights.len() != points.len()) {
        let got = format!("{} weights came for {} points", weights.len(), points.len());
        return fail("have one weight for each control point", got);
    }
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let mut lifted = Vec::with_capacity(points.len());
    for range in steps(points.len(), 1) {
        listen()?;
        if let Some(i) = range.clone().find(|&i| !points[i].is_finite()) {
            return fail("be finite", format!("control point {} is {}", name(i), points[i]));
        }
        if let Some(i) = range.clone().find(|&i| !(weight(i) > 0.0 && weight(i).is_finite())) {
            let got = format!("weight {} is {}", name(i), weight(i));
            return fail("have positive, finite weights", got);
        }
        lifted.extend(range.clone().map(|i| (points[i] * weight(i)).extend(weight(i))));
        let usable = |h: &DVec4| h.is_finite() && h.w.is_normal();
        if let Some(i) = range.clone().find(|&i| !usable(&lifted[i])) {
            let got = format!("control point {} with its weight is {}", name(i), lifted[i]);
            return fail("be finite when multiplied by its weights, and these not vanish", got);
        }
    }
    Ok(lifted)
}

/// Control points and, of a rational net, weights.
pub(super) fn project(
    net: &[DVec4],
    rational: bool,
    listen: &mut Listen<'_>,
) -> Result<(Vec<DVec3>, Option<Vec<f64>>)> {
    let all = (net.len(), 1);
    let points = in_steps(all, listen, |part| net[part].iter().map(|h| h.truncate() / h.w))?;
    if !rational {
        return Ok((points, None));
    }
    Ok((points, Some(in_steps(all, listen, |part| net[part].iter().map(|h| h.w))?)))
}

/// Smallest and largest coordinates.
pub(super) fn bounds(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let grow = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), grow)
}

/// The distance within which ends of a net in this box are the same place. Rounding of points of large
/// weight counts the more beside those of small weight.
pub(super) fn same_place((low, high): (DVec3, DVec3), weights: Option<&[f64]>) -> f64 {
    let farthest = low.abs().max(high.abs()).max_element();
    let weights = weights.unwrap_or(&[1.0]).iter();
    let most = weights.clone().copied().fold(0.0, f64::max);
    let least = weights.copied().fold(f64::INFINITY, f64::min);
    SAME_PLACE * low.distance(high) + ROUNDING * farthest * (most / least)
}

/// A bound of the distance between curves or surfaces of the same knots with these homogeneous
/// control points. With A = w P about the middle of the net, two rational points differ by a mean
/// of `ΔA - R Δw`, over the weights of the second.
pub(super) fn deviation(a: &[DVec4], b: &[DVec4]) -> f64 {
    let place = |h: &DVec4| h.truncate() / h.w;
    let first = place(&a[0]);
    let (low, high) =
        a.iter().fold((first, first), |(low, high), h| (low.min(place(h)), high.max(place(h))));
    let (middle, radius) = (low.midpoint(high), low.distance(high) / 2.0);
    let around = |h: &DVec4| -> DVec3 { h.truncate() - h.w * middle };
    let change =
        |(a, b): (&DVec4, &DVec4)| around(a).distance(around(b)) + radius * (a.w - b.w).abs();
    let most = a.iter().zip(b).map(change).fold(0.0, f64::max);
    let least = b.iter().map(|h| h.w).fold(f64::INFINITY, f64::min);
    if least > 0.0 { most / least } else { f64::INFINITY }
}

/// Whether two rows of homogeneous points are the same place, within a tolerance.
pub(super) fn same_row(a: &[DVec4], b: &[DVec4], tolerance: f64) -> bool {
    // Most rows that are not begin in different places.
    if a[0].project().distance(b[0].project()) > tolerance {
        return false;
    }
    // Weights count only up to a factor.
    let factor = a[0].w / b[0].w;
    let b: Vec<DVec4> = b.iter().map(|point| *point * factor).collect();
    deviation(a, &b) <= tolerance
}
