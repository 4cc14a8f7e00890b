//! Long calls: without the GIL, with progress reports, Ctrl-C and error conversion.

use std::fs::File;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use super::errors::{bad_argument, defect};
use super::{epoch, progress};
use crate::error::Result;
use crate::progress::{Epoch, Observer, Progress, Stage};

/// Minimum time between two checks for Ctrl-C, and between two calls of the callback.
const MIN_INTERVAL: Duration = Duration::from_millis(40);

/// Runs a job of the core without the GIL.
///
/// The job gets an observer that calls `callback`, if there is one, and checks for Ctrl-C. An
/// exception raised by either ends the job and is passed on to the caller.
pub(super) fn run<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    job: impl FnOnce(&mut Watcher) -> Result<T> + Send,
) -> PyResult<T> {
    run_watched(py, Callbacks { progress: callback, observer: None }, job)
}

/// The callbacks of a long call.
#[derive(Default)]
pub(super) struct Callbacks {
    /// Called from time to time with a `Progress`.
    pub(super) progress: Option<Py<PyAny>>,
    /// Called after each epoch of training, with an `Epoch`.
    pub(super) observer: Option<Py<PyAny>>,
}

/// As [`run`], with a callback for the epochs of a training.
pub(super) fn run_watched<T: Send>(
    py: Python<'_>,
    callbacks: Callbacks,
    job: impl FnOnce(&mut Watcher) -> Result<T> + Send,
) -> PyResult<T> {
    let Callbacks { progress: callback, observer } = callbacks;
    for (name, function) in [("progress", &callback), ("observer", &observer)] {
        if let Some(function) = function.as_ref().map(|function| function.bind(py))
            && !function.is_callable()
        {
            return Err(bad_argument(name, "callable", function));
        }
    }
    let mut watcher =
        Watcher { callback, observer, last_check: Instant::now(), stage: None, raised: None };
    let result = without_gil(py, || job(&mut watcher));
    match watcher.raised {
        Some(raised) => Err(raised),
        None => Ok(result??),
    }
}

/// Runs a job without the GIL. A panic becomes an error.
pub(super) fn without_gil<T: Send>(py: Python<'_>, job: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(job))).map_err(|panic| defect(&*panic))
}

/// The observer of a call from Python: calls the callbacks and checks for Ctrl-C.
pub(super) struct Watcher {
    callback: Option<Py<PyAny>>,
    observer: Option<Py<PyAny>>,
    last_check: Instant,
    /// The stage last reported, so that each stage is reported at least once.
    stage: Option<Stage>,
    raised: Option<PyErr>,
}

impl Watcher {
    /// Takes the GIL, handles signals, then runs `action`.
    fn check_in(&mut self, action: impl FnOnce(Python<'_>) -> PyResult<()>) -> ControlFlow<()> {
        let outcome = Python::attach(|py| py.check_signals().and_then(|()| action(py)));
        self.last_check = Instant::now();
        match outcome {
            Ok(()) => ControlFlow::Continue(()),
            Err(raised) => {
                self.raised = Some(raised);
                ControlFlow::Break(())
            }
        }
    }
}

impl Observer for Watcher {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let is_new = self.stage != Some(progress.stage) || progress.step == progress.total;
        let due = self.last_check.elapsed() >= MIN_INTERVAL || (is_new && self.callback.is_some());
        if !due {
            return ControlFlow::Continue(());
        }
        self.stage = Some(progress.stage);
        let callback = self.callback.take();
        let answer = self.check_in(|py| match &callback {
            Some(callback) => {
                callback.call1(py, (progress::Progress::from(*progress),)).map(|_| ())
            }
            None => Ok(()),
        });
        self.callback = callback;
        answer
    }

    fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let Some(observer) = self.observer.take() else {
            return ControlFlow::Continue(());
        };
        let answer = self
            .check_in(|py| observer.call1(py, (epoch::Epoch::of_core(py, epoch)?,)).map(|_| ()));
        self.observer = Some(observer);
        answer
    }
}

/// A file written by a call from Python, with checks for Ctrl-C.
pub(super) struct WatchedFile<'a> {
    file: File,
    watcher: &'a mut Watcher,
}

impl<'a> WatchedFile<'a> {
    pub(super) fn new(file: File, watcher: &'a mut Watcher) -> Self {
        Self { file, watcher }
    }
}

impl Write for WatchedFile<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let due = self.watcher.last_check.elapsed() >= MIN_INTERVAL;
        if due && self.watcher.check_in(|_| Ok(())).is_break() {
            return Err(io::Error::other("interrupted"));
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
