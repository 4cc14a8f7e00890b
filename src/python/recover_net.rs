//! The function `neurbs.recover_net`.

use glam::DVec3;
use pyo3::prelude::*;

use super::arrays::Numbers;
use super::surface::NurbsSurface;
use super::{arguments, call};
use crate::pipeline;

/// Recover the control net of a surface from points that lie on it.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     Points of one B-spline surface, without noise or outliers, in any order.
/// shape : (int, int)
///     Rows and columns of the control net.
/// progress : callable, optional
///     Called about 25 times a second with a `Progress`. An exception it raises ends the job.
///
/// Returns
/// -------
/// NurbsSurface
///     The surface, up to the directions of its parameters: open, with uniform knots, of degree 3
///     or the highest that the net allows.
///
/// Raises
/// ------
/// NeurbsError
///     If no surface with this net passes through the points, or none is found.
///
/// Notes
/// -----
/// A fit with this net is the start. From there, Levenberg-Marquardt steps solve for parameters and
/// control points together, from several starts. `reconstruct` does not use this method.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> i, j = np.mgrid[0:5, 0:4]
/// >>> net = np.stack([i, j, np.sin(i) + 0.3 * j], axis=-1)
/// >>> truth = neurbs.NurbsSurface(net)
/// >>> points = truth.evaluate(np.random.default_rng(0).random((600, 2)))
/// >>> found = neurbs.recover_net(points, (5, 4))
/// >>> bool(found.closest_points(points).distances.max() < 1e-6)
/// True
#[pyfunction]
#[pyo3(signature = (points, shape, *, progress=None))]
pub(super) fn recover_net(
    points: &Bound<'_, PyAny>,
    shape: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NurbsSurface> {
    let py = points.py();
    let shape = arguments::pair("shape", shape)?;
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let found = call::run(py, progress, |watcher| pipeline::recover_net(points, shape, watcher))?;
    NurbsSurface::new(py, found)
}
