//! A parallel map with results in order and regular progress reports.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::error::Result;
use crate::progress::{self, Observer, Progress, Stage};
use crate::worker_pool::for_each_task;

/// Target time between two calls of the observer.
const REPORT_INTERVAL: Duration = Duration::from_millis(20);

/// Triangles from which work is parallel: less is done before another thread has started.
pub(super) const MIN_PARALLEL_TRIANGLES: usize = 128;

/// Cells whose vertices are collected in the time that one triangle takes.
pub(super) const CELLS_COLLECTED_PER_TRIANGLE: usize = 8;

/// Runs `job` on each item in parallel; passes the results to `take` in order of the items.
///
/// `triangles` is the estimated number of triangles of all items; few are processed by one thread.
/// Threads synchronize after a fixed time, not after a fixed number of items, because the time of
/// an item is unknown. So `job` must not depend on results that `take` has received since the call.
pub(super) fn parallel_map<I: Send, T: Send, R: Default>(
    items: impl IntoIterator<Item = I, IntoIter: ExactSizeIterator + Send>,
    triangles: usize,
    observer: &mut dyn Observer,
    job: impl Fn(&mut R, I) -> T + Sync,
    mut take: impl FnMut(T) -> Result<()>,
) -> Result<()> {
    let mut items = items.into_iter().enumerate();
    let total = items.len();
    if total == 0 {
        return Ok(());
    }
    loop {
        let left = items.len();
        let at = Progress::of_stage(Stage::Tessellation, (total - left) as u64, total as u64, 0);
        progress::report(observer, &at)?;
        if left == 0 {
            return Ok(());
        }
        let started = Instant::now();
        let results = Mutex::new(vec![]);
        let in_time = || if started.elapsed() < REPORT_INTERVAL { items.next() } else { None };
        let group = std::iter::from_fn(in_time).take(left);
        let work = |scratch: &mut R, (index, item)| {
            let result = job(scratch, item);
            results.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        };
        // Parallel as well if a small estimate proves wrong: items are left after the first round.
        if triangles > MIN_PARALLEL_TRIANGLES || left < total {
            for_each_task(group, 1, work);
        } else {
            let mut scratch = R::default();
            group.for_each(|item| work(&mut scratch, item));
        }
        let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
        results.sort_unstable_by_key(|&(index, _)| index);
        results.into_iter().try_for_each(|(_, result)| take(result))?;
    }
}
