//! Ragged borders: curves as smooth as a band around the places allows.

use super::border::Border;
use super::level::Level;
use super::offset::outward;
use super::settings::RaggedSettings;
use super::spline_fit::{Form, Targets};
use crate::error::Result;
use crate::nurbs::NurbsCurve;

const SETTINGS: RaggedSettings = RaggedSettings::STANDARD;

/// A periodic curve with close knots, and the strongest fairness with which it passes all places
/// within a band; `None` if there is none.
pub(super) fn in_band(border: &Border, level: Level) -> Result<Option<NurbsCurve>> {
    let places = border.len();
    let count = crate::numeric::whole(SETTINGS.share * places as f64);
    if count < SETTINGS.min_control_points {
        return Ok(None);
    }
    // Even parameters, as knots are: each of them has places, however long the sides are.
    let at: Vec<f64> = (0..places).map(|k| k as f64 / places as f64).collect();
    let form = Form::Periodic(border.shift);
    let mut targets = border.uv.clone();
    let mut chosen = None;
    for fairness in SETTINGS.fairness {
        let places = Targets { at: &at, uv: &targets, tangents: &border.tangents };
        let Some(fit) = places.fit(form, count, fairness)? else { continue };
        if places.largest(&fit.curve) <= SETTINGS.band * border.spacing {
            chosen = Some((fit.curve, fairness));
            break;
        }
    }
    let Some((curve, fairness)) = chosen else { return Ok(None) };
    let depth: Vec<f64> = border.depth.iter().map(|depth| level.offset * depth).collect();
    let places = Targets { at: &at, uv: &targets, tangents: &border.tangents };
    targets = outward(&curve, &places, &depth)?;
    let moved = Targets { at: &at, uv: &targets, tangents: &border.tangents };
    Ok(moved.fit(form, count, fairness)?.map(|fit| fit.curve))
}
