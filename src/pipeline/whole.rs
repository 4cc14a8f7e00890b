//! How much of a whole reconstruction is done.

use std::ops::ControlFlow;

use crate::progress::{Epoch, Observer, Progress};

/// Microseconds that stages take for each point, on a processor of 2025: preparation, selection of
/// the points that it looks at, refinement, measuring.
const COSTS: [f64; 4] = [8.0, 100.0, 50.0, 2.0];

/// A stage of a reconstruction, by its place among them.
#[derive(Clone, Copy)]
pub(super) enum Part {
    Prepare,
    Select,
    Refine,
    Measure,
}

impl Part {
    /// The share of the whole that is done when it begins and when it ends, for so many points of
    /// which so many are looked at in selection.
    fn shares(self, points: usize, seen: usize) -> (f64, f64) {
        let counts = [points, seen.min(points), points, points];
        let costs: Vec<f64> = COSTS.iter().zip(counts).map(|(cost, n)| cost * n as f64).collect();
        let (stage, total) = (self as usize, costs.iter().sum::<f64>());
        let until = |end: usize| costs[..end].iter().sum::<f64>() / total;
        (until(stage), until(stage + 1))
    }

    /// An observer of this stage, who hears of the share of the whole.
    pub(super) fn observed(
        self,
        points: usize,
        seen: usize,
        observer: &mut dyn Observer,
    ) -> PartObserver<'_> {
        let (done, end) = self.shares(points, seen);
        PartObserver { observer, done, end, last: 0.0 }
    }
}

/// An observer of what is done before the first stage.
pub(super) fn before(observer: &mut dyn Observer) -> PartObserver<'_> {
    PartObserver { observer, done: 0.0, end: 0.0, last: 0.0 }
}

/// Tells an observer which share of the whole is done. How many rounds a stage has is not known
/// before: each takes half of what is left of it.
pub(super) struct PartObserver<'a> {
    observer: &'a mut dyn Observer,
    /// The share when the round began, and at the end of the stage.
    done: f64,
    end: f64,
    /// The share of the round that is done.
    last: f64,
}

impl Observer for PartObserver<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let round = (progress.step as f64 / progress.total.max(1) as f64).min(1.0);
        if round < self.last {
            self.done += 0.5 * self.last * (self.end - self.done);
        }
        self.last = round;
        let share = Some(self.done + 0.5 * round * (self.end - self.done));
        self.observer.observe(&Progress { share, ..*progress })
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        self.observer.learned(epoch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Stage;

    #[test]
    fn shares_follow_one_another_and_never_fall() {
        let mut shares = Vec::new();
        let mut note = |progress: &Progress| {
            shares.extend(progress.share);
            ControlFlow::Continue(())
        };
        for part in [Part::Prepare, Part::Select, Part::Refine, Part::Measure] {
            let mut observer = part.observed(3000, 2000, &mut note);
            for step in [0, 5, 10, 0, 10, 2, 4] {
                let progress = Progress::of_stage(Stage::Fitting, step, 10, 3000);
                assert!(observer.observe(&progress).is_continue());
            }
        }
        assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]), "{shares:?}");
        assert!(shares[0] == 0.0 && shares[shares.len() - 1] < 1.0);
    }
}
