//! `neurbs.NurbsSurface`: exact primitives (plane, cylinder, cone, sphere, torus).

use pyo3::prelude::*;

use super::arguments::{optional_real, real, refuse_old_name, vector};
use super::surface::NurbsSurface;
use crate::nurbs;

#[pymethods]
impl NurbsSurface {
    /// A parallelogram.
    ///
    /// Parameters
    /// ----------
    /// origin, u, v : array_like of shape (3,)
    ///     A corner, and the vectors of the two sides from there.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the sides are parallel or zero.
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

    /// The exact lateral surface of a cylinder; u runs around it, v along its axis.
    ///
    /// Parameters
    /// ----------
    /// base, axis : array_like of shape (3,)
    ///     The center of the base, and the vector from there to the center of the top.
    /// radius : float
    ///     The radius.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With outward normals.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the radius is not positive or the axis is zero.
    ///
    /// Notes
    /// -----
    /// Revolution of a line about the axis, *The NURBS Book*, A8.1.
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

    /// The exact lateral surface of a cone; u runs around it, v along its axis.
    ///
    /// Parameters
    /// ----------
    /// base, axis : array_like of shape (3,)
    ///     The center of the base, and the vector from there to the center of the top.
    /// radius : float
    ///     The radius at the base.
    /// top_radius : float, default 0
    ///     The radius at the top; 0 for a full cone.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With outward normals.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a radius is negative, both are 0, or the axis is zero.
    ///
    /// Notes
    /// -----
    /// Revolution of a line about the axis, *The NURBS Book*, A8.1.
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

    /// An exact sphere; u runs around the z axis, v from the south to the north pole.
    ///
    /// Parameters
    /// ----------
    /// center : array_like of shape (3,)
    ///     The center.
    /// radius : float
    ///     The radius.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With outward normals.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the radius is not positive.
    ///
    /// Notes
    /// -----
    /// Revolution of a semicircle about the z axis, *The NURBS Book*, A8.1. An edge of the net
    /// collapses at each pole; normals and closest points work there too.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    /// NurbsSurface(net 9 × 5, degree (2, 2), domain [0, 1] × [0, 1], rational, closed in u)
    #[staticmethod]
    #[pyo3(signature = (center, radius, *, centre=None), text_signature = "(center, radius)")]
    fn sphere(
        center: &Bound<'_, PyAny>,
        radius: &Bound<'_, PyAny>,
        centre: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        refuse_old_name("centre", "center", centre)?;
        let radius = real("radius", radius)?;
        let (py, center) = (center.py(), vector(center, "center")?);
        Self::new(py, nurbs::NurbsSurface::sphere(center, radius)?)
    }

    /// An exact torus about the z axis through its center; u runs around the axis.
    ///
    /// Parameters
    /// ----------
    /// center : array_like of shape (3,)
    ///     The center.
    /// major, minor : float
    ///     The radius of the circle that the tube follows, and the radius of the tube.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With outward normals.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a radius is not positive.
    ///
    /// Notes
    /// -----
    /// Revolution of a circle about the axis, *The NURBS Book*, A8.1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
    /// NurbsSurface(net 9 × 9, degree (2, 2), domain [0, 1] × [0, 1], rational, closed in u and v)
    #[staticmethod]
    #[pyo3(
        signature = (center, major, minor, *, centre=None),
        text_signature = "(center, major, minor)"
    )]
    fn torus(
        center: &Bound<'_, PyAny>,
        major: &Bound<'_, PyAny>,
        minor: &Bound<'_, PyAny>,
        centre: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        refuse_old_name("centre", "center", centre)?;
        let (major, minor) = (real("major", major)?, real("minor", minor)?);
        let (py, center) = (center.py(), vector(center, "center")?);
        Self::new(py, nurbs::NurbsSurface::torus(center, major, minor)?)
    }
}
