//! Mean lengths of a surface's isocurves.

use glam::{DVec2, DVec3};

use super::patches::Patches;
use super::settings::AlternatingFitSettings;
use crate::nurbs::{KnotVector, NurbsSurface};

const SETTINGS: AlternatingFitSettings = AlternatingFitSettings::STANDARD;

/// Mean lengths of the isocurves along u and along v, in the unit of the net.
///
/// ```
/// use neurbs::{DVec3, NurbsSurface, fit::isocurve_lengths};
/// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 3.0)?;
/// let (along_u, along_v) = isocurve_lengths(&plane);
/// assert!((along_u - 2.0).abs() + (along_v - 3.0).abs() < 1e-12);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[must_use]
pub fn isocurve_lengths(surface: &NurbsSurface) -> (f64, f64) {
    let count = SETTINGS.length_samples;
    let place = |knots: &KnotVector, i: usize| {
        let (start, end) = knots.domain();
        start + (end - start) * i as f64 / (count - 1) as f64
    };
    let patches = Patches::of(surface);
    let at = |i: usize, j: usize| {
        let uv = DVec2::new(place(surface.knots_u(), i), place(surface.knots_v(), j));
        patches.at(uv).point
    };
    let points: Vec<DVec3> = (0..count * count).map(|k| at(k / count, k % count)).collect();
    let length = |from: usize, to: usize| points[from].distance(points[to]);
    let (mut along_u, mut along_v) = (0.0, 0.0);
    for i in 1..count {
        for j in 0..count {
            along_u += length((i - 1) * count + j, i * count + j);
            along_v += length(j * count + i - 1, j * count + i);
        }
    }
    (along_u / count as f64, along_v / count as f64)
}
