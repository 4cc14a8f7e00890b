//! `neurbs.NurbsSurface`: surfaces from curves, and exact surfaces from numbers.

use std::f64::consts::TAU;

use glam::DVec3;
use pyo3::prelude::*;

use super::arguments::{optional_count, optional_real, real};
use super::arrays::Numbers;
use super::call::{self, Watcher};
use super::construction;
use super::curve::NurbsCurve;
use super::errors::bad_argument;
use super::surface::NurbsSurface;
use crate::nurbs;

/// A point or direction: three numbers.
pub(super) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec3> {
    let numbers = Numbers::new(value, name, "three real numbers", &[&[Some(3)]])?;
    let numbers: &[f64] = numbers.as_slice()?;
    let vector = DVec3::from_slice(numbers);
    if vector.is_finite() { Ok(vector) } else { Err(bad_argument(name, "finite", value)) }
}

#[pymethods]
impl NurbsSurface {
    /// The surface of straight lines between two curves.
    ///
    /// Parameters
    /// ----------
    /// start, end : NurbsCurve
    ///     The curves at u = 0 and u = 1, which run in v; their domains must be the same.
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

    /// A surface through curves.
    ///
    /// Parameters
    /// ----------
    /// curves : sequence of NurbsCurve
    ///     At least two, which run in v, with the same domain. Degrees and knots are made equal.
    /// degree : int, default 3
    ///     The degree in u; lower where there are not more curves than it.
    /// parametrization : {"chord", "uniform", "centripetal"}, default "chord"
    ///     How the curves are spaced in u.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If there are too few curves, their domains differ, neighbours coincide, or weights that
    ///     differ much would become negative between them.
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

    /// The surface that a profile sweeps when it turns about an axis, exact.
    ///
    /// Parameters
    /// ----------
    /// profile : NurbsCurve
    ///     Runs in v; u goes round the axis.
    /// origin, axis : array_like of shape (3,)
    ///     A point of the axis and its direction.
    /// angle : float, default 2π
    ///     How far it turns, in radians.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the axis has no direction, or the angle is not between 0 and 2π.
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

    /// The parallelogram from a corner along two sides.
    ///
    /// Parameters
    /// ----------
    /// origin, u, v : array_like of shape (3,)
    ///     The corner and the sides.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the sides span no plane.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.plane([0, 0, 0], [2, 0, 0], [0, 1, 0]).evaluate([[0.5, 1]])
    /// array([[1., 1., 0.]])
    #[staticmethod]
    fn plane(
        origin: &Bound<'_, PyAny>,
        u: &Bound<'_, PyAny>,
        v: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let py = origin.py();
        let (origin, u, v) = (vector(origin, "origin")?, vector(u, "u")?, vector(v, "v")?);
        Self::new(py, nurbs::NurbsSurface::plane(origin, u, v)?)
    }

    /// The side of a cylinder, exact; u runs round it, v along its axis.
    ///
    /// Parameters
    /// ----------
    /// base, axis : array_like of shape (3,)
    ///     The centre of the base, and the way from there to the centre of the top.
    /// radius : float
    ///     Its radius.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With normals that point outwards.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the radius is not positive or the axis has no length.
    ///
    /// Notes
    /// -----
    /// A line that turns about the axis, *The NURBS Book*, A8.1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 3], 1)
    /// NurbsSurface(net 9 × 2, degree (2, 1), domain [0, 1] × [0, 1], rational, closed in u)
    #[staticmethod]
    fn cylinder(
        base: &Bound<'_, PyAny>,
        axis: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let radius = real("radius", radius)?;
        let (py, base, axis) = (base.py(), vector(base, "base")?, vector(axis, "axis")?);
        Self::new(py, nurbs::NurbsSurface::cylinder(base, axis, radius)?)
    }

    /// The side of a cone, exact; u runs round it, v along its axis.
    ///
    /// Parameters
    /// ----------
    /// base, axis : array_like of shape (3,)
    ///     The centre of the base, and the way from there to the centre of the top.
    /// radius : float
    ///     The radius at the base.
    /// top_radius : float, default 0
    ///     The radius at the top: 0 for a whole cone.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With normals that point outwards.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a radius is negative or both are 0, or the axis has no length.
    ///
    /// Notes
    /// -----
    /// A line that turns about the axis, *The NURBS Book*, A8.1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> cone = neurbs.NurbsSurface.cone([0, 0, 0], [0, 0, 4], 3)
    /// >>> round(cone.area(), 6)  # π · 3 · 5
    /// 47.12389
    #[staticmethod]
    #[pyo3(
        signature = (base, axis, radius, top_radius=None),
        text_signature = "(base, axis, radius, top_radius=0.0)"
    )]
    fn cone(
        base: &Bound<'_, PyAny>,
        axis: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
        top_radius: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let radius = real("radius", radius)?;
        let top_radius = optional_real("top_radius", top_radius)?.unwrap_or(0.0);
        let (py, base, axis) = (base.py(), vector(base, "base")?, vector(axis, "axis")?);
        Self::new(py, nurbs::NurbsSurface::cone(base, axis, radius, top_radius)?)
    }

    /// The sphere, exact; u runs round the z axis, v from the south to the north pole.
    ///
    /// Parameters
    /// ----------
    /// centre : array_like of shape (3,)
    ///     Its centre.
    /// radius : float
    ///     Its radius.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With normals that point outwards.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the radius is not positive.
    ///
    /// Notes
    /// -----
    /// Half a circle that turns about the z axis, *The NURBS Book*, A8.1. The poles, where an edge
    /// of the net collapses, have normals and closest points like any other place.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    /// NurbsSurface(net 9 × 5, degree (2, 2), domain [0, 1] × [0, 1], rational, closed in u)
    #[staticmethod]
    fn sphere(centre: &Bound<'_, PyAny>, radius: &Bound<'_, PyAny>) -> PyResult<Self> {
        let radius = real("radius", radius)?;
        let (py, centre) = (centre.py(), vector(centre, "centre")?);
        Self::new(py, nurbs::NurbsSurface::sphere(centre, radius)?)
    }

    /// The torus about the z axis through its centre, exact; u runs round the axis.
    ///
    /// Parameters
    /// ----------
    /// centre : array_like of shape (3,)
    ///     Its centre.
    /// major, minor : float
    ///     The radius of the circle that the tube follows, and that of the tube.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With normals that point outwards.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a radius is not positive.
    ///
    /// Notes
    /// -----
    /// A circle that turns about the axis, *The NURBS Book*, A8.1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
    /// NurbsSurface(net 9 × 9, degree (2, 2), domain [0, 1] × [0, 1], rational, closed in u and v)
    #[staticmethod]
    fn torus(
        centre: &Bound<'_, PyAny>,
        major: &Bound<'_, PyAny>,
        minor: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (major, minor) = (real("major", major)?, real("minor", minor)?);
        let (py, centre) = (centre.py(), vector(centre, "centre")?);
        Self::new(py, nurbs::NurbsSurface::torus(centre, major, minor)?)
    }
}
