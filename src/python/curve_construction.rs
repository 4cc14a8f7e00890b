//! `neurbs.NurbsCurve`: interpolation of points, and arcs.

use std::f64::consts::TAU;

use pyo3::prelude::*;

use super::arguments::{optional_count, optional_real, refuse_old_name, vector};
use super::arrays::Numbers;
use super::call;
use super::construction::parametrization;
use super::curve::{DEFAULT_DEGREE, NurbsCurve};
use crate::nurbs;

#[pymethods]
impl NurbsCurve {
    /// Interpolate points in their order.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     More points than the degree; z is 0 if there are two columns.
    /// degree : int, default 3
    ///     The degree, from 1 to 25.
    /// parametrization : {"chord", "uniform", "centripetal"}, default "chord"
    ///     How parameters are spaced: in proportion to the distances between points, evenly, or in
    ///     proportion to the square roots of the distances.
    /// closed : bool, default False
    ///     Whether the curve is smoothly closed. The first point must not be repeated at the end.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     On [0, 1], with one control point per point, and ``degree`` more if it is closed.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are too few points, a point is not finite, or consecutive points coincide.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A9.1: a banded system, O(points · degree).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> curve = neurbs.NurbsCurve.interpolate([[0, 0], [1, 1], [2, 0], [3, 1]])
    /// >>> curve.evaluate([0, 1])
    /// array([[0., 0., 0.],
    ///        [3., 1., 0.]])
    #[staticmethod]
    #[pyo3(
        signature = (points, degree=None, *, parametrization=None, closed=false),
        text_signature = "(points, degree=3, *, parametrization='chord', closed=False)"
    )]
    fn interpolate(
        points: &Bound<'_, PyAny>,
        degree: Option<&Bound<'_, PyAny>>,
        parametrization: Option<&Bound<'_, PyAny>>,
        closed: bool,
    ) -> PyResult<Self> {
        let parametrization = self::parametrization(parametrization)?;
        let degree = optional_count("degree", degree)?.unwrap_or(DEFAULT_DEGREE);
        let numbers = Numbers::points(points, "points")?;
        let slice = numbers.as_slice()?;
        let core = call::run(points.py(), None, |watcher| {
            nurbs::NurbsCurve::interpolate(slice, degree, parametrization, closed, watcher)
        })?;
        Self::new(points.py(), core)
    }

    /// The exact arc ``center + x cos t + y sin t`` for t from 0 to ``angle``.
    ///
    /// Parameters
    /// ----------
    /// center, x, y : array_like of shape (3,)
    ///     The center and two radius vectors. Perpendicular vectors of the same length give a
    ///     circle, others an ellipse.
    /// angle : float, default 2π
    ///     The angle of the arc, in radians.
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
        signature = (center, x, y, angle=None, *, centre=None),
        text_signature = "(center, x, y, angle=6.283185307179586)"
    )]
    fn arc(
        center: &Bound<'_, PyAny>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        angle: Option<&Bound<'_, PyAny>>,
        centre: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        refuse_old_name("centre", "center", centre)?;
        let angle = optional_real("angle", angle)?.unwrap_or(TAU);
        let py = center.py();
        let (center, x, y) = (vector(center, "center")?, vector(x, "x")?, vector(y, "y")?);
        Self::new(py, nurbs::NurbsCurve::arc(center, x, y, angle)?)
    }
}
