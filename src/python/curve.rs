//! `neurbs.NurbsCurve`.

use glam::DVec3;
use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray1, PyArray2, PyArrayDyn};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::algebra::{affine, values};
use super::arrays::{self, Numbers};
use super::construction::parametrization;
use super::errors::bad_argument;
use super::evaluation::outside;
use super::shapes::vector;
use crate::nurbs::{self, KnotVector, MAX_DERIVATIVE};

/// A NURBS curve in space: an isocurve, a boundary, a profile.
///
/// Parameters
/// ----------
/// control_points : array_like of shape (n, 3)
///     The control points, as they lie in space (not multiplied by weights).
/// weights : array_like of shape (n,), optional
///     Positive weights; without them the curve is polynomial.
/// degree : int, default 3
///     The degree, from 1 to 9.
/// knots : array_like of shape (n + degree + 1,), optional
///     The knots; by default clamped and evenly spaced on [0, 1].
///
/// Raises
/// ------
/// NeurbsError
///     If control points, weights, degree and knots do not belong together, a number is not
///     finite, a weight is not positive, or the knots decrease.
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
    control_points: Py<PyArray2<f64>>,
    weights: Option<Py<PyArray1<f64>>>,
    knots: Py<PyArray1<f64>>,
}

impl NurbsCurve {
    pub(super) fn new(py: Python<'_>, core: nurbs::NurbsCurve) -> PyResult<Self> {
        let count = core.control_points().len();
        let points = bytemuck::cast_slice(core.control_points());
        let control_points = arrays::constant::<f64, Ix2>(py, &[count, 3], points)?;
        let weights = core.weights().map(|w| arrays::constant::<f64, Ix1>(py, &[count], w));
        let knots = core.knots().as_slice();
        let knots = arrays::constant::<f64, Ix1>(py, &[knots.len()], knots)?;
        Ok(Self { control_points, weights: weights.transpose()?, knots, core })
    }

    pub(super) fn core(&self) -> &nurbs::NurbsCurve {
        &self.core
    }
}

#[pymethods]
impl NurbsCurve {
    #[new]
    #[pyo3(signature = (control_points, weights=None, degree=3, knots=None))]
    fn py_new(
        control_points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
        degree: usize,
        knots: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let points = Numbers::points(control_points, "control_points")?;
        let points: Vec<DVec3> = points.as_slice()?.to_vec();
        let knots = match values(knots, "knots")? {
            Some(knots) => KnotVector::new(degree, knots)?,
            None => KnotVector::clamped_uniform(degree, points.len())?,
        };
        let core = nurbs::NurbsCurve::new(points, values(weights, "weights")?, knots)?;
        Self::new(control_points.py(), core)
    }

    /// The curve through points, in their order.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3)
    ///     More points than the degree.
    /// degree : int, default 3
    ///     The degree.
    /// parametrization : {"chord", "uniform", "centripetal"}, default "chord"
    ///     How points get their parameters.
    /// closed : bool, default False
    ///     Whether the curve closes smoothly behind the last point, which is not the first again.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are too few points, one is not finite, or neighbours coincide.
    #[staticmethod]
    #[pyo3(signature = (points, degree=3, *, parametrization="chord", closed=false))]
    fn interpolate(
        points: &Bound<'_, PyAny>,
        degree: usize,
        parametrization: &str,
        closed: bool,
    ) -> PyResult<Self> {
        let parametrization = self::parametrization(parametrization)?;
        let numbers = Numbers::points(points, "points")?;
        let core =
            nurbs::NurbsCurve::interpolate(numbers.as_slice()?, degree, parametrization, closed)?;
        Self::new(points.py(), core)
    }

    /// The arc ``centre + x cos t + y sin t`` with t from 0 to ``angle``, exact.
    ///
    /// Parameters
    /// ----------
    /// centre, x, y : array_like of shape (3,)
    ///     The centre and two radii: of one length and at right angles for a circle, else of an
    ///     ellipse.
    /// angle : float, default 2π
    ///     How far it goes, in radians.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the angle is not between 0 and 2π.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// NurbsCurve(9 control points, degree 2, domain [0, 1], rational, closed)
    #[staticmethod]
    #[pyo3(
        signature = (centre, x, y, angle=std::f64::consts::TAU),
        text_signature = "(centre, x, y, angle=6.283185307179586)"
    )]
    fn arc(
        centre: &Bound<'_, PyAny>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        angle: f64,
    ) -> PyResult<Self> {
        let py = centre.py();
        let (centre, x, y) = (vector(centre, "centre")?, vector(x, "x")?, vector(y, "y")?);
        Self::new(py, nurbs::NurbsCurve::arc(centre, x, y, angle)?)
    }

    /// The control points, read-only float64 of shape (n, 3).
    #[getter]
    fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.control_points)
    }

    /// The weights, read-only float64 of shape (n,); None if the curve is polynomial.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.weights.as_ref().map(|weights| arrays::view(py, weights)).transpose()
    }

    /// The degree.
    #[getter]
    fn degree(&self) -> usize {
        self.core.knots().degree()
    }

    /// The knots, read-only.
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.knots)
    }

    /// First and last parameter.
    #[getter]
    fn domain(&self) -> (f64, f64) {
        self.core.knots().domain()
    }

    /// Whether the curve ends where it begins.
    #[getter]
    fn closed(&self) -> bool {
        self.core.closed()
    }

    /// Points of the curve.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether parameters outside the domain continue the outermost pieces.
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

    /// Derivatives of the curve.
    ///
    /// Parameters
    /// ----------
    /// u : array_like of shape (n,)
    ///     Parameters inside the domain.
    /// order : int, default 1
    ///     Highest order of differentiation, at most 18.
    /// extrapolate : bool, default False
    ///     Whether parameters outside the domain continue the outermost pieces.
    /// out : ndarray of shape (n, order + 1, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, order + 1, 3)
    ///     At ``[:, i]`` the i-th derivative; the points at ``[:, 0]``.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, the order is too high, or an array has the
    ///     wrong shape or dtype.
    #[pyo3(signature = (u, order=1, *, extrapolate=false, out=None))]
    fn derivatives<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        order: usize,
        extrapolate: bool,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (py, u) = (u.py(), Numbers::sequence(u, "u")?);
        // An order beyond the limit is refused by the core, before memory for it is asked for.
        let side = order.min(MAX_DERIVATIVE) + 1;
        let result = arrays::output(py, out, &[u.shape()[0], side, 3])?;
        self.write(py, &u, order, extrapolate, &result)?;
        Ok(result)
    }

    /// The same curve with more knots, each strictly inside the domain.
    fn insert_knots(&self, knots: &Bound<'_, PyAny>) -> PyResult<Self> {
        let numbers = Numbers::sequence(knots, "knots")?;
        Self::new(knots.py(), self.core.insert_knots(numbers.as_slice()?)?)
    }

    /// The curve with as few of some inner knots, by default of all, as a tolerance allows.
    #[pyo3(signature = (knots=None, *, tolerance))]
    fn remove_knots(
        &self,
        py: Python<'_>,
        knots: Option<&Bound<'_, PyAny>>,
        tolerance: f64,
    ) -> PyResult<Self> {
        let knots = values(knots, "knots")?;
        Self::new(py, self.core.remove_knots(knots.as_deref(), tolerance)?)
    }

    /// The same curve with a higher degree, clamped.
    #[pyo3(signature = (times=1))]
    fn elevate_degree(&self, py: Python<'_>, times: usize) -> PyResult<Self> {
        Self::new(py, self.core.elevate_degree(times)?)
    }

    /// The parts before and after a parameter strictly inside the domain.
    fn split(&self, py: Python<'_>, u: f64) -> PyResult<(Self, Self)> {
        let (before, after) = self.core.split(u)?;
        Ok((Self::new(py, before)?, Self::new(py, after)?))
    }

    /// The same curve run through backwards.
    fn reversed(&self, py: Python<'_>) -> PyResult<Self> {
        Self::new(py, self.core.reversed()?)
    }

    /// The curve moved by an affine map: a matrix of shape (3, 4) or (4, 4).
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::new(matrix.py(), self.core.transformed(&affine(matrix)?)?)
    }

    /// The curve as plain lists and numbers: the arguments of the constructor.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let list = |array: Bound<'py, PyAny>| array.call_method0("tolist");
        let dict = PyDict::new(py);
        dict.set_item("control_points", list(self.control_points(py)?)?)?;
        dict.set_item("weights", self.weights(py)?.map(list).transpose()?)?;
        dict.set_item("degree", self.degree())?;
        dict.set_item("knots", list(self.knots(py)?)?)?;
        Ok(dict)
    }

    /// The curve that :meth:`to_dict` took apart.
    #[staticmethod]
    fn from_dict(data: &Bound<'_, PyDict>) -> PyResult<Self> {
        let item = |name: &str| Ok::<_, PyErr>(data.get_item(name)?.filter(|item| !item.is_none()));
        let Some(points) = item("control_points")? else {
            return Err(bad_argument("data", "a dict with control_points", data));
        };
        let degree = item("degree")?.map_or(Ok(3), |degree| degree.extract())?;
        Self::py_new(&points, item("weights")?.as_ref(), degree, item("knots")?.as_ref())
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
        Ok(py.detach(|| self.core.derivatives(u, order, out, outside))?)
    }
}
