//! The whole job, for `neurbs.reconstruct`.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arrays::Numbers;
use super::call::Watcher;
use super::history::Recorder;
use super::som::Map;
use super::surface::NurbsSurface;
use super::{arguments, arrays, call};
use crate::nurbs::OrderedSurface;
use crate::point_cloud;
use crate::reconstruct::{Aspect, Method, PERCENTILES, ReconstructOptions, Report};
use crate::som::Topology;

/// Surface, map, parameters, distances, report, and of what was told on the way stage, step and
/// error.
type Found<'py> = (
    NurbsSurface,
    Map,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyDict>,
    Vec<(&'static str, u64, f64)>,
);

/// Run the whole job; the public function is :func:`neurbs.reconstruct`.
#[pyfunction]
#[pyo3(signature = (
    points, tolerance, *, method, surface, grid, degree, topology, fairness, border, max_control_points, aspect,
    seed, max_steps, reach, min_change, progress
))]
#[expect(clippy::too_many_arguments, reason = "one for each of Python's keyword arguments")]
pub(super) fn reconstruct<'py>(
    points: &Bound<'py, PyAny>,
    tolerance: Option<&Bound<'py, PyAny>>,
    method: &Bound<'py, PyAny>,
    surface: &Bound<'py, PyAny>,
    grid: Option<&Bound<'py, PyAny>>,
    degree: &Bound<'py, PyAny>,
    topology: &Bound<'py, PyAny>,
    fairness: Option<&Bound<'py, PyAny>>,
    border: Option<&Bound<'py, PyAny>>,
    max_control_points: &Bound<'py, PyAny>,
    aspect: &Bound<'py, PyAny>,
    seed: &Bound<'py, PyAny>,
    max_steps: Option<&Bound<'py, PyAny>>,
    reach: Option<&Bound<'py, PyAny>>,
    min_change: Option<&Bound<'py, PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let py = points.py();
    let options = ReconstructOptions {
        tolerance: arguments::optional_real("tolerance", tolerance)?,
        method: arguments::choice("method", &Method::ALL, Method::name, method)?,
        surface: named_surface(surface)?,
        grid: grid.map(|grid| arguments::pair("grid", grid)).transpose()?,
        degree: arguments::count("degree", degree)?,
        topology: arguments::choice("topology", &Topology::ALL, Topology::name, topology)?,
        fairness: arguments::optional_real("fairness", fairness)?,
        border: arguments::optional_real("border", border)?,
        max_control_points: arguments::count("max_control_points", max_control_points)?,
        aspect: arguments::choice("aspect", &Aspect::ALL, Aspect::name, aspect)?,
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
    let report = report(py, &result.report)?;
    let som = Map::of_core(result.som);
    let count = result.distances.len();
    let uv = arrays::empty(py, &[count, 2])?;
    arrays::writable(&uv)?.as_slice_mut()?.copy_from_slice(bytemuck::cast_slice(&result.uv));
    let distances = arrays::empty(py, &[count])?;
    arrays::writable(&distances)?.as_slice_mut()?.copy_from_slice(&result.distances);
    Ok((NurbsSurface::new(py, result.surface)?, som, uv, distances, report, history))
}

/// The defaults of the options, as the core has them.
#[pyfunction]
pub(super) fn default_options(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let ReconstructOptions {
        tolerance,
        method,
        surface,
        grid,
        degree,
        topology,
        fairness,
        border,
        max_control_points,
        aspect,
        seed,
        max_steps,
        reach,
        min_change,
    } = ReconstructOptions::default();
    let options = PyDict::new(py);
    options.set_item("tolerance", tolerance)?;
    options.set_item("method", method.name())?;
    options.set_item("surface", surface.name())?;
    options.set_item("grid", grid)?;
    options.set_item("degree", degree)?;
    options.set_item("topology", topology.name())?;
    options.set_item("fairness", fairness)?;
    options.set_item("border", border)?;
    options.set_item("max_control_points", max_control_points)?;
    options.set_item("aspect", aspect.name())?;
    options.set_item("seed", seed)?;
    options.set_item("max_steps", max_steps)?;
    options.set_item("reach", reach)?;
    options.set_item("min_change", min_change)?;
    Ok(options)
}

/// The surface of ordered points, as the last stage of the paper's method makes it.
#[pyfunction]
pub(super) fn ordered_surface(
    grid: &Bound<'_, PyAny>,
    surface: &Bound<'_, PyAny>,
    degree: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NurbsSurface> {
    let py = grid.py();
    let (kind, degree) = (named_surface(surface)?, arguments::count("degree", degree)?);
    let numbers = Numbers::new(
        grid,
        "points",
        "real numbers of shape (n, 3), (n, 2) or, in order, (r, c, 3)",
        &[&[None, None, Some(3)]],
    )?;
    let (shape, points) = ((numbers.shape()[0], numbers.shape()[1]), numbers.as_slice()?);
    let make = |watcher: &mut Watcher| {
        kind.check_shape(shape)?;
        point_cloud::checked_bounds(points, watcher)?;
        kind.through(points.to_vec(), shape, degree)
    };
    NurbsSurface::new(py, call::run(py, progress, make)?)
}

fn named_surface(name: &Bound<'_, PyAny>) -> PyResult<OrderedSurface> {
    arguments::choice("surface", &OrderedSurface::ALL, OrderedSurface::name, name)
}

fn report<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("points", report.points)?;
    dict.set_item("diagonal", report.diagonal)?;
    dict.set_item("grid", report.grid)?;
    dict.set_item("degree", report.degree)?;
    dict.set_item("rms", report.distances.rms)?;
    dict.set_item("max", report.distances.max)?;
    let percentiles = PyDict::new(py);
    for (percent, distance) in PERCENTILES.iter().zip(report.distances.percentiles) {
        percentiles.set_item(percent, distance)?;
    }
    dict.set_item("percentiles", percentiles)?;
    dict.set_item("tolerance", report.tolerance)?;
    dict.set_item("within", report.within)?;
    dict.set_item("ended_by", report.ended_by.name())?;
    dict.set_item("fairness", report.fairness)?;
    dict.set_item("iterations", report.iterations)?;
    dict.set_item("warnings", PyTuple::new(py, &report.warnings)?)?;
    let training = &report.training;
    dict.set_item("steps", training.steps)?;
    dict.set_item("ordered_at", training.ordered_at)?;
    dict.set_item("stopped_by", training.stopped_by.name())?;
    dict.set_item("reached", training.reached)?;
    dict.set_item("change", training.change)?;
    dict.set_item("quantization_error", training.quantization_error)?;
    let seconds = PyDict::new(py);
    for (stage, time) in &report.times {
        seconds.set_item(stage, time.as_secs_f64())?;
    }
    dict.set_item("seconds", seconds)?;
    Ok(dict)
}
