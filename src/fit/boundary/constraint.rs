//! Boundary constraint: samples that keep the border of a surface in place.

use glam::DVec2;

use super::super::normal_equations::Sample;
use super::super::patches::Patches;
use super::super::settings::LeastSquaresSettings;
use super::closed::square_boundary;
use super::settings::BoundarySettings;
use crate::nurbs::NurbsSurface;

const SETTINGS: BoundarySettings = BoundarySettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Samples around a surface that is open in both directions. Its border may slide along them, but
/// not leave them.
///
/// Fairness pulls the border of few or noisy points to where it bends least. At the corners of a
/// square that was mapped from a disc this is far from the points.
pub(crate) struct BoundaryConstraint(Vec<Sample>);

impl BoundaryConstraint {
    /// The constraint to the border of a surface.
    pub(crate) fn of(surface: &NurbsSurface) -> Self {
        let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
        let (low, high) = (DVec2::new(u.0, v.0), DVec2::new(u.1, v.1));
        let places = square_boundary().map(|place| low + place * (high - low));
        Self::through(&Patches::of(surface), places.map(|place| (place, place)))
    }

    /// The constraint to places of a surface, each with its parameters on the border of the next
    /// surface.
    pub(crate) fn through(
        patches: &Patches<'_>,
        places: impl Iterator<Item = (DVec2, DVec2)>,
    ) -> Self {
        let places: Vec<_> = places.map(|(from, to)| (patches.at(from), to)).collect();
        let count = places.len();
        let sample = |i: usize| {
            let (at, uv) = places[i];
            let along = places[(i + 1) % count].0.point - places[(i + count - 1) % count].0.point;
            let normal = at.normal().cross(along).normalize_or_zero();
            Sample {
                point: at.point,
                uv,
                weight: 1.0,
                normal,
                tangential: LEAST_SQUARES.tangential_weight,
            }
        };
        Self((0..count).map(sample).collect())
    }

    /// Samples weighted for this number of points and this fairness.
    pub(crate) fn samples_for(&self, points: usize, fairness: f64) -> impl Iterator<Item = Sample> {
        let weight = SETTINGS.constraint_weight * fairness * points as f64 / self.0.len() as f64;
        self.0.iter().map(move |sample| Sample { weight, ..*sample })
    }
}

#[cfg(test)]
mod tests {
    use super::super::polar_projection::tests::surface;
    use super::*;

    #[test]
    fn samples_constrain_a_flat_border_across_it() {
        let flat = surface(|uv| uv.extend(0.0));
        let samples: Vec<Sample> = BoundaryConstraint::of(&flat).samples_for(1000, 0.5).collect();
        assert!((samples.iter().map(|sample| sample.weight).sum::<f64>() - 25.0).abs() < 1e-9);
        for Sample { point, uv, normal, .. } in samples {
            assert!(point.truncate().distance(uv) < 1e-12);
            let away = (uv - 0.5) / 0.5;
            assert!((away.abs().max_element() - 1.0).abs() < 1e-7, "{uv}");
            // In a corner the normal lies between those of both sides.
            assert!(normal.truncate().dot(away).abs() > 0.9, "{uv} {normal}");
            assert!((normal.length() - 1.0).abs() < 1e-12 && normal.z.abs() < 1e-12);
        }
    }
}
