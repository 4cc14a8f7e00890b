//! Defects of a surface by comparison with its points: folded, overshoot, uncovered, torn, thick.
//!
//! The other findings that make a surface invalid need the whole reconstruction; see
//! `pipeline/diagnose.rs`.

use glam::DVec3;
use rayon::prelude::*;

use super::cell_grid::CellGrid;
use super::error_terms::Comparison;
use super::settings::{DefectSettings, TermSettings};
use crate::cloud::{Neighbor, Plane, convex_hull, is_in_hull};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::numeric::{median, rms};
use crate::progress::Silent;

/// Finds the defects of a surface; a valid one has none. `diagonal` is that of the points' box in
/// their given frame.
///
/// # Errors
///
/// Those of the surface's evaluation; parameters in the domain cause none.
pub fn defects(
    compared: &Comparison<'_>,
    diagonal: f64,
    terms: &TermSettings,
    settings: &DefectSettings,
) -> Result<Vec<Diagnostic>> {
    let grid = CellGrid::of(compared.surface, settings.cells, &mut Silent)?;
    let distance = overshoot(compared, &grid);
    let found = compared.terms(terms)?;
    let share = folded_share(compared, &grid, settings);
    let off = rms(compared.distances.iter().copied());
    let closed = compared.closed[0];
    let all = [
        (share > settings.max_folded, Diagnostic::Folded { share }),
        (
            distance > settings.max_overshoot * diagonal,
            Diagnostic::Overshoot { distance, diagonal },
        ),
        (
            closed && found.uncovered > settings.max_uncovered,
            Diagnostic::Uncovered { share: found.uncovered },
        ),
        (found.torn > settings.max_torn, Diagnostic::Torn { share: found.torn }),
        (off > settings.max_thickness * diagonal, Diagnostic::Thick { rms: off, diagonal }),
    ];
    Ok(all.into_iter().filter(|(present, _)| *present).map(|(_, defect)| defect).collect())
}

/// Largest distance of a surface outside the cylinder around the box along the points' principal
/// axes, where its parameters are between those of the points: what lies beyond is trimmed.
///
/// The box itself would cut the corners of a sheet that is rotated against it.
fn overshoot(compared: &Comparison<'_>, grid: &CellGrid) -> f64 {
    let axes = compared.observations.axes();
    let local = compared.observations.points().iter().map(|point| axes.local(*point));
    let (low, high) = local.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
        (low.min(point), high.max(point))
    });
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let outside = |place: &DVec3| {
        let apart = axes.local(*place) - middle;
        let around = apart.truncate().length() - half.truncate().length();
        around.max(0.0).hypot((apart.z.abs() - half.z).max(0.0))
    };
    let hull = convex_hull(compared.uv);
    let cells = grid.places.iter().zip(&grid.uv).filter(|(_, uv)| is_in_hull(&hull, **uv));
    cells.map(|(place, _)| outside(place)).fold(0.0, f64::max)
}

/// Share of neighboring cells whose normals turn over against the local planes of the points.
///
/// From cell to cell, the surface's normal must stay on the same side of the local plane.
#[must_use]
pub fn folded_share(compared: &Comparison<'_>, grid: &CellGrid, settings: &DefectSettings) -> f64 {
    let (tree, points) = (compared.tree, compared.tree.points());
    let below = |found: &mut Vec<Neighbor>, place: &DVec3| {
        tree.nearest_where(*place, settings.k_neighbors, f64::INFINITY, found, |_| true);
        let plane = Plane::of(found.iter().map(|near| points[near.index as usize]));
        let spacing =
            found.iter().take(settings.spacing_rank).next_back().map_or(0.0, Neighbor::distance);
        (found.first().map_or(0.0, Neighbor::distance), spacing, plane)
    };
    let planes: Vec<(f64, f64, Plane)> = grid.places.par_iter().map_init(Vec::new, below).collect();
    let reach = settings.max_gap * median(planes.iter().map(|(_, spacing, _)| *spacing));
    let side = |cell: usize| {
        let (near, _, plane) = &planes[cell];
        let [_, width, thickness] = plane.deviations;
        let has_side = *near < reach && thickness < settings.max_flatness * width;
        has_side.then(|| (plane.normal(), grid.normals[cell].dot(plane.normal()).signum()))
    };
    let sides: Vec<Option<(DVec3, f64)>> = (0..planes.len()).map(side).collect();
    let (mut turned, mut count) = (0.0, 0.0);
    for [a, b] in grid.neighbors() {
        let (Some((normal_a, sign_a)), Some((normal_b, sign_b))) = (sides[a], sides[b]) else {
            continue;
        };
        let cosine = normal_a.dot(normal_b);
        if cosine.abs() > settings.min_plane_cosine {
            count += 1.0;
            turned += f64::from(sign_a * sign_b * cosine < 0.0);
        }
    }
    if count > 0.0 { turned / count } else { 0.0 }
}
