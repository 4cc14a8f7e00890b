//! `neurbs.NurbsCurve`.

use glam::DVec3;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::optional_count;
use super::arrays::Numbers;
use super::knots::values;
use super::spline::{SplineArrays, SplineItems};
use crate::nurbs::{self, KnotVector};

/// The degree of a curve that none is given for.
pub(super) const DEGREE: usize = 3;

/// A NURBS curve in space: an isocurve, a boundary, a profile.
///
/// A frozen value: whatever changes a curve returns a new one.
///
/// Parameters
/// ----------
/// control_points : array_like of shape (n, 3) or (n, 2)
///     The control points, as they lie in space (not multiplied by weights); two columns lie in
///     z = 0.
/// weights : array_like of shape (n,), optional
///     Positive weights; without them the curve is polynomial.
/// degree : int, default 3
///     The degree, from 1 to 9.
/// knots : array_like of shape (n + degree + 1,), optional
///     The knots, non-decreasing; by default clamped and evenly spaced on [0, 1].
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
///     If control points, weights, degree and knots do not belong together, a number is not
///     finite, a weight is not positive, or the knots decrease or repeat too often.
///
/// See Also
/// --------
/// NurbsSurface.isocurve : Curves of a surface.
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
        let degree = optional_count("degree", degree)?.unwrap_or(DEGREE);
        let points = Numbers::points(control_points, "control_points")?;
        let points: Vec<DVec3> = points.as_slice()?.to_vec();
        let knots = match values(knots, "knots")? {
            Some(knots) => KnotVector::new(degree, knots)?,
            None => KnotVector::clamped_uniform(degree, points.len())?,
        };
        let core = nurbs::NurbsCurve::new(points, values(weights, "weights")?, knots)?;
        Self::new(control_points.py(), core)
    }

    /// The control points, as they lie in space: ndarray of shape (n, 3), read-only.
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

    /// First and last parameter.
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

    /// Whether the curve ends where it begins.
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

    /// The curve as plain lists and numbers, for JSON and the like.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``control_points``, ``weights`` (or None), ``degree`` and ``knots``: the arguments of
    ///     the constructor.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1)
    /// >>> line.to_dict().get("degree")
    /// 1
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays.to_dict(py, self.degree())
    }

    /// The curve that :meth:`to_dict` took apart.
    ///
    /// Parameters
    /// ----------
    /// data : dict
    ///     ``control_points`` and, if they are not to have the constructor's defaults,
    ///     ``weights``, ``degree`` and ``knots``.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are no control points in it, or as the constructor.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> circle = neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> neurbs.NurbsCurve.from_dict(circle.to_dict()) == circle
    /// True
    #[staticmethod]
    fn from_dict(data: &Bound<'_, PyAny>) -> PyResult<Self> {
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
