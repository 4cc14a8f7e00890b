//! The class `neurbs.ClosestPoints`, and the method of `neurbs.NurbsSurface` that returns it.

use numpy::ndarray::Ix1;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::call;
use super::errors::NeurbsError;
use super::pickling::{Reduced, reduced};
use super::surface::NurbsSurface;
use crate::nurbs::ClosestPointSlices;

/// The projections of points onto a surface.
///
/// Returned by :meth:`NurbsSurface.closest_points`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct ClosestPoints {
    /// The parameters of the projections, float64 of shape (n, 2).
    #[pyo3(get)]
    uv: Py<PyArrayDyn<f64>>,
    /// The projections, float64 of shape (n, 3).
    #[pyo3(get)]
    points: Py<PyArrayDyn<f64>>,
    /// The distances from the points to their projections, float64 of shape (n,), in the points'
    /// unit.
    #[pyo3(get)]
    distances: Py<PyArrayDyn<f64>>,
    /// Whether Newton's method converged, bool of shape (n,).
    #[pyo3(get)]
    converged: Py<PyArray1<bool>>,
}

#[pymethods]
impl ClosestPoints {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        uv: Py<PyArrayDyn<f64>>,
        points: Py<PyArrayDyn<f64>>,
        distances: Py<PyArrayDyn<f64>>,
        converged: Py<PyArray1<bool>>,
    ) -> Self {
        Self { uv, points, distances, converged }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["uv", "points", "distances", "converged"])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let converged = self.converged.bind(py).readonly();
        let done = converged.as_array().iter().filter(|done| **done).count();
        format!("ClosestPoints({} points, {done} converged)", converged.len())
    }
}

#[pymethods]
impl NurbsSurface {
    /// Project points onto the surface: the globally closest surface points.
    ///
    /// The first call builds a tree over the surface, which costs about a thousand searches. The
    /// surface keeps it.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Points in space; z is 0 if there are two columns.
    /// out : ClosestPoints, optional
    ///     An earlier result for the same number of points, to be overwritten.
    ///
    /// Returns
    /// -------
    /// ClosestPoints
    ///     ``uv`` of shape (n, 2), clamped to the domain; ``points`` of shape (n, 3); ``distances``
    ///     and ``converged`` of shape (n,). This is ``out`` if given.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite, or an array has the wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// Branch and bound: a tree of boxes over nearly flat pieces gives lower bounds of the
    /// distance. Newton's method with second derivatives gives the projections. A piece is skipped
    /// only if it cannot contain a closer point, so folds, seams and borders cause no wrong result.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 2)
    /// >>> closest = sphere.closest_points([[0, 5, 0], [0, 0, 1]])
    /// >>> closest
    /// ClosestPoints(2 points, 2 converged)
    /// >>> closest.distances.round(12)
    /// array([3., 1.])
    #[pyo3(signature = (points, *, out=None))]
    fn closest_points(
        &self,
        points: &Bound<'_, PyAny>,
        out: Option<&Bound<'_, ClosestPoints>>,
    ) -> PyResult<Py<ClosestPoints>> {
        let py = points.py();
        let points = Numbers::points(points, "points")?;
        let count = points.shape()[0];
        let old = out.map(Bound::get);
        let array = |of: Option<&Py<PyArrayDyn<f64>>>, shape: &[usize]| {
            arrays::output(py, of.map(|array| array.bind(py).as_any()), shape)
        };
        let uv = array(old.map(|old| &old.uv), &[count, 2])?;
        let closest = array(old.map(|old| &old.points), &[count, 3])?;
        let distances = array(old.map(|old| &old.distances), &[count])?;
        let converged = match old {
            Some(old) => old.converged.bind(py).clone(),
            None => arrays::empty::<bool, Ix1>(py, &[count])?,
        };
        if converged.len() != count {
            let got = converged.len();
            return Err(NeurbsError::new_err(format!("out must be for {count} points, got {got}")));
        }
        {
            let points = points.as_slice()?;
            let mut uv = arrays::writable(&uv)?;
            let mut closest = arrays::writable(&closest)?;
            let mut distances = arrays::writable(&distances)?;
            let mut converged = arrays::writable(&converged)?;
            let slices = ClosestPointSlices {
                uv: bytemuck::cast_slice_mut(uv.as_slice_mut()?),
                points: bytemuck::cast_slice_mut(closest.as_slice_mut()?),
                distances: distances.as_slice_mut()?,
                converged: converged.as_slice_mut()?,
            };
            call::run(py, None, |watcher| {
                self.search(watcher)?.closest_points(points, slices, watcher)
            })?;
        }
        if let Some(out) = out {
            return Ok(out.clone().unbind());
        }
        let (uv, points, distances) = (uv.unbind(), closest.unbind(), distances.unbind());
        Py::new(py, ClosestPoints { uv, points, distances, converged: converged.unbind() })
    }
}
