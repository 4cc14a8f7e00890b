//! Progress reports of a training.

use glam::DVec3;

use super::batch_sums::BatchSums;
use super::map::SelfOrganizingMap;
use crate::error::Result;
use crate::progress::{self, Epoch, Observer, Progress, Stage};

impl SelfOrganizingMap {
    /// Records the mean distance and the number of reached points of an epoch.
    pub(super) fn record_epoch(&mut self, sums: &BatchSums) {
        self.error = Some(sums.mean_distance());
        self.reached = usize::try_from(sums.reached).unwrap_or(usize::MAX);
    }

    /// Reports the current progress.
    pub(super) fn report(&self, observer: &mut dyn Observer) -> Result<()> {
        let progress = Progress {
            stage: Stage::Training,
            step: self.steps,
            total: self.plan.max_steps.max(self.steps),
            change: self.change,
            error: self.error,
            radius: Some(self.radius()),
            reached: self.reached,
            points: usize::try_from(self.plan.epoch_points).unwrap_or(usize::MAX),
            share: None,
        };
        progress::report(observer, &progress)
    }

    /// Reports a finished epoch.
    pub(super) fn report_epoch(&self, nodes: &[DVec3], observer: &mut dyn Observer) -> Result<()> {
        let lattice: Vec<DVec3> = nodes.iter().map(|&node| self.frame.undo(node)).collect();
        let epoch = Epoch {
            step: self.steps,
            error: self.error.unwrap_or(f64::NAN),
            radius: self.plan.radius_at(self.steps.saturating_sub(1)),
            change: self.change.unwrap_or(f64::NAN),
            lattice: &lattice,
        };
        progress::report_epoch(observer, &epoch)
    }
}
