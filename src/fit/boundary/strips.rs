//! Strips of points (x, y) by x: the lowest point in each, and the empty area below.

use super::settings::BoundarySettings;

const SETTINGS: BoundarySettings = BoundarySettings::STANDARD;

/// Mean height of the lowest point in each strip above a curve, less the mean height by chance.
/// `ends` strips at either end are left out.
pub(super) fn empty_area(places: &[(f64, f64)], curve: impl Fn(f64) -> f64, ends: usize) -> f64 {
    let count = places.len();
    let places = lowest_in_strips(places.iter().copied(), SETTINGS.strips);
    let inner = places[ends..SETTINGS.strips - ends].iter().flatten();
    let above = inner.clone().map(|&(x, y)| (y - curve(x)).max(0.0));
    above.sum::<f64>() / inner.count().max(1) as f64 - SETTINGS.strips as f64 / count as f64
}

/// The lowest point (x, y) in each strip of x; one more strip contains the largest x.
pub(super) fn lowest_in_strips(
    places: impl Iterator<Item = (f64, f64)> + Clone,
    strips: usize,
) -> Vec<Option<(f64, f64)>> {
    let (start, end) = min_max(places.clone().map(|place| place.0));
    let scale = strips as f64 / (end - start).max(f64::MIN_POSITIVE);
    let mut found: Vec<Option<(f64, f64)>> = vec![None; strips + 1];
    for place in places {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let strip = &mut found[(((place.0 - start) * scale) as usize).min(strips)];
        if strip.is_none_or(|lowest| place.1 < lowest.1) {
            *strip = Some(place);
        }
    }
    found
}

pub(crate) fn min_max(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}
