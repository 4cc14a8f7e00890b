//! The number of threads.

use pyo3::prelude::*;

use super::errors::bad_argument;
use crate::worker_pool;

/// Return the number of threads for parallel work.
///
/// It is that of `set_num_threads`, of the environment variable ``NEURBS_NUM_THREADS``, of
/// ``RAYON_NUM_THREADS``, or of the processors, whichever exists first; at most 256.
///
/// Returns
/// -------
/// int
///
/// See Also
/// --------
/// set_num_threads : Change it.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> 1 <= neurbs.num_threads() <= 256
/// True
#[pyfunction]
pub(super) fn num_threads() -> usize {
    worker_pool::num_threads()
}

/// Set the number of threads for the calls that follow, in all Python threads.
///
/// Results do not depend on it.
///
/// Parameters
/// ----------
/// threads : int
///     From 1 to 256.
///
/// Raises
/// ------
/// NeurbsError
///     If it is out of range.
///
/// See Also
/// --------
/// num_threads : The present number.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> before = neurbs.num_threads()
/// >>> neurbs.set_num_threads(1)
/// >>> neurbs.num_threads()
/// 1
/// >>> neurbs.set_num_threads(before)
#[pyfunction]
pub(super) fn set_num_threads(threads: &Bound<'_, PyAny>) -> PyResult<()> {
    let number = threads.extract().ok().filter(|n| (1..=worker_pool::MAX_THREADS).contains(n));
    let Some(number) = number else {
        let must = format!("an integer from 1 to {}", worker_pool::MAX_THREADS);
        return Err(bad_argument("threads", &must, threads));
    };
    worker_pool::set_num_threads(number);
    Ok(())
}
