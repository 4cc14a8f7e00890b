//! Where on a surface points have their feet.

use glam::{DVec2, DVec3};

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
