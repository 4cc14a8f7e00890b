//! How long jobs report what they do, and how they are stopped.

use std::ops::ControlFlow;

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
    /// How many points lay on the lattice when they were last presented.
    pub reached: usize,
    /// How many points there are.
    pub points: usize,
}

/// A part of a long job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The lattice learns the points; a step is one presentation.
    Training,
    /// The distances from the points to the lattice are measured; a step is one point.
    Measuring,
    /// The surface is evaluated or turned into triangles; a step is one vertex.
    Tessellation,
}

impl Stage {
    /// The stage's name, as Python and reports spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Measuring => "measuring",
            Self::Tessellation => "tessellation",
        }
    }
}

/// Watches a long job, and may stop it.
///
/// The job calls it every few milliseconds, always from the thread that started the job. To
/// answer [`ControlFlow::Break`] ends the job with [`Error::Interrupted`]. Any
/// `FnMut(&Progress) -> ControlFlow<()>` is an observer.
pub trait Observer {
    /// Takes notice of the progress and says whether to go on.
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()>;
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

/// Reports to the observer and turns its wish to stop into an error.
pub(crate) fn report(observer: &mut dyn Observer, progress: &Progress) -> Result<()> {
    match observer.observe(progress) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}
