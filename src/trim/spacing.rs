//! The local spacing of places: how far apart they lie, from circumradii in space.

use rayon::prelude::*;

use super::adjacency::Lists;
use super::settings::SpacingSettings;
use super::triangulation::Triangulation;
use crate::numeric::median;

const SETTINGS: SpacingSettings = SpacingSettings::STANDARD;

/// The spacing at each place: the side of a square with one place each, in a random scatter.
///
/// Per place the median circumradius of its triangles, then the median over some rings of
/// neighbors, then means of logarithms. Circumradii, not distances to nearest neighbors: of scan
/// lines they measure the gap between lines. Only triangles that are kept count.
pub(super) fn local_spacing(
    triangulation: &Triangulation,
    around: &Lists,
    radii: &[f64],
    keep: &[bool],
) -> Vec<f64> {
    let count = around.len();
    let own = |place: usize| {
        let kept = around.at(place).iter().filter(|t| keep[**t as usize]);
        median(kept.map(|t| radii[*t as usize]).filter(|radius| radius.is_finite()))
    };
    let mut spacing: Vec<f64> = (0..count).into_par_iter().map(own).collect();
    // 0 where no triangle is kept.
    let everywhere = median(spacing.iter().copied().filter(|own| *own > 0.0));
    for own in &mut spacing {
        *own = if *own > 0.0 { *own } else { everywhere };
    }
    let next = Lists::places(count, triangulation, keep);
    for _ in 0..SETTINGS.median_rings {
        let middle = |place: usize| {
            let values = next.at(place).iter().map(|other| spacing[*other as usize]);
            median(values.chain([spacing[place]]))
        };
        spacing = (0..count).into_par_iter().map(middle).collect();
    }
    let mut logarithms: Vec<f64> = spacing.par_iter().map(|spacing| spacing.ln()).collect();
    for _ in 0..SETTINGS.mean_rings {
        let mean = |place: usize| {
            let others = next.at(place);
            let sum: f64 = others.iter().map(|other| logarithms[*other as usize]).sum();
            (sum + logarithms[place]) / (others.len() + 1) as f64
        };
        logarithms = (0..count).into_par_iter().map(mean).collect();
    }
    logarithms.into_par_iter().map(|log| log.exp() / SETTINGS.median_circumradius).collect()
}
