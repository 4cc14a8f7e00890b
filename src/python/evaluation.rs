//! `neurbs.NurbsSurface`: points, normals and derivatives.

use glam::{DVec2, DVec3};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::arguments::optional_count;
use super::arrays::{self, Numbers};
use super::call;
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::nurbs::{self, MAX_DERIVATIVE, Outside};

/// The core's option for the argument `extrapolate`.
pub(super) fn outside(extrapolate: bool) -> Outside {
    if extrapolate { Outside::Extrapolate } else { Outside::Refuse }
}

/// An array of float64.
pub(super) type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

impl NurbsSurface {
    /// Evaluates vectors at parameters, an array of `shape` for each, into `out` or a new array. One
    /// place has the array alone.
    fn map<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        shape: &[usize],
        out: Option<&Bound<'py, PyAny>>,
        f: impl FnOnce(&nurbs::NurbsSurface, &[DVec2], &mut [DVec3], &mut call::Watcher) -> Result<()>
        + Send,
    ) -> PyResult<Array<'py>> {
        let py = uv.py();
        let uv = Numbers::places(uv)?;
        let places = &uv.shape()[..uv.shape().len() - 1];
        let result = arrays::output(py, out, &[places, shape, &[3]].concat())?;
        let (core, uv) = (self.core(), uv.as_slice()?);
        let mut writable = arrays::writable(&result)?;
        let out = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        call::run(py, None, |watcher| f(core, uv, out, watcher))?;
        drop(writable);
        Ok(result)
    }
}

#[pymethods]
impl NurbsSurface {
    /// Evaluate points of the surface at scattered parameters.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2), or (2,) for one place
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : ndarray of shape (n, 3), or (3,) for one place, optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, 3), or (3,) for one place
    ///     ``out``, or a new array.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
    /// >>> surface.evaluate([[0.5, 0.5], [1, 1]])
    /// array([[0.5 , 0.5 , 0.25],
    ///        [1.  , 1.  , 1.  ]])
    /// >>> surface.evaluate([0.5, 0.5])
    /// array([0.5 , 0.5 , 0.25])
    #[pyo3(signature = (uv, *, extrapolate=false, out=None))]
    fn evaluate<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let outside = outside(extrapolate);
        self.map(uv, &[], out, |core, uv, out, watcher| core.evaluate(uv, out, outside, watcher))
    }

    /// Evaluate points of the surface; ``u`` and ``v`` broadcast.
    ///
    /// Parameters
    /// ----------
    /// u, v : float or array_like
    ///     Parameters inside the domain.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (..., 3)
    ///     A point for each pair of the broadcast parameters; of shape (3,) for two numbers.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or the shapes do not broadcast.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.evaluate_grid : Faster for all pairs of ``u`` and ``v``.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
    /// >>> surface(0.5, 0.5)
    /// array([0.5 , 0.5 , 0.25])
    /// >>> surface([0.5, 1], 1)
    /// array([[0.5, 1. , 0.5],
    ///        [1. , 1. , 1. ]])
    fn __call__<'py>(&self, u: &Bound<'py, PyAny>, v: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let py = u.py();
        let [u, v] = Numbers::broadcast([u, v], ["u", "v"])?;
        let pairs = u.as_slice()?.iter().zip(v.as_slice::<f64>()?);
        let uv: Vec<DVec2> = pairs.map(|(&u, &v)| DVec2::new(u, v)).collect();
        let result = arrays::output(py, None, &[u.shape(), &[3]].concat())?;
        let mut writable = arrays::writable(&result)?;
        let points = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        let core = self.core();
        call::run(py, None, |watcher| core.evaluate(&uv, points, Outside::Refuse, watcher))?;
        drop(writable);
        Ok(result)
    }

    /// Evaluate unit normals in the direction of ∂/∂u × ∂/∂v at scattered parameters.
    ///
    /// Where a tangent vanishes (a pole, a collapsed edge), the normal is the limit from the middle
    /// of the domain, or zero if there is none.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2), or (2,) for one place
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : ndarray of shape (n, 3), or (3,) for one place, optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, 3), or (3,) for one place
    ///     ``out``, or a new array.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.sphere([0, 0, 0], 2).normals([[0.25, 0.5], [0, 1]]).round(12) + 0
    /// array([[0., 1., 0.],
    ///        [0., 0., 1.]])
    #[pyo3(signature = (uv, *, extrapolate=false, out=None))]
    fn normals<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let outside = outside(extrapolate);
        self.map(uv, &[], out, |core, uv, out, watcher| core.normals(uv, out, outside, watcher))
    }

    /// Evaluate partial derivatives at scattered parameters.
    ///
    /// At a knot they are right-hand derivatives, at the end of the domain left-hand ones.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2), or (2,) for one place
    ///     Parameters inside the domain.
    /// order : int, default 1
    ///     Highest order of differentiation in each direction, at most 18.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : ndarray of shape (n, order + 1, order + 1, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, order + 1, order + 1, 3), or without n for one place
    ///     At ``[:, i, j]`` the i-th derivative in u and j-th in v; the points at ``[:, 0, 0]``.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, the order is too high, or an array has the
    ///     wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// Rational derivatives by the quotient rule, *The NURBS Book*, equation 4.20.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
    /// >>> derivatives = surface.derivatives([[0.5, 0.5]], order=1)
    /// >>> derivatives[0, 1, 0], derivatives[0, 1, 1]
    /// (array([1. , 0. , 0.5]), array([0., 0., 1.]))
    #[pyo3(
        signature = (uv, order=None, *, extrapolate=false, out=None),
        text_signature = "($self, uv, order=1, *, extrapolate=False, out=None)"
    )]
    fn derivatives<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        order: Option<&Bound<'py, PyAny>>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let outside = outside(extrapolate);
        let order: usize = optional_count("order", order)?.unwrap_or(1);
        // The core refuses an order above the limit; no memory is allocated for it here.
        let side = order.min(MAX_DERIVATIVE) + 1;
        self.map(uv, &[side, side], out, |core, uv, out, watcher| {
            core.derivatives(uv, order, out, outside, watcher)
        })
    }

    /// Evaluate points of the surface on the grid of all pairs of ``u`` and ``v``.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,) and (m,)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : ndarray of shape (n, m, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, m, 3)
    ///     ``out``, or a new array.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> net = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]]
    /// >>> neurbs.NurbsSurface(net, degree=1).evaluate_grid([0, 0.5, 1], [0, 1])[1]
    /// array([[0.5, 0. , 0. ],
    ///        [0.5, 1. , 0.5]])
    #[pyo3(signature = (u, v, *, extrapolate=false, out=None))]
    fn evaluate_grid<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let py = u.py();
        let (u, v) = (Numbers::sequence(u, "u")?, Numbers::sequence(v, "v")?);
        let result = arrays::output(py, out, &[u.shape()[0], v.shape()[0], 3])?;
        let (core, u, v) = (self.core(), u.as_slice()?, v.as_slice()?);
        let mut writable = arrays::writable(&result)?;
        let points = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        let outside = outside(extrapolate);
        call::run(py, None, |watcher| core.evaluate_grid(u, v, points, None, outside, watcher))?;
        drop(writable);
        Ok(result)
    }

    /// Evaluate points and unit normals on the grid of all pairs of ``u`` and ``v``, in one pass.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,) and (m,)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : (ndarray, ndarray) of shape (n, m, 3) each, optional
    ///     Where to write the results: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// points : ndarray of shape (n, m, 3)
    /// normals : ndarray of shape (n, m, 3)
    ///     See :meth:`normals` for poles.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> t = np.linspace(0, 1, 20)
    /// >>> points, normals = neurbs.NurbsSurface.sphere([0, 0, 0], 1).normals_grid(t, t)
    /// >>> np.abs(points - normals).max() < 1e-13
    /// np.True_
    #[pyo3(signature = (u, v, *, extrapolate=false, out=None))]
    fn normals_grid<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let py = u.py();
        let (u, v) = (Numbers::sequence(u, "u")?, Numbers::sequence(v, "v")?);
        let shape = [u.shape()[0], v.shape()[0], 3];
        let (out_points, out_normals) = out.unzip();
        let points = arrays::output(py, out_points.as_ref(), &shape)?;
        let normals = arrays::output(py, out_normals.as_ref(), &shape)?;
        let (core, u, v) = (self.core(), u.as_slice()?, v.as_slice()?);
        {
            let (mut points, mut normals) =
                (arrays::writable(&points)?, arrays::writable(&normals)?);
            let to_points = bytemuck::cast_slice_mut(points.as_slice_mut()?);
            let to_normals = Some(bytemuck::cast_slice_mut(normals.as_slice_mut()?));
            let outside = outside(extrapolate);
            call::run(py, None, |watcher| {
                core.evaluate_grid(u, v, to_points, to_normals, outside, watcher)
            })?;
        }
        Ok((points, normals))
    }
}
