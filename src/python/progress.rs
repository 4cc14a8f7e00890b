//! `neurbs.Progress`.

use pyo3::prelude::*;

use crate::progress;

/// What a long job is doing at this moment.
///
/// Attributes
/// ----------
/// stage : str
///     The part of the job: ``"training"``, ``"measuring"`` or ``"tessellation"``.
/// step : int
///     Steps done in this stage: presentations, points or vertices.
/// total : int
///     Steps after which this stage ends at the latest.
/// change : float or None
///     Largest move of a lattice node during the last finished epoch, in the points' unit.
/// error : float or None
///     Mean distance from points to their nearest nodes during that epoch, in the points' unit.
/// radius : float or None
///     How far on the lattice the neighbourhood reaches, in cells.
/// reached : int
///     How many points lay on the lattice when they were last presented.
/// points : int
///     How many points there are.
/// share : float or None
///     The share of a whole reconstruction that is done, 0 to 1, as far as can be told; None in
///     other jobs.
#[pyclass(frozen, get_all, module = "neurbs")]
pub(super) struct Progress {
    stage: &'static str,
    step: u64,
    total: u64,
    change: Option<f64>,
    error: Option<f64>,
    radius: Option<f64>,
    reached: usize,
    points: usize,
    share: Option<f64>,
}

impl From<progress::Progress> for Progress {
    fn from(progress: progress::Progress) -> Self {
        let progress::Progress {
            stage,
            step,
            total,
            change,
            error,
            radius,
            reached,
            points,
            share,
        } = progress;
        Self { stage: stage.name(), step, total, change, error, radius, reached, points, share }
    }
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        let Self { stage, step, total, reached, points, .. } = self;
        format!("Progress({stage} {step}/{total}, {reached} of {points} points reached)")
    }
}
