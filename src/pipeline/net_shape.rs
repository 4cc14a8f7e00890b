//! How many rows and columns of control points a surface begins with.

use super::options::{Aspect, ReconstructOptions};
use crate::chart::Kind;
use crate::numeric::whole;

/// Least control points along a side: those of a cubic.
const LEAST_SIDE: usize = 4;

/// Control points along a side of the square net that growth begins with, at most.
const FIRST_SIDE: usize = 12;

/// Control points around a tube, at least: with ten a circle is 10⁻⁴ of its radius off.
const AROUND: f64 = 10.0;

/// The net for a surface of these lengths: the given one, or two points for each control point.
pub(super) fn net_shape(
    points: usize,
    kind: Kind,
    [along_u, along_v]: [f64; 2],
    options: &ReconstructOptions<'_>,
) -> (usize, usize) {
    let most = options.max_control_points.isqrt().clamp(LEAST_SIDE, FIRST_SIDE);
    let side = (points / 2).isqrt().clamp(LEAST_SIDE, most);
    let (rows, cols) = options.grid.unwrap_or((side, side));
    if options.grid.is_some() && options.aspect == Aspect::Fixed {
        return (rows, cols);
    }
    let budget = (rows * cols) as f64;
    let ratio = along_u / along_v;
    match kind {
        Kind::Height if options.grid.is_none() => (side, side),
        Kind::Tube => split(budget, ratio.max(AROUND * AROUND / budget)),
        // Both ways around a torus bend as often, whatever their length.
        Kind::Torus => split(budget, ratio.sqrt().sqrt()),
        _ => split(budget, ratio),
    }
}

/// A number of control points in rows and columns, for a surface so many times longer than wide.
fn split(budget: f64, aspect: f64) -> (usize, usize) {
    let least = LEAST_SIDE as f64;
    let most = (budget / least).floor().max(least);
    let rows = (budget * aspect).sqrt().round().clamp(least, most);
    let cols = (budget / rows).floor().max(least);
    // What is left over may be enough for another row.
    (whole((budget / cols).floor().max(least)), whole(cols))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nets_follow_lengths() {
        let options = ReconstructOptions::default();
        assert_eq!(net_shape(1000, Kind::Sheet, [1.0, 1.0], &options), (12, 12));
        assert_eq!(net_shape(1000, Kind::Sheet, [4.0, 1.0], &options), (24, 6));
        assert_eq!(net_shape(6, Kind::Sheet, [1.0, 1.0], &options), (4, 4));
        let fixed = ReconstructOptions {
            grid: Some((5, 9)),
            aspect: Aspect::Fixed,
            ..ReconstructOptions::default()
        };
        assert_eq!(net_shape(1000, Kind::Sheet, [4.0, 1.0], &fixed), (5, 9));
    }
}
