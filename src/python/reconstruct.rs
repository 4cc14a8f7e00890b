//! The whole job, for `neurbs.reconstruct`.

use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::Numbers;
use super::call::Watcher;
use super::errors::bad_argument;
use super::history::Recorder;
use super::mesh::TriangleMesh;
use super::som::Map;
use super::surface::NurbsSurface;
use super::{arguments, call};
use crate::mesh::UniformGrid;
use crate::reconstruct::{Method, ReconstructOptions, Report};

/// Stage, step and error of what was told on the way.
type History = Vec<(&'static str, u64, f64)>;

/// Run the whole job; the public function is :func:`neurbs.reconstruct`.
#[pyfunction]
#[pyo3(signature = (points, *, method, grid, degree, seed, max_steps, reach, min_change, progress))]
#[expect(clippy::too_many_arguments, reason = "one for each of Python's keyword arguments")]
pub(super) fn reconstruct<'py>(
    points: &Bound<'py, PyAny>,
    method: &Bound<'py, PyAny>,
    grid: Option<&Bound<'py, PyAny>>,
    degree: &Bound<'py, PyAny>,
    seed: &Bound<'py, PyAny>,
    max_steps: Option<&Bound<'py, PyAny>>,
    reach: Option<&Bound<'py, PyAny>>,
    min_change: Option<&Bound<'py, PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(NurbsSurface, TriangleMesh, Map, Bound<'py, PyDict>, History)> {
    let py = points.py();
    let options = ReconstructOptions {
        method: named_method(method)?,
        grid: grid.map(|grid| arguments::pair("grid", grid)).transpose()?,
        degree: arguments::count("degree", degree)?,
        seed: arguments::count("seed", seed)?,
        max_steps: arguments::optional_count("max_steps", max_steps)?,
        reach: arguments::optional_real("reach", reach)?,
        min_change: arguments::optional_real("min_change", min_change)?,
    };
    let points = Numbers::points(points, "points")?;
    let points = points.as_slice()?;
    let job = |watcher: &mut Watcher| {
        let mut recorder = Recorder::new(watcher);
        let result = crate::reconstruct::reconstruct(points, &options, &mut recorder)?;
        Ok((result, recorder.into_history()))
    };
    let (result, history) =
        call::run(py, progress.as_ref().map(|callback| callback.clone_ref(py)), job)?;
    let start = Instant::now();
    let grid = UniformGrid::for_surface(&result.surface)?;
    let mesh = TriangleMesh::of_surface(py, &result.surface, grid, progress)?;
    let report = report(py, &result.report, start.elapsed())?;
    let som = Map::of_core(result.som);
    Ok((NurbsSurface::new(py, result.surface)?, mesh, som, report, history))
}

/// The defaults of the options, as the core has them.
#[pyfunction]
pub(super) fn default_options(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let ReconstructOptions { method, grid, degree, seed, max_steps, reach, min_change } =
        ReconstructOptions::default();
    let options = PyDict::new(py);
    options.set_item("method", method.name())?;
    options.set_item("grid", grid)?;
    options.set_item("degree", degree)?;
    options.set_item("seed", seed)?;
    options.set_item("max_steps", max_steps)?;
    options.set_item("reach", reach)?;
    options.set_item("min_change", min_change)?;
    Ok(options)
}

fn named_method(name: &Bound<'_, PyAny>) -> PyResult<Method> {
    let known = [Method::Paper];
    let wanted = name.extract::<String>().unwrap_or_default();
    let found = known.into_iter().find(|method| method.name() == wanted);
    found.ok_or_else(|| bad_argument("method", "'paper'", name))
}

fn report<'py>(
    py: Python<'py>,
    report: &Report,
    tessellation: Duration,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("points", report.points)?;
    dict.set_item("diagonal", report.diagonal)?;
    dict.set_item("grid", report.grid)?;
    dict.set_item("degree", report.degree)?;
    dict.set_item("steps", report.steps)?;
    dict.set_item("ordered_at", report.ordered_at)?;
    dict.set_item("stopped_by", report.stopped_by.name())?;
    dict.set_item("reached", report.reached)?;
    dict.set_item("change", report.change)?;
    dict.set_item("quantization_error", report.quantization_error)?;
    let seconds = PyDict::new(py);
    seconds.set_item("training", report.training_time.as_secs_f64())?;
    seconds.set_item("tessellation", tessellation.as_secs_f64())?;
    dict.set_item("seconds", seconds)?;
    Ok(dict)
}
