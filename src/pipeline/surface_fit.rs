//! A fitted surface with the points' parameters on it.

use glam::DVec2;

use crate::fit::{Approximation, EndedBy};
use crate::nurbs::NurbsSurface;

/// A surface fitted to the points of the local frame.
#[derive(Clone, Debug)]
pub(super) struct SurfaceFit {
    pub(super) surface: NurbsSurface,
    /// Parameters of each point's projection.
    pub(super) uv: Vec<DVec2>,
    /// Each point's distance from its projection.
    pub(super) distances: Vec<f64>,
    /// Weights of the squared distances; 0 for outliers.
    pub(super) weights: Vec<f64>,
    pub(super) fairness: f64,
    /// Mean squared distance of held-out points, as cross-validation estimates it.
    pub(super) expected: Option<f64>,
    pub(super) iterations: usize,
    pub(super) ended_by: EndedBy,
}

impl SurfaceFit {
    /// The result of an approximation with these weights.
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

    /// Distances of the points with weight.
    fn weighted_distances(&self) -> impl Iterator<Item = f64> + '_ {
        let all = self.distances.iter().zip(&self.weights);
        all.filter(|(_, weight)| **weight > 0.0).map(|(distance, _)| *distance)
    }

    /// Root of the weighted mean of the squared distances.
    pub(super) fn rms(&self) -> f64 {
        let (squares, weights) = self
            .distances
            .iter()
            .zip(&self.weights)
            .fold((0.0, 0.0), |(sum, all), (d, w)| (sum + w * d * d, all + w));
        (squares / weights).sqrt()
    }

    /// Root mean square distance to be expected of held-out points. Without cross-validation, it
    /// is that of the points.
    pub(super) fn error(&self) -> f64 {
        self.expected.map_or_else(|| self.rms(), f64::sqrt)
    }

    /// The largest distance of a point with weight.
    pub(super) fn max(&self) -> f64 {
        self.weighted_distances().fold(0.0, f64::max)
    }
}
