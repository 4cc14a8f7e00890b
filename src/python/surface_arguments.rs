//! Conversion of arguments that describe a surface: degrees, closed directions, nets, weights and
//! knots.

use pyo3::prelude::*;

use super::arguments;
use super::arrays::Numbers;
use super::errors::bad_argument;
use crate::nurbs::KnotVector;

/// One value for both directions, or a pair.
fn both<'py, T: Clone + FromPyObjectOwned<'py>>(
    name: &str,
    must: &str,
    value: Option<&Bound<'py, PyAny>>,
    default: T,
) -> PyResult<(T, T)> {
    let Some(value) = value else { return Ok((default.clone(), default)) };
    if let Ok(both) = value.extract::<T>() {
        return Ok((both.clone(), both));
    }
    let refused = || bad_argument(name, must, value);
    let [u, v] = arguments::two(value).ok_or_else(refused)?;
    let extract = |value: Bound<'py, PyAny>| value.extract::<T>().map_err(|_| refused());
    Ok((extract(u)?, extract(v)?))
}

/// A degree for both directions, or a pair.
pub(super) fn degrees(value: Option<&Bound<'_, PyAny>>) -> PyResult<(usize, usize)> {
    both("degree", "an integer from 0 or two of them", value, 3)
}

/// Whether directions are closed: one value for both, or a pair.
pub(super) fn closed(value: Option<&Bound<'_, PyAny>>) -> PyResult<(bool, bool)> {
    both("closed", "a bool or two of them", value, false)
}

/// Knot vectors for u and v.
pub(super) fn knot_vectors<'py>(
    knots: &Bound<'py, PyAny>,
    degree: (usize, usize),
) -> PyResult<(KnotVector, KnotVector)> {
    let refused = || bad_argument("knots", "two sequences, for u and v", knots);
    let [u, v] = arguments::two(knots).ok_or_else(refused)?;
    let vector = |name, degree, knots: &Bound<'py, PyAny>| -> PyResult<KnotVector> {
        let knots = Numbers::sequence(knots, name)?;
        Ok(KnotVector::new(degree, knots.as_slice()?.to_vec())?)
    };
    Ok((vector("knots in u", degree.0, &u)?, vector("knots in v", degree.1, &v)?))
}

/// A control net and its shape.
pub(super) fn net<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<(Numbers<'py>, (usize, usize))> {
    let expected = "real numbers of shape (n_u, n_v, 3)";
    let net = Numbers::new(value, name, expected, &[&[None, None, Some(3)]])?;
    let shape = (net.shape()[0], net.shape()[1]);
    Ok((net, shape))
}

/// Weights for a net of this shape.
pub(super) fn weights(
    value: Option<&Bound<'_, PyAny>>,
    (rows, cols): (usize, usize),
) -> PyResult<Option<Vec<f64>>> {
    let Some(value) = value else { return Ok(None) };
    let expected = format!("real numbers of shape ({rows}, {cols}), as the net");
    let weights = Numbers::new(value, "weights", &expected, &[&[Some(rows), Some(cols)]])?;
    Ok(Some(weights.as_slice()?.to_vec()))
}
