//! Orientation of the result: the side to which its normals point.

use glam::{DVec2, DVec3};

use super::settings::OrientationSettings;
use crate::chart::Kind;
use crate::error::Result;
use crate::nurbs::{Direction, NurbsSurface};
use crate::progress::Observer;
use crate::validate::CellGrid;

const SETTINGS: OrientationSettings = OrientationSettings::STANDARD;

/// Reverses a surface and the parameters on it, if its normals point to the wrong side.
///
/// Normals of tubes and tori point outward. The mean normal of others points along +z; if it is
/// perpendicular to z, along +x, then +y.
pub(super) fn oriented(
    surface: NurbsSurface,
    uv: &mut [DVec2],
    kind: Kind,
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    let grid = CellGrid::of(&surface, SETTINGS.cells, observer)?;
    let sign = if kind.closed().0 { outward_flux(&grid) } else { leading_component(&grid) };
    if sign >= 0.0 {
        return Ok(surface);
    }
    let (low, high) = surface.knots_v().domain();
    for uv in uv.iter_mut() {
        uv.y = (low + high - uv.y).clamp(low, high);
    }
    surface.reversed(Direction::V, observer)
}

/// Sums the normals' components away from the center of their cross section.
fn outward_flux(grid: &CellGrid) -> f64 {
    let side = grid.side;
    let section = |col: usize| (0..side).map(move |row| row * side + col);
    let sums = (0..side).map(|col| {
        let center = section(col).map(|at| grid.places[at]).sum::<DVec3>() / side as f64;
        let outward = |at: usize| grid.areas[at] * grid.normals[at].dot(grid.places[at] - center);
        section(col).map(outward).sum::<f64>()
    });
    sums.sum()
}

/// The first component of the mean normal, of z, x and y, that is not 0 up to rounding.
fn leading_component(grid: &CellGrid) -> f64 {
    let mean: DVec3 = grid.normals.iter().zip(&grid.areas).map(|(n, area)| *n * *area).sum();
    let least = SETTINGS.min_component * mean.length();
    let along = [mean.z, mean.x, mean.y];
    along.into_iter().find(|part| part.abs() > least).unwrap_or(0.0)
}
