//! The net that growth begins with: how many rows and columns of control points.

use super::options::{Aspect, ReconstructOptions};
use super::settings::InitialNetSettings;
use crate::chart::Kind;
use crate::numeric::whole;

const SETTINGS: InitialNetSettings = InitialNetSettings::STANDARD;

/// Rows and columns for a surface of these lengths: those of the options, else about one control
/// point for two points.
pub(super) fn initial_shape(
    points: usize,
    kind: Kind,
    [length_u, length_v]: [f64; 2],
    options: &ReconstructOptions<'_>,
) -> (usize, usize) {
    let InitialNetSettings { min_side, max_side, min_around } = SETTINGS;
    let max_side = options.max_control_points.isqrt().clamp(min_side, max_side);
    let side = (points / 2).isqrt().clamp(min_side, max_side);
    let (rows, cols) = options.grid.unwrap_or((side, side));
    if options.grid.is_some() && options.aspect == Aspect::Fixed {
        return (rows, cols);
    }
    let budget = (rows * cols) as f64;
    let ratio = length_u / length_v;
    match kind {
        Kind::Height if options.grid.is_none() => (side, side),
        Kind::Tube => split(budget, ratio.max(min_around * min_around / budget)),
        // Both directions of a torus bend by a full turn, whatever their length.
        Kind::Torus => split(budget, ratio.sqrt().sqrt()),
        _ => split(budget, ratio),
    }
}

/// Splits a number of control points into rows and columns whose ratio is about `aspect`.
fn split(budget: f64, aspect: f64) -> (usize, usize) {
    let least = SETTINGS.min_side as f64;
    let most = (budget / least).floor().max(least);
    let rows = (budget * aspect).sqrt().round().clamp(least, most);
    let cols = (budget / rows).floor().max(least);
    // The control points left over by rounding may be enough for another row.
    (whole((budget / cols).floor().max(least)), whole(cols))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_follow_the_lengths() {
        let options = ReconstructOptions::default();
        assert_eq!(initial_shape(1000, Kind::Sheet, [1.0, 1.0], &options), (12, 12));
        assert_eq!(initial_shape(1000, Kind::Sheet, [4.0, 1.0], &options), (24, 6));
        assert_eq!(initial_shape(6, Kind::Sheet, [1.0, 1.0], &options), (4, 4));
        let fixed = ReconstructOptions {
            grid: Some((5, 9)),
            aspect: Aspect::Fixed,
            ..ReconstructOptions::default()
        };
        assert_eq!(initial_shape(1000, Kind::Sheet, [4.0, 1.0], &fixed), (5, 9));
    }
}
