//! Four-sided boundary: the domain between curves, mapped to the unit square.

use glam::DVec2;
use rayon::prelude::*;

use super::super::sizes::POINTS_PER_TASK;
use super::super::spline_space::SplineSpace;
use super::curve::{BoundaryCurve, Depth};
use super::settings::BoundarySettings;
use super::straight::change_each;
use crate::error::Result;

const SETTINGS: BoundarySettings = BoundarySettings::STANDARD;

/// Maps parameters to the unit square like [`bounded`](super::bounded), but with curved sides along
/// their boundary. The parameters have noise of this size along u and v. The surface extends beyond
/// the sides by about `border` times `spacing`, the mean spacing along u and v.
///
/// Returns the parameters, and how deep the curves lie.
pub(crate) fn bounded_by_curves(
    uv: &[DVec2],
    space: &SplineSpace,
    noise: DVec2,
    border: f64,
    spacing: DVec2,
) -> Result<(Vec<DVec2>, Depth)> {
    let (closed, mut uv, mut depth) = (space.closed, uv.to_vec(), Depth::Free);
    let mut sides = [None, None];
    for d in [0, 1, 0, 1].into_iter().filter(|&d| !closed[d]) {
        let side = |distance: fn(f64) -> f64| {
            let places = uv.par_iter().with_min_len(POINTS_PER_TASK);
            let places: Vec<_> = places.map(|uv| (uv[1 - d], distance(uv[d]))).collect();
            BoundaryCurve::below(&places, noise[d], closed[1 - d])
        };
        let (low, high) = rayon::join(|| side(|at| at), || side(|at| 1.0 - at));
        let (low, high) = (low?, high?);
        depth = depth.max(low.depth()).max(high.depth());
        change_each(&mut uv, |uv| {
            let (start, end) = (low.at(uv[1 - d]), 1.0 - high.at(uv[1 - d]));
            uv[d] = ((uv[d] - start) / (end - start)).clamp(0.0, 1.0);
        });
        sides[d] = Some((low, high));
    }
    let margins = [0, 1].map(|d: usize| {
        let (low, high) = sides[d].as_ref()?;
        // Surfaces that extend beyond half a spacing of the control points deviate.
        let most = SETTINGS.max_margin / (space.shape()[d] - 1) as f64;
        Some([low, high].map(|edge: &BoundaryCurve| edge.margin(border, spacing[d], most)))
    });
    change_each(&mut uv, |uv| {
        let inside = *uv;
        for (d, margins) in margins.iter().enumerate() {
            let Some(margins) = margins else { continue };
            let [low, high] = margins.each_ref().map(|margin| margin(inside[1 - d]));
            uv[d] = (inside[d] + low) / (1.0 + low + high);
        }
    });
    Ok((uv, depth))
}
