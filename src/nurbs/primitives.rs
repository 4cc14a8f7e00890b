//! Exact primitives: plane, cylinder, cone, sphere, torus.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::curve::NurbsCurve;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::Silent;

impl NurbsSurface {
    /// Builds the parallelogram `origin + s u + t v` with s and t from 0 to 1.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// assert_eq!(plane.point(0.25, 1.0), DVec3::new(0.25, 1.0, 0.0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if `u` and `v` are parallel or zero.
    pub fn plane(origin: DVec3, u: DVec3, v: DVec3) -> Result<Self> {
        unit_vector("u × v", u.cross(v))?;
        Self::clamped(vec![origin, origin + v, origin + u, origin + u + v], (2, 2), 1)
    }

    /// Builds the side of a cylinder around the axis from `base` to `base + axis`.
    ///
    /// u runs around the axis, v along it, and the normals point outwards.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let cylinder = NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 2.0)?;
    /// assert!((cylinder.point(0.3, 0.5).truncate().length() - 2.0).abs() < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the radius is not positive or the axis has no length.
    pub fn cylinder(base: DVec3, axis: DVec3, radius: f64) -> Result<Self> {
        Self::cone(base, axis, radius, radius)
    }

    /// Builds the side of a cone, truncated unless `top_radius` is 0; otherwise as
    /// [`NurbsSurface::cylinder`].
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let cone = NurbsSurface::cone(DVec3::ZERO, DVec3::Z, 2.0, 0.0)?;
    /// assert!(cone.point(0.3, 1.0).distance(DVec3::Z) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a radius is negative or both are 0, or the axis has no length.
    pub fn cone(base: DVec3, axis: DVec3, radius: f64, top_radius: f64) -> Result<Self> {
        check_radius("radius", radius, radius == 0.0 && top_radius > 0.0)?;
        check_radius("top radius", top_radius, top_radius == 0.0)?;
        let out = unit_vector("axis", axis)?.any_orthonormal_vector();
        let profile = NurbsCurve::line(base + radius * out, base + axis + top_radius * out)?;
        Self::revolved(&profile, base, axis, TAU, &mut Silent)
    }

    /// Builds a sphere from the south pole (v = 0) to the north pole (v = 1).
    ///
    /// u runs around the z axis, and the normals point outwards.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0)?;
    /// assert!((sphere.point(0.3, 0.4).length() - 2.0).abs() < 1e-15 * 2.0);
    /// assert_eq!(sphere.normal(0.3, 1.0), DVec3::Z);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the radius is not positive.
    pub fn sphere(center: DVec3, radius: f64) -> Result<Self> {
        check_radius("radius", radius, false)?;
        let profile = NurbsCurve::arc(center, -radius * DVec3::Z, radius * DVec3::X, PI)?;
        Self::revolved(&profile, center, DVec3::Z, TAU, &mut Silent)
    }

    /// Builds a torus around the z axis through its center.
    ///
    /// `major` is the radius of the circle through the centers of the tube, `minor` the radius of
    /// the tube. Both directions are closed, and the normals point outwards.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0)?;
    /// assert_eq!(torus.closed(), (true, true));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a radius is not positive.
    pub fn torus(center: DVec3, major: f64, minor: f64) -> Result<Self> {
        check_radius("major radius", major, false)?;
        check_radius("minor radius", minor, false)?;
        let (x, z) = (minor * DVec3::X, minor * DVec3::Z);
        let profile = NurbsCurve::arc(center + major * DVec3::X, x, z, TAU)?;
        Self::revolved(&profile, center, DVec3::Z, TAU, &mut Silent)
    }
}

/// Normalizes a direction.
pub(super) fn unit_vector(name: &'static str, vector: DVec3) -> Result<DVec3> {
    vector.try_normalize().ok_or_else(|| {
        Error::parameter(name, "a finite vector of positive length", format!("{vector}"))
    })
}

/// Checks that a radius is positive and finite. A radius of 0 passes, too, if `zero_allowed`.
fn check_radius(name: &'static str, length: f64, enough: bool) -> Result<()> {
    if length.is_finite() && (length > 0.0 || enough) {
        return Ok(());
    }
    Err(Error::parameter(name, "a positive length", length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps() -> impl Iterator<Item = (f64, f64)> {
        (0..=24).flat_map(|i| (0..=24).map(move |j| (f64::from(i) / 24.0, f64::from(j) / 24.0)))
    }

    #[test]
    fn spheres_and_tori_are_exact() {
        let center = DVec3::new(1.0, -2.0, 0.5);
        let sphere = NurbsSurface::sphere(center, 3.0).unwrap();
        let torus = NurbsSurface::torus(center, 3.0, 0.7).unwrap();
        for (u, v) in steps() {
            let out = sphere.point(u, v) - center;
            assert!((out.length() - 3.0).abs() < 1e-14 * 3.0);
            assert!(sphere.normal(u, v).distance(out / 3.0) < 1e-14);
            let out = torus.point(u, v) - center;
            let ring = DVec3::new(out.x, out.y, 0.0).normalize() * 3.0;
            assert!((out.distance(ring) - 0.7).abs() < 1e-14 * 3.0);
            assert!(torus.normal(u, v).distance((out - ring) / 0.7) < 1e-13);
        }
        assert_eq!((sphere.closed(), torus.closed()), ((true, false), (true, true)));
    }

    #[test]
    fn cones_and_planes_are_exact() {
        let (base, axis) = (DVec3::X, DVec3::new(0.0, 3.0, 4.0));
        let cone = NurbsSurface::cone(base, axis, 2.0, 0.0).unwrap();
        for (u, v) in steps() {
            let out = cone.point(u, v) - base - v * axis;
            assert!((out.length() - 2.0 * (1.0 - v)).abs() < 1e-14 * 5.0);
            assert!(out.dot(axis).abs() < 1e-13);
            let slope = DVec3::new(0.0, 3.0, 4.0) / 5.0 * 2.0;
            assert!(cone.normal(u, v).dot(slope) > 0.5, "{} at {u} {v}", cone.normal(u, v));
        }
        let plane = NurbsSurface::plane(base, DVec3::X * 2.0, DVec3::Z).unwrap();
        assert_eq!(plane.point(0.5, 1.0), DVec3::new(2.0, 0.0, 1.0));
        let message = |result: Result<NurbsSurface>| result.unwrap_err().to_string();
        assert!(
            message(NurbsSurface::plane(base, DVec3::X, DVec3::X)).starts_with("u × v must be")
        );
        assert_eq!(
            message(NurbsSurface::sphere(base, -1.0)),
            "radius must be a positive length, got -1"
        );
        assert!(NurbsSurface::cone(base, axis, 0.0, 0.0).is_err());
    }
}
