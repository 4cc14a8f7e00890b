//! Progress reports of long jobs, and observers that may stop them.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::error::{Error, Result};

/// The state of a long job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The current stage.
    pub stage: Stage,
    /// Steps done in this stage.
    pub step: u64,
    /// Largest number of steps of this stage.
    pub total: u64,
    /// Largest move of a lattice node during the last finished epoch, in the points' unit. `None`
    /// before the first epoch has finished and in stages without a lattice.
    pub change: Option<f64>,
    /// In training, the mean distance from points to their nearest nodes during the last finished
    /// epoch. In a fit, the root mean square distance from the surface. In the points' unit; `None`
    /// before it is known.
    pub error: Option<f64>,
    /// Radius of the neighborhood on the lattice, in cells; `None` in stages without a lattice.
    pub radius: Option<f64>,
    /// Number of points that lay on the lattice when they were last presented.
    pub reached: usize,
    /// Number of points.
    pub points: usize,
    /// Estimated share of a whole reconstruction that is done; `None` in other jobs.
    pub share: Option<f64>,
}

impl Progress {
    /// The progress of a stage without a lattice.
    pub(crate) fn of_stage(stage: Stage, step: u64, total: u64, points: usize) -> Self {
        let (change, error, radius, share) = (None, None, None, None);
        Self { stage, step, total, change, error, radius, reached: 0, points, share }
    }
}

/// The lattice at the end of an epoch of training.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Epoch<'a> {
    /// Number of steps: presentations of online training, epochs of batch training.
    pub step: u64,
    /// Mean distance from points to their nearest nodes, each measured when the point was
    /// presented, in the points' unit.
    pub error: f64,
    /// Radius of the neighborhood on the lattice at the last step, in cells.
    pub radius: f64,
    /// Largest move of a node, in the points' unit.
    pub change: f64,
    /// The nodes, row by row, in the points' unit.
    pub lattice: &'a [DVec3],
}

/// A stage of a long job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The points are checked; a step is one point.
    Checking,
    /// Neighbors, duplicates and outliers are found; a step is one point.
    Cleaning,
    /// The lattice is trained on the points; a step is one presentation.
    Training,
    /// Distances from the points to the lattice or surface are measured; a step is one point.
    Measuring,
    /// A surface is fitted to the points; a step is one solution for the control net.
    Fitting,
    /// The surface is evaluated or turned into triangles; a step is one vertex.
    Tessellation,
}

impl Stage {
    /// The stage's name, as Python and reports spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Checking => "checking",
            Self::Cleaning => "cleaning",
            Self::Training => "training",
            Self::Measuring => "measuring",
            Self::Fitting => "fitting",
            Self::Tessellation => "tessellation",
        }
    }
}

/// Observes a long job, and may stop it.
///
/// The job calls it every few milliseconds, always from the thread that started the job. A
/// reconstruction continues during the call. [`ControlFlow::Break`] ends the job with
/// [`Error::Interrupted`]. Any `FnMut(&Progress) -> ControlFlow<()>` is an observer.
pub trait Observer {
    /// Receives the progress, and returns whether to continue.
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()>;

    /// Receives the lattice at the end of an epoch of training, and returns whether to continue.
    fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let _ = epoch;
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&Progress) -> ControlFlow<()>> Observer for F {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        self(progress)
    }
}

/// An observer that ignores all reports and never stops a job.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn observe(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// A callback between parts of longer work: an error stops the work.
pub(crate) type InterruptCheck<'a> = dyn FnMut() -> Result<()> + 'a;

/// A callback that reports to the observer between parts of a stage that has no steps.
pub(crate) fn interrupt_check(
    observer: &mut dyn Observer,
    stage: Stage,
    points: usize,
) -> impl FnMut() -> Result<()> {
    move || report(observer, &Progress::of_stage(stage, 0, points as u64, points))
}

/// Reports progress to the observer. A stop becomes [`Error::Interrupted`].
pub(crate) fn report(observer: &mut dyn Observer, progress: &Progress) -> Result<()> {
    error_if_stopped(observer.observe(progress))
}

/// Reports an epoch to the observer. A stop becomes [`Error::Interrupted`].
pub(crate) fn report_epoch(observer: &mut dyn Observer, epoch: &Epoch<'_>) -> Result<()> {
    error_if_stopped(observer.observe_epoch(epoch))
}

/// [`Error::Interrupted`] for a stop.
fn error_if_stopped(answer: ControlFlow<()>) -> Result<()> {
    match answer {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
