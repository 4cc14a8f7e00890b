//! Surfaces from curves: ruled, lofted, revolved.

use glam::DVec3;

use super::compatible::unify;
use super::curve::{NurbsCurve, arc};
use super::curve_family::Strip;
use super::interpolate::interpolate_strip;
use super::parametrization::{Parametrization, sites};
use super::primitives::direction;
use super::surface::NurbsSurface;
use super::work_blocks::{in_steps, listening};
use crate::error::{Error, Result};
use crate::progress::Observer;

impl NurbsSurface {
    /// The surface of straight lines between points of equal parameters of two curves, which run
    /// in v; u goes from 0 on the first to 1 on the second.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, NurbsSurface}, progress::Silent};
    /// let line = NurbsCurve::line(DVec3::ZERO, DVec3::Y)?;
    /// let other = NurbsCurve::line(DVec3::X, DVec3::ONE)?;
    /// let ruled = NurbsSurface::ruled(&line, &other, &mut Silent)?;
    /// assert_eq!(ruled.point(0.5, 1.0), DVec3::new(0.5, 1.0, 0.5));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
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
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, NurbsSurface, Parametrization}, progress::Silent};
    /// let line = |x: f64, z: f64| NurbsCurve::line(DVec3::new(x, 0.0, z), DVec3::new(x, 1.0, z));
    /// let curves = [line(0.0, 0.0)?, line(1.0, 1.0)?, line(2.0, 0.0)?];
    /// let lofted = NurbsSurface::lofted(&curves, 2, Parametrization::Uniform, &mut Silent)?;
    /// assert!(lofted.point(0.5, 0.3).distance(DVec3::new(1.0, 0.3, 1.0)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
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
        let strips: Result<Vec<Strip>> =
            curves.iter().map(|curve| curve.strip().copied(listen)).collect();
        let mut strips = strips?;
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
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, NurbsSurface}, progress::Silent};
    /// let profile = NurbsCurve::line(2.0 * DVec3::X, DVec3::new(2.0, 0.0, 5.0))?;
    /// let turn = std::f64::consts::TAU;
    /// let tube = NurbsSurface::revolved(&profile, DVec3::ZERO, DVec3::Z, turn, &mut Silent)?;
    /// assert!((tube.point(0.4, 0.7).truncate().length() - 2.0).abs() < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
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
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::progress::Silent;

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
}
