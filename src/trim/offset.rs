//! The offset: places of a border moved out to where the true border is.

use glam::{DVec2, DVec3};

use super::spline_fit::{Targets, metric};
use crate::error::Result;
use crate::nurbs::{NurbsCurve, Outside};
use crate::progress::Silent;

/// The places moved by distances in space to the right of a curve with the region on its left.
pub(super) fn outward(
    curve: &NurbsCurve,
    places: &Targets<'_>,
    distances: &[f64],
) -> Result<Vec<DVec2>> {
    let mut rows = vec![DVec3::ZERO; 2 * places.at.len()];
    curve.derivatives(places.at, 1, &mut rows, Outside::Extrapolate, &mut Silent)?;
    let moved = rows.chunks_exact(2).zip(places.uv).zip(places.tangents).zip(distances);
    let moved = moved.map(|(((row, uv), tangents), distance)| {
        *uv + right_of(row[1].truncate(), *tangents) * *distance
    });
    Ok(moved.collect())
}

/// The step in (u, v) of length 1 in space to the right of a direction in (u, v); zero where the
/// surface has no normal.
fn right_of(direction: DVec2, tangents: [DVec3; 2]) -> DVec2 {
    let [by_u, by_v] = tangents;
    let along = (direction.x * by_u + direction.y * by_v).normalize_or_zero();
    let right = along.cross(by_u.cross(by_v).normalize_or_zero());
    let step = metric(tangents).inverse() * DVec2::new(by_u.dot(right), by_v.dot(right));
    if step.is_finite() { step } else { DVec2::ZERO }
}
