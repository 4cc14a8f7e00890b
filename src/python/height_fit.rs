//! The functions `neurbs.fit_heights` and `neurbs.fit_weights`.

use glam::DVec3;
use numpy::PyArrayDyn;
use numpy::ndarray::IxDyn;
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::pickling::{Reduced, read_only, reduced};
use super::surface::NurbsSurface;
use super::surface_arguments::degrees;
use super::{arguments, call};
use crate::cloud;
use crate::fit::{self, HeightOptions};

/// The result of :func:`fit_heights`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct HeightFit {
    /// The surface, over a rectangle of the base plane.
    #[pyo3(get)]
    surface: Py<NurbsSurface>,
    /// The points' parameters, float64 of shape (n, 2).
    #[pyo3(get)]
    uv: Py<PyArrayDyn<f64>>,
    /// Heights of the points above the surface, float64 of shape (n,), in the points' unit.
    #[pyo3(get)]
    residuals: Py<PyArrayDyn<f64>>,
    /// The fairness weight of the fit.
    #[pyo3(get)]
    fairness: f64,
}

#[pymethods]
impl HeightFit {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        py: Python<'_>,
        surface: Py<NurbsSurface>,
        uv: Py<PyArrayDyn<f64>>,
        residuals: Py<PyArrayDyn<f64>>,
        fairness: f64,
    ) -> PyResult<Self> {
        let (uv, residuals) = (read_only(py, uv)?, read_only(py, residuals)?);
        Ok(Self { surface, uv, residuals, fairness })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["surface", "uv", "residuals", "fairness"])
    }

    fn __repr__(&self) -> String {
        let (rows, cols) = self.surface.get().core().shape();
        format!("HeightFit(net {rows} × {cols}, fairness {:e})", self.fairness)
    }
}

/// Fit a height field z = f(x, y), or one along another direction.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3)
///     Finite points, at least four distinct, not all on one line.
/// net : (int, int)
///     Rows and columns of the control net, along x and y. For other directions of the heights:
///     along the directions of largest and smallest scatter in the base plane.
/// up : array_like of shape (3,), default (0, 0, 1)
///     Direction of the heights, of any length.
/// degree : int or (int, int), default 3
///     Degrees in u and v; lower where the net has too few rows or columns.
/// weights : array_like of shape (n,), optional
///     Weight of each squared height residual, at least 0.
/// fairness : float, optional
///     Weight of the fairness energy: 1 makes it as important as all points together. The energy
///     sums squared third derivatives, or second ones where points are few. By default the weight
///     from 1e-12 to 100 that best predicts left-out points, by cross-validation in steps of half a
///     decade.
///
/// Returns
/// -------
/// HeightFit
///     With ``surface``, ``uv``, ``residuals`` and ``fairness``. Base-plane coordinates are linear
///     in u and v, so the heights are a tensor-product spline of x and y.
///
/// Raises
/// ------
/// NeurbsError
///     If the points do not form a surface or do not extend across the direction, or an option is
///     out of range.
///
/// Notes
/// -----
/// One least-squares fit, as in `scipy.interpolate.LSQBivariateSpline`. Holes without points are
/// filled by thin-plate energy.
///
/// The base rectangle is the bounding box of the points in the base plane. A side with at most two
/// points belongs to a scattered cloud; it is moved outward by two mean gaps, 2 / n of the
/// rectangle for n points, at most 0.02. Sides with more points, as in grids, stay.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> x, y = np.random.default_rng(0).random((2, 1000))
/// >>> fit = neurbs.fit_heights(np.column_stack([x, y, np.sin(3 * x) * y]), (10, 10))
/// >>> np.abs(fit.residuals).max() < 1e-4
/// np.True_
#[pyfunction]
#[pyo3(
    signature = (points, net, *, up=None, degree=None, weights=None, fairness=None),
    text_signature = "(points, net, *, up=(0, 0, 1), degree=3, weights=None, fairness=None)"
)]
pub(super) fn fit_heights(
    points: &Bound<'_, PyAny>,
    net: &Bound<'_, PyAny>,
    up: Option<&Bound<'_, PyAny>>,
    degree: Option<&Bound<'_, PyAny>>,
    weights: Option<&Bound<'_, PyAny>>,
    fairness: Option<&Bound<'_, PyAny>>,
) -> PyResult<HeightFit> {
    let py = points.py();
    let options = HeightOptions {
        net: arguments::pair("net", net)?,
        degree: degrees(degree)?,
        fairness: arguments::optional_real("fairness", fairness)?,
    };
    let up = up.map(|up| {
        let up = Numbers::new(up, "up", "a direction of shape (3,)", &[&[Some(3)]])?;
        Ok::<_, PyErr>(up.as_slice::<DVec3>()?[0].normalize_or_zero())
    });
    let up = up.transpose()?.unwrap_or(DVec3::Z);
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let weights = weights.map(|weights| Numbers::sequence(weights, "weights")).transpose()?;
    let weights = weights.as_ref().map(Numbers::as_slice).transpose()?;
    let found = call::run(py, None, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        fit::fit_heights(points, weights, up, &options, watcher)
    })?;
    Ok(HeightFit {
        surface: Py::new(py, NurbsSurface::new(py, found.surface)?)?,
        uv: arrays::constant::<f64, IxDyn>(
            py,
            &[found.uv.len(), 2],
            bytemuck::cast_slice(&found.uv),
        )?,
        residuals: arrays::constant::<f64, IxDyn>(py, &[points.len()], &found.residuals)?,
        fairness: found.fairness,
    })
}

/// Fit the weights of a surface's control points to reduce the distance to points.
///
/// With weights, a surface represents spheres and cylinders exactly, with few control points.
///
/// Parameters
/// ----------
/// surface : NurbsSurface
///     A polynomial surface near the points.
/// points : array_like of shape (n, 3) or (n, 2)
///     The points.
/// weights : array_like of shape (n,), optional
///     Weight of each squared distance, at least 0.
///
/// Returns
/// -------
/// NurbsSurface
///     With the same knots, and control points and weights that reduce the mean squared distance.
///     The surface is returned unchanged if the gain is below a twentieth, if it is rational
///     already, or if it has more than 256 control points.
///
/// Raises
/// ------
/// NeurbsError
///     If a point is not finite or array lengths disagree.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> uv = np.random.default_rng(0).random((500, 2))
/// >>> cylinder = np.column_stack([np.cos(1.5 * uv[:, 0]), np.sin(1.5 * uv[:, 0]), uv[:, 1]])
/// >>> polynomial = neurbs.NurbsSurface.fit(cylinder, uv, net=(3, 2), degree=(2, 1))
/// >>> rational = neurbs.fit_weights(polynomial, cylinder)
/// >>> [bool(s.closest_points(cylinder).distances.max() < 1e-5) for s in (polynomial, rational)]
/// [False, True]
#[pyfunction]
#[pyo3(signature = (surface, points, *, weights=None))]
pub(super) fn fit_weights(
    surface: &Bound<'_, NurbsSurface>,
    points: &Bound<'_, PyAny>,
    weights: Option<&Bound<'_, PyAny>>,
) -> PyResult<NurbsSurface> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let weights = weights.map(|weights| Numbers::sequence(weights, "weights")).transpose()?;
    let weights = weights.as_ref().map(Numbers::as_slice).transpose()?;
    let core = surface.get().core();
    let found = call::run(py, None, |watcher| {
        cloud::check_finite(points)?;
        fit::fit_weights(core, points, weights, watcher)
    })?;
    NurbsSurface::new(py, found)
}
