//! The class `neurbs.NurbsSurface`.

use std::sync::OnceLock;

use glam::DVec3;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::call::Watcher;
use super::errors::bad_argument;
use super::spline_arrays::{SplineArrays, SplineItems};
use super::surface_arguments::{self, degrees, knot_vectors, net};
use crate::error::Result;
use crate::nurbs::{self, ClosestPointSearch, HeightSearch};

/// A tensor-product NURBS surface.
///
/// Immutable: every operation returns a new surface. u runs along the rows of the control net, v
/// along its columns.
///
/// Parameters
/// ----------
/// control_points : array_like of shape (n_u, n_v, 3)
///     The control net in Cartesian coordinates (not multiplied by weights).
/// weights : array_like of shape (n_u, n_v), optional
///     Positive weights. Without weights the surface is polynomial.
/// degree : int or (int, int), default 3
///     Degrees in u and v, from 1 to 25.
/// knots : (array_like, array_like), optional
///     Non-decreasing knot vectors in u and v with ``n + degree + 1`` knots each, clamped or not.
///     Inner knots have a multiplicity of at most ``degree``. By default clamped and evenly spaced
///     on [0, 1].
/// closed : bool or (bool, bool), default False
///     Whether the surface is smoothly closed in u and v, with evenly spaced knots. The first row
///     or column must not be repeated at the end. The net of the result repeats its first
///     ``degree`` rows or columns.
///
/// Attributes
/// ----------
/// control_points : ndarray of shape (n_u, n_v, 3)
/// weights : ndarray of shape (n_u, n_v) or None
/// degree : (int, int)
/// knots : (ndarray, ndarray)
/// domain : ((float, float), (float, float))
/// closed : (bool, bool)
///
/// Raises
/// ------
/// NeurbsError
///     If array shapes and degrees disagree, a number is not finite, a weight is not positive, or a
///     knot vector decreases or repeats a knot too often.
///
/// See Also
/// --------
/// NurbsSurface.interpolate, NurbsSurface.approximate : Surfaces from a grid of points.
/// NurbsSurface.fit : A surface from scattered points with known parameters.
/// reconstruct : A surface from scattered points.
/// NurbsCurve : The class of isocurves and boundaries.
///
/// Notes
/// -----
/// With basis functions N of degrees p and q, control points P and weights w, the point at (u, v)
/// is ``Σ N_ip(u) N_jq(v) w_ij P_ij / Σ N_ip(u) N_jq(v) w_ij`` [1]_.
///
/// References
/// ----------
/// .. [1] L. Piegl and W. Tiller, *The NURBS Book*, second edition, Springer 1997, chapter 4.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
/// >>> surface
/// NurbsSurface(net 2 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
/// >>> surface.evaluate([[0.5, 0.5]])
/// array([[0.5 , 0.5 , 0.25]])
#[pyclass(frozen, module = "neurbs")]
pub(super) struct NurbsSurface {
    core: nurbs::NurbsSurface,
    arrays: SplineArrays,
    /// Built by the first search for closest points.
    search: OnceLock<ClosestPointSearch>,
    /// Built by the first search for heights.
    height_search: OnceLock<HeightSearch>,
}

impl NurbsSurface {
    pub(super) fn new(py: Python<'_>, core: nurbs::NurbsSurface) -> PyResult<Self> {
        let knots = [core.knots_u(), core.knots_v()];
        let arrays = SplineArrays::new(py, core.control_points(), core.weights(), &knots)?;
        Ok(Self { core, arrays, search: OnceLock::new(), height_search: OnceLock::new() })
    }

    pub(super) fn core(&self) -> &nurbs::NurbsSurface {
        &self.core
    }

    /// The search structure for closest points, built on first use.
    pub(super) fn search(&self, watcher: &mut Watcher) -> Result<&ClosestPointSearch> {
        if let Some(search) = self.search.get() {
            return Ok(search);
        }
        // Two threads may build it at the same time; the first one to finish is kept.
        let search = ClosestPointSearch::observed(&self.core, watcher)?;
        Ok(self.search.get_or_init(|| search))
    }

    /// The search structure for heights, built on first use.
    pub(super) fn height_search(&self, watcher: &mut Watcher) -> Result<&HeightSearch> {
        if let Some(search) = self.height_search.get() {
            return Ok(search);
        }
        // As for closest points.
        let search = HeightSearch::observed(&self.core, watcher)?;
        Ok(self.height_search.get_or_init(|| search))
    }
}

#[pymethods]
impl NurbsSurface {
    #[new]
    #[pyo3(
        signature = (control_points, weights=None, degree=None, knots=None, *, closed=None),
        text_signature = "(control_points, weights=None, degree=3, knots=None, *, closed=False)"
    )]
    fn py_new(
        control_points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
        degree: Option<&Bound<'_, PyAny>>,
        knots: Option<&Bound<'_, PyAny>>,
        closed: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = control_points.py();
        let (net, shape) = net(control_points, "control_points")?;
        let net: &[DVec3] = net.as_slice()?;
        let weights = surface_arguments::weights(weights, shape)?;
        let (degree, closed) = (degrees(degree)?, surface_arguments::closed(closed)?);
        let core = match knots {
            None => nurbs::NurbsSurface::periodic(net, weights.as_deref(), shape, degree, closed)?,
            Some(knots) if closed == (false, false) => {
                let (u, v) = knot_vectors(knots, degree)?;
                nurbs::NurbsSurface::new(net.to_vec(), weights, u, v)?
            }
            Some(knots) => return Err(bad_argument("knots", "None if closed", knots)),
        };
        Self::new(py, core)
    }

    /// The control net in Cartesian coordinates: ndarray of shape (n_u, n_v, 3), read-only.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.plane([0, 0, 0], [2, 0, 0], [0, 1, 0]).control_points[1, 0]
    /// array([2., 0., 0.])
    #[getter]
    fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arrays.control_points(py)
    }

    /// The weights: ndarray of shape (n_u, n_v), read-only; None if the surface is polynomial.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.sphere([0, 0, 0], 1).weights[0, :2].round(3)
    /// array([1.   , 0.707])
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.arrays.weights(py)
    }

    /// The degrees in u and v.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1).degree
    /// (2, 1)
    #[getter]
    fn degree(&self) -> (usize, usize) {
        (self.core.knots_u().degree(), self.core.knots_v().degree())
    }

    /// The knot vectors in u and v: two ndarrays of shape (n + degree + 1,), read-only.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1).knots[1]
    /// array([0., 0., 1., 1.])
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        Ok((self.arrays.knots(py, 0)?, self.arrays.knots(py, 1)?))
    }

    /// The parameter ranges: ((u first, u last), (v first, v last)).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.torus([0, 0, 0], 3, 1).domain
    /// ((0.0, 1.0), (0.0, 1.0))
    #[getter]
    fn domain(&self) -> ((f64, f64), (f64, f64)) {
        (self.core.knots_u().domain(), self.core.knots_v().domain())
    }

    /// Whether the surface is closed: (in u, in v).
    ///
    /// A sheet is open, a tube closed in one direction, a torus in both.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.torus([0, 0, 0], 3, 1).closed
    /// (True, True)
    #[getter]
    fn closed(&self) -> (bool, bool) {
        self.core.closed()
    }

    /// The surface as a dict of plain lists and numbers, for example for JSON.
    ///
    /// Returns
    /// -------
    /// dict
    ///     The arguments of the constructor: ``control_points``, ``weights`` (or None), ``degree`` and
    ///     ``knots``.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.from_dict : The inverse operation.
    ///
    /// Examples
    /// --------
    /// >>> import json, neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> text = json.dumps(plane.to_dict())
    /// >>> neurbs.NurbsSurface.from_dict(json.loads(text)) == plane
    /// True
    pub(super) fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays.to_dict(py, [self.degree().0, self.degree().1])
    }

    /// Make a surface from a dict returned by :meth:`to_dict`.
    ///
    /// Parameters
    /// ----------
    /// data : dict
    ///     ``control_points``, and optionally ``weights``, ``degree`` and ``knots``. Missing items
    ///     have the constructor's defaults.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are no control points, or as in the constructor.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> net = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]]
    /// >>> neurbs.NurbsSurface.from_dict({"control_points": net, "degree": 1})
    /// NurbsSurface(net 2 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
    #[staticmethod]
    pub(super) fn from_dict(data: &Bound<'_, PyAny>) -> PyResult<Self> {
        let SplineItems { control_points, weights, degree, knots } = SplineItems::new(data)?;
        Self::py_new(&control_points, weights.as_ref(), degree.as_ref(), knots.as_ref(), None)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.core == other.core
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let parts = (self.control_points(py)?, self.weights(py)?, self.degree(), self.knots(py)?);
        (py.get_type::<Self>(), parts).into_bound_py_any(py)
    }

    fn __repr__(&self) -> String {
        let (rows, cols) = self.core.shape();
        let kind = if self.core.weights().is_some() { "rational" } else { "polynomial" };
        let ((a, b), (c, d)) = self.domain();
        let closed = match self.core.closed() {
            (false, false) => "open",
            (true, false) => "closed in u",
            (false, true) => "closed in v",
            (true, true) => "closed in u and v",
        };
        let degree = self.degree();
        format!(
            "NurbsSurface(net {rows} × {cols}, degree {degree:?}, domain [{a}, {b}] × [{c}, {d}], \
             {kind}, {closed})"
        )
    }
}
