//! Angles about a center and their widest gap, and circles through points.

use std::f64::consts::TAU;

use glam::{DMat3, DVec2, DVec3};

use super::settings::AngleSettings;
use crate::numeric::median;

const SETTINGS: AngleSettings = AngleSettings::STANDARD;

/// Angles of points, in turns from 0 to 1.
pub(super) struct Angles {
    pub(super) turns: Vec<f64>,
    /// The widest gap, in radians.
    gap: f64,
    /// The middle of that gap, in turns.
    middle: f64,
}

impl Angles {
    /// The angles of places about the origin.
    pub(super) fn of(places: impl Iterator<Item = DVec2>) -> Self {
        let turns: Vec<f64> = places.map(|p| (p.to_angle() / TAU).rem_euclid(1.0)).collect();
        let mut sorted = turns.clone();
        sorted.sort_by(f64::total_cmp);
        let next = sorted.iter().skip(1).copied().chain(sorted.first().map(|first| first + 1.0));
        let gaps = sorted.iter().zip(next).map(|(from, to)| (to - from, 0.5 * (from + to)));
        let (gap, middle) =
            gaps.fold((0.0, 0.0), |best, gap| if gap.0 > best.0 { gap } else { best });
        Self { turns, gap: TAU * gap, middle }
    }

    /// Whether the angles cover the whole circle.
    pub(super) fn closed(&self) -> bool {
        self.gap < SETTINGS.max_closed_gap
    }

    /// The widest gap, in radians.
    pub(super) fn gap(&self) -> f64 {
        self.gap
    }

    /// The angles from one side of the gap to the other, scaled to [0, 1].
    pub(super) fn cut(&self) -> Vec<f64> {
        let from_gap: Vec<f64> =
            self.turns.iter().map(|turn| (turn - self.middle).rem_euclid(1.0)).collect();
        unit(&from_gap).0
    }
}

/// Numbers scaled to [0, 1], and the length of their range.
pub(super) fn unit(numbers: &[f64]) -> (Vec<f64>, f64) {
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let length = high - low;
    let share = |number: &f64| if length > 0.0 { (number - low) / length } else { 0.5 };
    (numbers.iter().map(share).collect(), length)
}

/// The center of the circle fitted to places (I. Kåsa, *A circle fitting procedure and its error
/// analysis*, 1976); their mean if that lies outside their box.
pub(super) fn circle_center(places: &[DVec2]) -> DVec2 {
    let mean = places.iter().sum::<DVec2>() / places.len().max(1) as f64;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for place in places {
        let local = *place - mean;
        let row = local.extend(1.0);
        matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        right += local.length_squared() * row;
    }
    let center = mean + 0.5 * (matrix.inverse() * right).truncate();
    let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let inside = center.cmpge(low).all() && center.cmple(high).all();
    if inside { center } else { mean }
}

/// The median length of places.
pub(super) fn radius(places: &[DVec2]) -> f64 {
    median(places.iter().map(|place| place.length()))
}
