//! Control points and their weights, apart and together.

use glam::{DVec3, DVec4};

use crate::error::{Error, Result};

/// Ends that lie within this share of the size of each other are the same place.
const SAME_PLACE: f64 = 1e-10;

/// Share of the largest coordinate by which sums of control points may differ from rounding alone:
/// what counts for small things far from the origin.
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
) -> Result<Vec<DVec4>> {
    let fail = |must, got| Err(Error::Net { must, got });
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return fail("be finite", format!("control point {} is {}", name(i), points[i]));
    }
    let Some(weights) = weights else {
        return Ok(points.iter().map(|p| p.extend(1.0)).collect());
    };
    if weights.len() != points.len() {
        let got = format!("{} weights came for {} points", weights.len(), points.len());
        return fail("have one weight for each control point", got);
    }
    if let Some(i) = weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
        return fail(
            "have positive, finite weights",
            format!("weight {} is {}", name(i), weights[i]),
        );
    }
    let lifted = points.iter().zip(weights).map(|(p, w)| (*p * *w).extend(*w));
    let lifted: Vec<DVec4> = lifted.collect();
    if let Some(i) = lifted.iter().position(|h| !(h.is_finite() && h.w.is_normal())) {
        let got = format!("control point {} with its weight is {}", name(i), lifted[i]);
        return fail("be finite when multiplied by its weights, and these not vanish", got);
    }
    Ok(lifted)
}

/// Control points and, of a rational net, weights.
pub(super) fn project(net: &[DVec4], rational: bool) -> (Vec<DVec3>, Option<Vec<f64>>) {
    let points = net.iter().map(|h| h.truncate() / h.w).collect();
    (points, rational.then(|| net.iter().map(|h| h.w).collect()))
}

/// Smallest and largest coordinates.
pub(super) fn bounds(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let grow = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), grow)
}

/// The distance within which ends of a net are the same place.
pub(super) fn same_place(points: &[DVec3]) -> f64 {
    let (low, high) = bounds(points.iter().copied());
    let farthest = low.abs().max(high.abs()).max_element();
    SAME_PLACE * low.distance(high) + ROUNDING * farthest
}
