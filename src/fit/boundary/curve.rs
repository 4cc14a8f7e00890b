//! Boundary curve: the likeliest smooth curve at which points end on one side of the domain.

use super::super::options::uniform;
use super::likelihood::{BoundaryPoint, DEGREE, Likelihood, height, sums};
use super::settings::BoundarySettings;
use super::strips::empty_area;
use crate::error::Result;
use crate::nurbs::{Basis, KnotVector};

const SETTINGS: BoundarySettings = BoundarySettings::STANDARD;

/// How closely a curve follows the points.
struct Flexibility {
    control_points: usize,
    /// Penalties among which the evidence chooses, see [`Likelihood::penalty`]. The search
    /// begins with the last.
    penalties: &'static [f64],
    /// The largest height of the curve.
    max_height: f64,
    /// Points higher than this do not influence the curve.
    max_influence: f64,
    /// Height up to which points determine the density along the curve. `None`: uniform density.
    density_height: Option<f64>,
}

/// Covers rounded corners instead of following them.
const STIFF: Flexibility = Flexibility {
    control_points: SETTINGS.stiff_control_points,
    penalties: SETTINGS.stiff_penalties,
    max_height: SETTINGS.stiff_max_height,
    max_influence: SETTINGS.stiff_max_influence,
    density_height: Some(SETTINGS.stiff_density_height),
};

/// Follows notches, but not into their corners, where parameters would crowd.
const FLEXIBLE: Flexibility = Flexibility {
    control_points: SETTINGS.flexible_control_points,
    penalties: SETTINGS.flexible_penalties,
    max_height: SETTINGS.flexible_max_height,
    max_influence: SETTINGS.flexible_max_influence,
    density_height: None,
};

/// Depth of a boundary curve inside the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Depth {
    /// The curve lies below its largest height.
    Free,
    /// The curve touches its largest height.
    AtLimit,
    /// The curve follows a notch.
    Notch,
}

/// A smooth curve, y over x in [0, 1].
pub(super) struct BoundaryCurve {
    knots: KnotVector,
    heights: Vec<f64>,
    max_height: f64,
    /// Standard deviations of the heights, and spacings of the points relative to the mean.
    uncertainties: Vec<(f64, f64)>,
}

impl BoundaryCurve {
    /// The height, clamped to the bounds against rounding.
    pub(super) fn at(&self, x: f64) -> f64 {
        height(&self.heights, &Basis::at(&self.knots, x))
            .clamp(SETTINGS.min_height, self.max_height)
    }

    /// The distance of the surface's border beyond the curve at each x, for a border of this number
    /// of spacings. It grows with the curve's uncertainty, up to `most` for each spacing of border.
    pub(super) fn margin(&self, border: f64, spacing: f64, most: f64) -> impl Fn(f64) -> f64 {
        let beyond = |&(deviation, relative_margin): &(f64, f64)| {
            let margin = 0.5 * spacing + SETTINGS.margin_deviations * deviation;
            border * relative_margin * margin.min(most)
        };
        let margins: Vec<f64> = self.uncertainties.iter().map(beyond).collect();
        move |x| height(&margins, &Basis::at(&self.knots, x))
    }

    /// The likeliest lower boundary of points (x, y) in the unit square, if y has noise of this
    /// size (see [`Likelihood`]). A closed curve is periodic in x.
    pub(super) fn below(places: &[(f64, f64)], noise: f64, closed: bool) -> Result<Self> {
        let stiff = Self::likeliest(places, noise, closed, &STIFF)?;
        if empty_area(places, |x| stiff.at(x), SETTINGS.end_strips) < SETTINGS.min_notch {
            return Ok(stiff);
        }
        Self::likeliest(places, noise, closed, &FLEXIBLE)
    }

    /// How deep the curve lies. If it is at its limit, another round may follow a deeper boundary.
    pub(super) fn depth(&self) -> Depth {
        if self.max_height > STIFF.max_height {
            Depth::Notch
        } else if self.heights.iter().any(|height| *height >= self.max_height) {
            Depth::AtLimit
        } else {
            Depth::Free
        }
    }

    fn likeliest(
        places: &[(f64, f64)],
        noise: f64,
        closed: bool,
        flexibility: &'static Flexibility,
    ) -> Result<Self> {
        let &Flexibility { control_points, penalties, max_height, max_influence, density_height } =
            flexibility;
        let near = places.iter().copied().filter(|place| place.1 < max_influence);
        let knots = uniform(DEGREE, control_points, closed)?;
        let bounds = (SETTINGS.min_height, max_height);
        let least = penalties[penalties.len() - 1];
        let mut likelihood = Likelihood::new(near, places.len(), knots, least, bounds);
        let even = likelihood.slopes.clone();
        if let Some(depth) = density_height {
            let low: Vec<&BoundaryPoint> =
                likelihood.places.iter().take_while(|place| place.y < depth).collect();
            // Uniform points between the curve and this height have their mean halfway between.
            let mean = low.iter().map(|place| place.y).sum::<f64>() / low.len().max(1) as f64;
            let density_height = depth - (2.0 * mean - depth).clamp(0.0, max_height);
            let least = |i: usize| {
                let corner = !closed && (i < 2 || i + 2 >= control_points);
                even[i] * if corner { SETTINGS.min_corner_density } else { SETTINGS.min_density }
            };
            let found = sums(low.iter().map(|place| &place.basis), control_points);
            let found = found.into_iter().enumerate();
            likelihood.slopes =
                found.map(|(i, sum)| (sum / density_height).max(least(i))).collect();
        }
        let lowest = places.iter().map(|place| place.1).fold(f64::INFINITY, f64::min);
        let mut heights = vec![lowest.clamp(SETTINGS.min_height, max_height); control_points];
        let scale = likelihood.find(&mut heights, noise, |_, _| {});
        let here = likelihood.choose_penalty(&mut heights, scale, penalties);
        let relative_margins =
            likelihood.slopes.iter().zip(&even).map(|(here, even)| relative_margin(here / even));
        let mut uncertainties: Vec<(f64, f64)> =
            likelihood.standard_deviations(&here).into_iter().zip(relative_margins).collect();
        let repeated = likelihood.knots.control_points() - control_points;
        heights.extend_from_within(..repeated);
        uncertainties.extend_from_within(..repeated);
        Ok(Self { knots: likelihood.knots, heights, max_height, uncertainties })
    }
}

/// The relative size of the margin, where the density is this share of the mean. It is proportional
/// to the spacing, but falls to zero at a rounded corner, where points are missing.
fn relative_margin(density: f64) -> f64 {
    let sparse = density.min(SETTINGS.sparse_density) / SETTINGS.sparse_density;
    sparse / density.clamp(SETTINGS.sparse_density, 1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::likelihood::tests::above;
    use super::*;

    #[test]
    fn curves_follow_gentle_bends() {
        let bent = |x: f64| 0.08 * x * (1.0 - x);
        let found = BoundaryCurve::below(&above(bent), 0.0, false).unwrap();
        for i in 0..=20 {
            let x = f64::from(i) / 20.0;
            assert!((found.at(x) - bent(x)).abs() < 0.006, "{x} {} {}", found.at(x), bent(x));
        }
    }

    #[test]
    fn notches_are_followed_and_rounded_corners_are_not() {
        let notch = |x: f64| 0.2 * (std::f64::consts::PI * x).sin().powi(2);
        let round = |x: f64| 0.5 - (0.25 - (x - 0.5).powi(2)).max(0.0).powf(0.25) / 2.0_f64.sqrt();
        let edges = [
            BoundaryCurve::below(&above(notch), 0.0, false).unwrap(),
            BoundaryCurve::below(&above(round), 0.0, false).unwrap(),
        ];
        assert_eq!(edges[0].depth(), Depth::Notch);
        assert!(edges[1].depth() < Depth::Notch);
        assert!((0.08..0.2).contains(&edges[0].at(0.5)), "{}", edges[0].at(0.5));
        assert!(edges[1].at(0.02) < 0.5 * round(0.02), "{}", edges[1].at(0.02));
    }

    #[test]
    fn noise_does_not_move_curves_outward() {
        let wave = |i: usize| 0.02 * 2.0_f64.sqrt() * (1.7 * (i * i % 9973) as f64).sin();
        let noisy: Vec<(f64, f64)> =
            above(|_| 0.05).into_iter().enumerate().map(|(i, (x, y))| (x, y + wave(i))).collect();
        for closed in [false, true] {
            let found = BoundaryCurve::below(&noisy, 0.02, closed).unwrap();
            for i in 0..=20 {
                let y = found.at(f64::from(i) / 20.0);
                assert!((y - 0.05).abs() < 0.012, "{y}");
            }
        }
    }

    #[test]
    fn margins_are_wider_where_curves_are_uncertain() {
        let level = above(|_| 0.05);
        let (count, spacing) = (level.len() as f64, (level.len() as f64).powf(-0.5));
        let sure = BoundaryCurve::below(&level, 0.0, false).unwrap();
        let margin = |edge: &BoundaryCurve, x: f64| edge.margin(0.5, spacing, 1.0)(x) / spacing;
        assert!((0.2..0.5).contains(&margin(&sure, 0.5)), "{}", margin(&sure, 0.5));
        assert!(margin(&sure, 0.0) > 1.2 * margin(&sure, 0.5));
        assert_eq!(sure.margin(0.0, spacing, 1.0)(0.5), 0.0);
        // A quarter of the points on the right half, so that their spacing doubles.
        let thinned = level.into_iter().enumerate().filter(|(i, (x, _))| *x < 0.5 || i % 4 == 0);
        let thinned: Vec<(f64, f64)> = thinned.map(|(_, place)| place).collect();
        assert!((thinned.len() as f64) < 0.7 * count);
        let thinned = BoundaryCurve::below(&thinned, 0.0, false).unwrap();
        assert!(margin(&thinned, 0.8) > 1.5 * margin(&thinned, 0.2));
    }

    #[test]
    fn few_points_give_curves_within_bounds() {
        for count in 1..6 {
            let places: Vec<(f64, f64)> = (0..count).map(|i| (f64::from(i) / 5.0, 0.3)).collect();
            let found = BoundaryCurve::below(&places, 0.0, false).unwrap();
            assert!((0..=10).all(|i| {
                (SETTINGS.min_height..=STIFF.max_height).contains(&found.at(f64::from(i) / 10.0))
            }));
        }
    }
}
