//! `neurbs.fit_heights`, and the weights of a surface: `neurbs.fit_weights`.

use glam::DVec3;
use numpy::PyArrayDyn;
use numpy::ndarray::IxDyn;
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::surface::NurbsSurface;
use super::surface_arguments::degrees;
use super::{arguments, call};
use crate::cloud;
use crate::fit::{self, HeightOptions};

/// What :func:`fit_heights` found.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct HeightFit {
    /// The surface, over a rectangle of the plane.
    #[pyo3(get)]
    surface: Py<NurbsSurface>,
    /// The points' parameters, float64 of shape (n, 2).
    #[pyo3(get)]
    uv: Py<PyArrayDyn<f64>>,
    /// Heights of the points above the surface, float64 of shape (n,), in the points' unit.
    #[pyo3(get)]
    residuals: Py<PyArrayDyn<f64>>,
    /// The weight of the fairness that was used.
    #[pyo3(get)]
    fairness: f64,
}

#[pymethods]
impl HeightFit {
    fn __repr__(&self) -> String {
        let (rows, cols) = self.surface.get().core().shape();
        format!("HeightFit(net {rows} × {cols}, fairness {:e})", self.fairness)
    }
}

/// Fit the surface z = f(x, y) closest to points, or the like along another direction.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3)
///     At least four distinct points, finite, not all on one line.
/// net : (int, int)
///     Rows and columns of the control net: along x and y, or where the heights are not along z,
///     along the directions across them in which the points scatter most and least.
/// up : array_like of shape (3,), default (0, 0, 1)
///     The direction of the heights; of any length.
/// degree : int or (int, int), default 3
///     Degrees in u and v.
/// weights : array_like of shape (n,), optional
///     How much each squared height counts, at least 0.
/// fairness : float, optional
///     Weight of the thin-plate energy, as in `NurbsSurface.fit`; by default the one among seven
///     from 1e-10 to 1 that best predicts points left out (cross-validation in four parts).
///
/// Returns
/// -------
/// HeightFit
///     With ``surface``, ``uv``, ``residuals`` and ``fairness``. The surface's plane coordinates are
///     linear in u and v, so that its heights are a tensor-product spline function of x and y.
///
/// Raises
/// ------
/// NeurbsError
///     If the points cannot be a surface or do not extend across the direction, or an option is out
///     of its range.
///
/// Notes
/// -----
/// One least squares, as `scipy.interpolate.LSQBivariateSpline` does it; but where there are no
/// points the surface spans the hole like a thin plate.
///
/// The surface ends at the rectangle around the points' places in the plane where more than two of
/// them lie on a side, as those of grids do. Where one or two do, the points are scattered and their
/// ground goes on: so does the surface, by two mean gaps between n points along the side's normal (2 / n
/// of the rectangle, 0.02 of it at most).
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

/// Fit the weights of a surface's control points, so that it comes nearer to points.
///
/// Spheres and cylinders are rational surfaces: with weights, fewer control points do.
///
/// Parameters
/// ----------
/// surface : NurbsSurface
///     A polynomial surface near the points.
/// points : array_like of shape (n, 3) or (n, 2)
///     The points.
/// weights : array_like of shape (n,), optional
///     How much each squared distance counts, at least 0.
///
/// Returns
/// -------
/// NurbsSurface
///     With the same knots, and control points moved and weighted so that the mean of the squared
///     distances falls. Never worse: what gains less than a twentieth comes back as it was, and so
///     do rational surfaces and those with more than 256 control points.
///
/// Raises
/// ------
/// NeurbsError
///     If a point is not finite or the numbers do not belong together.
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
