//! Batches of parameters: their checks, and their way through in blocks that report.

use std::hint;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::error::Result;
use crate::progress::{self, Listen, Observer, Progress, Stage};

/// Points between two calls of the observer: a few milliseconds, of which the threads lose a few
/// microseconds in meeting.
const POINTS_PER_REPORT: usize = 1 << 20;

/// Points that a thread takes at a time: tens of microseconds of work.
pub(super) const POINTS_PER_TASK: usize = 1 << 10;

/// Points that work without threads goes through before it listens again: a millisecond at most.
const POINTS_PER_STEP: usize = 1 << 15;

/// How long a block of tasks of unknown cost should take, and how many are tried first.
const BLOCK_TIME: Duration = Duration::from_millis(20);
const FIRST_BLOCK: usize = 2;

/// Time for which a thread that is done with its part looks whether the others at work are, before it
/// sleeps: to be woken takes as long as a small mesh.
const PATIENCE: Duration = Duration::from_micros(50);

/// Does `total` points in blocks from..to, with a report after each.
pub(super) fn in_blocks(
    total: usize,
    observer: &mut dyn Observer,
    mut work: impl FnMut(usize, usize),
) -> Result<()> {
    in_rows(total, 1, observer, &mut work)
}

/// Does `rows` rows of `width` points in blocks from..to, with a report after each.
pub(super) fn in_rows(
    rows: usize,
    width: usize,
    observer: &mut dyn Observer,
    mut work: impl FnMut(usize, usize),
) -> Result<()> {
    let total = rows * width;
    let block = POINTS_PER_REPORT.div_ceil(width.max(1));
    for from in (0..rows).step_by(block) {
        report(observer, from * width, total)?;
        work(from, rows.min(from + block));
    }
    report(observer, total, total)
}

/// Does `total` tasks, of which nobody knows how long one takes, in blocks from..to that take some
/// [`BLOCK_TIME`] each, with a report after each.
pub(super) fn in_timed_blocks(
    total: usize,
    observer: &mut dyn Observer,
    mut work: impl FnMut(usize, usize),
) -> Result<()> {
    let (mut from, mut block) = (0, FIRST_BLOCK);
    while from < total {
        report(observer, from, total)?;
        let (started, to) = (Instant::now(), total.min(from + block));
        work(from, to);
        if started.elapsed() > BLOCK_TIME {
            block = (block / 2).max(1);
        } else if started.elapsed() < BLOCK_TIME / 4 {
            block *= 2;
        }
        from = to;
    }
    report(observer, total, total)
}

/// Works through tasks on all threads, each of which takes so many at once and has room of its own
/// that it uses again.
///
/// The thread that calls does its part: what takes two milliseconds must not wait until the system
/// has found a processor for every thread that sleeps.
pub(crate) fn share<T, R: Default>(
    tasks: impl Iterator<Item = T> + Send,
    at_once: usize,
    work: impl Fn(&mut R, T) + Sync,
) {
    let at_once = at_once.max(1);
    let most = tasks.size_hint().1.unwrap_or(usize::MAX);
    let helpers = most.div_ceil(at_once).min(rayon::current_num_threads());
    let tasks = Mutex::new(tasks);
    let through = || {
        let (mut room, mut taken) = (R::default(), Vec::with_capacity(at_once));
        loop {
            let mut tasks = tasks.lock().unwrap_or_else(PoisonError::into_inner);
            taken.extend(tasks.by_ref().take(at_once));
            drop(tasks);
            if taken.is_empty() {
                return;
            }
            taken.drain(..).for_each(|task| work(&mut room, task));
        }
    };
    if helpers <= 1 {
        return through();
    }
    let at_work = AtomicUsize::new(0);
    rayon::in_place_scope(|scope| {
        for _ in 1..helpers {
            scope.spawn(|_| {
                at_work.fetch_add(1, Ordering::Relaxed);
                through();
                at_work.fetch_sub(1, Ordering::Release);
            });
        }
        through();
        // Threads of the pool have other work to look for. Those that have not come yet may need the
        // processor of this one.
        if rayon::current_thread_index().is_none() {
            let started = Instant::now();
            while at_work.load(Ordering::Acquire) > 0 && started.elapsed() < PATIENCE {
                hint::spin_loop();
            }
        }
    });
}

/// What work in small steps calls between them, to hear from the observer whether to go on.
pub(super) fn listening(observer: &mut dyn Observer) -> impl FnMut() -> Result<()> {
    move || report(observer, 0, 1)
}

/// The ranges of `rows` rows of `width` points, after each of which such work listens.
pub(super) fn steps(rows: usize, width: usize) -> impl Iterator<Item = Range<usize>> {
    let step = (POINTS_PER_STEP / width.max(1)).max(1);
    (0..rows).step_by(step).map(move |from| from..rows.min(from + step))
}

/// A list made of what `part` returns for each of these ranges.
pub(super) fn in_steps<T, I: Iterator<Item = T>>(
    (rows, width): (usize, usize),
    listen: &mut Listen<'_>,
    part: impl Fn(Range<usize>) -> I,
) -> Result<Vec<T>> {
    let mut all = Vec::with_capacity(rows * width);
    for rows in steps(rows, width) {
        listen()?;
        all.extend(part(rows));
    }
    Ok(all)
}

fn report(observer: &mut dyn Observer, done: usize, total: usize) -> Result<()> {
    let (step, total) = (done as u64, total as u64);
    let stage = Stage::Tessellation;
    progress::report(observer, &Progress::of_stage(stage, step, total, 0))
}
