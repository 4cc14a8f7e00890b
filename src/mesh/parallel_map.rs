//! Work on many blocks in parallel, with reports in between.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::error::Result;
use crate::nurbs::share;
use crate::progress::{self, Observer, Progress, Stage};

/// Time between two calls of the observer that is aimed at.
const REPORT: Duration = Duration::from_millis(20);

/// Triangles for which no other thread is woken: they would be done before that has come.
pub(super) const FEW: usize = 128;

/// Pieces whose vertices are collected in the time in which one triangle is found.
pub(super) const COLLECTED: usize = 8;

/// Does a job for each item, in parallel, and takes the results in order; reports in between. All
/// together belong to about so many triangles.
///
/// Threads meet after a certain time, not after a certain number of items, because nobody knows
/// how long one takes. So jobs must not see what has been taken since the call.
pub(super) fn in_groups<I: Send, T: Send, R: Default>(
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
        let early = || if started.elapsed() < REPORT { items.next() } else { None };
        let group = std::iter::from_fn(early).take(left);
        let work = |room: &mut R, (index, item)| {
            let result = job(room, item);
            results.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        };
        // What was wrongly expected to be little is shared after a while.
        if triangles > FEW || left < total {
            share(group, 1, work);
        } else {
            let mut room = R::default();
            group.for_each(|item| work(&mut room, item));
        }
        let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
        results.sort_unstable_by_key(|&(index, _)| index);
        results.into_iter().try_for_each(|(_, result)| take(result))?;
    }
}
