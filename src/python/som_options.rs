//! Python's keyword arguments as training options, and back.

use numpy::ndarray::Ix3;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::arrays::{self, Numbers};
use super::errors::bad_argument;
use crate::som::{
    Cells, Init, Kernel, Lattice, Neighborhood, Presentation, Schedule, SomOptions, Training,
};

/// Number of samples of a callable schedule. Linear interpolation between them differs from a
/// smooth curve by less than a millionth of its range.
const SAMPLES: u32 = 4097;

/// The options from a dict that has an entry for each of them.
pub(super) fn options(values: &Bound<'_, PyDict>) -> PyResult<SomOptions> {
    let entry = |name: &str| -> PyResult<Bound<'_, PyAny>> {
        values.get_item(name)?.ok_or_else(|| pyo3::exceptions::PyKeyError::new_err(name.to_owned()))
    };
    let given = |name: &str| Ok::<_, PyErr>(Some(entry(name)?).filter(|value| !value.is_none()));
    let count = |name| arguments::optional_count(name, given(name)?.as_ref());
    let real = |name| arguments::optional_real(name, given(name)?.as_ref());
    let kernel =
        |name: &Bound<'_, PyAny>| arguments::choice("kernel", &Kernel::ALL, Kernel::name, name);
    Ok(SomOptions {
        training: arguments::choice(
            "training",
            &Training::ALL,
            Training::name,
            &entry("training")?,
        )?,
        init: init(&entry("init")?)?,
        neighborhood: arguments::choice(
            "neighborhood",
            &Neighborhood::ALL,
            Neighborhood::name,
            &entry("neighborhood")?,
        )?,
        kernel: given("kernel")?.as_ref().map(kernel).transpose()?,
        presentation: arguments::choice(
            "presentation",
            &Presentation::ALL,
            Presentation::name,
            &entry("presentation")?,
        )?,
        gain: given("gain")?.map(|value| schedule("gain", &value)).transpose()?,
        radius: given("radius")?.map(|value| schedule("radius", &value)).transpose()?,
        epochs: count("epochs")?,
        max_steps: count("max_steps")?,
        reach: real("reach")?,
        min_change: real("min_change")?,
        seed: arguments::count("seed", &entry("seed")?)?,
    })
}

/// The default options, or those of the paper.
#[pyfunction]
pub(super) fn som_options(py: Python<'_>, paper: bool) -> PyResult<Bound<'_, PyDict>> {
    let options = if paper { SomOptions::paper() } else { SomOptions::default() };
    dict(py, &options)
}

/// The parameters of `neurbs.SelfOrganizingMap` for a lattice and options.
pub(super) fn settings<'py>(
    py: Python<'py>,
    lattice: &Lattice,
    options: &SomOptions,
) -> PyResult<Bound<'py, PyDict>> {
    let (dict, (rows, cols)) = (dict(py, options)?, lattice.shape());
    dict.set_item("rows", rows)?;
    dict.set_item("cols", cols)?;
    dict.set_item("topology", lattice.topology().name())?;
    dict.set_item("lattice", lattice.cells().map(Cells::name))?;
    if let Init::Given(nodes) = &options.init {
        let nodes: &[f64] = bytemuck::cast_slice(nodes);
        dict.set_item("init", arrays::constant::<f64, Ix3>(py, &[rows, cols, 3], nodes)?)?;
    }
    Ok(dict)
}

/// The options as keyword arguments; given start positions by their name only.
fn dict<'py>(py: Python<'py>, options: &SomOptions) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("training", options.training.name())?;
    dict.set_item("init", options.init.name())?;
    dict.set_item("neighborhood", options.neighborhood.name())?;
    dict.set_item("kernel", options.kernel.map(Kernel::name))?;
    dict.set_item("presentation", options.presentation.name())?;
    for (name, schedule) in [("gain", &options.gain), ("radius", &options.radius)] {
        let given = schedule.as_ref().map(|schedule| given(py, schedule)).transpose()?;
        dict.set_item(name, given)?;
    }
    dict.set_item("epochs", options.epochs)?;
    dict.set_item("max_steps", options.max_steps)?;
    dict.set_item("reach", options.reach)?;
    dict.set_item("min_change", options.min_change)?;
    dict.set_item("seed", options.seed)?;
    Ok(dict)
}

/// A schedule as Python gives it.
fn given<'py>(py: Python<'py>, schedule: &Schedule) -> PyResult<Bound<'py, PyAny>> {
    match schedule {
        Schedule::Gaussian { start, scale } => ("gaussian", *start, *scale).into_bound_py_any(py),
        Schedule::Linear { start, end } => ("linear", *start, *end).into_bound_py_any(py),
        Schedule::Exponential { start, end } => ("exponential", *start, *end).into_bound_py_any(py),
        Schedule::Constant(value) => value.into_bound_py_any(py),
        Schedule::Table(values) => ("table", values.clone()).into_bound_py_any(py),
    }
}

fn init(value: &Bound<'_, PyAny>) -> PyResult<Init> {
    if let Ok(name) = value.extract::<String>() {
        let found = Init::NAMED.into_iter().find(|init| init.name() == name);
        let names: Vec<String> =
            Init::NAMED.iter().map(|init| format!("'{}'", init.name())).collect();
        let must = format!("{} or an array of positions", names.join(", "));
        return found.ok_or_else(|| bad_argument("init", &must, value));
    }
    let expected = "a name or real numbers of shape (rows, cols, 3) or (nodes, 3)";
    let shapes: [&[Option<usize>]; 2] = [&[None, None, Some(3)], &[None, Some(3)]];
    let numbers = Numbers::new(value, "init", expected, &shapes)?;
    Ok(Init::Given(numbers.as_slice()?.to_vec()))
}

/// A schedule from a number, a tuple such as `("linear", start, end)`, or a callable of the share
/// of the training that is done.
fn schedule(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Schedule> {
    let must = "a number, ('gaussian', start, scale), ('linear', start, end), \
                ('exponential', start, end), ('table', values) or a callable";
    if value.is_callable() {
        let at = |index: u32| -> PyResult<f64> {
            let share = f64::from(index) / f64::from(SAMPLES - 1);
            let answer = value.call1((share,))?;
            arguments::real(name, &answer)
                .map_err(|_| bad_argument(name, "a callable that returns numbers", &answer))
        };
        return Ok(Schedule::Table((0..SAMPLES).map(at).collect::<PyResult<_>>()?));
    }
    if let Ok(constant) = arguments::real(name, value) {
        return Ok(Schedule::Constant(constant));
    }
    let wrong = || bad_argument(name, must, value);
    let parts = value.cast::<PyTuple>().map_err(|_| wrong())?;
    let kind: String = parts.get_item(0).and_then(|kind| kind.extract()).map_err(|_| wrong())?;
    let part = |index: usize| -> PyResult<Option<f64>> {
        match parts.get_item(index) {
            Ok(part) if !part.is_none() => {
                Ok(Some(arguments::real(name, &part).map_err(|_| wrong())?))
            }
            _ => Ok(None),
        }
    };
    let needed = |index: usize| part(index)?.ok_or_else(wrong);
    match (kind.as_str(), parts.len()) {
        ("gaussian", 1..=3) => Ok(Schedule::Gaussian { start: part(1)?, scale: part(2)? }),
        ("linear", 3) => Ok(Schedule::Linear { start: needed(1)?, end: needed(2)? }),
        ("exponential", 3) => Ok(Schedule::Exponential { start: needed(1)?, end: needed(2)? }),
        ("table", 2) => Ok(Schedule::Table(parts.get_item(1)?.extract().map_err(|_| wrong())?)),
        _ => Err(wrong()),
    }
}
