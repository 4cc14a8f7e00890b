//! The threads of the crate: their number, a shared pool, and a new pool for each long job.
//!
//! The observer of a long job is called on the calling thread, outside of the pool. A fork copies a
//! process without its threads, so a pool made before the fork would never work in the child. Each
//! process makes its own pool.

use std::mem;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{env, hint, process, thread};

use arc_swap::ArcSwapOption;
use glam::DVec3;
use rayon::{Scope, ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};
use crate::progress::{Epoch, Observer, Progress, Stage};

/// Largest number of threads.
pub(crate) const MAX_THREADS: usize = 256;

/// Environment variables for the number of threads; the first with a number from 1 decides.
const VARIABLES: [&str; 2] = ["NEURBS_NUM_THREADS", "RAYON_NUM_THREADS"];

/// Time between two polls of the events of a job, and between two reports from the same stage.
const INTERVAL: Duration = Duration::from_millis(2);

/// Time for which an idle thread polls the active ones before it sleeps. Waking a thread takes as
/// long as a small mesh.
const SPIN_TIME: Duration = Duration::from_micros(50);

/// Points per thread.
const POINTS_PER_THREAD: usize = 256;

/// The number of threads; 0 until it is asked for.
static NUM_THREADS: AtomicUsize = AtomicUsize::new(0);

/// The pool that calls share. Reading and replacing it takes no lock, which a fork could leave held.
static POOL: ArcSwapOption<Pool> = ArcSwapOption::const_empty();

struct Pool {
    process: u32,
    threads: ThreadPool,
}

/// The number of threads for parallel work, at most 256.
///
/// Inside a rayon pool it is the number of the pool's threads. Otherwise the first of these that
/// exists decides: [`set_num_threads`], the environment variables `NEURBS_NUM_THREADS` and
/// `RAYON_NUM_THREADS`, the number of processors.
///
/// ```
/// neurbs::set_num_threads(3);
/// assert_eq!(neurbs::num_threads(), 3);
/// ```
#[must_use]
pub fn num_threads() -> usize {
    if rayon::current_thread_index().is_some() {
        return rayon::current_num_threads();
    }
    match NUM_THREADS.load(Ordering::Relaxed) {
        0 => {
            set_num_threads(from_environment().unwrap_or_else(processors));
            NUM_THREADS.load(Ordering::Relaxed)
        }
        threads => threads,
    }
}

/// Sets the number of threads for the calls that follow. Numbers outside 1 to 256 are clamped.
/// Results do not depend on it.
pub fn set_num_threads(threads: usize) {
    NUM_THREADS.store(threads.clamp(1, MAX_THREADS), Ordering::Relaxed);
}

fn from_environment() -> Option<usize> {
    let number = |name| env::var(name).ok()?.trim().parse().ok();
    VARIABLES.into_iter().filter_map(number).find(|threads| *threads > 0)
}

fn processors() -> usize {
    thread::available_parallelism().map_or(1, Into::into)
}

/// Runs a job in the shared pool, or in the rayon pool that the caller is in.
pub(crate) fn install<T: Send>(job: impl FnOnce() -> T + Send) -> T {
    if rayon::current_thread_index().is_some() { job() } else { pool().threads.install(job) }
}

/// Runs a job on the calling thread. Its tasks run in the shared pool, or in the rayon pool that the
/// caller is in. Returns when all tasks are done.
pub(crate) fn in_place_scope<'a, T>(job: impl FnOnce(&Scope<'a>) -> T) -> T {
    if rayon::current_thread_index().is_some() {
        rayon::in_place_scope(job)
    } else {
        pool().threads.in_place_scope(job)
    }
}

/// Processes tasks on all threads. A thread takes `batch_size` tasks at a time and reuses its own
/// scratch buffer.
///
/// The calling thread works, too: a job of two milliseconds must not wait until the system has
/// woken every sleeping thread.
pub(crate) fn for_each_task<T, R: Default>(
    tasks: impl Iterator<Item = T> + Send,
    batch_size: usize,
    work: impl Fn(&mut R, T) + Sync,
) {
    let batch_size = batch_size.max(1);
    let max_tasks = tasks.size_hint().1.unwrap_or(usize::MAX);
    let threads = max_tasks.div_ceil(batch_size).min(num_threads());
    let tasks = Mutex::new(tasks);
    let worker = || {
        let (mut scratch, mut batch) = (R::default(), Vec::with_capacity(batch_size));
        loop {
            let mut tasks = tasks.lock().unwrap_or_else(PoisonError::into_inner);
            batch.extend(tasks.by_ref().take(batch_size));
            drop(tasks);
            if batch.is_empty() {
                return;
            }
            batch.drain(..).for_each(|task| work(&mut scratch, task));
        }
    };
    if threads <= 1 {
        return worker();
    }
    let active = AtomicUsize::new(0);
    in_place_scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|_| {
                active.fetch_add(1, Ordering::Relaxed);
                worker();
                active.fetch_sub(1, Ordering::Release);
            });
        }
        worker();
        // Threads of the pool have other work. Threads that have not started yet may need the
        // processor of this one.
        if rayon::current_thread_index().is_none() {
            let started = Instant::now();
            while active.load(Ordering::Acquire) > 0 && started.elapsed() < SPIN_TIME {
                hint::spin_loop();
            }
        }
    });
}

/// Starts a task in the shared pool, or in the rayon pool that the caller is in, without waiting.
pub(crate) fn spawn(task: impl FnOnce() + Send + 'static) {
    if rayon::current_thread_index().is_some() {
        rayon::spawn(task);
    } else {
        pool().threads.spawn(task);
    }
}

/// The shared pool of this process. A fork or another number of threads makes a new one.
fn pool() -> Arc<Pool> {
    let (process, threads) = (process::id(), num_threads());
    let fits =
        |pool: &Pool| pool.process == process && pool.threads.current_num_threads() == threads;
    if let Some(pool) = POOL.load_full().filter(|pool| fits(pool)) {
        return pool;
    }
    let made = Arc::new(Pool { process, threads: new_pool(threads) });
    if let Some(old) = POOL.swap(Some(Arc::clone(&made)))
        && old.process != process
    {
        // Its threads are in the parent, which may have held their locks at the fork.
        mem::forget(old);
    }
    made
}

/// A new pool. If no thread can be started, the calling thread becomes its only one.
fn new_pool(threads: usize) -> ThreadPool {
    let of = |threads| ThreadPoolBuilder::new().num_threads(threads);
    let pool = of(threads).build().or_else(|_| of(1).use_current_thread().build());
    pool.expect("a pool of the current thread alone starts no thread")
}

/// Runs a job in a new pool with a thread for each [`POINTS_PER_THREAD`] points. The observer is
/// called on the calling thread.
///
/// The whole job enters the pool once. Otherwise each parallel loop of the job would wait for a thread
/// to wake up; a job on a small cloud has hundreds of them.
///
/// The pool is new for each job. The kernel may put two long-idle threads on one core for 50 ms, as
/// long as a whole job on a small cloud. Two threads start in 0.1 ms.
pub(crate) fn run_observed<T: Send>(
    points: usize,
    observer: &mut dyn Observer,
    job: impl FnOnce(&mut dyn Observer) -> Result<T> + Send,
) -> Result<T> {
    if rayon::current_thread_index().is_some() {
        return job(observer);
    }
    let pool = new_pool(num_threads().min(points.div_ceil(POINTS_PER_THREAD)).max(1));
    if rayon::current_thread_index().is_some() {
        return job(observer);
    }
    let queue = EventQueue::default();
    let (mut done, mut stopped) = (Err(Error::Interrupted), false);
    pool.in_place_scope(|scope| {
        // The job must end if the observer panics.
        let _stop = StopOnDrop(&queue);
        let (queue, done) = (&queue, &mut done);
        scope.spawn(move |_| {
            // The wait must end if the job panics.
            let _end = EndOnDrop(queue);
            *done = job(&mut Sender { queue, last: None });
        });
        while !stopped && let Some(events) = queue.wait() {
            stopped = events.into_iter().any(|event| event.send(observer).is_break());
        }
    });
    if stopped { Err(Error::Interrupted) } else { done }
}

/// A report of a job to its observer.
enum Event {
    Progress(Progress),
    Epoch { step: u64, error: f64, radius: f64, change: f64, lattice: Vec<DVec3> },
}

impl Event {
    fn send(self, observer: &mut dyn Observer) -> ControlFlow<()> {
        match self {
            Self::Progress(progress) => observer.observe(&progress),
            Self::Epoch { step, error, radius, change, lattice } => {
                observer.observe_epoch(&Epoch { step, error, radius, change, lattice: &lattice })
            }
        }
    }

    /// Whether the observer need not see this event once there is a newer one.
    fn is_outdated_by(&self, newer: &Self) -> bool {
        match (self, newer) {
            (Self::Progress(old), Self::Progress(new)) => {
                old.stage == new.stage && old.step < old.total
            }
            _ => false,
        }
    }
}

/// Events on their way from a job to its observer, and the observer's answer.
#[derive(Default)]
struct EventQueue {
    waiting: Mutex<Waiting>,
    ended: Condvar,
    stopped: AtomicBool,
}

#[derive(Default)]
struct Waiting {
    events: Vec<Event>,
    ended: bool,
}

impl EventQueue {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        // No change under this lock can be left half done.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The events of the next interval; `None` after the last of a job that has ended.
    fn wait(&self) -> Option<Vec<Event>> {
        let waited = self.ended.wait_timeout_while(self.waiting(), INTERVAL, |now| !now.ended);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let events = mem::take(&mut waiting.events);
        (!(waiting.ended && events.is_empty())).then_some(events)
    }

    fn push(&self, event: Event) -> ControlFlow<()> {
        let mut waiting = self.waiting();
        if waiting.events.last().is_some_and(|last| last.is_outdated_by(&event)) {
            waiting.events.pop();
        }
        waiting.events.push(event);
        drop(waiting);
        if self.stopped.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Stops the job when dropped.
struct StopOnDrop<'a>(&'a EventQueue);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.stopped.store(true, Ordering::Relaxed);
    }
}

/// Marks the job as ended when dropped.
struct EndOnDrop<'a>(&'a EventQueue);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.waiting().ended = true;
        self.0.ended.notify_one();
    }
}

/// The observer inside the pool: it queues events for the one outside.
struct Sender<'a> {
    queue: &'a EventQueue,
    /// Stage and time of the last report.
    last: Option<(Stage, Instant)>,
}

impl Observer for Sender<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let soon =
            |(stage, at): (Stage, Instant)| stage == progress.stage && at.elapsed() < INTERVAL;
        if progress.step < progress.total && self.last.is_some_and(soon) {
            return ControlFlow::Continue(());
        }
        self.last = Some((progress.stage, Instant::now()));
        self.queue.push(Event::Progress(*progress))
    }

    fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let &Epoch { step, error, radius, change, lattice } = epoch;
        self.queue.push(Event::Epoch { step, error, radius, change, lattice: lattice.to_vec() })
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::thread;

    use super::*;
    use crate::progress::{Silent, report};

    /// Reports from one step to the next, up to the end.
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
        assert!(run_observed(1000, &mut observer, job).unwrap().is_some());
        // Earlier reports may have been outdated.
        assert!(steps.is_sorted() && steps.last() == Some(&3), "{steps:?}");
    }

    #[test]
    fn few_points_have_few_threads() {
        let threads = |_: &mut dyn Observer| Ok(rayon::current_num_threads());
        assert_eq!(run_observed(POINTS_PER_THREAD, &mut Silent, threads).unwrap(), 1);
        let all = num_threads();
        assert_eq!(run_observed(all * POINTS_PER_THREAD, &mut Silent, threads).unwrap(), all);
    }

    #[test]
    fn observers_stop_jobs_by_an_answer_or_a_panic() {
        let mut stop = |_: &Progress| ControlFlow::Break(());
        assert!(matches!(run_observed(1000, &mut stop, job), Err(Error::Interrupted)));
        let mut panic = |_: &Progress| -> ControlFlow<()> { panic!("an observer's own") };
        assert!(catch_unwind(AssertUnwindSafe(|| run_observed(1000, &mut panic, job))).is_err());
    }

    #[test]
    fn observers_may_use_the_shared_pool() {
        let mut observer = |_: &Progress| {
            let threads = num_threads();
            let sums: Vec<usize> = install(|| rayon::broadcast(|_| rayon::current_num_threads()));
            assert_eq!(sums, vec![threads; threads]);
            ControlFlow::Continue(())
        };
        assert!(run_observed(1000, &mut observer, job).is_ok());
    }

    #[test]
    fn calls_share_one_pool_and_a_users_pool_comes_first() {
        assert!(Arc::ptr_eq(&pool(), &pool()));
        let own = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(own.install(|| (num_threads(), install(rayon::current_num_threads))), (3, 3));
        assert_eq!(install(rayon::current_num_threads), num_threads());
    }
}
