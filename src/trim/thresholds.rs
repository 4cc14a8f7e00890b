//! Thresholds for circumradii, in spacings: what is outside, and what is a hole.
//!
//! In a random scatter a triangle's circumradius exceeds r spacings with probability
//! (1 + x) exp(-x), x = π r² (R. E. Miles 1970).

use std::f64::consts::PI;

use super::settings::{SpacingSettings, ThresholdSettings};
use crate::numeric::quantile;

const SETTINGS: ThresholdSettings = ThresholdSettings::STANDARD;

/// Circumradii, in spacings, that separate what holds points from what does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Thresholds {
    /// What discs of this radius reach from the outside is outside.
    pub grow: f64,
    /// A hole has room for a disc of this radius.
    pub hole: f64,
}

impl Thresholds {
    /// The thresholds of a random scatter of this many places.
    pub(super) fn of_scatter(places: usize) -> Self {
        Self { grow: SETTINGS.grow, hole: hole_radius(places) }
    }

    /// The thresholds of places that scatter more than at random.
    pub(super) fn of_clumps(self, clumping: f64) -> Self {
        Self { grow: self.grow * clumping.sqrt(), hole: self.hole * clumping }
    }

    /// Thresholds with another radius of discs that reach from the outside.
    pub(super) fn grown(self, times: f64) -> Self {
        Self { grow: self.grow * times, hole: self.hole.max(self.grow * times) }
    }
}

/// The radius of which a random scatter has an empty disc with the chance of a false hole.
fn hole_radius(places: usize) -> f64 {
    let mut x: f64 = 10.0;
    // Converges by a factor of x an iteration.
    for _ in 0..60 {
        x = (2.0 * places as f64 * (1.0 + x) / SETTINGS.false_hole).ln();
    }
    (x / PI).sqrt()
}

/// How unevenly places scatter: 1 at random, more if they clump. From circumradii in spacings.
pub(super) fn clumping(radii: impl IntoIterator<Item = f64>) -> f64 {
    let decile = quantile(radii, 0.9) / SETTINGS.ninth_decile;
    decile.clamp(1.0, SETTINGS.max_clumping)
}

/// How far places are from a lattice: 0 on one, 1 at random. From circumradii.
pub(super) fn irregularity(radii: &[f64]) -> f64 {
    let deciles = [0.9, 0.5].map(|share| quantile(radii.iter().copied(), share));
    let random = SETTINGS.ninth_decile / SpacingSettings::STANDARD.median_circumradius - 1.0;
    ((deciles[0] / deciles[1] - 1.0) / random).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hole_radii_grow_with_the_number_of_places() {
        for (places, radius) in [(60, 1.97), (300, 2.1), (3000, 2.3), (100_000, 2.5)] {
            assert!((hole_radius(places) - radius).abs() < 0.06, "{places}");
        }
    }

    #[test]
    fn evenness_counts_as_random() {
        assert_eq!((clumping([0.7; 100]), irregularity(&[0.7; 100])), (1.0, 0.0));
        assert!(clumping((0..100).map(f64::from)) == SETTINGS.max_clumping);
    }
}
