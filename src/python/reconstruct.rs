//! The functions behind `neurbs.reconstruct` and `neurbs.reconstruct_paper`.

use glam::DVec3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use super::arrays::Numbers;
use super::call::Watcher;
use super::error_history::Recorder;
use super::errors::bad_argument;
use super::kind::{kind_name, named_kind};
use super::shell::Shell;
use super::som::Map;
use super::surface::NurbsSurface;
use super::{arguments, arrays, call, diagnostics, som_options};
use crate::error::Result;
use crate::nurbs::OrderedSurface;
use crate::pipeline::{
    Aspect, PERCENTILES, PaperOptions, ReconstructOptions, Reconstruction, Report, Start,
    TrimReport, Trimming,
};
use crate::progress::Observer;

/// Surface, shell, map, parameters, deviations, inliers, report and error history (stage, step, error).
type Found<'py> = (
    NurbsSurface,
    Shell,
    Map,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyDict>,
    Vec<(&'static str, u64, f64)>,
);

/// Reconstruct a surface; the public function is :func:`neurbs.reconstruct`.
#[pyfunction]
#[pyo3(signature = (points, options, progress))]
pub(super) fn reconstruct<'py>(
    points: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let py = points.py();
    with_options(options, |options| {
        let points = Numbers::points(points, "points")?;
        let points = points.as_slice()?;
        run(py, progress, |observer| crate::pipeline::reconstruct(points, options, observer))
    })
}

/// Check the options of `reconstruct` before there are points; `weights` must be None.
#[pyfunction]
pub(super) fn check_options(options: &Bound<'_, PyDict>) -> PyResult<()> {
    with_options(options, |options| Ok(options.check(0)?))
}

/// Calls a function with options that have their names.
fn with_options<R>(
    options: &Bound<'_, PyDict>,
    call: impl FnOnce(&ReconstructOptions<'_>) -> PyResult<R>,
) -> PyResult<R> {
    let option = |name: &str| Ok::<_, PyErr>(options.get_item(name)?.filter(|it| !it.is_none()));
    let needed = |name: &str| options.as_any().get_item(name);
    let real = |name: &str| arguments::optional_real(name, option(name)?.as_ref());
    let truth = |name: &str| arguments::truth(name, &needed(name)?);
    let weights =
        option("weights")?.map(|weights| Numbers::sequence(&weights, "weights")).transpose()?;
    let given = option("init")?.filter(|init| !init.is_instance_of::<PyString>());
    let given = given.map(|nodes| nodes_of(&nodes)).transpose()?;
    call(&ReconstructOptions {
        tolerance: real("tolerance")?,
        grid: option("grid")?.map(|grid| arguments::pair("grid", &grid)).transpose()?,
        degree: arguments::count("degree", &needed("degree")?)?,
        kind: named_kind(&needed("kind")?)?,
        init: match &given {
            Some(nodes) => {
                let shape = (nodes.shape()[0], nodes.shape()[1]);
                Start::Given { nodes: nodes.as_slice()?, shape }
            }
            None => arguments::choice("init", &Start::NAMED, Start::name, &needed("init")?)?,
        },
        weights: weights.as_ref().map(Numbers::as_slice).transpose()?,
        clean: truth("clean")?,
        robust: truth("robust")?,
        component: arguments::optional_count("component", option("component")?.as_ref())?,
        axis_scale: option("axis_scale")?.map(|scale| axis_scale(&scale)).transpose()?,
        rational: truth("rational")?,
        fairness: real("fairness")?,
        border: real("border")?,
        trim: trimming(&needed("trim")?)?,
        max_control_points: arguments::count("max_control_points", &needed("max_control_points")?)?,
        aspect: arguments::choice("aspect", &Aspect::ALL, Aspect::name, &needed("aspect")?)?,
        seed: arguments::count("seed", &needed("seed")?)?,
    })
}

/// Run the paper's method; the public function is :func:`neurbs.reconstruct_paper`.
#[pyfunction]
#[pyo3(signature = (points, options, progress))]
pub(super) fn reconstruct_paper<'py>(
    points: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let option = |name: &str| Ok::<_, PyErr>(options.get_item(name)?.filter(|it| !it.is_none()));
    let needed = |name: &str| options.as_any().get_item(name);
    let real = |name: &str| arguments::optional_real(name, option(name)?.as_ref());
    let options = PaperOptions {
        grid: option("grid")?.map(|grid| arguments::pair("grid", &grid)).transpose()?,
        degree: arguments::count("degree", &needed("degree")?)?,
        surface: arguments::choice(
            "surface",
            &OrderedSurface::ALL,
            OrderedSurface::name,
            &needed("surface")?,
        )?,
        max_steps: arguments::optional_count("max_steps", option("max_steps")?.as_ref())?,
        reach: real("reach")?,
        min_change: real("min_change")?,
        seed: arguments::count("seed", &needed("seed")?)?,
    };
    let py = points.py();
    let points = Numbers::points(points, "points")?;
    let points = points.as_slice()?;
    run(py, progress, |observer| crate::pipeline::reconstruct_paper(points, &options, observer))
}

/// Runs a reconstruction and converts its result.
fn run(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    job: impl FnOnce(&mut dyn Observer) -> Result<Reconstruction> + Send,
) -> PyResult<Found<'_>> {
    let (result, history) = call::run(py, progress, |watcher: &mut Watcher| {
        let mut recorder = Recorder::new(watcher);
        let result = job(&mut recorder)?;
        Ok((result, recorder.into_history()))
    })?;
    let report = report(py, &result.report)?;
    report.set_item("som", som_options::settings(py, &result.som.lattice, &result.som_options)?)?;
    let som = Map::of_core(result.som);
    let count = result.deviations.len();
    let uv = arrays::moved(py, &[count, 2], result.uv)?;
    let deviations = arrays::moved(py, &[count], result.deviations)?;
    let inliers = PyArray1::from_vec(py, result.inliers);
    let surface = NurbsSurface::new(py, result.surface)?;
    Ok((surface, result.shell.into(), som, uv, deviations, inliers, report, history))
}

/// The default options of `reconstruct`.
#[pyfunction]
pub(super) fn default_options(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let ReconstructOptions {
        tolerance,
        grid,
        degree,
        kind,
        init,
        weights: _,
        clean,
        robust,
        component,
        axis_scale: _,
        rational,
        fairness,
        border,
        trim: _,
        max_control_points,
        aspect,
        seed,
    } = ReconstructOptions::default();
    let options = PyDict::new(py);
    options.set_item("tolerance", tolerance)?;
    options.set_item("grid", grid)?;
    options.set_item("degree", degree)?;
    options.set_item("kind", kind_name(kind))?;
    options.set_item("init", init.name())?;
    options.set_item("weights", py.None())?;
    options.set_item("clean", clean)?;
    options.set_item("robust", robust)?;
    options.set_item("component", component)?;
    options.set_item("axis_scale", py.None())?;
    options.set_item("rational", rational)?;
    options.set_item("fairness", fairness)?;
    options.set_item("border", border)?;
    options.set_item("trim", Trimming::Auto.name())?;
    options.set_item("max_control_points", max_control_points)?;
    options.set_item("aspect", aspect.name())?;
    options.set_item("seed", seed)?;
    Ok(options)
}

/// Given node positions in grid order.
fn nodes_of<'py>(nodes: &Bound<'py, PyAny>) -> PyResult<Numbers<'py>> {
    let expected = "'auto', 'geodesic', 'pca', or real numbers of shape (rows, cols, 3)";
    Numbers::new(nodes, "init", expected, &[&[None, None, Some(3)]])
}

fn axis_scale(scale: &Bound<'_, PyAny>) -> PyResult<DVec3> {
    let numbers = Numbers::new(scale, "axis_scale", "three positive numbers", &[&[Some(3)]])?;
    Ok(numbers.as_slice::<DVec3>()?[0])
}

/// Whether faces are trimmed: "auto", "outer", or a truth value.
pub(super) fn trimming(value: &Bound<'_, PyAny>) -> PyResult<Trimming> {
    let named = [Trimming::Auto, Trimming::Outer];
    if let Ok(name) = value.cast::<PyString>()
        && let Some(found) = named.into_iter().find(|one| name == one.name())
    {
        return Ok(found);
    }
    match value.extract::<bool>() {
        Ok(true) => Ok(Trimming::Yes),
        Ok(false) => Ok(Trimming::No),
        Err(_) => Err(bad_argument("trim", "'auto', True, 'outer' or False", value)),
    }
}

/// The keyword arguments of `neurbs.TrimReport`.
pub(super) fn trim_report<'py>(
    py: Python<'py>,
    report: &TrimReport,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("area", report.area)?;
    dict.set_item("surface_area", report.surface_area)?;
    dict.set_item("holes", PyTuple::new(py, &report.holes)?)?;
    dict.set_item("outside", report.outside)?;
    dict.set_item("beyond", report.beyond)?;
    dict.set_item("beyond_untrimmed", report.beyond_untrimmed)?;
    Ok(dict)
}

fn report<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("points", report.points)?;
    dict.set_item("diagonal", report.diagonal)?;
    dict.set_item("grid", report.grid)?;
    dict.set_item("degree", report.degree)?;
    dict.set_item("rms", report.deviations.rms)?;
    dict.set_item("max", report.deviations.max)?;
    let percentiles = PyDict::new(py);
    for (percent, distance) in PERCENTILES.iter().zip(report.deviations.percentiles) {
        percentiles.set_item(percent, distance)?;
    }
    dict.set_item("percentiles", percentiles)?;
    dict.set_item("tolerance", report.tolerance)?;
    dict.set_item("within", report.within)?;
    dict.set_item("ended_by", report.ended_by.name())?;
    dict.set_item("fairness", report.fairness)?;
    dict.set_item("iterations", report.iterations)?;
    dict.set_item("kind", report.kind.name())?;
    dict.set_item("direction", report.direction.map(<(f64, f64, f64)>::from))?;
    dict.set_item("axis_scale", <(f64, f64, f64)>::from(report.axis_scale))?;
    dict.set_item("valid", report.valid)?;
    dict.set_item("converged", report.converged)?;
    dict.set_item("candidates", diagnostics::ranking(py, &report.candidates)?)?;
    dict.set_item("diagnostics", diagnostics::findings(py, &report.diagnostics)?)?;
    dict.set_item("duplicates", report.duplicates)?;
    dict.set_item("inliers", report.inliers)?;
    dict.set_item("outliers", report.outliers)?;
    let trim = report.trim.as_ref().map(|trim| trim_report(py, trim)).transpose()?;
    dict.set_item("trim", trim)?;
    let training = &report.training;
    dict.set_item("steps", training.steps)?;
    dict.set_item("ordered_at", training.ordered_at)?;
    dict.set_item("stopped_by", training.stopped_by.name())?;
    dict.set_item("reached", training.reached)?;
    dict.set_item("change", training.change)?;
    dict.set_item("quantization_error", training.quantization_error)?;
    let seconds = PyDict::new(py);
    for (stage, time) in &report.seconds {
        seconds.set_item(stage, time)?;
    }
    dict.set_item("seconds", seconds)?;
    Ok(dict)
}
