//! Creases: isocurves at which the surface's tangents may jump.

use glam::DVec2;

use super::plane_curves::crossings_with_line;
use crate::error::Result;
use crate::nurbs::{Direction, NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// Relative jump of a tangent that makes a knot a crease. Rounding stays far below.
const JUMP: f64 = 1e-6;

/// Share of a span between a knot and the place where the tangent before it is taken.
const INSET: f64 = 1e-9;

/// Samples across each span along a knot.
const SAMPLES: u32 = 4;

/// The inner knots of a direction at which the derivative in that direction jumps.
pub(super) fn creases(surface: &NurbsSurface, direction: Direction) -> Vec<f64> {
    let (knots, other) = match direction {
        Direction::U => (surface.knots_u(), surface.knots_v()),
        Direction::V => (surface.knots_v(), surface.knots_u()),
    };
    let along = other.breaks();
    let places = along.windows(2).flat_map(|ends| {
        (0..SAMPLES)
            .map(|k| ends[0] + (ends[1] - ends[0]) * (f64::from(k) + 0.5) / f64::from(SAMPLES))
    });
    let places: Vec<f64> = places.collect();
    let tangent = |at: f64, place: f64| match direction {
        Direction::U => surface.tangents(at, place)[1],
        Direction::V => surface.tangents(place, at)[2],
    };
    let breaks = knots.breaks();
    let jumps = |k: &usize| {
        let at = breaks[*k];
        let before = at - INSET * (at - breaks[k - 1]);
        knots.multiplicity(at) >= knots.degree()
            && places.iter().any(|&place| {
                let (left, right) = (tangent(before, place), tangent(at, place));
                left.distance(right) > JUMP * left.length().max(right.length())
            })
    };
    (1..breaks.len() - 1).filter(jumps).map(|k| breaks[k]).collect()
}

/// Splits a curve in (u, v) where it crosses creases of a surface. The curve in space has a kink
/// there.
///
/// Lines of constant u or v stay whole, because their curve in space is exact.
pub(super) fn split_at_creases(
    surface: &NurbsSurface,
    curve: NurbsCurve,
) -> Result<Vec<NurbsCurve>> {
    let points = curve.control_points();
    let straight =
        |coordinate: usize| points.iter().all(|p| p[coordinate] == points[0][coordinate]);
    if straight(0) || straight(1) {
        return Ok(vec![curve]);
    }
    let mut cuts = vec![];
    for (direction, axis) in [(Direction::U, DVec2::X), (Direction::V, DVec2::Y)] {
        for value in creases(surface, direction) {
            cuts.extend(crossings_with_line(&curve, axis, value)?);
        }
    }
    split_at(curve, cuts)
}

/// Splits a curve at parameters inside its domain, in any order.
pub(super) fn split_at(curve: NurbsCurve, mut cuts: Vec<f64>) -> Result<Vec<NurbsCurve>> {
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let (mut parts, mut rest) = (vec![], curve);
    for at in cuts {
        let (before, after) = rest.split(at, &mut Silent)?;
        parts.push(before);
        rest = after;
    }
    parts.push(rest);
    Ok(parts)
}
