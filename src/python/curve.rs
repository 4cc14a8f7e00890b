//! The class `neurbs.NurbsCurve`.

use glam::DVec3;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::optional_count;
use super::arrays::Numbers;
use super::knots::optional_values;
use super::spline_arrays::{SplineArrays, SplineItems};
use crate::nurbs::{self, KnotVector};

/// Default degree of a curve.
pub(super) const DEFAULT_DEGREE: usize = 3;

/// A NURBS curve in space: an isocurve, a boundary, a profile.
///
/// Immutable: every operation returns a new curve.
///
/// Parameters
/// ----------
/// control_points : array_like of shape (n, 3) or (n, 2)
///     The control points in Cartesian coordinates (not multiplied by weights); z is 0 if there are
///     two columns.
/// weights : array_like of shape (n,), optional
///     Positive weights. Without weights the curve is polynomial.
/// degree : int, default 3
///     The degree, from 1 to 25.
/// knots : array_like of shape (n + degree + 1,), optional
///     Non-decreasing knots. By default clamped and evenly spaced on [0, 1].
///
/// Attributes
/// ----------
/// control_points : ndarray of shape (n, 3)
/// weights : ndarray of shape (n,) or None
/// degree : int
/// knots : ndarray of shape (n + degree + 1,)
/// domain : (float, float)
/// closed : bool
///
/// Raises
/// ------
/// NeurbsError
///     If array lengths and degree disagree, a number is not finite, a weight is not positive, or
///     the knots decrease or repeat too often.
///
/// See Also
/// --------
/// NurbsSurface.isocurve : A curve of a surface.
/// NurbsSurface.ruled, NurbsSurface.lofted, NurbsSurface.revolved : Surfaces from curves.
///
/// Notes
/// -----
/// L. Piegl and W. Tiller, *The NURBS Book*, second edition, Springer 1997, section 4.2.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> curve = neurbs.NurbsCurve([[0, 0, 0], [1, 2, 0], [2, 0, 0]], degree=2)
/// >>> curve
/// NurbsCurve(3 control points, degree 2, domain [0, 1], polynomial, open)
/// >>> curve.evaluate([0.5])
/// array([[1., 1., 0.]])
#[pyclass(frozen, module = "neurbs")]
pub(super) struct NurbsCurve {
    core: nurbs::NurbsCurve,
    arrays: SplineArrays,
}

impl NurbsCurve {
    pub(super) fn new(py: Python<'_>, core: nurbs::NurbsCurve) -> PyResult<Self> {
        let knots = [core.knots()];
        let arrays = SplineArrays::new(py, core.control_points(), core.weights(), &knots)?;
        Ok(Self { core, arrays })
    }

    pub(super) fn core(&self) -> &nurbs::NurbsCurve {
        &self.core
    }
}

#[pymethods]
impl NurbsCurve {
    #[new]
    #[pyo3(
        signature = (control_points, weights=None, degree=None, knots=None),
        text_signature = "(control_points, weights=None, degree=3, knots=None)"
    )]
    fn py_new(
        control_points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
        degree: Option<&Bound<'_, PyAny>>,
        knots: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let degree = optional_count("degree", degree)?.unwrap_or(DEFAULT_DEGREE);
        let points = Numbers::points(control_points, "control_points")?;
        let points: Vec<DVec3> = points.as_slice()?.to_vec();
        let knots = match optional_values(knots, "knots")? {
            Some(knots) => KnotVector::new(degree, knots)?,
            None => KnotVector::clamped_uniform(degree, points.len())?,
        };
        let core = nurbs::NurbsCurve::new(points, optional_values(weights, "weights")?, knots)?;
        Self::new(control_points.py(), core)
    }

    /// The control points in Cartesian coordinates: ndarray of shape (n, 3), read-only.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1).control_points
    /// array([[0., 0., 0.],
    ///        [1., 2., 0.]])
    #[getter]
    fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arrays.control_points(py)
    }

    /// The weights: ndarray of shape (n,), read-only; None if the curve is polynomial.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0]).weights[:3].round(3)
    /// array([1.   , 0.707, 1.   ])
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.arrays.weights(py)
    }

    /// The degree.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0]).degree
    /// 2
    #[getter]
    fn degree(&self) -> usize {
        self.core.knots().degree()
    }

    /// The knots: ndarray of shape (n + degree + 1,), read-only.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=1).knots
    /// array([0. , 0. , 0.5, 1. , 1. ])
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arrays.knots(py, 0)
    }

    /// The first and last parameter.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1, knots=[2, 2, 5, 5]).domain
    /// (2.0, 5.0)
    #[getter]
    fn domain(&self) -> (f64, f64) {
        self.core.knots().domain()
    }

    /// Whether the end points coincide.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0]).closed
    /// True
    #[getter]
    fn closed(&self) -> bool {
        self.core.closed()
    }

    /// The curve as a dict of plain lists and numbers, for example for JSON.
    ///
    /// Returns
    /// -------
    /// dict
    ///     The arguments of the constructor: ``control_points``, ``weights`` (or None), ``degree``
    ///     and ``knots``.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1)
    /// >>> line.to_dict().get("degree")
    /// 1
    pub(super) fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays.to_dict(py, self.degree())
    }

    /// Make a curve from a dict returned by :meth:`to_dict`.
    ///
    /// Parameters
    /// ----------
    /// data : dict
    ///     ``control_points``, and optionally ``weights``, ``degree`` and ``knots``. Missing items
    ///     have the constructor's defaults.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are no control points, or as in the constructor.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> circle = neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> neurbs.NurbsCurve.from_dict(circle.to_dict()) == circle
    /// True
    #[staticmethod]
    pub(super) fn from_dict(data: &Bound<'_, PyAny>) -> PyResult<Self> {
        let SplineItems { control_points, weights, degree, knots } = SplineItems::new(data)?;
        Self::py_new(&control_points, weights.as_ref(), degree.as_ref(), knots.as_ref())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.core == other.core
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let parts = (self.control_points(py)?, self.weights(py)?, self.degree(), self.knots(py)?);
        (py.get_type::<Self>(), parts).into_bound_py_any(py)
    }

    fn __repr__(&self) -> String {
        let count = self.core.control_points().len();
        let kind = if self.core.weights().is_some() { "rational" } else { "polynomial" };
        let closed = if self.core.closed() { "closed" } else { "open" };
        let ((a, b), degree) = (self.domain(), self.degree());
        format!(
            "NurbsCurve({count} control points, degree {degree}, domain [{a}, {b}], {kind}, \
             {closed})"
        )
    }
}
