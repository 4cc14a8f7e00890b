//! `neurbs.NurbsSurface`: ruled, lofted and revolved surfaces from curves.

use std::f64::consts::TAU;

use pyo3::prelude::*;

use super::arguments::{optional_count, optional_real, vector};
use super::call::{self, Watcher};
use super::construction;
use super::curve::NurbsCurve;
use super::surface::NurbsSurface;
use crate::nurbs;

#[pymethods]
impl NurbsSurface {
    /// The ruled surface between two curves.
    ///
    /// Parameters
    /// ----------
    /// start, end : NurbsCurve
    ///     The curves at u = 0 and u = 1, which run in v. Their domains must be the same.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the domains differ or the curves coincide.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, section 8.3.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 0]], degree=1)
    /// >>> neurbs.NurbsSurface.ruled(line, neurbs.NurbsCurve([[0, 0, 1], [1, 1, 1]], degree=1))
    /// NurbsSurface(net 2 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
    #[staticmethod]
    fn ruled(py: Python<'_>, start: &NurbsCurve, end: &NurbsCurve) -> PyResult<Self> {
        let ruled =
            |watcher: &mut Watcher| nurbs::NurbsSurface::ruled(start.core(), end.core(), watcher);
        Self::new(py, call::run(py, None, ruled)?)
    }

    /// A lofted surface through curves.
    ///
    /// Parameters
    /// ----------
    /// curves : sequence of NurbsCurve
    ///     At least two curves that run in v, with the same domain. Degrees and knots are made
    ///     compatible.
    /// degree : int, default 3
    ///     The degree in u, reduced if there are not more curves than it.
    /// parametrization : {"chord", "uniform", "centripetal"}, default "chord"
    ///     Spacing of the curves in u.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are too few curves, their domains differ, consecutive curves coincide, or
    ///     weights would become negative between the curves.
    ///
    /// Notes
    /// -----
    /// Skinning, *The NURBS Book*, section 10.3.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> rings = [
    /// ...     neurbs.NurbsCurve.arc([0, 0, z], [r, 0, 0], [0, r, 0])
    /// ...     for z, r in [(0, 1), (1, 2), (2, 1.5)]
    /// ... ]
    /// >>> neurbs.NurbsSurface.lofted(rings)
    /// NurbsSurface(net 3 × 9, degree (2, 2), domain [0, 1] × [0, 1], rational, closed in v)
    #[staticmethod]
    #[pyo3(
        signature = (curves, degree=None, *, parametrization=None),
        text_signature = "(curves, degree=3, *, parametrization='chord')"
    )]
    fn lofted(
        py: Python<'_>,
        curves: Vec<Py<NurbsCurve>>,
        degree: Option<&Bound<'_, PyAny>>,
        parametrization: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let degree = optional_count("degree", degree)?.unwrap_or(3);
        let parametrization = construction::parametrization(parametrization)?;
        let curves: Vec<_> = curves.iter().map(|curve| curve.get().core().clone()).collect();
        let lofted = |watcher: &mut Watcher| {
            nurbs::NurbsSurface::lofted(&curves, degree, parametrization, watcher)
        };
        Self::new(py, call::run(py, None, lofted)?)
    }

    /// The exact surface of revolution of a profile.
    ///
    /// Parameters
    /// ----------
    /// profile : NurbsCurve
    ///     The profile, which runs in v; u runs around the axis.
    /// origin, axis : array_like of shape (3,)
    ///     A point of the axis and its direction.
    /// angle : float, default 2π
    ///     The angle of revolution, in radians.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the axis is zero, or the angle is not between 0 and 2π.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A8.1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> profile = neurbs.NurbsCurve([[1, 0, 0], [2, 0, 1], [1, 0, 2]], degree=2)
    /// >>> neurbs.NurbsSurface.revolved(profile, [0, 0, 0], [0, 0, 1])
    /// NurbsSurface(net 9 × 3, degree (2, 2), domain [0, 1] × [0, 1], rational, closed in u)
    #[staticmethod]
    #[pyo3(
        signature = (profile, origin, axis, angle=None),
        text_signature = "(profile, origin, axis, angle=6.283185307179586)"
    )]
    fn revolved(
        profile: &NurbsCurve,
        origin: &Bound<'_, PyAny>,
        axis: &Bound<'_, PyAny>,
        angle: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let angle = optional_real("angle", angle)?.unwrap_or(TAU);
        let (py, origin, axis) = (origin.py(), vector(origin, "origin")?, vector(axis, "axis")?);
        let revolved = |watcher: &mut Watcher| {
            nurbs::NurbsSurface::revolved(profile.core(), origin, axis, angle, watcher)
        };
        Self::new(py, call::run(py, None, revolved)?)
    }
}
