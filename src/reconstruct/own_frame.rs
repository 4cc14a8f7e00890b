//! The frame that work is done in, and what is told of that in the points' own frame and unit.

use std::ops::ControlFlow;

use glam::DVec3;

use super::units::Units;
use crate::point_cloud::Normalization;
use crate::progress::{Epoch, Observer, Progress};

/// Where points are in work, by what their coordinates count.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) units: Units,
    pub(super) counted: Normalization,
}

impl Frame {
    /// From the points' frame.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        self.counted.apply(self.units.apply(point))
    }

    /// Points whose coordinates are what they count.
    pub(super) fn counted(&self, points: &[DVec3]) -> Vec<DVec3> {
        points.iter().map(|&point| self.counted.apply(point)).collect()
    }

    /// Back to the points' frame.
    pub(super) fn undo(&self, point: DVec3) -> DVec3 {
        self.units.undo(self.counted.undo(point))
    }

    /// A length of the frame as the points' coordinates count.
    pub(super) fn length(&self, length: f64) -> f64 {
        length / self.counted.scale
    }
}

/// Hands on what work in a frame tells.
pub(super) struct OwnFrame<'a> {
    pub(super) frame: Frame,
    pub(super) observer: &'a mut dyn Observer,
}

impl Observer for OwnFrame<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let length = |length: f64| self.frame.length(length);
        let (change, error) = (progress.change.map(length), progress.error.map(length));
        self.observer.observe(&Progress { change, error, ..*progress })
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let lattice: Vec<DVec3> = epoch.lattice.iter().map(|&node| self.frame.undo(node)).collect();
        let (error, change) = (self.frame.length(epoch.error), self.frame.length(epoch.change));
        self.observer.learned(&Epoch { error, change, lattice: &lattice, ..*epoch })
    }
}
