//! The functions `neurbs.candidates` and `neurbs.validate`, and their results as Python objects.

use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arrays::Numbers;
use super::call;
use super::kind::named_kind;
use super::surface::NurbsSurface;
use crate::diagnostic::Diagnostic;
use crate::pipeline::{Candidate, ReconstructOptions};
use crate::{cloud, pipeline};

/// A diagnostic for Python: code, message, data, and whether it is a defect.
type Finding<'py> = (&'static str, String, Bound<'py, PyDict>, bool);

/// Rank the hypotheses; the public function is :func:`neurbs.candidates`.
#[pyfunction]
#[pyo3(signature = (points, kind, progress))]
pub(super) fn candidates<'py>(
    points: &Bound<'py, PyAny>,
    kind: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let py = points.py();
    let options = ReconstructOptions { kind: named_kind(kind)?, ..ReconstructOptions::default() };
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let found = call::run(py, progress, |watcher| pipeline::candidates(points, &options, watcher))?;
    ranking(py, &found)
}

/// Find the defects of a surface; the public function is :func:`neurbs.validate`.
#[pyfunction]
#[pyo3(signature = (surface, points, progress))]
pub(super) fn validate<'py>(
    surface: &Bound<'py, NurbsSurface>,
    points: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let surface = surface.get().core();
    let found = call::run(py, progress, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        crate::validate::validate(surface, points, watcher)
    })?;
    findings(py, &found)
}

/// The keyword arguments of `neurbs.Candidate`, one dict per candidate.
pub(super) fn ranking<'py>(
    py: Python<'py>,
    candidates: &[Candidate],
) -> PyResult<Bound<'py, PyTuple>> {
    let dicts = candidates.iter().map(|candidate| {
        let terms = PyDict::new(py);
        for (name, value) in &candidate.terms {
            terms.set_item(name, value)?;
        }
        let dict = PyDict::new(py);
        dict.set_item("chart", candidate.chart)?;
        dict.set_item("kind", candidate.kind.name())?;
        dict.set_item("direction", candidate.direction.map(<(f64, f64, f64)>::from))?;
        dict.set_item("score", candidate.score)?;
        dict.set_item("terms", terms)?;
        dict.set_item("rank", candidate.rank)?;
        dict.set_item("outcome", &candidate.outcome)?;
        Ok(dict)
    });
    PyTuple::new(py, dicts.collect::<PyResult<Vec<_>>>()?)
}

/// The arguments of `neurbs.Diagnostic`, one tuple per diagnostic.
pub(super) fn findings<'py>(
    py: Python<'py>,
    diagnostics: &[Diagnostic],
) -> PyResult<Bound<'py, PyTuple>> {
    let found = diagnostics.iter().map(|one| finding(py, one));
    PyTuple::new(py, found.collect::<PyResult<Vec<_>>>()?)
}

/// Issues Python warnings, as if the caller of the extension did.
pub(super) fn warn(py: Python<'_>, diagnostics: &[Diagnostic]) -> PyResult<()> {
    if diagnostics.is_empty() {
        return Ok(());
    }
    let module = py.import("neurbs.diagnostics")?;
    let found = module.call_method1("of_core", (findings(py, diagnostics)?,))?;
    let level = PyDict::new(py);
    level.set_item("stacklevel", 1)?;
    module.call_method("warn", (found,), Some(&level))?;
    Ok(())
}

fn finding<'py>(py: Python<'py>, found: &Diagnostic) -> PyResult<Finding<'py>> {
    let data = PyDict::new(py);
    match found {
        Diagnostic::ClosedBody => {}
        Diagnostic::Folded { share }
        | Diagnostic::Uncovered { share }
        | Diagnostic::Torn { share } => data.set_item("share", share)?,
        Diagnostic::Overshoot { distance, diagonal } => {
            data.set_item("distance", distance)?;
            data.set_item("diagonal", diagonal)?;
        }
        Diagnostic::Thick { rms, diagonal } => {
            data.set_item("rms", rms)?;
            data.set_item("diagonal", diagonal)?;
        }
        Diagnostic::TwoLayers { rms, noise } => {
            data.set_item("rms", rms)?;
            data.set_item("noise", noise)?;
        }
        Diagnostic::Components { sizes } => data.set_item("sizes", sizes)?,
        Diagnostic::MixedUnits { scale } => data.set_item("scale", scale)?,
        Diagnostic::LeftOut { count, points, together } => {
            data.set_item("count", count)?;
            data.set_item("points", points)?;
            data.set_item("together", together)?;
        }
        Diagnostic::NoData { value, count } => {
            data.set_item("value", value)?;
            data.set_item("count", count)?;
        }
        Diagnostic::Untrimmed { reason } | Diagnostic::TrimDoubtful { reason } => {
            data.set_item("reason", reason)?;
        }
        Diagnostic::Regions { count } => data.set_item("count", count)?,
        Diagnostic::ToleranceMissed { tolerance, missed, points, cause } => {
            data.set_item("tolerance", tolerance)?;
            data.set_item("missed", missed)?;
            data.set_item("points", points)?;
            data.set_item("cause", cause.name())?;
        }
        Diagnostic::KindDoubtful { requested, rms, diagonal } => {
            data.set_item("requested", requested.name())?;
            data.set_item("rms", rms)?;
            data.set_item("diagonal", diagonal)?;
        }
        Diagnostic::NotSettled { steps, change } => {
            data.set_item("steps", steps)?;
            data.set_item("change", change)?;
        }
    }
    Ok((found.code(), found.to_string(), data, found.is_defect()))
}
