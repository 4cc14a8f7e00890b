//! What a training has learned, for `neurbs.SelfOrganizingMap`.

use numpy::PyArray3;
use numpy::ndarray::Ix3;
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::{arguments, call};
use crate::som::{Lattice, SelfOrganizingMap, SomOptions, StoppedBy};

/// Train a map; the public method is :meth:`neurbs.SelfOrganizingMap.fit`.
#[pyfunction]
#[pyo3(signature = (
    points, *, grid, gain_scale, radius_scale, max_steps, reach, min_change, seed, progress
))]
#[expect(clippy::too_many_arguments, reason = "one for each of Python's keyword arguments")]
pub(super) fn train(
    points: &Bound<'_, PyAny>,
    grid: &Bound<'_, PyAny>,
    gain_scale: Option<&Bound<'_, PyAny>>,
    radius_scale: Option<&Bound<'_, PyAny>>,
    max_steps: Option<&Bound<'_, PyAny>>,
    reach: Option<&Bound<'_, PyAny>>,
    min_change: Option<&Bound<'_, PyAny>>,
    seed: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<TrainedMap> {
    let (rows, cols) = arguments::pair("grid", grid)?;
    let options = SomOptions {
        seed: arguments::count("seed", seed)?,
        gain_scale: arguments::optional_real("gain_scale", gain_scale)?,
        radius_scale: arguments::optional_real("radius_scale", radius_scale)?,
        max_steps: arguments::optional_count("max_steps", max_steps)?,
        reach: arguments::optional_real("reach", reach)?,
        min_change: arguments::optional_real("min_change", min_change)?,
    };
    let lattice = Lattice::quad(rows, cols)?;
    let numbers = Numbers::points(points, "points")?;
    let slice = numbers.as_slice()?;
    let som = call::run(points.py(), progress, |watcher| {
        SelfOrganizingMap::fit(slice, lattice, &options, watcher)
    })?;
    TrainedMap::new(points.py(), &som)
}

/// A trained map: the lattice's nodes in space, and how the training went.
#[pyclass(frozen, module = "neurbs._core")]
pub(super) struct TrainedMap {
    codebook: Py<PyArray3<f64>>,
    /// Number of presentations made.
    #[pyo3(get)]
    steps: u64,
    /// The step from which on the radius is zero.
    #[pyo3(get)]
    ordered_at: u64,
    stopped_by: StoppedBy,
    /// How many points are on the lattice.
    #[pyo3(get)]
    reached: usize,
    /// Largest move of a node during the last finished epoch, in the points' unit; None if not even
    /// one was finished.
    #[pyo3(get)]
    change: Option<f64>,
}

impl TrainedMap {
    pub(super) fn new(py: Python<'_>, som: &SelfOrganizingMap) -> PyResult<Self> {
        let (rows, cols) = som.lattice.shape();
        let nodes = bytemuck::cast_slice(&som.codebook);
        Ok(Self {
            codebook: arrays::constant::<f64, Ix3>(py, &[rows, cols, 3], nodes)?,
            steps: som.steps,
            ordered_at: som.ordered_at,
            stopped_by: som.stopped_by,
            reached: som.reached,
            change: som.change,
        })
    }
}

#[pymethods]
impl TrainedMap {
    /// The nodes' positions, read-only float64 of shape (rows, cols, 3).
    #[getter]
    fn codebook<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.codebook)
    }

    /// What ended the training: "reached", "settled" or "max_steps".
    #[getter]
    fn stopped_by(&self) -> &'static str {
        self.stopped_by.name()
    }
}
