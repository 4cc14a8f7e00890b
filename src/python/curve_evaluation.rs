//! `neurbs.NurbsCurve`: points, derivatives, tangents, curvature, bounding box, closest points.

use bytemuck::{AnyBitPattern, NoUninit};
use glam::DVec3;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::arguments::optional_count;
use super::arrays::{self, Numbers};
use super::call::{self, Watcher};
use super::curve::NurbsCurve;
use super::curve_points::CurvePoints;
use super::evaluation::{Array, outside};
use crate::error::Result;
use crate::nurbs::MAX_DERIVATIVE;

#[pymethods]
impl NurbsCurve {
    /// Evaluate points of the curve.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,), or float
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost pieces to parameters outside the domain.
    /// out : ndarray of shape (n, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, 3), or (3,) for one parameter
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
    /// >>> curve = neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2)
    /// >>> curve.evaluate([0.5, 1])
    /// array([[1., 1., 0.],
    ///        [2., 0., 0.]])
    /// >>> curve.evaluate(0.5)
    /// array([1., 1., 0.])
    #[pyo3(signature = (u, *, extrapolate=false, out=None))]
    fn evaluate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let (py, u) = (u.py(), Numbers::one_or_more(u, "u")?);
        let result = arrays::output(py, out, &[u.shape(), &[3]].concat())?;
        self.write(py, &u, 0, extrapolate, &result)?;
        Ok(result)
    }

    /// Evaluate derivatives of the curve.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,), or float
    ///     Parameters inside the domain.
    /// order : int, default 1
    ///     Highest order of differentiation, at most 18.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost pieces to parameters outside the domain.
    /// out : ndarray of shape (n, order + 1, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, order + 1, 3), or without n for one parameter
    ///     The i-th derivatives at ``[:, i]``; the points at ``[:, 0]``.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, the order is too high, or an array has the
    ///     wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// Rational derivatives by the quotient rule, *The NURBS Book*, A4.2.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> curve = neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2)
    /// >>> curve.derivatives([0.5], order=2)[0]
    /// array([[ 1.,  1.,  0.],
    ///        [ 2.,  0.,  0.],
    ///        [ 0., -8.,  0.]])
    #[pyo3(
        signature = (u, order=None, *, extrapolate=false, out=None),
        text_signature = "($self, u, order=1, *, extrapolate=False, out=None)"
    )]
    fn derivatives<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        order: Option<&Bound<'py, PyAny>>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let (py, u) = (u.py(), Numbers::one_or_more(u, "u")?);
        let order: usize = optional_count("order", order)?.unwrap_or(1);
        // The core refuses an order above the limit; no memory is allocated for it here.
        let side = order.min(MAX_DERIVATIVE) + 1;
        let result = arrays::output(py, out, &[u.shape(), &[side, 3]].concat())?;
        self.write(py, &u, order, extrapolate, &result)?;
        Ok(result)
    }

    /// Evaluate points of the curve: :meth:`evaluate` for parameters of any shape.
    ///
    /// Parameters
    /// ----------
    /// u : float or array_like
    ///     Parameters inside the domain.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (..., 3)
    ///     A point for each parameter; of shape (3,) for a number.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2)(0.5)
    /// array([1., 1., 0.])
    fn __call__<'py>(&self, u: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let (py, u) = (u.py(), Numbers::of_any_shape(u, "u")?);
        let result = arrays::output(py, None, &[u.shape(), &[3]].concat())?;
        self.write(py, &u, 0, false, &result)?;
        Ok(result)
    }

    /// Evaluate unit tangents, in the direction of the derivative.
    ///
    /// Where the derivative vanishes (a cusp), the tangent is the limit from larger parameters, at
    /// the end of the domain that from smaller ones; zero if there is none.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,), or float
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost pieces to parameters outside the domain.
    /// out : ndarray of shape (n, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, 3), or (3,) for one parameter
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
    /// >>> circle = neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> circle.tangents([0, 0.25]).round(12) + 0
    /// array([[ 0.,  1.,  0.],
    ///        [-1.,  0.,  0.]])
    #[pyo3(signature = (u, *, extrapolate=false, out=None))]
    fn tangents<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let (py, u) = (u.py(), Numbers::one_or_more(u, "u")?);
        let result = arrays::output(py, out, &[u.shape(), &[3]].concat())?;
        let (core, outside) = (self.core(), outside(extrapolate));
        fill(py, &u, &result, |u, out, watcher| core.tangents(u, out, outside, watcher))?;
        Ok(result)
    }

    /// Evaluate curvatures, in 1 / unit: inverse radii of the circles that fit best.
    ///
    /// A curvature is NaN where the derivative vanishes.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,), or float
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost pieces to parameters outside the domain.
    /// out : ndarray of shape (n,), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n,), or () for one parameter
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
    /// >>> neurbs.NurbsCurve.arc([0, 0, 0], [4, 0, 0], [0, 4, 0]).curvatures([0.1, 0.6]).round(12)
    /// array([0.25, 0.25])
    #[pyo3(signature = (u, *, extrapolate=false, out=None))]
    fn curvatures<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let (py, u) = (u.py(), Numbers::one_or_more(u, "u")?);
        let result = arrays::output(py, out, u.shape())?;
        let (core, outside) = (self.core(), outside(extrapolate));
        fill(py, &u, &result, |u, out, watcher| core.curvatures(u, out, outside, watcher))?;
        Ok(result)
    }

    /// The axis-aligned bounding box of the curve.
    ///
    /// Parameters
    /// ----------
    /// tight : bool, default True
    ///     Whether to compute the exact box, to 1e-10 of the size. Otherwise return the box of the
    ///     control points, which is larger.
    ///
    /// Returns
    /// -------
    /// low, high : ndarray of shape (3,)
    ///     Smallest and largest coordinates, in the points' unit.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> low, high = neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2).bounding_box()
    /// >>> high.round(9)
    /// array([2., 1., 0.])
    #[pyo3(signature = (*, tight=true))]
    fn bounding_box<'py>(
        &self,
        py: Python<'py>,
        tight: bool,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let core = self.core();
        let (low, high) =
            if tight { call::run(py, None, |_| core.bounding_box())? } else { core.net_box() };
        let array = |corner: DVec3| arrays::filled(py, None, corner.as_ref());
        Ok((array(low)?, array(high)?))
    }

    /// Project points onto the curve: the globally closest points of the curve.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Points in space; z is 0 if there are two columns.
    ///
    /// Returns
    /// -------
    /// CurvePoints
    ///     ``u`` of shape (n,), ``points`` of shape (n, 3) and ``distances`` of shape (n,).
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite, or the array has the wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// Branch and bound over the pieces between knots, with Newton's method; *The NURBS Book*,
    /// section 6.1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> circle = neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> closest = circle.closest_points([[0, 3, 0], [-1, 0, 1]])
    /// >>> closest
    /// CurvePoints(2 points)
    /// >>> closest.u.round(12), closest.distances.round(12)
    /// (array([0.25, 0.5 ]), array([2., 1.]))
    fn closest_points(&self, points: &Bound<'_, PyAny>) -> PyResult<CurvePoints> {
        let py = points.py();
        let points = Numbers::points(points, "points")?;
        let (core, points) = (self.core(), points.as_slice()?);
        let found = call::run(py, None, |watcher| core.closest_points(points, watcher))?;
        CurvePoints::of_core(py, &found)
    }
}

impl NurbsCurve {
    fn write(
        &self,
        py: Python<'_>,
        u: &Numbers<'_>,
        order: usize,
        extrapolate: bool,
        result: &Bound<'_, PyArrayDyn<f64>>,
    ) -> PyResult<()> {
        let (core, outside) = (self.core(), outside(extrapolate));
        fill(py, u, result, |u, out, watcher| core.derivatives(u, order, out, outside, watcher))
    }
}

/// Computes values at parameters into an array.
fn fill<T: AnyBitPattern + NoUninit + Send>(
    py: Python<'_>,
    u: &Numbers<'_>,
    result: &Bound<'_, PyArrayDyn<f64>>,
    compute: impl FnOnce(&[f64], &mut [T], &mut Watcher) -> Result<()> + Send,
) -> PyResult<()> {
    let u = u.as_slice()?;
    let mut writable = arrays::writable(result)?;
    let out = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
    call::run(py, None, |watcher| compute(u, out, watcher))
}
