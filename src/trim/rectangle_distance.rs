//! Whether trimming is pointless: the outline follows the sides of the rectangle.

use glam::DVec2;

use super::closed_polygon::sampled;
use super::outside::in_space;
use super::places::Rectangle;
use super::settings::OutlineSettings;
use crate::brep::Face;
use crate::cloud::KdTree;
use crate::error::Result;
use crate::nurbs::NurbsSurface;

const SETTINGS: OutlineSettings = OutlineSettings::STANDARD;

/// Parts of a side whose lengths are summed: a side around a tube ends where it begins.
const LENGTH_PARTS: usize = 8;

/// Whether the open sides of the rectangle are close to a face's outer loop.
pub(super) fn follows_sides(
    face: &Face,
    surface: &NurbsSurface,
    rectangle: &Rectangle,
    spacing: f64,
) -> Result<bool> {
    let sides = sides(rectangle);
    if sides.is_empty() {
        return Ok(true);
    }
    let outline = sampled(face.outer().curves());
    let count = outline.len();
    // As dense as the spacing, to measure distances from places rather than from sides.
    let step = |k: usize| {
        let (a, b) = (outline[k], outline[(k + 1) % count]);
        let at = move |i: usize, parts: usize| a + (b - a) * (i as f64 / parts as f64);
        let point = |i: usize| {
            let at = at(i, LENGTH_PARTS);
            surface.point(at.x, at.y)
        };
        let length: f64 = (0..LENGTH_PARTS).map(|i| point(i).distance(point(i + 1))).sum();
        let parts = crate::numeric::whole(length / (SETTINGS.sample_distance * spacing)) + 1;
        // A surface may run away from its points.
        let parts = parts.min(SETTINGS.side_samples);
        (0..parts).map(move |i| at(i, parts))
    };
    let dense: Vec<DVec2> = (0..count).flat_map(step).collect();
    let points = in_space(surface, &dense)?;
    let tree = KdTree::new(&points);
    // A narrow bay is near the sides at its mouth alone.
    let depth = |at: &DVec2| {
        let on_side = |d: usize, side: f64| {
            let mut on_side = *at;
            on_side[d] = side;
            surface.point(at.x, at.y).distance(surface.point(on_side.x, on_side.y))
        };
        let both = (0..2).flat_map(|d| [(d, rectangle.low[d]), (d, rectangle.high[d])]);
        both.map(|(d, side)| on_side(d, side)).fold(f64::INFINITY, f64::min)
    };
    if dense.iter().any(|at| depth(at) > SETTINGS.pointless_distance * spacing) {
        return Ok(false);
    }
    let distances: Vec<f64> = in_space(surface, &sides)?
        .iter()
        .map(|side| tree.nearest(*side, 1)[0].distance() / spacing)
        .collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    Ok(largest < SETTINGS.pointless_distance && mean < SETTINGS.pointless_mean)
}

/// Places along the sides that are no seams.
fn sides(rectangle: &Rectangle) -> Vec<DVec2> {
    let mut places = vec![];
    for d in (0..2).filter(|d| !rectangle.closed[*d]) {
        for side in [rectangle.low[d], rectangle.high[d]] {
            places.extend((0..=SETTINGS.side_samples).map(|k| {
                let share = k as f64 / SETTINGS.side_samples as f64;
                let mut at = rectangle.low + rectangle.size() * share;
                at[d] = side;
                at
            }));
        }
    }
    places
}
