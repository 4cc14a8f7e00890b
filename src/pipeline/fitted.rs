//! A surface with the points' parameters on it.

use glam::DVec2;

use crate::fit::{Approximation, EndedBy};
use crate::nurbs::NurbsSurface;

/// A surface fitted to points of the local frame; one face of what a list of them may replace.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) surface: NurbsSurface,
    /// Parameters of each point's projection.
    pub(super) uv: Vec<DVec2>,
    /// Each point's distance from there.
    pub(super) distances: Vec<f64>,
    /// What each squared distance counts; 0 of outliers.
    pub(super) weights: Vec<f64>,
    pub(super) fairness: f64,
    /// Mean square of the distance that cross-validation expects of a point that was left out.
    pub(super) expected: Option<f64>,
    pub(super) iterations: usize,
    pub(super) ended_by: EndedBy,
}

impl Fitted {
    pub(super) fn new(found: Approximation, weights: Vec<f64>) -> Self {
        Self {
            surface: found.surface,
            uv: found.uv,
            distances: found.distances,
            weights,
            fairness: found.fairness,
            expected: found.expected,
            iterations: found.iterations,
            ended_by: found.ended_by,
        }
    }

    /// Distances of the points that count.
    pub(super) fn counted(&self) -> impl Iterator<Item = f64> + '_ {
        let all = self.distances.iter().zip(&self.weights);
        all.filter(|(_, weight)| **weight > 0.0).map(|(distance, _)| *distance)
    }

    /// Root of the weighted mean of their squares.
    pub(super) fn rms(&self) -> f64 {
        let (squares, weights) = self
            .distances
            .iter()
            .zip(&self.weights)
            .fold((0.0, 0.0), |(sum, all), (d, w)| (sum + w * d * d, all + w));
        (squares / weights).sqrt()
    }

    /// Root mean square of the distance to be expected of a point that was left out; that of the
    /// points where none was, since the fairness was given or raised.
    pub(super) fn error(&self) -> f64 {
        self.expected.map_or_else(|| self.rms(), f64::sqrt)
    }

    /// The largest of them.
    pub(super) fn max(&self) -> f64 {
        self.counted().fold(0.0, f64::max)
    }
}
