//! The share of a whole reconstruction that is done.

use std::ops::ControlFlow;

use crate::progress::{Epoch, Observer, Progress};

/// Microseconds a point for each phase, on a processor of 2025. The cost of ranking is for a
/// sampled point, the others are for a given point.
const COSTS: [f64; 5] = [8.0, 100.0, 50.0, 2.0, 10.0];

/// A phase of a reconstruction; its number is its place in [`COSTS`].
#[derive(Clone, Copy)]
pub(super) enum Phase {
    Prepare,
    Rank,
    Refine,
    Measure,
    Trim,
}

impl Phase {
    /// The share of the whole that is done when the phase begins and when it ends.
    fn shares(self, points: usize, sampled: usize) -> (f64, f64) {
        let counts = [points, sampled.min(points), points, points, points];
        let costs: Vec<f64> = COSTS.iter().zip(counts).map(|(cost, n)| cost * n as f64).collect();
        let (phase, total) = (self as usize, costs.iter().sum::<f64>());
        let until = |end: usize| costs[..end].iter().sum::<f64>() / total;
        (until(phase), until(phase + 1))
    }

    /// An observer of this phase that reports the share of the whole to `observer`.
    pub(super) fn observed(
        self,
        points: usize,
        sampled: usize,
        observer: &mut dyn Observer,
    ) -> PhaseObserver<'_> {
        let (done, end) = self.shares(points, sampled);
        PhaseObserver { observer, done, end, last: 0.0 }
    }
}

/// An observer of the work before the first phase: it reports a share of 0.
pub(super) fn before_phases(observer: &mut dyn Observer) -> PhaseObserver<'_> {
    PhaseObserver { observer, done: 0.0, end: 0.0, last: 0.0 }
}

/// Adds the share of the whole to each report.
///
/// A phase consists of rounds whose number is not known in advance. Each round takes half of the
/// phase's remaining share.
pub(super) struct PhaseObserver<'a> {
    observer: &'a mut dyn Observer,
    /// Share of the whole at the start of the round.
    done: f64,
    /// Share of the whole at the end of the phase.
    end: f64,
    /// Share of the round that is done.
    last: f64,
}

impl Observer for PhaseObserver<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let round = (progress.step as f64 / progress.total.max(1) as f64).min(1.0);
        if round < self.last {
            self.done += 0.5 * self.last * (self.end - self.done);
        }
        self.last = round;
        let share = Some(self.done + 0.5 * round * (self.end - self.done));
        self.observer.observe(&Progress { share, ..*progress })
    }

    fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        self.observer.observe_epoch(epoch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Stage;

    #[test]
    fn the_reported_share_never_falls() {
        let mut shares = Vec::new();
        let mut note = |progress: &Progress| {
            shares.extend(progress.share);
            ControlFlow::Continue(())
        };
        for phase in [Phase::Prepare, Phase::Rank, Phase::Refine, Phase::Measure, Phase::Trim] {
            let mut observer = phase.observed(3000, 2000, &mut note);
            for step in [0, 5, 10, 0, 10, 2, 4] {
                let progress = Progress::of_stage(Stage::Fitting, step, 10, 3000);
                assert!(observer.observe(&progress).is_continue());
            }
        }
        assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]), "{shares:?}");
        assert!(shares[0] == 0.0 && shares[shares.len() - 1] < 1.0);
    }
}
