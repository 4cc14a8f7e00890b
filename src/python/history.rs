//! How the error falls during a job, for the report of it.

use std::ops::ControlFlow;

use super::call::Watcher;
use crate::progress::{Epoch, Observer, Progress, Stage};

/// Entries kept at most: of a longer history, every other one is left out again and again.
const MOST: usize = 4096;

/// Hands on to a watcher what a job tells, and keeps the errors.
pub(super) struct Recorder<'a> {
    watcher: &'a mut Watcher,
    history: Vec<(&'static str, u64, f64)>,
    /// Errors told so far, and how many of them lead to one entry.
    told: usize,
    every: usize,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(watcher: &'a mut Watcher) -> Self {
        Self { watcher, history: Vec::new(), told: 0, every: 1 }
    }

    /// Stage, step and error in the points' unit of what was kept, in the order of the job.
    pub(super) fn into_history(self) -> Vec<(&'static str, u64, f64)> {
        self.history
    }

    fn keep(&mut self, stage: Stage, step: u64, error: f64) {
        if self.told.is_multiple_of(self.every) {
            self.history.push((stage.name(), step, error));
        }
        self.told += 1;
        if self.history.len() == MOST {
            let mut kept = false;
            self.history.retain(|_| {
                kept = !kept;
                kept
            });
            self.every *= 2;
        }
    }
}

impl Observer for Recorder<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        // Training tells each epoch by itself.
        if let Some(error) = progress.error
            && progress.stage != Stage::Training
            && self.history.last().is_none_or(|last| last.2 != error)
        {
            self.keep(progress.stage, progress.step, error);
        }
        self.watcher.observe(progress)
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        self.keep(Stage::Training, epoch.step, epoch.error);
        self.watcher.learned(epoch)
    }
}
