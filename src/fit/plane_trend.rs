//! The plane that fits heights best, by weighted least squares.

use glam::{DMat2, DVec2, DVec3};

use super::settings::LeastSquaresSettings;

const SETTINGS: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// The least-squares plane of heights.
pub(super) struct PlaneTrend {
    center: DVec3,
    slope: DVec2,
}

impl PlaneTrend {
    pub(super) fn of(points: &[DVec3], weights: Option<&[f64]>) -> Self {
        let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (i, &point) in points.iter().enumerate() {
            sum += weight(i) * point;
            total += weight(i);
        }
        let center = sum / total;
        let (mut moments, mut right) = (DMat2::ZERO, DVec2::ZERO);
        for (i, &point) in points.iter().enumerate() {
            let (away, weight) = (point - center, weight(i));
            let place = away.truncate();
            moments += weight * DMat2::from_cols(place.x * place, place.y * place);
            right += weight * away.z * place;
        }
        // Collinear places do not determine the slope across their line.
        let extended = moments.determinant()
            > SETTINGS.zero_ratio * (moments.x_axis.x + moments.y_axis.y).powi(2);
        Self { center, slope: if extended { moments.inverse() * right } else { DVec2::ZERO } }
    }

    pub(super) fn height(&self, place: DVec2) -> f64 {
        self.center.z + self.slope.dot(place - self.center.truncate())
    }
}
