//! The defects of a surface: what makes it invalid.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::CellGrid;
use super::terms::{Compared, TermSettings};
use crate::cloud::{Neighbor, Plane};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::numeric::{median, rms};
use crate::progress::Silent;

/// The neighbour whose distance is the spacing around a cell.
const SPACING: usize = 4;

/// When a surface is not valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefectSettings {
    /// Share of neighbouring cells whose normals turn over against the local planes.
    pub folded: f64,
    /// How far outside of the points' box it goes, in the box's diagonal.
    pub overshoot: f64,
    /// Share of a closed surface's area without points near.
    pub uncovered: f64,
    /// Share of the links between neighbours that are torn.
    pub torn: f64,
    /// Root mean square distance of the points, in the diagonal of their box.
    pub thick: f64,
    /// Points by which folds are told from bends, at most.
    pub points: usize,
    /// Cells along a side of the grid on which folds are looked for.
    pub cells: usize,
    /// Points in a local plane.
    pub neighbors: usize,
    /// Thickness over width up to which a local plane has a side.
    pub flat: f64,
    /// Cosine between neighbouring local planes from which on their sides are compared.
    pub alike: f64,
}

impl Default for DefectSettings {
    fn default() -> Self {
        Self {
            folded: 0.01,
            overshoot: 0.1,
            uncovered: 0.1,
            torn: 0.05,
            thick: 0.11,
            points: 50_000,
            cells: 70,
            neighbors: 12,
            flat: 0.14,
            alike: 0.7,
        }
    }
}

/// The defects of a surface, none of a valid one.
///
/// # Errors
///
/// Those of evaluation, which none of these meets.
pub fn defects(
    compared: &Compared<'_>,
    terms: &TermSettings,
    settings: &DefectSettings,
) -> Result<Vec<Diagnostic>> {
    let diagonal = compared.diagonal;
    let grid = CellGrid::of(compared.surface, settings.cells, &mut Silent)?;
    let distance = overshoot(compared, &grid);
    let found = compared.terms(terms)?;
    let share = folded_share(compared, &grid, settings);
    let off = rms(compared.distances.iter().copied());
    let closed = compared.closed[0];
    let all = [
        (share > settings.folded, Diagnostic::Folded { share }),
        (distance > settings.overshoot * diagonal, Diagnostic::Overshoot { distance, diagonal }),
        (
            closed && found.uncovered > settings.uncovered,
            Diagnostic::Uncovered { share: found.uncovered },
        ),
        (found.torn > settings.torn, Diagnostic::Torn { share: found.torn }),
        (off > settings.thick * diagonal, Diagnostic::Thick { rms: off, diagonal }),
    ];
    Ok(all.into_iter().filter(|(present, _)| *present).map(|(_, defect)| defect).collect())
}

/// How far a surface goes outside of the cylinder around the points' box along their principal
/// axes: the box itself would cut the corners of a sheet that is turned against it.
fn overshoot(compared: &Compared<'_>, grid: &CellGrid) -> f64 {
    let axes = compared.seen.axes();
    let local = compared.seen.points().iter().map(|point| axes.local(*point));
    let (low, high) = local.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
        (low.min(point), high.max(point))
    });
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let outside = |place: &DVec3| {
        let apart = axes.local(*place) - middle;
        let around = apart.truncate().length() - half.truncate().length();
        around.max(0.0).hypot((apart.z.abs() - half.z).max(0.0))
    };
    grid.places.iter().map(outside).fold(0.0, f64::max)
}

/// Share of neighbouring cells whose normals turn over against the local planes of the points
/// beneath: the side of the plane, carried along, must not change against the surface's.
#[must_use]
pub fn folded_share(compared: &Compared<'_>, grid: &CellGrid, settings: &DefectSettings) -> f64 {
    let (tree, points) = (compared.tree, compared.tree.points());
    let below = |found: &mut Vec<Neighbor>, place: &DVec3| {
        tree.nearest_where(*place, settings.neighbors, f64::INFINITY, found, |_| true);
        let plane = Plane::of(found.iter().map(|near| points[near.index as usize]));
        let spacing = found.iter().take(SPACING).next_back().map_or(0.0, Neighbor::distance);
        (found.first().map_or(0.0, Neighbor::distance), spacing, plane)
    };
    let planes: Vec<(f64, f64, Plane)> = grid.places.par_iter().map_init(Vec::new, below).collect();
    let reach = 2.0 * median(planes.iter().map(|(_, spacing, _)| *spacing));
    let side = |cell: usize| {
        let (near, _, plane) = &planes[cell];
        let [_, width, thickness] = plane.deviations;
        let told = *near < reach && thickness < settings.flat * width;
        told.then(|| (plane.normal(), grid.normals[cell].dot(plane.normal()).signum()))
    };
    let sides: Vec<Option<(DVec3, f64)>> = (0..planes.len()).map(side).collect();
    let (mut turned, mut count) = (0.0, 0.0);
    for [a, b] in grid.neighbors() {
        let (Some((normal_a, sign_a)), Some((normal_b, sign_b))) = (sides[a], sides[b]) else {
            continue;
        };
        let cosine = normal_a.dot(normal_b);
        if cosine.abs() > settings.alike {
            count += 1.0;
            turned += f64::from(sign_a * sign_b * cosine < 0.0);
        }
    }
    if count > 0.0 { turned / count } else { 0.0 }
}
