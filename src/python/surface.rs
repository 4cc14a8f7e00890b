//! `neurbs.NurbsSurface`.

use numpy::ndarray::{Ix1, Ix2, Ix3};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayDyn};
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::errors::bad_argument;
use super::mesh::TriangleMesh;
use super::{arguments, call};
use crate::error::Result;
use crate::mesh::UniformGrid;
use crate::nurbs::{self, KnotVector};

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
/// NurbsSurface(net 2 × 2, degree (1, 1), polynomial)
/// >>> surface.evaluate([[0.5, 0.5]])
/// array([[0.5 , 0.5 , 0.25]])
#[pyclass(frozen, module = "neurbs")]
pub(super) struct NurbsSurface {
    core: nurbs::NurbsSurface,
    control_points: Py<PyArray3<f64>>,
    weights: Option<Py<PyArray2<f64>>>,
    knots: (Py<PyArray1<f64>>, Py<PyArray1<f64>>),
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
        Ok(Self { control_points, weights: weights.transpose()?, knots, core })
    }

    pub(super) fn core(&self) -> &nurbs::NurbsSurface {
        &self.core
    }

    /// Maps parameters to points or normals, into `out` or a new array.
    fn map<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
        f: impl FnOnce(&nurbs::NurbsSurface, Scattered<'_>, &mut call::Watcher) -> Result<()> + Send,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = uv.py();
        let uv = Numbers::parameters(uv)?;
        let result = arrays::output(py, out, &[uv.shape()[0], 3])?;
        let (core, uv) = (&self.core, uv.as_slice()?);
        let mut writable = arrays::writable(&result)?;
        let out = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        call::run(py, None, |watcher| f(core, Scattered { uv, out }, watcher))?;
        drop(writable);
        Ok(result)
    }
}

/// Parameters and the place for what belongs to them.
struct Scattered<'a> {
    uv: &'a [glam::DVec2],
    out: &'a mut [glam::DVec3],
}

#[pymethods]
impl NurbsSurface {
    #[new]
    #[pyo3(
        signature = (control_points, weights=None, degree=None, knots=None),
        text_signature = "(control_points, weights=None, degree=3, knots=None)"
    )]
    fn py_new<'py>(
        control_points: &Bound<'py, PyAny>,
        weights: Option<&Bound<'py, PyAny>>,
        degree: Option<&Bound<'py, PyAny>>,
        knots: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let expected = "real numbers of shape (n_u, n_v, 3)";
        let shapes: &[&[_]] = &[&[None, None, Some(3)]];
        let net = Numbers::new(control_points, "control_points", expected, shapes)?;
        let (rows, cols) = (net.shape()[0], net.shape()[1]);
        let weights = weights.map(|weights| {
            let expected = format!("real numbers of shape ({rows}, {cols}), as the net");
            Numbers::new(weights, "weights", &expected, &[&[Some(rows), Some(cols)]])
        });
        let weights = match weights.transpose()? {
            Some(weights) => Some(weights.as_slice()?.to_vec()),
            None => None,
        };
        let degree = degree.map_or(Ok((3, 3)), degrees)?;
        let (knots_u, knots_v) = match knots {
            None => (
                KnotVector::clamped_uniform(degree.0, rows)?,
                KnotVector::clamped_uniform(degree.1, cols)?,
            ),
            Some(knots) => {
                let refused = || bad_argument("knots", "two sequences, for u and v", knots);
                let [u, v] = arguments::two(knots).ok_or_else(refused)?;
                let vector = |name, degree, knots: &Bound<'py, PyAny>| -> PyResult<KnotVector> {
                    let knots = Numbers::sequence(knots, name)?;
                    Ok(KnotVector::new(degree, knots.as_slice()?.to_vec())?)
                };
                (vector("knots in u", degree.0, &u)?, vector("knots in v", degree.1, &v)?)
            }
        };
        let net = net.as_slice()?.to_vec();
        Self::new(control_points.py(), nurbs::NurbsSurface::new(net, weights, knots_u, knots_v)?)
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

    /// Points of the surface at scattered parameters.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2)
    ///     Parameters inside the domain.
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
    #[pyo3(signature = (uv, *, out=None))]
    fn evaluate<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.map(uv, out, |core, at, watcher| core.evaluate(at.uv, at.out, watcher))
    }

    /// Unit normals of the surface, in the direction of ∂/∂u × ∂/∂v, at scattered parameters.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2)
    ///     Parameters inside the domain.
    /// out : ndarray of shape (n, 3), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n, 3)
    ///     ``out``, or a new array. Where the tangents give no normal it is the one a small step
    ///     towards the middle of the domain, and zero if there is none either.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    #[pyo3(signature = (uv, *, out=None))]
    fn normals<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.map(uv, out, |core, at, watcher| core.normals(at.uv, at.out, watcher))
    }

    /// Points of the surface on the grid of all pairs of ``u`` and ``v``.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,) and (m,)
    ///     Parameters inside the domain.
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
    #[pyo3(signature = (u, v, *, out=None))]
    fn evaluate_grid<'py>(
        &self,
        u: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = u.py();
        let (u, v) = (Numbers::sequence(u, "u")?, Numbers::sequence(v, "v")?);
        let result = arrays::output(py, out, &[u.shape()[0], v.shape()[0], 3])?;
        let (core, u, v) = (&self.core, u.as_slice()?, v.as_slice()?);
        let mut writable = arrays::writable(&result)?;
        let points = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        call::run(py, None, |watcher| core.evaluate_grid(u, v, points, None, watcher))?;
        drop(writable);
        Ok(result)
    }

    /// Turn the surface into triangles.
    ///
    /// Parameters
    /// ----------
    /// shape : (int, int), optional
    ///     Vertices along u and v of a uniform grid, at least 2 each; by default four cells to a
    ///     knot span (fewer for very large nets), and at least 33 vertices a side.
    ///
    /// Returns
    /// -------
    /// TriangleMesh
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a side is too small, or there would be more than 100 million triangles.
    #[pyo3(signature = (*, shape=None))]
    fn tessellate(
        &self,
        py: Python<'_>,
        shape: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<TriangleMesh> {
        let grid = match shape {
            None => UniformGrid::for_surface(&self.core)?,
            Some(shape) => {
                let (n_u, n_v) = arguments::pair("shape", shape)?;
                UniformGrid::new(n_u, n_v)?
            }
        };
        TriangleMesh::of_surface(py, &self.core, grid, None)
    }

    fn __repr__(&self) -> String {
        let (rows, cols) = self.core.shape();
        let kind = if self.core.weights().is_some() { "rational" } else { "polynomial" };
        format!("NurbsSurface(net {rows} × {cols}, degree {:?}, {kind})", self.degree())
    }
}

/// One degree for both directions, or two.
fn degrees(value: &Bound<'_, PyAny>) -> PyResult<(usize, usize)> {
    if let Ok(both) = value.extract::<usize>() {
        return Ok((both, both));
    }
    let refused = || bad_argument("degree", "an integer from 0 or two of them", value);
    let [u, v] = arguments::two(value).ok_or_else(refused)?;
    let degree = |value: Bound<'_, PyAny>| value.extract().map_err(|_| refused());
    Ok((degree(u)?, degree(v)?))
}
