//! To which side normals point.

use glam::{DVec2, DVec3};

use crate::chart::Kind;
use crate::error::Result;
use crate::nurbs::{Direction, NurbsSurface};
use crate::progress::Observer;
use crate::validate::CellGrid;

/// Cells along a side on which the normals are summed.
const CELLS: usize = 32;

/// Share of the mean normal along z, or else x, under which it lies across that axis.
const ACROSS: f64 = 1e-6;

/// The surface with normals outward where it is closed, and else with a mean normal along +z, or, if
/// that lies in the plane of x and y, along +x, then +y. Parameters are turned with it.
pub(super) fn oriented(
    surface: NurbsSurface,
    uv: &mut [DVec2],
    kind: Kind,
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    let grid = CellGrid::of(&surface, CELLS, observer)?;
    let outward = if kind.closed().0 { around(&grid) } else { upward(&grid) };
    if outward >= 0.0 {
        return Ok(surface);
    }
    let (low, high) = surface.knots_v().domain();
    for uv in uv.iter_mut() {
        uv.y = (low + high - uv.y).clamp(low, high);
    }
    surface.reversed(Direction::V, observer)
}

/// The sum of the normals by how far they point away from the middle of their section.
fn around(grid: &CellGrid) -> f64 {
    let side = grid.side;
    let section = |col: usize| (0..side).map(move |row| row * side + col);
    let sums = (0..side).map(|col| {
        let centre = section(col).map(|at| grid.places[at]).sum::<DVec3>() / side as f64;
        let outward = |at: usize| grid.areas[at] * grid.normals[at].dot(grid.places[at] - centre);
        section(col).map(outward).sum::<f64>()
    });
    sums.sum()
}

/// The first component, of z, x and y, that the mean normal has.
fn upward(grid: &CellGrid) -> f64 {
    let mean: DVec3 = grid.normals.iter().zip(&grid.areas).map(|(n, area)| *n * *area).sum();
    let along = [mean.z, mean.x, mean.y];
    along.into_iter().find(|part| part.abs() > ACROSS * mean.length()).unwrap_or(0.0)
}
