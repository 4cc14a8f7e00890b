//! Surfaces from curves, and the exact ones that everybody knows: plane to torus.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::batch::{in_steps, listening};
use super::curve::{NurbsCurve, arc};
use super::interpolate::{Parametrization, interpolate_strip, sites};
use super::knot_vector::KnotVector;
use super::strip::{Strip, unify};
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::{Observer, Silent};

impl NurbsSurface {
    /// The Bézier patch of this net, of degree `rows - 1` × `cols - 1`.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has not between 2 and 10 control points; [`Error::Net`] as
    /// [`NurbsSurface::new`].
    pub fn bezier(
        net: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        (rows, cols): (usize, usize),
    ) -> Result<Self> {
        let knots = |count: usize| KnotVector::clamped_uniform(count.saturating_sub(1), count);
        Self::new(net, weights, knots(rows)?, knots(cols)?)
    }

    /// A surface that closes smoothly on itself in the directions said, with evenly spaced knots
    /// on `[0, 1]²`: each row or column of the net is given once, the first ones are repeated
    /// here.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let ring = |i: i32, z: i32| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), f64::from(z));
    /// let net: Vec<_> = (0..6).flat_map(|i| (0..3).map(move |z| ring(i, z))).collect();
    /// let tube = NurbsSurface::periodic(&net, None, (6, 3), (3, 2), (true, false))?;
    /// assert_eq!((tube.shape(), tube.closed()), ((9, 3), (true, false)));
    /// assert!(tube.point(0.0, 0.4).distance(tube.point(1.0, 0.4)) < 1e-15);
    /// assert!(tube.normal(0.0, 0.4).distance(tube.normal(1.0, 0.4)) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has not more control points than its degree; [`Error::Net`]
    /// as [`NurbsSurface::new`].
    pub fn periodic(
        net: &[DVec3],
        weights: Option<&[f64]>,
        (rows, cols): (usize, usize),
        degrees: (usize, usize),
        closed: (bool, bool),
    ) -> Result<Self> {
        let knots = |degree, count, closed| {
            if closed {
                KnotVector::periodic_uniform(degree, count)
            } else {
                KnotVector::clamped_uniform(degree, count)
            }
        };
        let (u, v) = (knots(degrees.0, rows, closed.0)?, knots(degrees.1, cols, closed.1)?);
        if net.len() != rows * cols {
            let got = format!("{} came for {rows} × {cols}", net.len());
            return Err(Error::Net { must: "have as many control points as its shape", got });
        }
        let place = |k: usize| {
            let (i, j) = (k / v.control_points(), k % v.control_points());
            (i % rows) * cols + j % cols
        };
        let count = u.control_points() * v.control_points();
        if let Some(weights) = weights.filter(|weights| weights.len() != net.len()) {
            let got = format!("{} weights came for {} points", weights.len(), net.len());
            return Err(Error::Net { must: "have one weight for each control point", got });
        }
        let weights = weights.map(|weights| (0..count).map(|k| weights[place(k)]).collect());
        Self::new((0..count).map(|k| net[place(k)]).collect(), weights, u, v)
    }

    /// The surface of straight lines between points of equal parameters of two curves, which run
    /// in v; u goes from 0 on the first to 1 on the second.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the curves have different domains, [`Error::Interrupted`] if the
    /// observer stops it.
    pub fn ruled(from: &NurbsCurve, to: &NurbsCurve, observer: &mut dyn Observer) -> Result<Self> {
        Self::lofted(&[from.clone(), to.clone()], 1, Parametrization::Uniform, observer)
    }

    /// A surface through curves, which run in v, in their order (skinning; The NURBS Book, section
    /// 10.3). Degrees and knots are made equal first. The degree in u is lower where there are not
    /// more curves than it.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if there are fewer than two curves, their domains differ, or two
    /// neighbours coincide; [`Error::Net`] if weights that differ too much from curve to curve
    /// would become negative between them; [`Error::Interrupted`] if the observer stops it.
    pub fn lofted(
        curves: &[NurbsCurve],
        degree: usize,
        parametrization: Parametrization,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        if curves.len() < 2 {
            return Err(Error::parameter("curves", "at least two", curves.len()));
        }
        let listen = &mut listening(observer);
        let mut strips: Vec<Strip> = curves.iter().map(|curve| curve.strip().clone()).collect();
        unify(&mut strips, listen)?;
        let (count, width) = (strips.len(), strips[0].rows());
        let points = in_steps((count, width), listen, |rows| {
            rows.flat_map(|row| strips[row].points.iter().copied())
        })?;
        let places = in_steps((points.len(), 1), listen, |part| {
            points[part].iter().map(|h| h.truncate() / h.w)
        })?;
        let degree = degree.min(count - 1);
        let sites = sites("curves", &places, width, parametrization, false, listen)?;
        let strip = interpolate_strip(points, width, &sites, degree, false, listen)?;
        let rational = curves.iter().any(|curve| curve.weights().is_some());
        let knots = [strip.knots, strips.swap_remove(0).knots];
        Self::from_homogeneous(strip.points, rational, knots, listen)
    }

    /// The surface that a profile sweeps when it turns about an axis by `angle` (at most a full
    /// turn), exact (The NURBS Book, A8.1). u runs round the axis on `[0, 1]`, v along the profile.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the axis has no direction, or for the angle; [`Error::Interrupted`]
    /// if the observer stops it.
    pub fn revolved(
        profile: &NurbsCurve,
        origin: DVec3,
        axis: DVec3,
        angle: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let axis = direction("axis", axis)?;
        let (circle, weights, knots) = arc(angle)?;
        let profile = profile.strip();
        let count = profile.rows();
        let turned = |k: usize| {
            let (at, weight, h) =
                (circle[k / count], weights[k / count], profile.points[k % count]);
            let point = h.truncate() / h.w - origin;
            let centre = point.dot(axis) * axis;
            let x = point - centre;
            let turned = origin + centre + at.x * x + at.y * axis.cross(x);
            (turned * (weight * h.w)).extend(weight * h.w)
        };
        let listen = &mut listening(observer);
        let net = in_steps((circle.len() * count, 1), listen, |part| part.map(&turned))?;
        Self::from_homogeneous(net, true, [knots, profile.knots.clone()], listen)
    }

    /// The parallelogram `origin + s u + t v` with s and t from 0 to 1.
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
    /// [`Error::Parameter`] if `u` and `v` span no plane.
    pub fn plane(origin: DVec3, u: DVec3, v: DVec3) -> Result<Self> {
        direction("u × v", u.cross(v))?;
        Self::clamped(vec![origin, origin + v, origin + u, origin + u + v], (2, 2), 1)
    }

    /// The side of a cylinder about the axis from `base` along `axis`, whose length is the height;
    /// u runs round, v along the axis, and the normals point outwards.
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

    /// The side of a cone, cut off or, with a `top_radius` of 0, whole; else as
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
        check_length("radius", radius, radius == 0.0 && top_radius > 0.0)?;
        check_length("top radius", top_radius, top_radius == 0.0)?;
        let out = direction("axis", axis)?.any_orthonormal_vector();
        let profile = NurbsCurve::line(base + radius * out, base + axis + top_radius * out)?;
        Self::revolved(&profile, base, axis, TAU, &mut Silent)
    }

    /// The sphere, from the south pole (v = 0) to the north pole (v = 1); u runs round the z axis,
    /// and the normals point outwards.
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
    pub fn sphere(centre: DVec3, radius: f64) -> Result<Self> {
        check_length("radius", radius, false)?;
        let profile = NurbsCurve::arc(centre, -radius * DVec3::Z, radius * DVec3::X, PI)?;
        Self::revolved(&profile, centre, DVec3::Z, TAU, &mut Silent)
    }

    /// The torus about the z axis through its centre: `major` is the radius of the circle that the
    /// tube follows, `minor` that of the tube. Both directions are closed, the normals point
    /// outwards.
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
    pub fn torus(centre: DVec3, major: f64, minor: f64) -> Result<Self> {
        check_length("major radius", major, false)?;
        check_length("minor radius", minor, false)?;
        let (x, z) = (minor * DVec3::X, minor * DVec3::Z);
        let profile = NurbsCurve::arc(centre + major * DVec3::X, x, z, TAU)?;
        Self::revolved(&profile, centre, DVec3::Z, TAU, &mut Silent)
    }
}

/// The unit vector of a direction.
fn direction(name: &'static str, vector: DVec3) -> Result<DVec3> {
    vector.try_normalize().ok_or_else(|| {
        Error::parameter(name, "a direction, finite and longer than 0", format!("{vector}"))
    })
}

/// A length must be positive, or just not negative if that is `enough`.
fn check_length(name: &'static str, length: f64, enough: bool) -> Result<()> {
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
        let centre = DVec3::new(1.0, -2.0, 0.5);
        let sphere = NurbsSurface::sphere(centre, 3.0).unwrap();
        let torus = NurbsSurface::torus(centre, 3.0, 0.7).unwrap();
        for (u, v) in steps() {
            let out = sphere.point(u, v) - centre;
            assert!((out.length() - 3.0).abs() < 1e-14 * 3.0);
            assert!(sphere.normal(u, v).distance(out / 3.0) < 1e-14);
            let out = torus.point(u, v) - centre;
            let ring = DVec3::new(out.x, out.y, 0.0).normalize() * 3.0;
            assert!((out.distance(ring) - 0.7).abs() < 1e-14 * 3.0);
            assert!(torus.normal(u, v).distance((out - ring) / 0.7) < 1e-13);
        }
        assert_eq!((sphere.closed(), torus.closed()), ((true, false), (true, true)));
    }

    #[test]
    fn cones_have_their_radii_and_planes_their_corners() {
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

    #[test]
    fn ruled_and_lofted_surfaces_hold_their_curves() {
        let circle = NurbsCurve::arc(DVec3::ZERO, DVec3::X, DVec3::Y, TAU).unwrap();
        let wave = [(0.0, 0.0), (1.0, 2.0), (2.0, -1.0), (3.0, 0.0), (4.0, 1.0)];
        let wave = wave.map(|(x, y)| DVec3::new(x, y, 5.0)).to_vec();
        let wave = NurbsCurve::clamped(wave, 3).unwrap();
        let ruled = NurbsSurface::ruled(&circle, &wave, &mut Silent).unwrap();
        let top = circle.transformed(&glam::DAffine3::from_translation(DVec3::Z * 9.0)).unwrap();
        let curves = [circle.clone(), wave.clone(), top.clone()];
        let lofted = |curves: &[NurbsCurve]| {
            NurbsSurface::lofted(curves, 3, Parametrization::ChordLength, &mut Silent)
        };
        let (alone, lofted) = (lofted(&curves[..1]), lofted(&curves).unwrap());
        assert_eq!(lofted.knots_u().degree(), 2);
        for t in (0..=20).map(|i| f64::from(i) / 20.0) {
            let (a, b) = (circle.point(t), wave.point(t));
            assert!(ruled.point(0.0, t).distance(a) < 1e-14);
            assert!(ruled.point(1.0, t).distance(b) < 1e-14);
            // Weights of the circle draw the middle of the line towards the wave, not off it.
            let middle = ruled.point(0.5, t);
            assert!((middle - a).cross(b - a).length() < 1e-12);
            assert!(lofted.point(0.0, t).distance(a) < 1e-13);
            assert!(lofted.point(1.0, t).distance(top.point(t)) < 1e-13);
        }
        assert!(alone.is_err());
    }

    #[test]
    fn closed_directions_have_no_seam() {
        let net: Vec<DVec3> = (0..35)
            .map(|i| DVec3::new(f64::from(i).sin(), f64::from(i * i % 7), f64::from(i % 5)))
            .collect();
        let weights: Vec<f64> = (0..35).map(|i| 1.0 + f64::from(i % 3)).collect();
        for degree in 2..=4 {
            let both = (true, true);
            let shape = (degree, degree);
            let closed = NurbsSurface::periodic(&net, Some(&weights), (7, 5), shape, both);
            let closed = closed.unwrap();
            assert_eq!(closed.closed(), both);
            for t in [0.0, 0.21, 0.7] {
                for ((a, b), (c, d)) in [((0.0, t), (1.0, t)), ((t, 0.0), (t, 1.0))] {
                    assert!(closed.point(a, b).distance(closed.point(c, d)) < 1e-13);
                    let (start, end) = (closed.frame(a, b), closed.frame(c, d));
                    assert!(start.u.distance(end.u) < 1e-11 && start.v.distance(end.v) < 1e-11);
                    assert!(closed.normal(a, b).distance(closed.normal(c, d)) < 1e-12);
                }
            }
        }
    }
}
