//! Long work in blocks: progress reports and interrupt checks.

use std::ops::Range;
use std::time::{Duration, Instant};

use crate::error::Result;
use crate::progress::{self, InterruptCheck, Observer, Progress, Stage};
use crate::worker_pool;

/// Points between two progress reports: a few milliseconds of work. Synchronizing the threads costs
/// a few microseconds.
const POINTS_PER_REPORT: usize = 1 << 20;

/// Points in the task of a thread: tens of microseconds of work.
pub(super) const POINTS_PER_TASK: usize = 1 << 10;

/// Points between two interrupt checks of single-threaded work: at most a millisecond.
const POINTS_PER_STEP: usize = 1 << 15;

/// Points with unknown cost in the task of a thread at most.
pub(super) const MAX_POINTS_PER_TASK: usize = 64;

/// Target duration of a block of tasks with unknown cost, and the size of the first block.
const BLOCK_TIME: Duration = Duration::from_millis(20);
const FIRST_BLOCK: usize = 2;

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

/// Returns `map` of each of the points, in their order. The points may have different costs; they
/// are mapped in parallel.
pub(crate) fn map_in_blocks<P: Sync, T: Clone + Default + Send>(
    points: &[P],
    observer: &mut dyn Observer,
    map: impl Fn(&P) -> T + Sync,
) -> Result<Vec<T>> {
    let mut mapped = vec![T::default(); points.len()];
    for_timed_blocks(points.len(), observer, |from, to| {
        let tasks = points[from..to].iter().zip(&mut mapped[from..to]);
        let share = (to - from) / (4 * worker_pool::num_threads());
        let share = share.min(MAX_POINTS_PER_TASK);
        worker_pool::for_each_task(tasks, share, |(): &mut (), (point, out)| *out = map(point));
    })?;
    Ok(mapped)
}

/// Returns a function that checks whether the observer stops the work; for work in small steps.
pub(crate) fn interrupt_check(observer: &mut dyn Observer) -> impl FnMut() -> Result<()> {
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
    check_interrupt: &mut InterruptCheck<'_>,
    part: impl Fn(Range<usize>) -> I,
) -> Result<Vec<T>> {
    let mut all = Vec::with_capacity(rows * width);
    for rows in row_ranges(rows, width) {
        check_interrupt()?;
        all.extend(part(rows));
    }
    Ok(all)
}

fn report(observer: &mut dyn Observer, done: usize, total: usize) -> Result<()> {
    let (step, total) = (done as u64, total as u64);
    let stage = Stage::Tessellation;
    progress::report(observer, &Progress::of_stage(stage, step, total, 0))
}
