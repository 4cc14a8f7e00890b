//! `neurbs.ClosestPoints`, and the method of `neurbs.NurbsSurface` that finds them.

use numpy::ndarray::Ix1;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::call;
use super::errors::NeurbsError;
use super::surface::NurbsSurface;
use crate::nurbs::ClosestPointSlices;

/// The feet of points on a surface.
///
/// Made by :meth:`NurbsSurface.closest_points`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct ClosestPoints {
    /// The parameters of the feet, float64 of shape (n, 2).
    #[pyo3(get)]
    uv: Py<PyArrayDyn<f64>>,
    /// The feet, float64 of shape (n, 3).
    #[pyo3(get)]
    points: Py<PyArrayDyn<f64>>,
    /// Their distances, float64 of shape (n,), in the points' unit.
    #[pyo3(get)]
    distances: Py<PyArrayDyn<f64>>,
    /// Whether Newton's method came to its end, bool of shape (n,).
    #[pyo3(get)]
    converged: Py<PyArray1<bool>>,
}

#[pymethods]
impl ClosestPoints {
    fn __repr__(&self, py: Python<'_>) -> String {
        let converged = self.converged.bind(py).readonly();
        let done = converged.as_array().iter().filter(|done| **done).count();
        format!("ClosestPoints({} points, {done} converged)", converged.len())
    }
}

#[pymethods]
impl NurbsSurface {
    /// The points of the surface that are closest to points in space, globally.
    ///
    /// The first call prepares a tree over the surface, which costs about as much as a thousand
    /// searches; the surface keeps it.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Points in space; two columns lie in z = 0.
    /// out : ClosestPoints, optional
    ///     An earlier result for as many points, whose arrays are written to.
    ///
    /// Returns
    /// -------
    /// ClosestPoints
    ///     ``uv`` of shape (n, 2), clamped to the domain; ``points`` of shape (n, 3); ``distances``
    ///     and ``converged`` of shape (n,). It is ``out``, if that was given.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite, or an array has the wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// A tree of boxes over nearly flat pieces of the surface gives lower bounds, Newton's method
    /// with second derivatives gives feet; a piece is left aside only when it can hold no closer
    /// one. So folds, seams and borders lead to no wrong foot.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 2)
    /// >>> feet = sphere.closest_points([[0, 5, 0], [0, 0, 1]])
    /// >>> feet
    /// ClosestPoints(2 points, 2 converged)
    /// >>> feet.distances.round(12)
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
        let feet = array(old.map(|old| &old.points), &[count, 3])?;
        let distances = array(old.map(|old| &old.distances), &[count])?;
        let converged = match old {
            Some(old) => old.converged.bind(py).clone(),
            None => arrays::empty::<bool, Ix1>(py, &[count])?,
        };
        if converged.len() != count {
            let got = format!("{} of them", converged.len());
            return Err(NeurbsError::new_err(format!("out must be of {count} points, got {got}")));
        }
        {
            let points = points.as_slice()?;
            let mut uv = arrays::writable(&uv)?;
            let mut feet = arrays::writable(&feet)?;
            let mut distances = arrays::writable(&distances)?;
            let mut converged = arrays::writable(&converged)?;
            let slices = ClosestPointSlices {
                uv: bytemuck::cast_slice_mut(uv.as_slice_mut()?),
                points: bytemuck::cast_slice_mut(feet.as_slice_mut()?),
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
        let (uv, points, distances) = (uv.unbind(), feet.unbind(), distances.unbind());
        Py::new(py, ClosestPoints { uv, points, distances, converged: converged.unbind() })
    }
}
