//! The whole job, for `neurbs.reconstruct`.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use super::arrays::Numbers;
use super::call::Watcher;
use super::history::Recorder;
use super::som::Map;
use super::surface::NurbsSurface;
use super::{arguments, arrays, call};
use crate::cloud;
use crate::nurbs::OrderedSurface;
use crate::pipeline::{Aspect, Method, PERCENTILES, ReconstructOptions, Report, Start};
use crate::topology::Kind;

/// The kinds of surface that may be asked for; `None` is found out.
const KINDS: [Option<Kind>; 5] =
    [None, Some(Kind::Sheet), Some(Kind::Height), Some(Kind::Tube), Some(Kind::Torus)];

fn kind_name(kind: Option<Kind>) -> &'static str {
    kind.map_or("auto", Kind::name)
}

/// Surface, map, parameters, distances, inliers, report, and of what was told on the way stage, step and
/// error.
type Found<'py> = (
    NurbsSurface,
    Map,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyDict>,
    Vec<(&'static str, u64, f64)>,
);

/// Run the whole job; the public function is :func:`neurbs.reconstruct`, whose options these are.
#[pyfunction]
#[pyo3(signature = (points, options, progress))]
pub(super) fn reconstruct<'py>(
    points: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let py = points.py();
    let option = |name: &str| Ok::<_, PyErr>(options.get_item(name)?.filter(|it| !it.is_none()));
    let needed = |name: &str| options.as_any().get_item(name);
    let real = |name: &str| arguments::optional_real(name, option(name)?.as_ref());
    let truth = |name: &str| arguments::truth(name, &needed(name)?);
    let weights =
        option("weights")?.map(|weights| Numbers::sequence(&weights, "weights")).transpose()?;
    let given = option("init")?.filter(|init| !init.is_instance_of::<PyString>());
    let given = given.map(|nodes| nodes_of(&nodes)).transpose()?;
    let options = ReconstructOptions {
        tolerance: real("tolerance")?,
        method: arguments::choice("method", &Method::ALL, Method::name, &needed("method")?)?,
        surface: named_surface(&needed("surface")?)?,
        grid: option("grid")?.map(|grid| arguments::pair("grid", &grid)).transpose()?,
        degree: arguments::count("degree", &needed("degree")?)?,
        topology: arguments::choice("topology", &KINDS, kind_name, &needed("topology")?)?,
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
        piece: arguments::optional_count("pieces", option("pieces")?.as_ref())?,
        rational: truth("rational")?,
        fairness: real("fairness")?,
        border: real("border")?,
        max_control_points: arguments::count("max_control_points", &needed("max_control_points")?)?,
        aspect: arguments::choice("aspect", &Aspect::ALL, Aspect::name, &needed("aspect")?)?,
        seed: arguments::count("seed", &needed("seed")?)?,
        max_steps: arguments::optional_count("max_steps", option("max_steps")?.as_ref())?,
        reach: real("reach")?,
        min_change: real("min_change")?,
    };
    let points = Numbers::points(points, "points")?;
    let points = points.as_slice()?;
    let job = |watcher: &mut Watcher| {
        let mut recorder = Recorder::new(watcher);
        let result = crate::pipeline::reconstruct(points, &options, &mut recorder)?;
        Ok((result, recorder.into_history()))
    };
    let (result, history) = call::run(py, progress, job)?;
    let report = report(py, &result.report)?;
    let som = Map::of_core(result.som);
    let count = result.distances.len();
    let uv = arrays::moved(py, &[count, 2], result.uv)?;
    let distances = arrays::moved(py, &[count], result.distances)?;
    let inliers = PyArray1::from_vec(py, result.inliers);
    Ok((NurbsSurface::new(py, result.surface)?, som, uv, distances, inliers, report, history))
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
        init,
        weights: _,
        clean,
        robust,
        piece,
        rational,
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
    options.set_item("topology", kind_name(topology))?;
    options.set_item("init", init.name())?;
    options.set_item("weights", py.None())?;
    options.set_item("clean", clean)?;
    options.set_item("robust", robust)?;
    options.set_item("pieces", piece)?;
    options.set_item("rational", rational)?;
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
        cloud::checked_bounds(points, watcher)?;
        kind.through(points.to_vec(), shape, degree)
    };
    NurbsSurface::new(py, call::run(py, progress, make)?)
}

/// The nodes of a lattice, in order.
fn nodes_of<'py>(nodes: &Bound<'py, PyAny>) -> PyResult<Numbers<'py>> {
    let expected = "'auto', 'geodesic', 'pca', or real numbers of shape (rows, cols, 3)";
    Numbers::new(nodes, "init", expected, &[&[None, None, Some(3)]])
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
    dict.set_item("topology", report.topology.name())?;
    dict.set_item("topology_reason", report.topology_reason.as_deref())?;
    dict.set_item("duplicates", report.duplicates)?;
    dict.set_item("inliers", report.inliers)?;
    dict.set_item("outliers", report.outliers)?;
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
