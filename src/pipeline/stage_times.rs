//! Wall time of each stage, for the report.

use std::time::{Duration, Instant};

/// A clock that is read at the end of each stage.
pub(super) struct StageTimes {
    last: Instant,
    times: Vec<(&'static str, Duration)>,
}

impl StageTimes {
    /// Starts the clock of the first stage.
    pub(super) fn start() -> Self {
        Self { last: Instant::now(), times: Vec::new() }
    }

    /// Ends a stage. A stage that ends twice gets the sum of both times.
    pub(super) fn end_stage(&mut self, stage: &'static str) {
        let now = Instant::now();
        let spent = now - self.last;
        match self.times.iter_mut().find(|(other, _)| *other == stage) {
            Some((_, before)) => *before += spent,
            None => self.times.push((stage, spent)),
        }
        self.last = now;
    }

    /// The stages in their order, with their times in seconds.
    pub(super) fn seconds(self) -> Vec<(&'static str, f64)> {
        self.times.into_iter().map(|(stage, time)| (stage, time.as_secs_f64())).collect()
    }
}
