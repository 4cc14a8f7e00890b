//! `neurbs.NurbsCurve`: curves through points, and arcs.

use std::f64::consts::TAU;

use pyo3::prelude::*;

use super::arguments::{optional_count, optional_real};
use super::arrays::Numbers;
use super::call;
use super::construction::parametrization;
use super::curve::{DEGREE, NurbsCurve};
use super::shapes::vector;
use crate::nurbs;

#[pymethods]
impl NurbsCurve {
    /// The curve through points, in their order.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     More points than the degree.
    /// degree : int, default 3
    ///     The degree, from 1 to 9.
    /// parametrization : {"chord", "uniform", "centripetal"}, default "chord"
    ///     How points get their parameters: in proportion to their distances, evenly, or in
    ///     proportion to the roots of their distances.
    /// closed : bool, default False
    ///     Whether the curve closes smoothly behind the last point, which is not the first again.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     On [0, 1], with as many control points as there are points (and ``degree`` more if it
    ///     is closed).
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are too few points, one is not finite, or neighbours coincide.
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
        let degree = optional_count("degree", degree)?.unwrap_or(DEGREE);
        let numbers = Numbers::points(points, "points")?;
        let slice = numbers.as_slice()?;
        let core = call::run(points.py(), None, |watcher| {
            nurbs::NurbsCurve::interpolate(slice, degree, parametrization, closed, watcher)
        })?;
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
        signature = (centre, x, y, angle=None),
        text_signature = "(centre, x, y, angle=6.283185307179586)"
    )]
    fn arc(
        centre: &Bound<'_, PyAny>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        angle: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let angle = optional_real("angle", angle)?.unwrap_or(TAU);
        let py = centre.py();
        let (centre, x, y) = (vector(centre, "centre")?, vector(x, "x")?, vector(y, "y")?);
        Self::new(py, nurbs::NurbsCurve::arc(centre, x, y, angle)?)
    }
}
