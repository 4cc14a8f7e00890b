//! The part of a surface that lies beyond the points.

use glam::{DVec2, DVec3};

use super::places::{Places, Rectangle};
use super::settings::CoverageSettings;
use crate::brep::Face;
use crate::cloud::KdTree;
use crate::error::Result;
use crate::numeric::whole;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::Silent;

const SETTINGS: CoverageSettings = CoverageSettings::STANDARD;

/// The shares of the area that lie farther from every place than some spacings: of the faces, and
/// of the whole surface.
pub(super) fn shares_beyond(
    faces: &[Face],
    surface: &NurbsSurface,
    places: &Places,
    spacing: &[f64],
) -> Result<(f64, f64)> {
    let samples = samples(&Rectangle::of(surface), places.len());
    let mut derivatives = vec![DVec3::ZERO; 4 * samples.len()];
    surface.derivatives(&samples, 1, &mut derivatives, Outside::Refuse, &mut Silent)?;
    let tree = KdTree::new(&places.points);
    let is_far = |k: usize| {
        let nearest = &tree.nearest(derivatives[4 * k], 1)[0];
        nearest.distance() > SETTINGS.far * spacing[nearest.index as usize]
    };
    let mut inside = vec![false; samples.len()];
    for face in faces {
        for (inside, own) in inside.iter_mut().zip(face.contains(&samples, &mut Silent)?) {
            *inside |= own;
        }
    }
    // Areas of the whole surface and of the faces, each with the part of it that is far.
    let (mut all, mut far, mut kept, mut far_kept) = (0.0, 0.0, 0.0, 0.0);
    for (k, table) in derivatives.chunks_exact(4).enumerate() {
        let area = table[1].cross(table[2]).length();
        let beyond = if is_far(k) { area } else { 0.0 };
        all += area;
        far += beyond;
        if inside[k] {
            kept += area;
            far_kept += beyond;
        }
    }
    let share = |part: f64, all: f64| if all > 0.0 { part / all } else { 0.0 };
    Ok((share(far_kept, kept), share(far, all)))
}

/// Middles of the cells of a grid over the rectangle.
fn samples(rectangle: &Rectangle, places: usize) -> Vec<DVec2> {
    let side = whole((SETTINGS.samples_per_place * places as f64).sqrt());
    let side = side.min(SETTINGS.max_side);
    let (low, cell) = (rectangle.low, rectangle.size() / side as f64);
    let at = |k: usize| DVec2::new((k / side) as f64 + 0.5, (k % side) as f64 + 0.5);
    (0..side * side).map(|k| low + cell * at(k)).collect()
}
