//! Functions for rounds of a fit over points in parts: robust weights, finer knots, lengths.

use numpy::PyArrayDyn;
use numpy::ndarray::IxDyn;
use pyo3::prelude::*;

use super::arguments::{count, real, two};
use super::arrays::{self, Numbers};
use super::errors::{argument_error, bad_argument};
use super::surface::NurbsSurface;
use super::surface_arguments::closed;
use crate::fit;

/// Weights by Tukey's biweight: 1 up to the reach of `usual`, the median of all distances, and by
/// the usual distance around each point beyond.
#[pyfunction]
pub(super) fn robust_weights(
    distances: &Bound<'_, PyAny>,
    around: &Bound<'_, PyAny>,
    usual: &Bound<'_, PyAny>,
) -> PyResult<Py<PyArrayDyn<f64>>> {
    let py = distances.py();
    let distances = Numbers::sequence(distances, "distances")?;
    let around = Numbers::sequence(around, "around")?;
    if distances.shape() != around.shape() {
        let must = format!("must be of shape {:?}, as distances", distances.shape());
        let message = format!("around {must}, got {:?}", around.shape());
        return Err(argument_error("around", message));
    }
    let usual = real("usual", usual)?;
    let weights = fit::robust_weights(distances.as_slice()?, around.as_slice()?, usual);
    arrays::constant::<f64, IxDyn>(py, &[weights.len()], &weights)
}

/// Finer knots for a surface whose spans in u and v have these sums of squared errors, for at most
/// so many control points; None if no span can be divided.
#[pyfunction]
pub(super) fn refined_knots<'py>(
    surface: &Bound<'py, NurbsSurface>,
    closed: &Bound<'py, PyAny>,
    errors: &Bound<'py, PyAny>,
    most: &Bound<'py, PyAny>,
) -> PyResult<Option<[Py<PyArrayDyn<f64>>; 2]>> {
    let py = surface.py();
    let refused = || bad_argument("errors", "two sequences, for u and v", errors);
    let [u, v] = two(errors).ok_or_else(refused)?;
    let sums = |errors: &Bound<'py, PyAny>| -> PyResult<Vec<f64>> {
        Ok(Numbers::sequence(errors, "errors")?.as_slice()?.to_vec())
    };
    let (closed, most) = (self::closed(Some(closed))?, count("most", most)?);
    let found = fit::refined_knots(surface.get().core(), closed, &[sums(&u)?, sums(&v)?], most)?;
    let array = |knots: &[f64]| arrays::constant::<f64, IxDyn>(py, &[knots.len()], knots);
    found.map(|(u, v)| Ok([array(u.as_slice())?, array(v.as_slice())?])).transpose()
}

/// Mean lengths of a surface's isocurves along u and along v, in the unit of its net.
#[pyfunction]
pub(super) fn isocurve_lengths(surface: &Bound<'_, NurbsSurface>) -> (f64, f64) {
    fit::isocurve_lengths(surface.get().core())
}
