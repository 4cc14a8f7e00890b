//! Warm start: the fairness, anisotropy and reach of one height field, as a start for the next.

use super::fit_result::HeightFit;

/// The fairness and anisotropy that were best with another net, or for other points of the same surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WarmStart {
    fairness: f64,
    /// Number of points of that fit. The same energy has less relative weight beside more points.
    points: usize,
    pub(super) reach: Option<f64>,
    pub(super) anisotropy: f64,
}

impl WarmStart {
    /// The fairness with the same absolute weight beside this number of points.
    pub(crate) fn fairness_for(&self, points: usize) -> f64 {
        if points == self.points {
            return self.fairness;
        }
        self.fairness * self.points as f64 / points as f64
    }
}

impl From<&HeightFit> for WarmStart {
    fn from(fit: &HeightFit) -> Self {
        let HeightFit { fairness, reach, anisotropy, .. } = *fit;
        Self { fairness, points: fit.uv.len(), reach, anisotropy }
    }
}
