//! The class `neurbs.FacePoints`: projections of points onto faces.

use glam::{DVec2, DVec3};
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray1, PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::arrays;
use super::pickling::{Reduced, reduced};
use crate::brep::FacePoint;

/// The projections of points onto the faces of a shell.
///
/// Returned by :meth:`Shell.closest_points` and :meth:`Face.closest_points`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct FacePoints {
    /// The index of the face of each projection, uint32 of shape (n,).
    #[pyo3(get)]
    face_index: Py<PyArray1<u32>>,
    /// The parameters of the projections on their faces' surfaces, float64 of shape (n, 2).
    #[pyo3(get)]
    uv: Py<PyArray2<f64>>,
    /// The projections, float64 of shape (n, 3).
    #[pyo3(get)]
    points: Py<PyArray2<f64>>,
    /// The distances from the points to their projections, float64 of shape (n,), in the points'
    /// unit.
    #[pyo3(get)]
    distances: Py<PyArray1<f64>>,
}

impl FacePoints {
    pub(super) fn new(py: Python<'_>, found: &[FacePoint]) -> PyResult<Self> {
        let count = found.len();
        let faces: Vec<u32> = found.iter().map(|point| crate::numeric::index(point.face)).collect();
        let uv: Vec<DVec2> = found.iter().map(|point| point.uv).collect();
        let points: Vec<DVec3> = found.iter().map(|point| point.point).collect();
        let distances: Vec<f64> = found.iter().map(|point| point.distance).collect();
        Ok(Self {
            face_index: arrays::moved::<u32, u32, Ix1>(py, &[count], faces)?.unbind(),
            uv: arrays::moved::<DVec2, f64, Ix2>(py, &[count, 2], uv)?.unbind(),
            points: arrays::moved::<DVec3, f64, Ix2>(py, &[count, 3], points)?.unbind(),
            distances: arrays::moved::<f64, f64, Ix1>(py, &[count], distances)?.unbind(),
        })
    }
}

#[pymethods]
impl FacePoints {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        face_index: Py<PyArray1<u32>>,
        uv: Py<PyArray2<f64>>,
        points: Py<PyArray2<f64>>,
        distances: Py<PyArray1<f64>>,
    ) -> Self {
        Self { face_index, uv, points, distances }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["face_index", "uv", "points", "distances"])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("FacePoints({} points)", self.distances.bind(py).len())
    }
}
