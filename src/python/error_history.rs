//! The history of the error during a job, for its report.

use std::ops::ControlFlow;

use super::call::Watcher;
use crate::progress::{Epoch, Observer, Progress, Stage};

/// Largest number of entries. When it is reached, every other entry is dropped.
const MAX_ENTRIES: usize = 4096;

/// Forwards progress to a watcher, and records the errors.
pub(super) struct Recorder<'a> {
    watcher: &'a mut Watcher,
    history: Vec<(&'static str, u64, f64)>,
    /// Number of errors observed so far, and the number of them per entry.
    count: usize,
    stride: usize,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(watcher: &'a mut Watcher) -> Self {
        Self { watcher, history: Vec::new(), count: 0, stride: 1 }
    }

    /// The entries: stage, step and error in the points' unit, in order.
    pub(super) fn into_history(self) -> Vec<(&'static str, u64, f64)> {
        self.history
    }

    fn keep(&mut self, stage: Stage, step: u64, error: f64) {
        if self.count.is_multiple_of(self.stride) {
            self.history.push((stage.name(), step, error));
        }
        self.count += 1;
        if self.history.len() == MAX_ENTRIES {
            let mut kept = false;
            self.history.retain(|_| {
                kept = !kept;
                kept
            });
            self.stride *= 2;
        }
    }
}

impl Observer for Recorder<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        // Training reports its errors once per epoch.
        if let Some(error) = progress.error
            && progress.stage != Stage::Training
            && self.history.last().is_none_or(|last| last.2 != error)
        {
            self.keep(progress.stage, progress.step, error);
        }
        self.watcher.observe(progress)
    }

    fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        self.keep(Stage::Training, epoch.step, epoch.error);
        self.watcher.observe_epoch(epoch)
    }
}
