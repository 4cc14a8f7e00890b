//! The knot vector and its validity rules.

use super::span_table::SpanTable;
use crate::error::{Error, Result};

/// Highest degree in either direction, that of OpenCASCADE.
pub const MAX_DEGREE: usize = 25;

/// A non-decreasing sequence of knots with its degree.
///
/// [`KnotVector::new`] checks all rules, so other code need not:
///
/// - The degree is between 1 and [`MAX_DEGREE`].
/// - The knots are finite and do not decrease.
/// - There are at least `2 (degree + 1)` knots.
/// - The domain is not empty.
/// - The multiplicity of a knot is at most `degree` inside the domain and `degree + 1` at its ends.
///
/// Hence every basis function is defined, and the curve or surface is continuous.
#[derive(Clone)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
    /// For each level k from 1 to the degree: `1 / (knots[j] - knots[j - k])` for all j, zero where
    /// the knots coincide. These are the only denominators of basis functions.
    reciprocals: Vec<f64>,
    table: SpanTable,
}

impl PartialEq for KnotVector {
    fn eq(&self, other: &Self) -> bool {
        self.degree == other.degree && self.knots == other.knots
    }
}

impl std::fmt::Debug for KnotVector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { degree, knots, .. } = self;
        f.debug_struct("KnotVector").field("degree", degree).field("knots", knots).finish()
    }
}

impl KnotVector {
    /// Builds a knot vector of this degree.
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
    /// [`Error::Parameter`] if the degree is out of range, [`Error::Knots`] if the knots break a
    /// rule.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self> {
        check_degree(degree)?;
        let fail = |must, got| Err(Error::Knots { degree, must, got });
        if knots.len() < 2 * (degree + 1) {
            let required = 2 * (degree + 1);
            return fail(
                "have at least 2 (degree + 1) knots",
                format!("{} of {required} were given", knots.len()),
            );
        }
        if let Some(i) = knots.iter().position(|k| !k.is_finite()) {
            return fail("be finite", format!("knot {i} is {}", knots[i]));
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
            let got = format!("knot {} is {} after {}", i + 1, knots[i + 1], knots[i]);
            return fail("not decrease", got);
        }
        let invertible =
            |width: f64| width == 0.0 || (width.is_finite() && width.recip().is_finite());
        if let Some(i) = knots.windows(2).position(|pair| !invertible(pair[1] - pair[0])) {
            let got = format!("knots {i} and {} are {:e} apart", i + 1, knots[i + 1] - knots[i]);
            return fail("have spans with finite reciprocals", got);
        }
        let (start, end) = (knots[degree], knots[knots.len() - degree - 1]);
        if start >= end {
            return fail("have a nonempty domain", format!("it begins and ends at {start}"));
        }
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        if !(last - first).is_finite() || !(end - start).recip().is_finite() {
            let got = format!("they reach from {first:e} to {last:e}");
            return fail("have a finite length, and a domain with a finite reciprocal", got);
        }
        for run in knots.chunk_by(|a, b| a == b) {
            let inside = start < run[0] && run[0] < end;
            if run.len() > degree + usize::from(!inside) {
                let got = format!("{} has multiplicity {}", run[0], run.len());
                return fail("repeat no knot more than degree times (once more at the ends)", got);
            }
        }
        Ok(Self::with_tables(degree, knots))
    }

    /// Builds the tables for fast evaluation of valid knots.
    fn with_tables(degree: usize, knots: Vec<f64>) -> Self {
        let reciprocal =
            |(k, j): (usize, usize)| match j.checked_sub(k).map(|i| knots[j] - knots[i]) {
                Some(width) if width > 0.0 => width.recip(),
                _ => 0.0,
            };
        let levels = (1..=degree).flat_map(|k| (0..knots.len()).map(move |j| (k, j)));
        let (reciprocals, table) =
            (levels.map(reciprocal).collect(), SpanTable::new(degree, &knots));
        Self { degree, knots, reciprocals, table }
    }

    /// The degree of the basis functions.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.degree(), 2);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The number of basis functions, and of control points.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.control_points(), 5);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn control_points(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// All knots, with repetitions.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.as_slice()[2..5], [0.0, 0.5, 0.5]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.knots
    }

    /// The first and last parameter of the curve or surface.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.domain(), (0.0, 1.0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.control_points()])
    }

    /// Whether the curve or surface begins and ends at its outermost control points: the knots at
    /// both ends of the domain have multiplicity `degree` or more.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert!(knots.is_clamped());
    /// assert!(!KnotVector::periodic_uniform(2, 4)?.is_clamped());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        let (start, end) = self.domain();
        self.knots[1] == start && self.knots[self.knots.len() - 2] == end
    }

    /// The knots strictly inside the domain, with repetitions.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.inner(), [0.5, 0.5]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn inner(&self) -> &[f64] {
        let (start, end) = self.domain();
        let from = self.knots.partition_point(|&knot| knot <= start);
        &self.knots[from..self.knots.partition_point(|&knot| knot < end)]
    }

    /// The ends of the domain and the distinct knots inside it. Neighboring breaks bound a span.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.breaks(), [0.0, 0.5, 1.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        let (start, end) = self.domain();
        let mut breaks: Vec<f64> =
            [start].iter().chain(self.inner()).chain(&[end]).copied().collect();
        breaks.dedup();
        breaks
    }

    /// The Greville abscissae, one for each control point: averages of `degree` knots.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.greville(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn greville(&self) -> Vec<f64> {
        let average = |knots: &[f64]| knots.iter().sum::<f64>() / self.degree as f64;
        let windows = self.knots[1..self.knots.len() - 1].windows(self.degree);
        windows.map(average).collect()
    }

    /// The multiplicity of a value among the knots.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!((knots.multiplicity(0.5), knots.multiplicity(0.7)), (2, 0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn multiplicity(&self, value: f64) -> usize {
        self.knots.iter().filter(|&&knot| knot == value).count()
    }

    /// Maps the knots linearly to another domain.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.with_domain((0.0, 4.0))?.inner(), [2.0, 2.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Knots`] if the new domain is empty or not finite.
    pub fn with_domain(&self, (start, end): (f64, f64)) -> Result<Self> {
        let (from, to) = self.domain();
        let scale = (end - start) / (to - from);
        let place = |&knot: &f64| match knot {
            knot if knot == from => start,
            knot if knot == to => end,
            knot => start + (knot - from) * scale,
        };
        Self::new(self.degree, self.knots.iter().map(place).collect())
    }

    /// The knots of the reversed curve on the same domain.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(1, vec![0.0, 0.0, 0.25, 1.0, 1.0])?;
    /// assert_eq!(knots.reversed().inner(), [0.75]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn reversed(&self) -> Self {
        let (start, end) = self.domain();
        let place = |&knot: &f64| match knot {
            knot if knot == start => end,
            knot if knot == end => start,
            knot => start + (end - knot),
        };
        Self::with_tables(self.degree, self.knots.iter().rev().map(place).collect())
    }

    /// The distinct knots with their multiplicities, in order.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.distinct().collect::<Vec<_>>(), [(0.0, 3), (0.5, 2), (1.0, 3)]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    pub fn distinct(&self) -> impl Iterator<Item = (f64, usize)> {
        let runs = self.knots.chunk_by(|a, b| a == b);
        runs.map(|run| (run[0], run.len()))
    }

    /// The number of nonempty spans of the domain.
    ///
    /// ```
    /// use neurbs::nurbs::KnotVector;
    /// let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0])?;
    /// assert_eq!(knots.spans(), 2);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn spans(&self) -> usize {
        self.breaks().len() - 1
    }

    /// The index i with `knots[i] <= u < knots[i + 1]`; see [`SpanTable::span`].
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(crate) fn span(&self, u: f64) -> usize {
        self.table.span(self.degree, &self.knots, u)
    }

    /// At level `k` (1 to the degree), `1 / (knots[j] - knots[j - k])` for all j.
    #[inline]
    pub(crate) fn reciprocals(&self, k: usize) -> &[f64] {
        &self.reciprocals[(k - 1) * self.knots.len()..k * self.knots.len()]
    }
}

/// Checks that a degree is between 1 and [`MAX_DEGREE`].
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
    fn error_messages_contain_both_numbers() {
        assert!(message(0, &[0.0, 1.0]).contains("between 1 and 25, got 0"));
        assert!(message(3, &[0.0, 1.0]).contains("2 of 8 were given"));
        assert!(message(1, &[0.0, 0.0, f64::NAN, 1.0]).contains("knot 2 is NaN"));
        assert!(message(1, &[0.0, 0.0, 2.0, 1.0]).contains("knot 3 is 1 after 2"));
        assert!(message(1, &[0.0, 1.0, 1.0, 2.0]).contains("begins and ends at 1"));
        assert!(message(1, &[0.0, 0.0, 5e-324, 5e-324]).contains("knots 1 and 2 are 5e-324 apart"));
        assert!(message(1, &[-1e308, -1e308, 1e308, 1e308]).contains("are inf apart"));
        assert!(message(1, &[0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).contains("0.5 has multiplicity 2"));
        assert!(message(1, &[0.0, 0.0, 0.0, 0.5, 1.0, 1.0]).contains("0 has multiplicity 3"));
    }

    #[test]
    fn unclamped_and_repeated_knots_are_accepted() {
        assert!(KnotVector::new(2, (0..8).map(f64::from).collect()).is_ok());
        assert!(KnotVector::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).is_ok());
    }
}
