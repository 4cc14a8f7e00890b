//! The class `neurbs.Progress`.

use pyo3::prelude::*;

use super::pickling::{Reduced, reduced};
use crate::progress;

/// The current state of a long job.
///
/// Attributes
/// ----------
/// stage : str
///     The stage of the job: ``"checking"``, ``"cleaning"``, ``"training"``, ``"measuring"``,
///     ``"fitting"`` or ``"tessellation"``.
/// step : int
///     Steps done in this stage: presentations, points or vertices.
/// total : int
///     Largest number of steps of this stage.
/// change : float or None
///     Largest move of a node in the last finished epoch, in the points' unit.
/// error : float or None
///     Mean distance from points to their nearest nodes in that epoch, in the points' unit.
/// radius : float or None
///     Radius of the neighborhood, in cells.
/// reached : int
///     Number of points on the lattice at their last presentation.
/// points : int
///     Number of points.
/// share : float or None
///     Estimated share of a whole reconstruction that is done, from 0 to 1; None in other jobs.
#[pyclass(frozen, get_all, module = "neurbs")]
pub(super) struct Progress {
    stage: String,
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
        let stage = stage.name().to_owned();
        Self { stage, step, total, change, error, radius, reached, points, share }
    }
}

#[pymethods]
impl Progress {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    #[expect(clippy::too_many_arguments, reason = "one for each attribute")]
    fn of_parts(
        stage: String,
        step: u64,
        total: u64,
        change: Option<f64>,
        error: Option<f64>,
        radius: Option<f64>,
        reached: usize,
        points: usize,
        share: Option<f64>,
    ) -> Self {
        Self { stage, step, total, change, error, radius, reached, points, share }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(
            slf,
            &["stage", "step", "total", "change", "error", "radius", "reached", "points", "share"],
        )
    }

    fn __repr__(&self) -> String {
        let Self { stage, step, total, reached, points, .. } = self;
        format!("Progress({stage} {step}/{total}, {reached} of {points} points reached)")
    }
}
