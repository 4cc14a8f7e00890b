//! The knot vector, which owns every rule about knots.

use crate::error::{Error, Result};

/// Highest degree in either direction.
pub const MAX_DEGREE: usize = 9;

/// A non-decreasing sequence of knots that belongs to its degree.
///
/// [`KnotVector::new`] is the only door; what has passed it needs no second check: the degree is
/// between 1 and [`MAX_DEGREE`], the knots are finite and do not decrease, there are at least
/// `2 (degree + 1)` of them, the domain is not empty, and no knot is repeated more than `degree`
/// times inside the domain (`degree + 1` times at its ends). So every basis function is defined
/// and the curve or surface is continuous.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
}

impl KnotVector {
    /// A knot vector of this degree.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.control_points(), 4);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for the degree, [`Error::Knots`] for the knots.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self> {
        check_degree(degree)?;
        let fail = |must, got| Err(Error::Knots { degree, must, got });
        if knots.len() < 2 * (degree + 1) {
            let least = 2 * (degree + 1);
            return fail("have 2 (degree + 1) knots", format!("{} < {least} came", knots.len()));
        }
        if let Some(i) = knots.iter().position(|k| !k.is_finite()) {
            return fail("be finite", format!("knot {i} is {}", knots[i]));
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
            let got = format!("knot {} is {} after {}", i + 1, knots[i + 1], knots[i]);
            return fail("not decrease", got);
        }
        let knots = Self { degree, knots };
        let (start, end) = knots.domain();
        if start >= end {
            return fail("have a domain", format!("it begins and ends at {start}"));
        }
        for (value, times) in knots.distinct() {
            let inside = start < value && value < end;
            if times > degree + usize::from(!inside) {
                let got = format!("{value} stands {times} times");
                return fail("repeat no knot more than degree times (once more at the ends)", got);
            }
        }
        Ok(knots)
    }

    /// The clamped knot vector on `[0, 1]` with evenly spaced inner knots.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree is out of range or there are not more control points
    /// than the degree.
    pub fn clamped_uniform(degree: usize, control_points: usize) -> Result<Self> {
        check_degree(degree)?;
        if control_points <= degree {
            let must = format!("more than the degree, {degree}");
            return Err(Error::parameter("number of control points", must, control_points));
        }
        let spans = control_points - degree;
        let inner = (1..spans).map(|i| i as f64 / spans as f64);
        let ends = |value| std::iter::repeat_n(value, degree + 1);
        Ok(Self { degree, knots: ends(0.0).chain(inner).chain(ends(1.0)).collect() })
    }

    /// The degree of the basis functions.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// How many basis functions, and so control points, there are.
    #[must_use]
    pub fn control_points(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// All knots, with repetitions.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.knots
    }

    /// First and last parameter of the curve or surface.
    #[must_use]
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.control_points()])
    }

    /// Whether the first and last knots stand `degree + 1` times, so that the outermost control
    /// points are ends of the curve.
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        let (start, end) = self.domain();
        self.knots[0] == start && self.knots[self.knots.len() - 1] == end
    }

    /// The distinct knots with their multiplicities, in order.
    pub fn distinct(&self) -> impl Iterator<Item = (f64, usize)> {
        let runs = self.knots.chunk_by(|a, b| a == b);
        runs.map(|run| (run[0], run.len()))
    }

    /// The number of spans of the domain that are not empty.
    #[must_use]
    pub fn spans(&self) -> usize {
        let domain = &self.knots[self.degree..=self.control_points()];
        domain.windows(2).filter(|pair| pair[0] < pair[1]).count()
    }

    /// The index i with `knots[i] <= u < knots[i + 1]`, in the last span also with `u` at its end
    /// (The NURBS Book, A2.1). Outside the domain: the first or last span. The span is never empty.
    #[must_use]
    pub(super) fn span(&self, u: f64) -> usize {
        let (start, end) = self.domain();
        // The knot at either end of the domain may stand more often than the degree's share of it.
        let before = if u < end { u.max(start) } else { end.next_down() };
        self.knots[..=self.control_points()].partition_point(|&knot| knot <= before) - 1
    }
}

/// Checks that a degree is one that the kernel works with.
pub(crate) fn check_degree(degree: usize) -> Result<()> {
    if (1..=MAX_DEGREE).contains(&degree) {
        Ok(())
    } else {
        Err(Error::parameter("degree", format!("between 1 and {MAX_DEGREE}"), degree))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(degree: usize, knots: &[f64]) -> String {
        KnotVector::new(degree, knots.to_vec()).unwrap_err().to_string()
    }

    #[test]
    fn refusals_name_both_numbers() {
        assert!(message(0, &[0.0, 1.0]).contains("between 1 and 9, got 0"));
        assert!(message(3, &[0.0, 1.0]).contains("2 < 8 came"));
        assert!(message(1, &[0.0, 0.0, f64::NAN, 1.0]).contains("knot 2 is NaN"));
        assert!(message(1, &[0.0, 0.0, 2.0, 1.0]).contains("knot 3 is 1 after 2"));
        assert!(message(1, &[0.0, 1.0, 1.0, 2.0]).contains("begins and ends at 1"));
        assert!(message(1, &[0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).contains("0.5 stands 2 times"));
        assert!(message(1, &[0.0, 0.0, 0.0, 0.5, 1.0, 1.0]).contains("0 stands 3 times"));
    }

    #[test]
    fn unclamped_and_repeated_knots_are_accepted() {
        assert!(KnotVector::new(2, (0..8).map(f64::from).collect()).is_ok());
        assert!(KnotVector::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).is_ok());
    }

    #[test]
    fn spans_follow_the_definition() {
        let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
        assert_eq!(knots.spans(), 2);
        for (u, span) in [(-1.0, 2), (0.0, 2), (0.99, 2), (1.0, 4), (1.5, 4), (2.0, 4), (9.0, 4)] {
            assert_eq!(knots.span(u), span, "u = {u}");
        }
    }

    #[test]
    fn clamped_uniform_is_what_new_accepts() {
        for degree in 1..=MAX_DEGREE {
            for count in degree + 1..degree + 6 {
                let knots = KnotVector::clamped_uniform(degree, count).unwrap();
                assert_eq!(knots.control_points(), count);
                assert_eq!(KnotVector::new(degree, knots.as_slice().to_vec()).unwrap(), knots);
            }
        }
        assert!(KnotVector::clamped_uniform(3, 3).is_err());
    }
}
