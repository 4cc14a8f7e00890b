//! The class `neurbs.CurvePoints`: projections of points onto a curve.

use glam::DVec3;
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray1, PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::arrays;
use super::pickling::{Reduced, reduced};
use crate::nurbs::CurvePoint;

/// The projections of points onto a curve.
///
/// Returned by :meth:`NurbsCurve.closest_points`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct CurvePoints {
    /// The parameters of the projections, float64 of shape (n,).
    #[pyo3(get)]
    u: Py<PyArray1<f64>>,
    /// The projections, float64 of shape (n, 3).
    #[pyo3(get)]
    points: Py<PyArray2<f64>>,
    /// The distances from the points to their projections, float64 of shape (n,), in the points'
    /// unit.
    #[pyo3(get)]
    distances: Py<PyArray1<f64>>,
}

impl CurvePoints {
    pub(super) fn of_core(py: Python<'_>, found: &[CurvePoint]) -> PyResult<Self> {
        let count = found.len();
        let u: Vec<f64> = found.iter().map(|point| point.u).collect();
        let points: Vec<DVec3> = found.iter().map(|point| point.point).collect();
        let distances: Vec<f64> = found.iter().map(|point| point.distance).collect();
        Ok(Self {
            u: arrays::moved::<f64, f64, Ix1>(py, &[count], u)?.unbind(),
            points: arrays::moved::<DVec3, f64, Ix2>(py, &[count, 3], points)?.unbind(),
            distances: arrays::moved::<f64, f64, Ix1>(py, &[count], distances)?.unbind(),
        })
    }
}

#[pymethods]
impl CurvePoints {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        u: Py<PyArray1<f64>>,
        points: Py<PyArray2<f64>>,
        distances: Py<PyArray1<f64>>,
    ) -> Self {
        Self { u, points, distances }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["u", "points", "distances"])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("CurvePoints({} points)", self.distances.bind(py).len())
    }
}
