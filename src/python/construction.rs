//! `neurbs.NurbsSurface`: interpolation, approximation and least-squares fits of points.

use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::arguments::{choice, optional_real, pair};
use super::arrays::{self, Numbers};
use super::call;
use super::errors::NeurbsError;
use super::surface::NurbsSurface;
use super::surface_arguments::{closed, degrees, knot_vectors, net, weights};
use crate::fit::{FitOptions, fit};
use crate::nurbs::{self, GridOptions, Parametrization};

/// A parametrization by its name, by default chord length.
pub(super) fn parametrization(name: Option<&Bound<'_, PyAny>>) -> PyResult<Parametrization> {
    let all =
        [Parametrization::ChordLength, Parametrization::Uniform, Parametrization::Centripetal];
    let name_of = |one| match one {
        Parametrization::ChordLength => "chord",
        Parametrization::Uniform => "uniform",
        Parametrization::Centripetal => "centripetal",
    };
    let chosen = |name| choice("parametrization", &all, name_of, name);
    name.map_or(Ok(Parametrization::default()), chosen)
}

fn grid_options(
    degree: Option<&Bound<'_, PyAny>>,
    name: Option<&Bound<'_, PyAny>>,
    closed: Option<&Bound<'_, PyAny>>,
) -> PyResult<GridOptions> {
    let (degree, closed) = (degrees(degree)?, self::closed(closed)?);
    Ok(GridOptions { degree, parametrization: parametrization(name)?, closed })
}

type Vectors<'py> = Bound<'py, PyArrayDyn<f64>>;

#[pymethods]
impl NurbsSurface {
    /// Interpolate a grid of points.
    ///
    /// Parameters
    /// ----------
    /// grid : array_like of shape (n, m, 3)
    ///     Points in rows and columns.
    /// degree : int or (int, int), default 3
    ///     Degrees in u and v, each lower than the number of points in that direction.
    /// parametrization : {"chord", "uniform", "centripetal"}, default "chord"
    ///     How parameters are spaced: in proportion to the distances between points, evenly, or in
    ///     proportion to the square roots of the distances.
    /// closed : bool or (bool, bool), default False
    ///     Whether the surface is smoothly closed in u and v. The first row or column must not be
    ///     repeated at the end.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     On [0, 1]², with one control point per point and ``degree`` more rows in closed
    ///     directions. It passes through the points at :meth:`grid_parameters`.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are too few points, one is not finite, or neighboring rows coincide.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A9.4: banded systems, O(points · degree).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> x, y = np.mgrid[0:5, 0:6]
    /// >>> grid = np.stack([x, y, np.sin(x) * y], axis=-1)
    /// >>> surface = neurbs.NurbsSurface.interpolate(grid)
    /// >>> u, v = neurbs.NurbsSurface.grid_parameters(grid)
    /// >>> np.allclose(surface.evaluate_grid(u, v), grid)
    /// True
    #[staticmethod]
    #[pyo3(
        signature = (grid, degree=None, *, parametrization=None, closed=None),
        text_signature = "(grid, degree=3, *, parametrization='chord', closed=False)"
    )]
    fn interpolate(
        grid: &Bound<'_, PyAny>,
        degree: Option<&Bound<'_, PyAny>>,
        parametrization: Option<&Bound<'_, PyAny>>,
        closed: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let options = grid_options(degree, parametrization, closed)?;
        let (numbers, shape) = net(grid, "grid")?;
        let points = numbers.as_slice()?;
        let core = call::run(grid.py(), None, |watcher| {
            nurbs::NurbsSurface::interpolate(points, shape, &options, watcher)
        })?;
        Self::new(grid.py(), core)
    }

    /// The parameters at which :meth:`interpolate` passes through the points of a grid.
    ///
    /// Parameters
    /// ----------
    /// grid, degree, parametrization, closed
    ///     As in :meth:`interpolate`.
    /// out : (ndarray, ndarray) of shape (n,) and (m,), optional
    ///     Where to write the results: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// u : ndarray of shape (n,)
    /// v : ndarray of shape (m,)
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     As in :meth:`interpolate`.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, section 9.2.1 and A9.3: averages over rows and columns, without those that
    /// collapse to one point.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> u, v = neurbs.NurbsSurface.grid_parameters([[[0, 0, 0], [0, 3, 0], [0, 4, 0]]] * 2 + [
    /// ...     [[1, 0, 0], [1, 3, 0], [1, 4, 0]]], parametrization="uniform")
    /// >>> u
    /// array([0. , 0.5, 1. ])
    #[staticmethod]
    #[pyo3(
        signature = (grid, degree=None, *, parametrization=None, closed=None, out=None),
        text_signature = "(grid, degree=3, *, parametrization='chord', closed=False, out=None)"
    )]
    fn grid_parameters<'py>(
        grid: &Bound<'py, PyAny>,
        degree: Option<&Bound<'py, PyAny>>,
        parametrization: Option<&Bound<'py, PyAny>>,
        closed: Option<&Bound<'py, PyAny>>,
        out: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<(Vectors<'py>, Vectors<'py>)> {
        let options = grid_options(degree, parametrization, closed)?;
        let (py, (numbers, shape)) = (grid.py(), net(grid, "grid")?);
        let points = numbers.as_slice()?;
        let (u, v) = call::run(py, None, |watcher| {
            nurbs::NurbsSurface::grid_parameters(points, shape, &options, watcher)
        })?;
        let (out_u, out_v) = out.unzip();
        Ok((arrays::filled(py, out_u.as_ref(), &u)?, arrays::filled(py, out_v.as_ref(), &v)?))
    }

    /// Approximate a grid of points by a surface with a smaller net.
    ///
    /// Parameters
    /// ----------
    /// grid : array_like of shape (n, m, 3)
    ///     Points in rows and columns.
    /// net : (int, int)
    ///     Numbers of control points along u and v: more than the degree, at most the number of
    ///     points. In closed directions, repeated control points are not included.
    /// degree, parametrization, closed
    ///     As in :meth:`interpolate`.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     On [0, 1]²: least squares along u, then along v.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the net does not suit the grid or the degree, or as in :meth:`interpolate`.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.fit : For scattered points with known parameters.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, section 9.4: knots follow the density of the points. Banded normal
    /// equations, O(points · degree²).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> x, y = np.mgrid[0:1:30j, 0:1:40j]
    /// >>> grid = np.stack([x, y, np.sin(3 * x) * y], axis=-1)
    /// >>> surface = neurbs.NurbsSurface.approximate(grid, (8, 6))
    /// >>> surface
    /// NurbsSurface(net 8 × 6, degree (3, 3), domain [0, 1] × [0, 1], polynomial, open)
    /// >>> surface.closest_points(grid.reshape(-1, 3)).distances.max() < 1e-2
    /// np.True_
    #[staticmethod]
    #[pyo3(
        signature = (grid, net, degree=None, *, parametrization=None, closed=None),
        text_signature = "(grid, net, degree=3, *, parametrization='chord', closed=False)"
    )]
    fn approximate(
        grid: &Bound<'_, PyAny>,
        net: &Bound<'_, PyAny>,
        degree: Option<&Bound<'_, PyAny>>,
        parametrization: Option<&Bound<'_, PyAny>>,
        closed: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let options = grid_options(degree, parametrization, closed)?;
        let net = pair("net", net)?;
        let (numbers, shape) = self::net(grid, "grid")?;
        let points = numbers.as_slice()?;
        let core = call::run(grid.py(), None, |watcher| {
            nurbs::NurbsSurface::approximate(points, shape, net, &options, watcher)
        })?;
        Self::new(grid.py(), core)
    }

    /// Fit a surface to points with known parameters, by least squares.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3)
    ///     Points in space, in any order.
    /// uv : array_like of shape (n, 2)
    ///     Their parameters within the domain, which is [0, 1]² unless ``knots`` are given.
    /// net : (int, int), optional
    ///     Numbers of control points along u and v. In closed directions, repeated control points
    ///     are not included. Required without ``knots``.
    /// degree : int or (int, int), default 3
    ///     Degrees in u and v.
    /// knots : (array_like, array_like), optional
    ///     Knot vectors in u and v; periodic in closed directions. Evenly spaced by default.
    /// weights : array_like of shape (n,), optional
    ///     Weight of each squared distance, at least 0.
    /// fairness : float, default 1e-6
    ///     Weight of the thin-plate energy ∫∫ S_uu² + 2 S_uv² + S_vv², relative to the sum of the
    ///     squared distances; 0 for none.
    /// closed : bool or (bool, bool), default False
    ///     Whether the surface is smoothly closed in u and v.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If array lengths disagree, a parameter lies outside the domain, or the points do not
    ///     determine the net: choose a smaller net or more fairness.
    ///
    /// Notes
    /// -----
    /// Sparse normal equations, solved by Cholesky factorization. Memory is about 90 bytes per
    /// point.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> uv = np.random.default_rng(0).random((500, 2))
    /// >>> points = np.column_stack([uv, uv[:, 0] * uv[:, 1]])
    /// >>> surface = neurbs.NurbsSurface.fit(points, uv, net=(5, 5))
    /// >>> np.abs(surface.evaluate(uv) - points).max() < 1e-6
    /// np.True_
    #[staticmethod]
    #[pyo3(
        signature = (
            points, uv, *, net=None, degree=None, knots=None, weights=None, fairness=None,
            closed=None
        ),
        text_signature = "(points, uv, *, net=None, degree=3, knots=None, weights=None, \
                          fairness=1e-6, closed=False)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn fit(
        points: &Bound<'_, PyAny>,
        uv: &Bound<'_, PyAny>,
        net: Option<&Bound<'_, PyAny>>,
        degree: Option<&Bound<'_, PyAny>>,
        knots: Option<&Bound<'_, PyAny>>,
        weights: Option<&Bound<'_, PyAny>>,
        fairness: Option<&Bound<'_, PyAny>>,
        closed: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = points.py();
        let (degree, closed) = (degrees(degree)?, self::closed(closed)?);
        let fairness = optional_real("fairness", fairness)?.unwrap_or(1e-6);
        let net = net.map(|net| pair("net", net)).transpose()?;
        let options = match (net, knots) {
            (Some(net), None) => FitOptions { fairness, ..FitOptions::new(net, degree, closed)? },
            (None, Some(knots)) => {
                let (knots_u, knots_v) = knot_vectors(knots, degree)?;
                FitOptions { knots_u, knots_v, closed, fairness }
            }
            _ => {
                let message = "one of net and knots must be given, got both or neither";
                return Err(NeurbsError::new_err(message));
            }
        };
        let points = Numbers::points(points, "points")?;
        let uv = Numbers::parameters(uv)?;
        let weights = weights.map(|weights| Numbers::sequence(weights, "weights")).transpose()?;
        let weights = weights.as_ref().map(Numbers::as_slice).transpose()?;
        let (points, uv) = (points.as_slice()?, uv.as_slice()?);
        let core = call::run(py, None, |watcher| fit(points, uv, weights, &options, watcher))?;
        Self::new(py, core)
    }

    /// The Bézier patch with these control points.
    ///
    /// Parameters
    /// ----------
    /// net : array_like of shape (n, m, 3)
    ///     Control points, 2 to 10 along each side.
    /// weights : array_like of shape (n, m), optional
    ///     Positive weights.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Of degree (n - 1, m - 1) on [0, 1]².
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a side has too few or too many control points.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, section 1.5.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.bezier([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]])
    /// NurbsSurface(net 2 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
    #[staticmethod]
    #[pyo3(signature = (net, weights=None))]
    fn bezier(net: &Bound<'_, PyAny>, weights: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let (numbers, shape) = self::net(net, "net")?;
        let (points, weights) = (numbers.as_slice()?.to_vec(), self::weights(weights, shape)?);
        Self::new(net.py(), nurbs::NurbsSurface::bezier(points, weights, shape)?)
    }
}
