//! Where on a surface points have their feet, and what lies below them.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::fit::Base;
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

/// Where a surface of heights over a rectangle lies straight above or below points: places beside it have the
/// next on its border.
pub(super) fn below(surface: &NurbsSurface, points: &[DVec3], base: &Base) -> Vec<DVec2> {
    let ends = base.places(&[(0.0, 0.0), (1.0, 1.0)].map(|(u, v)| surface.point(u, v)));
    let inside = |place: DVec2| (place - ends[0]) / (ends[1] - ends[0]);
    let places = base.places(points).into_iter();
    places.map(|at| inside(at).clamp(DVec2::ZERO, DVec2::ONE)).collect()
}

/// Where one of heights over x and y does, and how far away that is.
pub(super) fn heights(surface: &NurbsSurface, points: &[DVec3]) -> (Vec<DVec2>, Vec<f64>) {
    let uv = below(surface, points, &Base::over(points, DVec3::Z));
    let distances = apart(surface, &uv, points);
    (uv, distances)
}

/// How far points are from where they lie on a surface.
pub(super) fn apart(surface: &NurbsSurface, uv: &[DVec2], points: &[DVec3]) -> Vec<f64> {
    let apart = |(at, point): (&DVec2, &DVec3)| surface.point(at.x, at.y).distance(*point);
    uv.par_iter().zip(points).map(apart).collect()
}
