//! Where on a surface points have their feet, and what lies below them.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, ClosestPointSlices, NurbsSurface};
use crate::progress::Observer;

/// Parameters of the points' feet, and how far away they are.
pub(super) fn feet(
    surface: &NurbsSurface,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<(Vec<DVec2>, Vec<f64>)> {
    let count = points.len();
    let (mut uv, mut feet) = (vec![DVec2::ZERO; count], vec![DVec3::ZERO; count]);
    let (mut distances, mut converged) = (vec![0.0; count], vec![false; count]);
    let found = ClosestPointSlices {
        uv: &mut uv,
        points: &mut feet,
        distances: &mut distances,
        converged: &mut converged,
    };
    ClosestPointSearch::new(surface)?.closest_points(points, found, observer)?;
    Ok((uv, distances))
}

/// Where a surface of heights over x and y lies straight above or below points, and how far away: places
/// beside it have the next on its border.
pub(super) fn heights(surface: &NurbsSurface, points: &[DVec3]) -> (Vec<DVec2>, Vec<f64>) {
    let ends = [(0.0, 0.0), (1.0, 1.0)].map(|(u, v)| surface.point(u, v).truncate());
    let over = |point: &DVec3| {
        let inside = (point.truncate() - ends[0]) / (ends[1] - ends[0]);
        let uv = inside.clamp(DVec2::ZERO, DVec2::ONE);
        (uv, surface.point(uv.x, uv.y).distance(*point))
    };
    points.par_iter().map(over).unzip()
}
