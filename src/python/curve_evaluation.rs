//! `neurbs.NurbsCurve`: points and derivatives.

use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::arguments::optional_count;
use super::arrays::{self, Numbers};
use super::call;
use super::curve::NurbsCurve;
use super::evaluation::outside;
use crate::nurbs::MAX_DERIVATIVE;

#[pymethods]
impl NurbsCurve {
    /// Evaluate points of the curve.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost pieces to parameters outside the domain.
    /// out : ndarray of shape (n, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, 3)
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
    #[pyo3(signature = (u, *, extrapolate=false, out=None))]
    fn evaluate<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, u) = (u.py(), Numbers::sequence(u, "u")?);
        let result = arrays::output(py, out, &[u.shape()[0], 3])?;
        self.write(py, &u, 0, extrapolate, &result)?;
        Ok(result)
    }

    /// Evaluate derivatives of the curve.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,)
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
    /// ndarray of shape (n, order + 1, 3)
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
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, u) = (u.py(), Numbers::sequence(u, "u")?);
        let order: usize = optional_count("order", order)?.unwrap_or(1);
        // The core refuses an order above the limit; no memory is allocated for it here.
        let side = order.min(MAX_DERIVATIVE) + 1;
        let result = arrays::output(py, out, &[u.shape()[0], side, 3])?;
        self.write(py, &u, order, extrapolate, &result)?;
        Ok(result)
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
        let u = u.as_slice()?;
        let mut writable = arrays::writable(result)?;
        let out = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        let outside = outside(extrapolate);
        call::run(py, None, |watcher| self.core().derivatives(u, order, out, outside, watcher))
    }
}
