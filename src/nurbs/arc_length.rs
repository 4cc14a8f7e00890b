//! Arc length of a curve by adaptive Gauss-Legendre quadrature.

use glam::DAffine3;

use super::control_net::bounds;
use super::curve::NurbsCurve;
use super::gauss::{self, check_accuracy};
use super::work_blocks::interrupt_check;
use crate::error::Result;
use crate::progress::Observer;

/// Quadrature nodes per piece.
const NODE_COUNT: usize = 8;

/// Maximal number of halvings of a span. Near a singular point the remaining pieces are negligible
/// by then.
const MAX_HALVINGS: usize = 12;

/// Relative difference below which two length estimates agree up to rounding.
const ROUNDING: f64 = 1e-15;

impl NurbsCurve {
    /// Returns the length, in the points' unit, with relative error at most `accuracy`.
    ///
    /// Applies Gauss-Legendre quadrature to each span and halves it until two estimates agree.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let circle = NurbsCurve::arc(DVec3::ZERO, DVec3::X, DVec3::Y, std::f64::consts::TAU)?;
    /// let length = circle.length(1e-12, &mut Silent)?;
    /// assert!((length / std::f64::consts::TAU - 1.0).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`crate::Error::Parameter`] if the accuracy is not between 1e-14 and 1,
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn length(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        check_accuracy(accuracy)?;
        let (low, high) = bounds(self.control_points().iter().copied());
        let middle = low.midpoint(high);
        let centered = self.transformed(&DAffine3::from_translation(-middle))?;
        let rule = gauss::rule(NODE_COUNT);
        let breaks = centered.knots().breaks();
        let quadrature = |from: f64, to: f64| -> f64 {
            let speed = |(place, weight): &(f64, f64)| {
                let u = from + place * (to - from);
                weight * (to - from) * centered.velocity(u).length()
            };
            rule.iter().map(speed).sum()
        };
        let spans: Vec<(f64, f64, f64)> = breaks
            .windows(2)
            .map(|ends| (ends[0], ends[1], quadrature(ends[0], ends[1])))
            .collect();
        let total: f64 = spans.iter().map(|(.., length)| length).sum();
        let allowed = (accuracy / spans.len() as f64).max(ROUNDING) * total;
        let mut check_interrupt = interrupt_check(observer);
        let span_length = |span: &(f64, f64, f64)| {
            check_interrupt()?;
            Ok(refined_length(*span, (allowed, false), &quadrature, MAX_HALVINGS))
        };
        spans.iter().map(span_length).sum()
    }
}

/// Returns the length of the piece `(from, to)`, halving it until its estimates agree.
///
/// `length` is the estimate for the whole piece. `parent_agreed` says whether the estimate of the
/// parent piece agreed with the sum over its halves. Two agreements in a row are required, because
/// near a cusp one may be accidental.
fn refined_length(
    (from, to, length): (f64, f64, f64),
    (allowed, parent_agreed): (f64, bool),
    quadrature: &impl Fn(f64, f64) -> f64,
    halvings: usize,
) -> f64 {
    let middle = f64::midpoint(from, to);
    let halves = [(from, middle), (middle, to)].map(|(a, b)| (a, b, quadrature(a, b)));
    let sum = halves[0].2 + halves[1].2;
    let agrees = (sum - length).abs() <= allowed;
    if agrees && parent_agreed || halvings == 0 {
        return sum;
    }
    let allowed = (allowed / 2.0, agrees);
    halves.iter().map(|half| refined_length(*half, allowed, quadrature, halvings - 1)).sum()
}
