//! Which places of a border lie outside of its curves, and how far.

use glam::{DVec2, DVec3};

use super::border::Border;
use super::places::Rectangle;
use super::settings::OutlineSettings;
use crate::cloud::KdTree;
use crate::error::Result;
use crate::nurbs::{NurbsCurve, NurbsSurface, Outside};
use crate::progress::Silent;

const SETTINGS: OutlineSettings = OutlineSettings::STANDARD;

/// The distances of places outside of the curves, in spacings; 0 for those inside.
pub(super) fn outside_shares(
    border: &Border,
    curves: &[NurbsCurve],
    surface: &NurbsSurface,
) -> Result<Vec<f64>> {
    let step = SETTINGS.sample_distance * border.spacing;
    // A surface may run away from its points.
    let most = SETTINGS.side_samples * border.len();
    let count = (border.length() / step).ceil().min(most as f64);
    let samples = samples(curves, crate::numeric::whole(count));
    let rectangle = Rectangle::of(surface);
    let places: Vec<DVec2> = samples.iter().map(|(at, _)| rectangle.wrapped(*at)).collect();
    let points = in_space(surface, &places)?;
    let tree = KdTree::new(&points);
    let outside = |k: usize| {
        let nearest = &tree.nearest(border.points[k], 1)[0];
        let (at, along) = samples[nearest.index as usize];
        let right = along.perp_dot(rectangle.way(at, border.uv[k])) < 0.0;
        if right { nearest.distance() / border.spacing } else { 0.0 }
    };
    Ok((0..border.len()).map(outside).collect())
}

/// Places along curves, with directions.
fn samples(curves: &[NurbsCurve], count: usize) -> Vec<(DVec2, DVec2)> {
    let controls: usize = curves.iter().map(|curve| curve.control_points().len()).sum();
    let mut samples = vec![];
    for curve in curves {
        let share = curve.control_points().len() as f64 / controls as f64;
        let own = crate::numeric::whole((share * count as f64).ceil()) + 4;
        let (from, to) = curve.knots().domain();
        let at = |k: usize| curve.point(from + (to - from) * k as f64 / own as f64).truncate();
        let points: Vec<DVec2> = (0..=own).map(at).collect();
        samples
            .extend(points.windows(2).map(|pair| (0.5 * (pair[0] + pair[1]), pair[1] - pair[0])));
    }
    samples
}

/// The points of a surface, extrapolated outside of its rectangle.
pub(super) fn in_space(surface: &NurbsSurface, uv: &[DVec2]) -> Result<Vec<DVec3>> {
    let mut points = vec![DVec3::ZERO; uv.len()];
    surface.evaluate(uv, &mut points, Outside::Extrapolate, &mut Silent)?;
    Ok(points)
}
