//! What one fit of heights tells the next.

use super::fit_result::HeightFit;

/// The fairness that was best with another net, or for other points of the same surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WarmStart {
    fairness: f64,
    /// Of so many points: beside more, as much counts less.
    points: usize,
    pub(super) reach: Option<f64>,
}

impl WarmStart {
    /// The fairness that counts as much beside so many points.
    pub(crate) fn beside(&self, points: usize) -> f64 {
        if points == self.points {
            return self.fairness;
        }
        self.fairness * self.points as f64 / points as f64
    }
}

impl From<&HeightFit> for WarmStart {
    fn from(fit: &HeightFit) -> Self {
        Self { fairness: fit.fairness, points: fit.uv.len(), reach: fit.reach }
    }
}
