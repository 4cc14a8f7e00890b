//! Long work in blocks: parallel tasks, progress reports and interrupt checks.

use std::hint;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::error::Result;
use crate::progress::{self, Listen, Observer, Progress, Stage};

/// Points between two progress reports: a few milliseconds of work. Synchronizing the threads costs
/// a few microseconds.
const POINTS_PER_REPORT: usize = 1 << 20;

/// Points in the task of a thread: tens of microseconds of work.
pub(super) const POINTS_PER_TASK: usize = 1 << 10;

/// Points between two interrupt checks of single-threaded work: at most a millisecond.
const POINTS_PER_STEP: usize = 1 << 15;

/// Target duration of a block of tasks with unknown cost, and the size of the first block.
const BLOCK_TIME: Duration = Duration::from_millis(20);
const FIRST_BLOCK: usize = 2;

/// Time for which an idle thread polls the active ones before it sleeps. Waking a thread takes as
/// long as a small mesh.
const SPIN_TIME: Duration = Duration::from_micros(50);

/// Calls `work(from, to)` for blocks of `total` points, with a progress report before each.
pub(super) fn for_blocks(
    total: usize,
    observer: &mut dyn Observer,
    mut work: impl FnMut(usize, usize),
) -> Result<()> {
    for_row_blocks(total, 1, observer, &mut work)
}

/// Calls `work(from, to)` for blocks of `rows` rows of `width` points, with a progress report
/// before each.
pub(super) fn for_row_blocks(
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

/// Calls `work(from, to)` for blocks of tasks with unknown cost, with a progress report before
/// each. The block size adapts so that a block takes about [`BLOCK_TIME`].
pub(super) fn for_timed_blocks(
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
    let threads = max_tasks.div_ceil(batch_size).min(rayon::current_num_threads());
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
    rayon::in_place_scope(|scope| {
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

/// Returns a function that checks whether the observer stops the work; for work in small steps.
pub(super) fn interrupt_check(observer: &mut dyn Observer) -> impl FnMut() -> Result<()> {
    move || report(observer, 0, 1)
}

/// Divides `rows` rows of `width` points into ranges between two interrupt checks.
pub(super) fn row_ranges(rows: usize, width: usize) -> impl Iterator<Item = Range<usize>> {
    let step = (POINTS_PER_STEP / width.max(1)).max(1);
    (0..rows).step_by(step).map(move |from| from..rows.min(from + step))
}

/// Collects the results of `part` for each of these ranges, with interrupt checks.
pub(super) fn collect_in_steps<T, I: Iterator<Item = T>>(
    (rows, width): (usize, usize),
    listen: &mut Listen<'_>,
    part: impl Fn(Range<usize>) -> I,
) -> Result<Vec<T>> {
    let mut all = Vec::with_capacity(rows * width);
    for rows in row_ranges(rows, width) {
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
