//! `neurbs.NurbsSurface.z`: the heights of a surface over the plane of x and y.

use numpy::PyUntypedArrayMethods;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::call;
use super::surface::NurbsSurface;

#[pymethods]
impl NurbsSurface {
    /// Return the height of the surface at x and y: the z of its only point there.
    ///
    /// The result is NaN outside of the surface, where it has several heights (folds, tubes, walls),
    /// and for x or y that are not finite. Borders belong to the surface. The first call prepares
    /// the surface, which keeps that.
    ///
    /// Parameters
    /// ----------
    /// x, y : float or array_like
    ///     Coordinates in the points' unit; they broadcast.
    /// out : ndarray, optional
    ///     Where to write the result: float64, C-contiguous, of the broadcast shape.
    ///
    /// Returns
    /// -------
    /// float or ndarray
    ///     Of the broadcast shape of ``x`` and ``y``; a float for two numbers. This is ``out`` if
    ///     given.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the shapes do not broadcast, or an array has the wrong dtype.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.closest_points : For surfaces of any shape.
    ///
    /// Notes
    /// -----
    /// Newton's method for x(u, v) = x and y(u, v) = y on patches whose map to the plane is shown to
    /// be one-to-one. Heights are exact up to rounding.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
    /// >>> surface.z(0.5, 0.5)
    /// 0.25
    /// >>> surface.z(np.array([[0.5], [2.0]]), [0, 1])
    /// array([[0. , 0.5],
    ///        [nan, nan]])
    #[pyo3(signature = (x, y, *, out=None))]
    fn z<'py>(
        &self,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = x.py();
        let [x, y] = Numbers::broadcast([x, y], ["x", "y"])?;
        let result = arrays::output(py, out, x.shape())?;
        let (x, y) = (x.as_slice()?, y.as_slice()?);
        let mut writable = arrays::writable(&result)?;
        let z = writable.as_slice_mut()?;
        call::run(py, None, |watcher| self.height_search(watcher)?.heights(x, y, z, watcher))?;
        match (out, &*z) {
            (None, [only]) if result.ndim() == 0 => only.into_bound_py_any(py),
            _ => Ok(result.clone().into_any()),
        }
    }
}
