//! Jobs inside a thread pool, watched from outside.
//!
//! Parallel parts of a job outside of the pool each hand their work over, sleep, and are woken in
//! the end. A small cloud has hundreds of them, and they would wait as long as they work.
//!
//! The threads are new ones for each job. What slept since the last one counts as light to the kernel, which
//! lets two such threads share a core for a twentieth of a second, as long as the whole job of a small cloud;
//! new ones count as busy. To start two takes a tenth of a millisecond.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::ThreadPoolBuilder;

use crate::error::{Error, Result};
use crate::progress::{Epoch, Observer, Progress, Stage};

/// Time between two looks at the news, and between two reports from the same stage.
const INTERVAL: Duration = Duration::from_millis(2);

/// Points that are worth a thread of their own.
const POINTS_PER_THREAD: usize = 256;

/// Runs a job in as many threads as so many points are worth; the observer is called from this thread.
///
/// Neither waits for the other: to wake a thread takes longer than many a step of a small job.
pub(super) fn in_pool<T: Send>(
    points: usize,
    observer: &mut dyn Observer,
    job: impl FnOnce(&mut dyn Observer) -> Result<T> + Send,
) -> Result<T> {
    if rayon::current_thread_index().is_some() {
        return job(observer);
    }
    let threads = rayon::current_num_threads().min(points.div_ceil(POINTS_PER_THREAD)).max(1);
    let Ok(pool) = ThreadPoolBuilder::new().num_threads(threads).build() else {
        // Where no more threads may be started, this one has to do.
        return job(observer);
    };
    let desk = Desk::default();
    let (mut done, mut stopped) = (Err(Error::Interrupted), false);
    pool.in_place_scope(|scope| {
        // The job is not to go on when the observer panics.
        let _stop = Stop(&desk);
        let (desk, done) = (&desk, &mut done);
        scope.spawn(move |_| {
            // Nobody waits for a job that panics.
            let _end = End(desk);
            *done = job(&mut Relay { desk, last: None });
        });
        while !stopped && let Some(news) = desk.wait() {
            stopped = news.into_iter().any(|news| news.tell(observer).is_break());
        }
    });
    if stopped { Err(Error::Interrupted) } else { done }
}

/// What a job tells.
enum News {
    Progress(Progress),
    Epoch { step: u64, error: f64, radius: f64, change: f64, lattice: Vec<DVec3> },
}

impl News {
    fn tell(self, observer: &mut dyn Observer) -> ControlFlow<()> {
        match self {
            Self::Progress(progress) => observer.observe(&progress),
            Self::Epoch { step, error, radius, change, lattice } => {
                observer.learned(&Epoch { step, error, radius, change, lattice: &lattice })
            }
        }
    }

    /// Whether this need not be told any more when there is something newer.
    fn is_outdated_by(&self, newer: &Self) -> bool {
        match (self, newer) {
            (Self::Progress(old), Self::Progress(new)) => {
                old.stage == new.stage && old.step < old.total
            }
            _ => false,
        }
    }
}

/// Where a job leaves its news, and the observer its wish to stop.
#[derive(Default)]
struct Desk {
    news: Mutex<Tray>,
    ended: Condvar,
    stopped: AtomicBool,
}

#[derive(Default)]
struct Tray {
    news: Vec<News>,
    ended: bool,
}

impl Desk {
    fn tray(&self) -> MutexGuard<'_, Tray> {
        // Nothing is half done where the lock is held.
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The news there are after a while; nothing after the last of a job that has ended.
    fn wait(&self) -> Option<Vec<News>> {
        let waiting = self.ended.wait_timeout_while(self.tray(), INTERVAL, |tray| !tray.ended);
        let (mut tray, _) = waiting.unwrap_or_else(PoisonError::into_inner);
        let news = std::mem::take(&mut tray.news);
        (!(tray.ended && news.is_empty())).then_some(news)
    }

    fn leave(&self, news: News) -> ControlFlow<()> {
        let mut tray = self.tray();
        if tray.news.last().is_some_and(|last| last.is_outdated_by(&news)) {
            tray.news.pop();
        }
        tray.news.push(news);
        drop(tray);
        if self.stopped.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Stops the job when dropped.
struct Stop<'a>(&'a Desk);

impl Drop for Stop<'_> {
    fn drop(&mut self) {
        self.0.stopped.store(true, Ordering::Relaxed);
    }
}

/// Says that the job has ended when dropped.
struct End<'a>(&'a Desk);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.tray().ended = true;
        self.0.ended.notify_one();
    }
}

/// The observer in the pool: leaves news for the one outside.
struct Relay<'a> {
    desk: &'a Desk,
    /// The last report: its stage and its time.
    last: Option<(Stage, Instant)>,
}

impl Observer for Relay<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let soon =
            |(stage, at): (Stage, Instant)| stage == progress.stage && at.elapsed() < INTERVAL;
        if progress.step < progress.total && self.last.is_some_and(soon) {
            return ControlFlow::Continue(());
        }
        self.last = Some((progress.stage, Instant::now()));
        self.desk.leave(News::Progress(*progress))
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let &Epoch { step, error, radius, change, lattice } = epoch;
        self.desk.leave(News::Epoch { step, error, radius, change, lattice: lattice.to_vec() })
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::thread;

    use super::*;
    use crate::progress::{Silent, report};

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
        assert!(in_pool(1000, &mut observer, job).unwrap().is_some());
        // Of those before some may be outdated already.
        assert!(steps.is_sorted() && steps.last() == Some(&3), "{steps:?}");
    }

    #[test]
    fn few_points_have_few_threads() {
        let threads = |_: &mut dyn Observer| Ok(rayon::current_num_threads());
        assert_eq!(in_pool(POINTS_PER_THREAD, &mut Silent, threads).unwrap(), 1);
        let all = rayon::current_num_threads();
        assert_eq!(in_pool(all * POINTS_PER_THREAD, &mut Silent, threads).unwrap(), all);
    }

    #[test]
    fn observers_stop_jobs_by_an_answer_or_a_panic() {
        let mut stop = |_: &Progress| ControlFlow::Break(());
        assert!(matches!(in_pool(1000, &mut stop, job), Err(Error::Interrupted)));
        let mut panic = |_: &Progress| -> ControlFlow<()> { panic!("an observer's own") };
        assert!(catch_unwind(AssertUnwindSafe(|| in_pool(1000, &mut panic, job))).is_err());
    }

    #[test]
    fn observers_may_ask_for_as_many_jobs_as_the_pool_has_threads() {
        let mut observer = |_: &Progress| {
            let threads = rayon::current_num_threads();
            let sums: Vec<usize> = rayon::broadcast(|_| threads);
            assert_eq!(sums, vec![threads; threads]);
            ControlFlow::Continue(())
        };
        assert!(in_pool(1000, &mut observer, job).is_ok());
    }
}
