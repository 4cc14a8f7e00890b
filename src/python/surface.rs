//! `neurbs.NurbsSurface`.

use std::sync::OnceLock;

use glam::DVec3;
use numpy::ndarray::{Ix1, Ix2, Ix3};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments;
use super::arrays::{self, Numbers};
use super::errors::bad_argument;
use crate::error::Result;
use crate::nurbs::{self, ClosestPointSearch, KnotVector};

/// A tensor-product NURBS surface.
///
/// u runs along the rows of the control net, v along its columns.
///
/// Parameters
/// ----------
/// control_points : array_like of shape (n_u, n_v, 3)
///     The control net, as it lies in space (not multiplied by weights).
/// weights : array_like of shape (n_u, n_v), optional
///     Positive weights; without them the surface is polynomial.
/// degree : int or (int, int), default 3
///     Degrees in u and v, from 1 to 9.
/// knots : (array_like, array_like), optional
///     Knot vectors in u and v, with ``n + degree + 1`` knots each; by default clamped and evenly
///     spaced on [0, 1].
/// closed : bool or (bool, bool), default False
///     Directions in which the surface closes smoothly on itself behind the last row or column of
///     the net, with evenly spaced knots. The surface's own net then repeats its first rows.
///
/// Raises
/// ------
/// NeurbsError
///     If net, weights, degree and knots do not belong together, a number is not finite, a weight
///     is not positive, or a knot vector decreases.
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
    control_points: Py<PyArray3<f64>>,
    weights: Option<Py<PyArray2<f64>>>,
    knots: (Py<PyArray1<f64>>, Py<PyArray1<f64>>),
    /// Made by the first search for closest points.
    search: OnceLock<ClosestPointSearch>,
}

impl NurbsSurface {
    pub(super) fn new(py: Python<'_>, core: nurbs::NurbsSurface) -> PyResult<Self> {
        let (rows, cols) = core.shape();
        let net = bytemuck::cast_slice(core.control_points());
        let control_points = arrays::constant::<f64, Ix3>(py, &[rows, cols, 3], net)?;
        let weights = core.weights().map(|w| arrays::constant::<f64, Ix2>(py, &[rows, cols], w));
        let knots = |knots: &KnotVector| {
            let knots = knots.as_slice();
            arrays::constant::<f64, Ix1>(py, &[knots.len()], knots)
        };
        let knots = (knots(core.knots_u())?, knots(core.knots_v())?);
        let search = OnceLock::new();
        Ok(Self { control_points, weights: weights.transpose()?, knots, core, search })
    }

    pub(super) fn core(&self) -> &nurbs::NurbsSurface {
        &self.core
    }

    /// The prepared search for closest points.
    pub(super) fn search(&self) -> Result<&ClosestPointSearch> {
        if let Some(search) = self.search.get() {
            return Ok(search);
        }
        // Two threads may prepare it at once; the first to end is kept.
        let search = ClosestPointSearch::new(&self.core)?;
        Ok(self.search.get_or_init(|| search))
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
        let weights = self::weights(weights, shape)?;
        let (degree, closed) = (degrees(degree)?, self::closed(closed)?);
        let core = match knots {
            None => nurbs::NurbsSurface::periodic(&net, weights.as_deref(), shape, degree, closed)?,
            Some(knots) if closed == (false, false) => {
                let (u, v) = knot_vectors(knots, degree)?;
                nurbs::NurbsSurface::new(net, weights, u, v)?
            }
            Some(knots) => return Err(bad_argument("knots", "None with closed", knots)),
        };
        Self::new(py, core)
    }

    /// The control net, read-only float64 of shape (n_u, n_v, 3).
    #[getter]
    fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.control_points)
    }

    /// The weights, read-only float64 of shape (n_u, n_v); None if the surface is polynomial.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.weights.as_ref().map(|weights| arrays::view(py, weights)).transpose()
    }

    /// The degrees in u and v.
    #[getter]
    fn degree(&self) -> (usize, usize) {
        (self.core.knots_u().degree(), self.core.knots_v().degree())
    }

    /// The knot vectors in u and v, read-only.
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        Ok((arrays::view(py, &self.knots.0)?, arrays::view(py, &self.knots.1)?))
    }

    /// The parameter ranges: ((u first, u last), (v first, v last)).
    #[getter]
    fn domain(&self) -> ((f64, f64), (f64, f64)) {
        (self.core.knots_u().domain(), self.core.knots_v().domain())
    }

    /// Which directions end where they begin: (in u, in v).
    #[getter]
    fn closed(&self) -> (bool, bool) {
        self.core.closed()
    }

    /// The surface as plain lists and numbers, for JSON and the like.
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
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> neurbs.NurbsSurface.from_dict(plane.to_dict()) == plane
    /// True
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let list = |array: Bound<'py, PyAny>| array.call_method0("tolist");
        let weights = self.weights(py)?.map(list).transpose()?;
        let (u, v) = self.knots(py)?;
        let dict = PyDict::new(py);
        dict.set_item("control_points", list(self.control_points(py)?)?)?;
        dict.set_item("weights", weights)?;
        dict.set_item("degree", [self.degree().0, self.degree().1])?;
        dict.set_item("knots", [list(u)?, list(v)?])?;
        Ok(dict)
    }

    /// The surface that :meth:`to_dict` took apart.
    ///
    /// Parameters
    /// ----------
    /// data : dict
    ///     ``control_points`` and, if they are not to have the constructor's defaults,
    ///     ``weights``, ``degree`` and ``knots``.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are no control points in it, or as the constructor.
    #[staticmethod]
    fn from_dict(data: &Bound<'_, PyDict>) -> PyResult<Self> {
        let item = |name: &str| Ok::<_, PyErr>(data.get_item(name)?.filter(|item| !item.is_none()));
        let Some(net) = item("control_points")? else {
            return Err(bad_argument("data", "a dict with control_points", data));
        };
        let (weights, degree, knots) = (item("weights")?, item("degree")?, item("knots")?);
        Self::py_new(&net, weights.as_ref(), degree.as_ref(), knots.as_ref(), None)
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

/// One value for both directions, or two.
pub(super) fn both<'py, T: Clone + FromPyObjectOwned<'py>>(
    name: &str,
    must: &str,
    value: Option<&Bound<'py, PyAny>>,
    default: T,
) -> PyResult<(T, T)> {
    let Some(value) = value else { return Ok((default.clone(), default)) };
    if let Ok(both) = value.extract::<T>() {
        return Ok((both.clone(), both));
    }
    let refused = || bad_argument(name, must, value);
    let [u, v] = arguments::two(value).ok_or_else(refused)?;
    let extract = |value: Bound<'py, PyAny>| value.extract::<T>().map_err(|_| refused());
    Ok((extract(u)?, extract(v)?))
}

/// One degree for both directions, or two.
pub(super) fn degrees(value: Option<&Bound<'_, PyAny>>) -> PyResult<(usize, usize)> {
    both("degree", "an integer from 0 or two of them", value, 3)
}

/// Whether directions are closed: one answer for both, or two.
pub(super) fn closed(value: Option<&Bound<'_, PyAny>>) -> PyResult<(bool, bool)> {
    both("closed", "a bool or two of them", value, false)
}

/// Knot vectors for u and v.
pub(super) fn knot_vectors<'py>(
    knots: &Bound<'py, PyAny>,
    degree: (usize, usize),
) -> PyResult<(KnotVector, KnotVector)> {
    let refused = || bad_argument("knots", "two sequences, for u and v", knots);
    let [u, v] = arguments::two(knots).ok_or_else(refused)?;
    let vector = |name, degree, knots: &Bound<'py, PyAny>| -> PyResult<KnotVector> {
        let knots = Numbers::sequence(knots, name)?;
        Ok(KnotVector::new(degree, knots.as_slice()?.to_vec())?)
    };
    Ok((vector("knots in u", degree.0, &u)?, vector("knots in v", degree.1, &v)?))
}

/// A net of points and its shape.
pub(super) fn net(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<DVec3>, (usize, usize))> {
    let expected = "real numbers of shape (n_u, n_v, 3)";
    let net = Numbers::new(value, name, expected, &[&[None, None, Some(3)]])?;
    Ok((net.as_slice()?.to_vec(), (net.shape()[0], net.shape()[1])))
}

/// Weights of a net of this shape.
pub(super) fn weights(
    value: Option<&Bound<'_, PyAny>>,
    (rows, cols): (usize, usize),
) -> PyResult<Option<Vec<f64>>> {
    let Some(value) = value else { return Ok(None) };
    let expected = format!("real numbers of shape ({rows}, {cols}), as the net");
    let weights = Numbers::new(value, "weights", &expected, &[&[Some(rows), Some(cols)]])?;
    Ok(Some(weights.as_slice()?.to_vec()))
}
