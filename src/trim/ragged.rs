//! Ragged borders: curves as smooth as a band around the places allows.

use glam::DVec2;

use super::arc_length::shares;
use super::border::Border;
use super::level::Level;
use super::offset::outward;
use super::settings::RaggedSettings;
use super::spline_fit::{Form, Targets};
use crate::error::Result;
use crate::nurbs::NurbsCurve;

const SETTINGS: RaggedSettings = RaggedSettings::STANDARD;

/// A periodic curve with a control point for each place: the higher the step, the less smooth and
/// the nearer. `None` after the last step, or if the places do not determine it.
pub(super) fn in_band(border: &Border, level: Level, step: usize) -> Result<Option<NurbsCurve>> {
    let count = border.len();
    let Some(&fairness) = SETTINGS.fairness.get(step) else { return Ok(None) };
    if count < SETTINGS.min_control_points {
        return Ok(None);
    }
    // Square roots of lengths: a curve with even knots makes no loops between places (E. T. Y. Lee
    // 1989).
    let at = shares((0..count).map(|k| (border.along[k + 1] - border.along[k]).sqrt()));
    let at = &at[..count];
    let form = Form::Periodic(border.shift);
    let fit =
        |uv: &[DVec2]| Targets { at, uv, tangents: &border.tangents }.fit(form, count, fairness);
    let Some(through) = fit(&border.uv)? else { return Ok(None) };
    let depth: Vec<f64> = border.depth.iter().map(|depth| level.offset * depth).collect();
    let own = Targets { at, uv: &border.uv, tangents: &border.tangents };
    let moved = outward(&through.curve, &own, &depth)?;
    Ok(fit(&moved)?.map(|fit| fit.curve))
}
