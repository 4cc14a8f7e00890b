//! `neurbs.NurbsSurface`: exact surfaces from numbers.

use glam::DVec3;
use pyo3::prelude::*;

use super::arguments::{optional_real, real};
use super::arrays::Numbers;
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
