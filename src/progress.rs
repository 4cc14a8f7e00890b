//! How long jobs report what they do, and how they are stopped.

use std::ops::ControlFlow;

use glam::DVec3;

use crate::error::{Error, Result};

/// What a long job is doing at this moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The part of the job.
    pub stage: Stage,
    /// Steps done in this stage.
    pub step: u64,
    /// Steps after which this stage ends at the latest.
    pub total: u64,
    /// Largest move of a lattice node during the last finished epoch, in the points' unit;
    /// `None` before the first has finished and in stages without a lattice.
    pub change: Option<f64>,
    /// Mean distance from points to their nearest nodes during the last finished epoch, or while a
    /// surface is fitted the root of their mean squared distance from it, in the points' unit;
    /// `None` before there is one.
    pub error: Option<f64>,
    /// How far on the lattice the neighbourhood reaches, in cells; `None` in stages without one.
    pub radius: Option<f64>,
    /// How many points lay on the lattice when they were last presented.
    pub reached: usize,
    /// How many points there are.
    pub points: usize,
    /// The share of a whole reconstruction that is done, as far as can be told; `None` in other jobs.
    pub share: Option<f64>,
}

impl Progress {
    /// Of a stage in which no lattice changes.
    pub(crate) fn of_stage(stage: Stage, step: u64, total: u64, points: usize) -> Self {
        let (change, error, radius, share) = (None, None, None, None);
        Self { stage, step, total, change, error, radius, reached: 0, points, share }
    }
}

/// What an epoch of training has made of the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Epoch<'a> {
    /// Steps made: presentations of online training, epochs of batch training.
    pub step: u64,
    /// Mean distance from points to their nearest nodes, each measured when the point was looked
    /// at, in the points' unit.
    pub error: f64,
    /// How far on the lattice the neighbourhood reached at the last step, in cells.
    pub radius: f64,
    /// Largest move of a node, in the points' unit.
    pub change: f64,
    /// The nodes, row by row, in the points' unit.
    pub lattice: &'a [DVec3],
}

/// A part of a long job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The points are looked through for what cannot be a surface; a step is one point.
    Checking,
    /// Neighbours are found, duplicates and outliers set aside; a step is one point.
    Cleaning,
    /// The lattice learns the points; a step is one presentation.
    Training,
    /// The distances from the points to the lattice are measured; a step is one point.
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

/// Watches a long job, and may stop it.
///
/// The job calls it every few milliseconds, always from the thread that started the job; a
/// reconstruction goes on meanwhile. To answer [`ControlFlow::Break`] ends the job with
/// [`Error::Interrupted`]. Any `FnMut(&Progress) -> ControlFlow<()>` is an observer.
pub trait Observer {
    /// Takes notice of the progress and says whether to go on.
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()>;

    /// Sees the lattice at the end of an epoch of training, and says whether to go on.
    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let _ = epoch;
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&Progress) -> ControlFlow<()>> Observer for F {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        self(progress)
    }
}

/// The observer for those who do not want to watch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn observe(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// What longer work calls between its pieces, to hear whether to go on.
pub(crate) type Listen<'a> = dyn FnMut() -> Result<()> + 'a;

/// Listens to the observer between the pieces of a stage's preparations.
pub(crate) fn listener(
    observer: &mut dyn Observer,
    stage: Stage,
    points: usize,
) -> impl FnMut() -> Result<()> {
    move || report(observer, &Progress::of_stage(stage, 0, points as u64, points))
}

/// Reports to the observer and turns its wish to stop into an error.
pub(crate) fn report(observer: &mut dyn Observer, progress: &Progress) -> Result<()> {
    result(observer.observe(progress))
}

/// Shows the observer an epoch and turns its wish to stop into an error.
pub(crate) fn show(observer: &mut dyn Observer, epoch: &Epoch<'_>) -> Result<()> {
    result(observer.learned(epoch))
}

fn result(answer: ControlFlow<()>) -> Result<()> {
    match answer {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
