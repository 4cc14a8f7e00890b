//! What is told of work in a frame, in the points' own frame and unit.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::point_cloud::Normalization;
use crate::progress::{Epoch, Observer, Progress};

/// Hands on what work in a frame tells.
pub(super) struct OwnFrame<'a> {
    pub(super) frame: Normalization,
    pub(super) observer: &'a mut dyn Observer,
}

impl Observer for OwnFrame<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let length = |length: f64| length / self.frame.scale;
        let (change, error) = (progress.change.map(length), progress.error.map(length));
        self.observer.observe(&Progress { change, error, ..*progress })
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let lattice: Vec<DVec3> = epoch.lattice.iter().map(|&node| self.frame.undo(node)).collect();
        let (error, change) = (epoch.error / self.frame.scale, epoch.change / self.frame.scale);
        self.observer.learned(&Epoch { error, change, lattice: &lattice, ..*epoch })
    }
}
