//! Jobs inside the thread pool, watched from outside.
//!
//! Parallel parts of a job outside of the pool each hand their work over, sleep, and are woken in
//! the end. A small cloud has hundreds of them, and they would wait as long as they work.

use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use glam::DVec3;

use crate::error::{Error, Result};
use crate::progress::{Epoch, Observer, Progress, Stage};

/// Time between two reports from the same stage.
const INTERVAL: Duration = Duration::from_millis(2);

/// Time after which a thread that waits for the observer looks for other work: the observer itself
/// may have some.
const PATIENCE: Duration = Duration::from_millis(1);

/// Runs a job in the thread pool; the observer is called from this thread.
pub(super) fn in_pool<T: Send>(
    observer: &mut dyn Observer,
    job: impl FnOnce(&mut dyn Observer) -> Result<T> + Send,
) -> Result<T> {
    if rayon::current_thread_index().is_some() {
        return job(observer);
    }
    let (told, news) = channel();
    let (answer, answers) = channel();
    let mut done = Err(Error::Interrupted);
    rayon::in_place_scope(|scope| {
        // Dropped when the observer panics: nobody waits for it then.
        let (news, answer) = (news, answer);
        let done = &mut done;
        scope.spawn(move |_| *done = job(&mut Relay { told, answers, last: None }));
        for news in news {
            let go_on = match news {
                News::Progress(progress) => observer.observe(&progress),
                News::Epoch { step, error, radius, change, lattice } => {
                    observer.learned(&Epoch { step, error, radius, change, lattice: &lattice })
                }
            };
            if answer.send(go_on).is_err() {
                break;
            }
        }
    });
    done
}

/// What a job tells.
enum News {
    Progress(Progress),
    Epoch { step: u64, error: f64, radius: f64, change: f64, lattice: Vec<DVec3> },
}

/// The observer in the pool: asks the one outside.
struct Relay {
    told: Sender<News>,
    answers: Receiver<ControlFlow<()>>,
    /// The last report: its stage and its time.
    last: Option<(Stage, Instant)>,
}

impl Relay {
    fn ask(&self, news: News) -> ControlFlow<()> {
        if self.told.send(news).is_err() {
            return ControlFlow::Break(());
        }
        loop {
            match self.answers.recv_timeout(PATIENCE) {
                Ok(answer) => return answer,
                Err(RecvTimeoutError::Disconnected) => return ControlFlow::Break(()),
                Err(RecvTimeoutError::Timeout) => {
                    rayon::yield_now();
                }
            }
        }
    }
}

impl Observer for Relay {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let soon =
            |(stage, at): (Stage, Instant)| stage == progress.stage && at.elapsed() < INTERVAL;
        if progress.step < progress.total && self.last.is_some_and(soon) {
            return ControlFlow::Continue(());
        }
        let answer = self.ask(News::Progress(*progress));
        self.last = Some((progress.stage, Instant::now()));
        answer
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let &Epoch { step, error, radius, change, lattice } = epoch;
        self.ask(News::Epoch { step, error, radius, change, lattice: lattice.to_vec() })
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::thread;

    use super::*;
    use crate::progress::report;

    /// Reports to the end, from one step to the next.
    fn job(observer: &mut dyn Observer) -> Result<Option<usize>> {
        for step in 0..=3 {
            report(observer, &Progress::of_stage(Stage::Fitting, step, 3, 10))?;
        }
        Ok(rayon::current_thread_index())
    }

    #[test]
    fn jobs_run_in_the_pool_and_observers_outside() {
        let (own, mut steps) = (thread::current().id(), Vec::new());
        let mut observer = |progress: &Progress| {
            assert_eq!(thread::current().id(), own);
            steps.push(progress.step);
            ControlFlow::Continue(())
        };
        assert!(in_pool(&mut observer, job).unwrap().is_some());
        // Of those in between some may come too soon.
        assert_eq!((steps.first(), steps.last()), (Some(&0), Some(&3)));
    }

    #[test]
    fn observers_stop_jobs_by_an_answer_or_a_panic() {
        let mut stop = |_: &Progress| ControlFlow::Break(());
        assert!(matches!(in_pool(&mut stop, job), Err(Error::Interrupted)));
        let mut panic = |_: &Progress| -> ControlFlow<()> { panic!("an observer's own") };
        assert!(catch_unwind(AssertUnwindSafe(|| in_pool(&mut panic, job))).is_err());
    }

    #[test]
    fn observers_may_ask_for_as_many_jobs_as_the_pool_has_threads() {
        let mut observer = |_: &Progress| {
            let threads = rayon::current_num_threads();
            let sums: Vec<usize> = rayon::broadcast(|_| threads);
            assert_eq!(sums, vec![threads; threads]);
            ControlFlow::Continue(())
        };
        assert!(in_pool(&mut observer, job).is_ok());
    }
}
