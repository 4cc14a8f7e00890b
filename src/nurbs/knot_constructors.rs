//! Clamped and periodic knot vectors, evenly spaced or with given inner knots.

use super::knot_vector::{KnotVector, check_degree};
use crate::error::{Error, Result};

/// Maximal number of control points of evenly spaced knots. A larger number is probably an error
/// and would exhaust memory.
const MAX_CONTROL_POINTS: usize = 1 << 24;

/// Relative difference below which two knot distances equal the period up to rounding.
const PERIOD_ROUNDING: f64 = 1e-12;

impl KnotVector {
    /// Builds evenly spaced knots on `[0, 1]` that repeat with period 1, for a closed curve or
    /// surface.
    ///
    /// The last `degree` control points repeat the first ones, and the seam is as smooth as every
    /// other knot.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::periodic_uniform(2, 4)?;
    /// assert_eq!(knots.control_points(), 4 + 2);
    /// assert_eq!(knots.as_slice()[..4], [-0.5, -0.25, 0.0, 0.25]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree is out of range or there are at most `degree` distinct
    /// control points.
    pub fn periodic_uniform(degree: usize, distinct: usize) -> Result<Self> {
        check_count(degree, distinct)?;
        let breaks: Vec<f64> = (0..=distinct).map(|i| i as f64 / distinct as f64).collect();
        Self::periodic(degree, &breaks)
    }

    /// Builds knots whose period is the distance from the first to the last of `breaks`, which
    /// increase.
    pub(crate) fn periodic(degree: usize, breaks: &[f64]) -> Result<Self> {
        let (count, period) = (breaks.len() - 1, breaks[breaks.len() - 1] - breaks[0]);
        let before = (1..=degree).rev().map(|i| {
            let turns = i.div_ceil(count);
            breaks[turns * count - i] - turns as f64 * period
        });
        let after = (1..=degree).map(|i| breaks[i % count] + (i / count) as f64 * period);
        let after = after.map(|knot| knot + period);
        Self::new(degree, before.chain(breaks.iter().copied()).chain(after).collect())
    }

    /// Builds clamped knots with these inner knots.
    pub(crate) fn clamped(
        degree: usize,
        (start, end): (f64, f64),
        inner: impl IntoIterator<Item = f64>,
    ) -> Result<Self> {
        let ends = |value| std::iter::repeat_n(value, degree + 1);
        Self::new(degree, ends(start).chain(inner).chain(ends(end)).collect())
    }

    /// Builds clamped knots on `[0, 1]` with evenly spaced inner knots.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::clamped_uniform(1, 3)?;
    /// assert_eq!(knots.as_slice(), [0.0, 0.0, 0.5, 1.0, 1.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree is out of range or there are at most `degree` control
    /// points.
    pub fn clamped_uniform(degree: usize, control_points: usize) -> Result<Self> {
        check_count(degree, control_points)?;
        let spans = control_points - degree;
        Self::clamped(degree, (0.0, 1.0), (1..spans).map(|i| i as f64 / spans as f64))
    }

    /// Whether the knots repeat with the length of the domain as period. Then the basis functions
    /// of a closed curve or surface match at the seam.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// assert!(KnotVector::periodic_uniform(2, 4)?.is_periodic());
    /// assert!(!KnotVector::clamped_uniform(2, 4)?.is_periodic());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn is_periodic(&self) -> bool {
        let (start, end) = self.domain();
        let (period, n) = (end - start, self.control_points());
        let tolerance = PERIOD_ROUNDING * period;
        let pairs = self.as_slice().iter().zip(&self.as_slice()[n - self.degree()..]);
        pairs.into_iter().all(|(a, b)| (b - a - period).abs() <= tolerance)
    }
}

/// Checks the degree, and that there are more control points than the degree.
fn check_count(degree: usize, control_points: usize) -> Result<()> {
    check_degree(degree)?;
    if (degree + 1..=MAX_CONTROL_POINTS).contains(&control_points) {
        return Ok(());
    }
    let must = if control_points > degree {
        format!("at most {MAX_CONTROL_POINTS}")
    } else {
        format!("more than the degree, {degree}")
    };
    Err(Error::parameter("number of control points", must, control_points))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::MAX_DEGREE;

    #[test]
    fn periodic_knots_repeat() {
        for degree in 1..=MAX_DEGREE {
            let knots = KnotVector::periodic(degree, &[1.0, 1.5, 4.0]).unwrap();
            assert!(knots.is_periodic());
            // With degree 1, a curve always begins at its first control point.
            assert_eq!(knots.is_clamped(), degree == 1);
            assert_eq!((knots.control_points(), knots.domain()), (degree + 2, (1.0, 4.0)));
            assert!(knots.reversed().is_periodic());
            assert!(knots.with_domain((-7.0, 0.1)).unwrap().is_periodic());
        }
        assert!(!KnotVector::clamped_uniform(3, 9).unwrap().is_periodic());
    }

    #[test]
    fn clamped_uniform_knots_are_valid() {
        for degree in 1..=MAX_DEGREE {
            for count in degree + 1..degree + 6 {
                let knots = KnotVector::clamped_uniform(degree, count).unwrap();
                assert_eq!(knots.control_points(), count);
                assert_eq!(KnotVector::new(degree, knots.as_slice().to_vec()).unwrap(), knots);
            }
        }
        assert!(KnotVector::clamped_uniform(3, 3).is_err());
        assert!(KnotVector::clamped_uniform(3, usize::MAX).is_err());
        assert!(KnotVector::periodic_uniform(3, usize::MAX).is_err());
    }
}
