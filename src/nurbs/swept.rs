//! Surfaces from curves: ruled, lofted, revolved.

use glam::DVec3;

use super::compatible::unify;
use super::curve::{NurbsCurve, arc};
use super::curve_family::CurveFamily;
use super::interpolate::interpolate_family;
use super::parametrization::{Parametrization, row_parameters};
use super::primitives::unit_vector;
use super::surface::NurbsSurface;
use super::work_blocks::{collect_in_steps, interrupt_check};
use crate::error::{Error, Result};
use crate::progress::Observer;

impl NurbsSurface {
    /// Builds the surface of straight lines between points of equal parameters of two curves.
    ///
    /// The curves run in v; u is 0 on the first and 1 on the second.
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

    /// Builds a surface through curves, in their order (skinning; The NURBS Book, section 10.3).
    ///
    /// The curves run in v. Their degrees and knots are made compatible first. The degree in u is
    /// at most the number of curves minus 1.
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
    /// - [`Error::Parameter`] if there are fewer than two curves, their domains differ, or two
    ///   neighboring curves coincide.
    /// - [`Error::Net`] if the weights differ so much from curve to curve that they would become
    ///   negative between them.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn lofted(
        curves: &[NurbsCurve],
        degree: usize,
        parametrization: Parametrization,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        if curves.len() < 2 {
            return Err(Error::parameter("curves", "at least two", curves.len()));
        }
        let check_interrupt = &mut interrupt_check(observer);
        let families: Result<Vec<CurveFamily>> =
            curves.iter().map(|curve| curve.family().copied(check_interrupt)).collect();
        let mut families = families?;
        unify(&mut families, check_interrupt)?;
        let (count, width) = (families.len(), families[0].rows());
        let points = collect_in_steps((count, width), check_interrupt, |rows| {
            rows.flat_map(|row| families[row].points.iter().copied())
        })?;
        let places = collect_in_steps((points.len(), 1), check_interrupt, |part| {
            points[part].iter().map(|h| h.truncate() / h.w)
        })?;
        let degree = degree.min(count - 1);
        let parameters =
            row_parameters("curves", &places, width, parametrization, false, check_interrupt)?;
        let family =
            interpolate_family(points, width, &parameters, degree, false, check_interrupt)?;
        let rational = curves.iter().any(|curve| curve.weights().is_some());
        let knots = [family.knots, families.swap_remove(0).knots];
        Self::from_homogeneous(family.points, rational, knots, check_interrupt)
    }

    /// Revolves a profile around an axis by `angle` (at most a full turn), exactly (The NURBS Book,
    /// A8.1).
    ///
    /// u runs around the axis on `[0, 1]`, v along the profile.
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
    /// [`Error::Parameter`] if the axis has no direction or the angle is out of range;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn revolved(
        profile: &NurbsCurve,
        origin: DVec3,
        axis: DVec3,
        angle: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let axis = unit_vector("axis", axis)?;
        let (circle, weights, knots) = arc(angle)?;
        let profile = profile.family();
        let count = profile.rows();
        let turned = |k: usize| {
            let (at, weight, h) =
                (circle[k / count], weights[k / count], profile.points[k % count]);
            let point = h.truncate() / h.w - origin;
            let center = point.dot(axis) * axis;
            let x = point - center;
            let turned = origin + center + at.x * x + at.y * axis.cross(x);
            (turned * (weight * h.w)).extend(weight * h.w)
        };
        let check_interrupt = &mut interrupt_check(observer);
        let net =
            collect_in_steps((circle.len() * count, 1), check_interrupt, |part| part.map(&turned))?;
        Self::from_homogeneous(net, true, [knots, profile.knots.clone()], check_interrupt)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::progress::Silent;

    #[test]
    fn ruled_and_lofted_surfaces_contain_their_curves() {
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
            // The weights of the circle move the middle along the line, towards the wave.
            let middle = ruled.point(0.5, t);
            assert!((middle - a).cross(b - a).length() < 1e-12);
            assert!(lofted.point(0.0, t).distance(a) < 1e-13);
            assert!(lofted.point(1.0, t).distance(top.point(t)) < 1e-13);
        }
        assert!(alone.is_err());
    }
}
