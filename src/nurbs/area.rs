//! Area of a surface by adaptive Gauss-Legendre quadrature.

use pulp::Arch;

use super::adaptive_quadrature::{Estimates, NODE_COUNTS, Region, integral};
use super::basis::{Row, with_capacity};
use super::bezier_patch::{BezierPatch, bernstein};
use super::gauss;
use super::gauss::check_accuracy;
use super::surface::NurbsSurface;
use super::work_blocks::interrupt_check;
use crate::error::Result;
use crate::progress::Observer;

/// Two estimates of an area agree up to rounding if they differ by less than this fraction of an
/// upper bound: the lengths of the tangents times the extent of the patch.
const ROUNDING: f64 = 1e-15;

impl NurbsSurface {
    /// Returns the area, in the square of the points' unit, with relative error at most `accuracy`
    /// (for instance 1e-9).
    ///
    /// Applies Gauss-Legendre quadrature to each Bézier patch. The error estimate is the larger
    /// difference from two coarser rules. While the total error estimate exceeds `accuracy`, the
    /// pieces with the largest errors are quartered.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let area = NurbsSurface::sphere(DVec3::ZERO, 1.0)?.area(1e-12, &mut Silent)?;
    /// assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the accuracy is not between 1e-14 and 1,
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn area(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        check_accuracy(accuracy)?;
        let (patches, _) = BezierPatch::of(self, &mut interrupt_check(observer))?;
        let degrees = (self.knots_u().degree(), self.knots_v().degree());
        with_capacity!(degrees.0.max(degrees.1), CAPACITY => {
            let rules = NODE_COUNTS.map(|count| Rule::<CAPACITY>::new(count, degrees));
            integral(&patches, Piece::<CAPACITY>::centered, &rules, accuracy, observer)
        })
    }
}

/// A part of the surface.
#[derive(Clone)]
struct Piece<const CAPACITY: usize> {
    patch: BezierPatch,
    /// The diagonal of the bounding box of the patch that contains this piece.
    extent: f64,
}

impl<const CAPACITY: usize> Piece<CAPACITY> {
    fn centered(patch: &BezierPatch) -> Self {
        let (patch, extent) = patch.centered();
        Self { patch, extent }
    }
}

impl<const CAPACITY: usize> Region for Piece<CAPACITY> {
    type Rules = [Rule<CAPACITY>; 3];

    fn estimates(&self, rules: &Self::Rules) -> Estimates {
        let arch = Arch::new();
        let integrate = |rule: &Rule<CAPACITY>| {
            arch.dispatch(
                #[inline(always)]
                || rule.integrate(&self.patch),
            )
        };
        let [(area, lengths), (second, _), (third, _)] = rules.each_ref().map(integrate);
        Estimates { values: [area, second, third], rounding: ROUNDING * self.extent * lengths }
    }

    fn quarters(&self) -> [Self; 4] {
        let (first, second) = self.patch.halves_u();
        let ((a, b), (c, d)) = (first.halves_v(), second.halves_v());
        [a, b, c, d].map(|patch| Self { patch, extent: self.extent })
    }
}

/// A tensor-product quadrature rule for patches of the same degrees.
struct Rule<const CAPACITY: usize> {
    u: Vec<QuadratureNode<CAPACITY>>,
    v: Vec<QuadratureNode<CAPACITY>>,
}

/// A quadrature node with the Bernstein polynomials at its parameter.
struct QuadratureNode<const CAPACITY: usize> {
    weight: f64,
    values: Row<CAPACITY>,
    slopes: Row<CAPACITY>,
}

impl<const CAPACITY: usize> Rule<CAPACITY> {
    fn new(count: usize, degrees: (usize, usize)) -> Self {
        let nodes = |degree| {
            let node = |(place, weight): (f64, f64)| {
                let [values, slopes, _] = bernstein(degree, place);
                QuadratureNode { weight, values, slopes }
            };
            gauss::rule(count).into_iter().map(node).collect()
        };
        Self { u: nodes(degrees.0), v: nodes(degrees.1) }
    }

    /// Integrates the area element, and the sum of the tangents' lengths.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn integrate(&self, patch: &BezierPatch) -> (f64, f64) {
        let (mut area, mut lengths) = (0.0, 0.0);
        for u in &self.u {
            let (along, along_slopes) = (patch.row(&u.values), patch.row(&u.slopes));
            for v in &self.v {
                let value = along.sum(&v.values);
                let (by_u, by_v) = (along_slopes.sum(&v.values), along.sum(&v.slopes));
                let point = value.truncate() / value.w;
                let tangent = |d: glam::DVec4| (d.truncate() - d.w * point) / value.w;
                let (by_u, by_v) = (tangent(by_u), tangent(by_v));
                let weight = u.weight * v.weight;
                area += weight * by_u.cross(by_v).length();
                lengths += weight * (by_u.length() + by_v.length());
            }
        }
        (area, lengths)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::error::Error;
    use crate::progress::{Progress, Silent};

    #[test]
    fn areas_match_closed_forms() {
        use std::f64::consts::PI;
        let area =
            |surface: Result<NurbsSurface>| surface.unwrap().area(1e-12, &mut Silent).unwrap();
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-11, "{a} {b}");
        close(area(NurbsSurface::torus(DVec3::ONE, 3.0, 1.0)), 12.0 * PI * PI);
        close(area(NurbsSurface::cone(DVec3::ONE, DVec3::X * 4.0, 3.0, 0.0)), 15.0 * PI);
        close(
            area(NurbsSurface::plane(DVec3::ONE, DVec3::X * 2.0, DVec3::new(5.0, 3.0, 0.0))),
            6.0,
        );
    }

    #[test]
    fn areas_of_degenerate_and_distant_surfaces_are_accurate() {
        let line = |i: i32| DVec3::new(0.3, 0.7, -0.1) * f64::from(i * i % 11);
        let line = NurbsSurface::clamped((0..64).map(line).collect(), (8, 8), 3).unwrap();
        assert!(line.area(1e-12, &mut Silent).unwrap() < 1e-13);
        let far = NurbsSurface::sphere(DVec3::new(5e6, 7.5e6, 300.0), 2.0).unwrap();
        let area = far.area(1e-14, &mut Silent).unwrap();
        // The coordinates of the center are rounded to 1e-9.
        assert!((area / (16.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9, "{area}");
        let mut stop = |_: &Progress| std::ops::ControlFlow::Break(());
        assert!(matches!(far.area(1e-9, &mut stop), Err(Error::Interrupted)));
    }

    #[test]
    fn accuracy_holds_on_singular_surfaces() {
        // Random nets have singular points in many of their patches.
        let random = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        let net = (0..225).map(|k| DVec3::new(random(3 * k), random(3 * k + 1), random(3 * k + 2)));
        let noise = NurbsSurface::clamped(net.collect(), (15, 15), 3).unwrap();
        let area = |accuracy| noise.area(accuracy, &mut Silent).unwrap();
        let exact = area(1e-11);
        for accuracy in [1e-3, 1e-6, 1e-9] {
            assert!((area(accuracy) / exact - 1.0).abs() <= accuracy, "{accuracy}");
        }
    }

    #[test]
    fn accidental_agreement_of_two_rules_does_not_end_refinement() {
        // For this folded patch the 12 × 12 and the 8 × 8 rule agree to 1e-5, but both are wrong by
        // 2e-4.
        let patch = [
            [0.814, 0.0, -0.624, 4.084],
            [0.831, 0.0, 0.982, 5.208],
            [0.629, 0.335, 0.102, 5.755],
            [-0.905, 0.54, -0.703, 9.455],
            [0.484, -0.541, -0.847, 4.211],
            [0.754, -0.392, 0.231, 9.903],
            [0.656, -0.516, -0.875, 2.012],
            [-0.382, 0.409, -0.674, 3.825],
            [-0.358, 0.24, 0.506, 5.187],
            [0.519, 0.242, 0.167, 1.325],
            [0.184, 0.371, 0.543, 8.397],
            [0.296, -0.07, -0.119, 7.737],
        ];
        let net = patch.iter().map(|p| DVec3::new(p[0], p[1], p[2])).collect();
        let weights = patch.iter().map(|p| p[3]).collect();
        let knots = |degree| crate::nurbs::KnotVector::clamped_uniform(degree, degree + 1).unwrap();
        let patch = NurbsSurface::new(net, Some(weights), knots(2), knots(3)).unwrap();
        let area = |accuracy| patch.area(accuracy, &mut Silent).unwrap();
        assert!((area(1e-5) / area(1e-9) - 1.0).abs() <= 1e-5);
    }
}
