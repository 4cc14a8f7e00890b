//! The length of a curve.

use glam::DAffine3;

use super::control_net::bounds;
use super::curve::NurbsCurve;
use super::gauss::{self, check_accuracy};
use super::work_blocks::listening;
use crate::error::Result;
use crate::progress::Observer;

/// Points of the quadrature along a piece.
const NODES: usize = 8;

/// Halvings of a span at most when its length is measured: where the curve is singular, the pieces
/// are negligible by then.
const MOST_HALVINGS: usize = 12;

/// Two estimates of a length agree when they differ by this share of it: the rest is rounding.
const ROUNDING: f64 = 1e-15;

impl NurbsCurve {
    /// The length, in the points' unit, to a share of `accuracy`: Gauss-Legendre quadrature on each
    /// span, which is halved until it agrees with itself.
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
    /// [`Error::Parameter`] if the accuracy is not between 1e-14 and 1, [`Error::Interrupted`] if
    /// the observer stops it.
    pub fn length(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        check_accuracy(accuracy)?;
        let (low, high) = bounds(self.control_points().iter().copied());
        let middle = low.midpoint(high);
        let centred = self.transformed(&DAffine3::from_translation(-middle))?;
        let rule = gauss::rule(NODES);
        let breaks = centred.knots().breaks();
        let part = |from: f64, to: f64| -> f64 {
            let speed = |(place, weight): &(f64, f64)| {
                let u = from + place * (to - from);
                weight * (to - from) * centred.velocity(u).length()
            };
            rule.iter().map(speed).sum()
        };
        let spans: Vec<(f64, f64, f64)> =
            breaks.windows(2).map(|ends| (ends[0], ends[1], part(ends[0], ends[1]))).collect();
        let total: f64 = spans.iter().map(|(.., length)| length).sum();
        let enough = (accuracy / spans.len() as f64).max(ROUNDING) * total;
        let mut listen = listening(observer);
        let whole = |span: &(f64, f64, f64)| {
            listen()?;
            Ok(halved(*span, (enough, false), &part, MOST_HALVINGS))
        };
        spans.iter().map(whole).sum()
    }
}

/// The length of a piece, from one parameter to another, of which this estimate is known, and
/// whether it agreed with that of the piece it is a half of. Near a cusp one agreement may be chance.
fn halved(
    (from, to, length): (f64, f64, f64),
    (enough, agreed): (f64, bool),
    part: &impl Fn(f64, f64) -> f64,
    halvings: usize,
) -> f64 {
    let middle = f64::midpoint(from, to);
    let halves = [(from, middle), (middle, to)].map(|(a, b)| (a, b, part(a, b)));
    let sum = halves[0].2 + halves[1].2;
    let agrees = (sum - length).abs() <= enough;
    if agrees && agreed || halvings == 0 {
        return sum;
    }
    let enough = (enough / 2.0, agrees);
    halves.iter().map(|half| halved(*half, enough, part, halvings - 1)).sum()
}
