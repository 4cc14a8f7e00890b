//! The NURBS curve: boundary curves, isocurves, profiles.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3, DVec4};

use super::basis::{MAX_ORDER, derivatives, padded};
use super::control_net::{
    bounds, coincidence_tolerance, dehomogenize, rows_coincide, to_homogeneous,
};
use super::curve_family::CurveFamily;
use super::derivatives::{check_order, rational_derivatives};
use super::knot_vector::KnotVector;
use super::parameter_checks::{Outside, check_inside, check_length};
use super::work_blocks::for_row_blocks;
use crate::error::{Error, Result};
use crate::progress::{InterruptCheck, Observer};
use crate::worker_pool;

/// A NURBS curve in space.
///
/// ```
/// use neurbs::{DVec3, nurbs::NurbsCurve};
/// let curve = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0), DVec3::X * 2.0], 2)?;
/// assert_eq!(curve.point(0.5), DVec3::new(1.0, 1.0, 0.0));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct NurbsCurve {
    control_points: Vec<DVec3>,
    weights: Option<Vec<f64>>,
    family: CurveFamily,
}

/// Curves are equal if their control points, weights and knots are.
impl PartialEq for NurbsCurve {
    fn eq(&self, other: &Self) -> bool {
        self.control_points == other.control_points
            && self.weights == other.weights
            && self.knots() == other.knots()
    }
}

impl NurbsCurve {
    /// Builds a curve from control points, weights and knots; without weights it is polynomial (all
    /// weights are 1).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{KnotVector, NurbsCurve}};
    /// let points = vec![DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    /// let weights = Some(vec![1.0, 0.5_f64.sqrt(), 1.0]);
    /// let quarter = NurbsCurve::new(points, weights, KnotVector::clamped_uniform(2, 3)?)?;
    /// assert!((quarter.point(0.3).length() - 1.0).abs() < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if one of these holds:
    ///
    /// - The numbers of control points and weights do not match the knots.
    /// - A control point is not finite.
    /// - A weight is not positive and finite.
    pub fn new(
        control_points: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        knots: KnotVector,
    ) -> Result<Self> {
        Self::new_interruptible(control_points, weights, knots, &mut || Ok(()))
    }

    /// Builds a curve, with interrupt checks.
    fn new_interruptible(
        control_points: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        knots: KnotVector,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (count, needed) = (control_points.len(), knots.control_points());
        if count != needed {
            let got = format!("{count} control points were given with knots for {needed}");
            return Err(Error::Net {
                must: "have as many control points as its knots require",
                got,
            });
        }
        let points = to_homogeneous(
            &control_points,
            weights.as_deref(),
            |i| i.to_string(),
            check_interrupt,
        )?;
        Ok(Self { control_points, weights, family: CurveFamily { knots, points, width: 1 } })
    }

    /// Builds a polynomial curve on `[0, 1]` with clamped, evenly spaced knots.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert_eq!(arch.point(0.5), DVec3::new(1.0, 0.5, 0.5));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if there are at most `degree` control points.
    pub fn clamped(control_points: Vec<DVec3>, degree: usize) -> Result<Self> {
        let knots = KnotVector::clamped_uniform(degree, control_points.len())?;
        Self::new(control_points, None, knots)
    }

    /// Builds the straight line from one point to another, on `[0, 1]`.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let line = NurbsCurve::line(DVec3::ZERO, DVec3::X)?;
    /// assert_eq!(line.point(0.25), 0.25 * DVec3::X);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if a point is not finite.
    pub fn line(from: DVec3, to: DVec3) -> Result<Self> {
        Self::clamped(vec![from, to], 1)
    }

    /// Builds the arc `center + x cos t + y sin t`, t from 0 to `angle` (at most a full turn).
    ///
    /// The arc is an exact rational quadratic on `[0, 1]`, in as few pieces of at most a quarter
    /// turn as possible (The NURBS Book, A7.1). It is circular if x and y have the same length and
    /// are orthogonal.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let circle = NurbsCurve::arc(DVec3::ZERO, DVec3::X, DVec3::Y, std::f64::consts::TAU)?;
    /// assert!((circle.point(0.3).length() - 1.0).abs() < 1e-15);
    /// assert!(circle.closed());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the angle is out of range; [`Error::Net`] if a number is not finite.
    pub fn arc(center: DVec3, x: DVec3, y: DVec3, angle: f64) -> Result<Self> {
        let (circle, weights, knots) = arc(angle)?;
        let place = |at: &DVec2| center + at.x * x + at.y * y;
        Self::new(circle.iter().map(place).collect(), Some(weights), knots)
    }

    /// Builds a curve from homogeneous control points (w x, w y, w z, w).
    pub(super) fn from_homogeneous(
        points: Vec<DVec4>,
        rational: bool,
        knots: KnotVector,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (places, weights) = dehomogenize(&points, rational, check_interrupt)?;
        drop(points);
        Self::new_interruptible(places, weights, knots, check_interrupt)
    }

    /// The control points.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert_eq!(arch.control_points()[1], DVec3::ONE);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn control_points(&self) -> &[DVec3] {
        &self.control_points
    }

    /// The weights; `None` if the curve is polynomial.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert!(arch.weights().is_none());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The knots.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert_eq!(arch.knots().as_slice(), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn knots(&self) -> &KnotVector {
        &self.family.knots
    }

    /// Whether the curve ends where it begins.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert!(!arch.closed());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn closed(&self) -> bool {
        let (start, end) = self.knots().domain();
        let point = |at: f64| {
            let basis = padded::<MAX_ORDER>(self.knots(), at);
            let points = &self.family.points[basis.first..=basis.first + self.knots().degree()];
            points.iter().zip(&basis.values).map(|(point, b)| *b * *point).sum::<DVec4>()
        };
        let net_box = bounds(self.control_points.iter().copied());
        let tolerance = coincidence_tolerance(net_box, self.weights());
        rows_coincide(&[point(start)], &[point(end)], tolerance)
    }

    /// Returns the point at a parameter; outside the domain the outermost piece is extrapolated.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// assert_eq!(arch.point(1.0), 2.0 * DVec3::X);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn point(&self, u: f64) -> DVec3 {
        let mut out = [DVec3::ZERO];
        self.derivatives_at(u, &mut out);
        out[0]
    }

    /// Computes the derivatives of orders 0 to `order` at each parameter: `order + 1` vectors in
    /// `out` for each (The NURBS Book, A4.2).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, Outside}, progress::Silent};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X], 2)?;
    /// let mut out = [DVec3::ZERO; 2];
    /// arch.derivatives(&[0.5], 1, &mut out, Outside::Refuse, &mut Silent)?;
    /// assert_eq!(out, [DVec3::new(1.0, 0.5, 0.5), 2.0 * DVec3::X]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if the order is too high, a parameter is outside the domain and
    ///   `outside` refuses that, or `out` has the wrong length.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn derivatives(
        &self,
        u: &[f64],
        order: usize,
        out: &mut [DVec3],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_order(order)?;
        check_length(out.len(), u.len() * (order + 1))?;
        check_inside("u", self.knots(), outside, 0, u.iter().copied())?;
        let side = order + 1;
        for_row_blocks(u.len(), side * side, observer, |from, to| {
            let tasks = u[from..to].iter().zip(out[from * side..to * side].chunks_mut(side));
            worker_pool::for_each_task(tasks, 256, |(): &mut (), (&u, out)| {
                self.derivatives_at(u, out);
            });
        })
    }

    fn derivatives_at(&self, u: f64, out: &mut [DVec3]) {
        let mut rows = vec![[0.0; MAX_ORDER]; out.len()];
        let first = derivatives(self.knots(), u, &mut rows);
        let points = &self.family.points[first..=first + self.knots().degree()];
        let sum = |row: &[f64; MAX_ORDER]| points.iter().zip(row).map(|(p, b)| *b * *p).sum();
        let table: Vec<DVec4> = rows.iter().map(sum).collect();
        rational_derivatives(&table, 1, out);
    }

    /// The first derivative.
    pub(crate) fn velocity(&self, u: f64) -> DVec3 {
        let mut out = [DVec3::ZERO; 2];
        self.derivatives_at(u, &mut out);
        out[1]
    }

    /// The control points as a family of one curve.
    pub(super) fn family(&self) -> &CurveFamily {
        &self.family
    }
}

/// Returns control points, weights and knots of an arc of the unit circle that begins on the x axis
/// (The NURBS Book, A7.1).
pub(super) fn arc(angle: f64) -> Result<(Vec<DVec2>, Vec<f64>, KnotVector)> {
    if !(0.0 < angle && angle <= TAU) {
        return Err(Error::parameter("angle", "between 0 and a full turn, 2π", angle));
    }
    // A rounded quarter, third or half turn must not need an extra piece.
    let pieces = (1..4).find(|n| angle <= f64::from(*n) * FRAC_PI_2 * (1.0 + 1e-12)).unwrap_or(4);
    let step = angle / f64::from(2 * pieces);
    let middle = step.cos();
    let corner = |i: u32| {
        if angle == f64::from(pieces) * FRAC_PI_2 {
            // Quarter turns are exact, so a full turn ends where it begins.
            let turns = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
            let (x, y) = turns[i as usize % 8];
            return DVec2::new(f64::from(x), f64::from(y));
        }
        let direction = DVec2::from_angle(step * f64::from(i));
        if i % 2 == 1 { direction / middle } else { direction }
    };
    let weights = (0..=2 * pieces).map(|i| if i % 2 == 1 { middle } else { 1.0 }).collect();
    let inner = (1..pieces).flat_map(|i| [f64::from(i) / f64::from(pieces); 2]);
    let knots = KnotVector::clamped(2, (0.0, 1.0), inner)?;
    Ok(((0..=2 * pieces).map(corner).collect(), weights, knots))
}
