//! The knot vector, which owns every rule about knots.

use crate::error::{Error, Result};

/// Highest degree in either direction.
pub const MAX_DEGREE: usize = 9;

/// Cells of the table that finds spans, for each span: with two, and evenly spaced knots, a cell
/// and its neighbours hold [`FEW`] of them.
const CELLS_PER_SPAN: usize = 2;

/// So many knots are compared without branches, which random parameters would mispredict.
const FEW: u32 = 2;

/// A non-decreasing sequence of knots that belongs to its degree.
///
/// [`KnotVector::new`] is the only door; what has passed it needs no second check: the degree is
/// between 1 and [`MAX_DEGREE`], the knots are finite and do not decrease, there are at least
/// `2 (degree + 1)` of them, the domain is not empty, and no knot is repeated more than `degree`
/// times inside the domain (`degree + 1` times at its ends). So every basis function is defined
/// and the curve or surface is continuous.
#[derive(Clone)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
    /// For each level k from 1 to the degree, one after the other: `1 / (knots[j] - knots[j - k])`
    /// at j, zero where the knots coincide. Basis functions divide by nothing else.
    reciprocals: Vec<f64>,
    /// For each cell of an even division of the domain, the spans that its parameters can be in.
    cells: Vec<(u32, u32)>,
    /// Whether no cell leaves more than [`FEW`] knots to compare with.
    even: bool,
    /// Cells for each unit of the parameter.
    cell_density: f64,
    /// Index of the last knot below the domain's end: that of its last span.
    last_span: usize,
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
        let knots = Self {
            degree,
            knots,
            reciprocals: vec![],
            cells: vec![],
            even: false,
            cell_density: 0.0,
            last_span: 0,
        };
        let pairs = || knots.knots.windows(2);
        let ordinary =
            |width: f64| width == 0.0 || (width.is_finite() && width.recip().is_finite());
        if let Some(i) = pairs().position(|pair| !ordinary(pair[1] - pair[0])) {
            let got = format!(
                "knots {i} and {} are {:e} apart",
                i + 1,
                knots.knots[i + 1] - knots.knots[i]
            );
            return fail("have spans that can be divided by", got);
        }
        let (start, end) = knots.domain();
        if start >= end {
            return fail("have a domain", format!("it begins and ends at {start}"));
        }
        if !(end - start).is_finite() || !(end - start).recip().is_finite() {
            let got = format!("it reaches from {start:e} to {end:e}");
            return fail("have a domain whose length and its inverse are numbers", got);
        }
        for (value, times) in knots.distinct() {
            let inside = start < value && value < end;
            if times > degree + usize::from(!inside) {
                let got = format!("{value} stands {times} times");
                return fail("repeat no knot more than degree times (once more at the ends)", got);
            }
        }
        Ok(knots.tabulated())
    }

    /// With the tables that make evaluation fast.
    fn tabulated(mut self) -> Self {
        let t = &self.knots;
        let reciprocal = |(k, j): (usize, usize)| match j.checked_sub(k).map(|i| t[j] - t[i]) {
            Some(width) if width > 0.0 => width.recip(),
            _ => 0.0,
        };
        let levels = (1..=self.degree).flat_map(|k| (0..t.len()).map(move |j| (k, j)));
        self.reciprocals = levels.map(reciprocal).collect();
        let (start, end) = self.domain();
        let count = CELLS_PER_SPAN * (self.control_points() - self.degree);
        // One cell more on both sides, against the rounding of the parameter's cell.
        let border = |i: f64| start + i / count as f64 * (end - start);
        self.last_span = t.partition_point(|&knot| knot < end) - 1;
        let inner = &t[self.degree + 1..=self.last_span];
        let before = |u: f64| u32::try_from(inner.partition_point(|&knot| knot <= u));
        let cell = |i: usize| {
            let (i, most) = (i as f64, inner.len());
            let most = u32::try_from(most).unwrap_or(u32::MAX);
            (before(border(i - 1.0)).unwrap_or(0), before(border(i + 2.0)).unwrap_or(most))
        };
        self.cells = (0..count).map(cell).collect();
        self.even = self.cells.iter().all(|(from, to)| to - from <= FEW);
        self.cell_density = count as f64 / (end - start);
        self
    }

    /// Knots that repeat with the period of `[0, 1]`, evenly spaced, for a closed curve or
    /// surface: the last `degree` control points are the first ones again, and the seam is as
    /// smooth as every other knot.
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
    /// [`Error::Parameter`] if the degree is out of range or there are not more different control
    /// points than the degree.
    pub fn periodic_uniform(degree: usize, distinct: usize) -> Result<Self> {
        check_count(degree, distinct)?;
        let breaks: Vec<f64> = (0..=distinct).map(|i| i as f64 / distinct as f64).collect();
        Self::periodic(degree, &breaks)
    }

    /// Knots that repeat with the period from the first to the last of `breaks`, which increase.
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

    /// Clamped knots with these inner ones.
    pub(crate) fn clamped(
        degree: usize,
        (start, end): (f64, f64),
        inner: impl IntoIterator<Item = f64>,
    ) -> Result<Self> {
        let ends = |value| std::iter::repeat_n(value, degree + 1);
        Self::new(degree, ends(start).chain(inner).chain(ends(end)).collect())
    }

    /// The clamped knot vector on `[0, 1]` with evenly spaced inner knots.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree is out of range or there are not more control points
    /// than the degree.
    pub fn clamped_uniform(degree: usize, control_points: usize) -> Result<Self> {
        check_count(degree, control_points)?;
        let spans = control_points - degree;
        Self::clamped(degree, (0.0, 1.0), (1..spans).map(|i| i as f64 / spans as f64))
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

    /// Whether the curve or surface begins and ends at its outermost control points: the first and
    /// the last `degree` knots before the domain's ends equal them.
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        let (start, end) = self.domain();
        self.knots[1] == start && self.knots[self.knots.len() - 2] == end
    }

    /// The knots strictly inside the domain, with repetitions.
    #[must_use]
    pub fn inner(&self) -> &[f64] {
        let (start, end) = self.domain();
        let from = self.knots.partition_point(|&knot| knot <= start);
        &self.knots[from..self.knots.partition_point(|&knot| knot < end)]
    }

    /// Ends of the domain and distinct knots inside it: between two neighbours lies one span.
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        let (start, end) = self.domain();
        let mut breaks: Vec<f64> =
            [start].iter().chain(self.inner()).chain(&[end]).copied().collect();
        breaks.dedup();
        breaks
    }

    /// The Greville abscissae, one for each control point: averages of `degree` knots.
    #[must_use]
    pub fn greville(&self) -> Vec<f64> {
        let average = |knots: &[f64]| knots.iter().sum::<f64>() / self.degree as f64;
        let windows = self.knots[1..self.knots.len() - 1].windows(self.degree);
        windows.map(average).collect()
    }

    /// Whether the knots repeat with the length of the domain as their period, so that the basis
    /// functions of a closed curve or surface fit together at the seam.
    #[must_use]
    pub fn is_periodic(&self) -> bool {
        let (start, end) = self.domain();
        let (period, n) = (end - start, self.control_points());
        let tolerance = PERIOD_ROUNDING * period;
        let pairs = self.knots.iter().zip(&self.knots[n - self.degree..]);
        pairs.into_iter().all(|(a, b)| (b - a - period).abs() <= tolerance)
    }

    /// How often a value stands among the knots.
    #[must_use]
    pub fn multiplicity(&self, value: f64) -> usize {
        self.knots.iter().filter(|&&knot| knot == value).count()
    }

    /// The same knots on another domain.
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
    #[must_use]
    pub fn reversed(&self) -> Self {
        let (start, end) = self.domain();
        let place = |&knot: &f64| match knot {
            knot if knot == start => end,
            knot if knot == end => start,
            knot => start + (end - knot),
        };
        let knots = self.knots.iter().rev().map(place).collect();
        Self { knots, ..self.clone() }.tabulated()
    }

    /// The distinct knots with their multiplicities, in order.
    pub fn distinct(&self) -> impl Iterator<Item = (f64, usize)> {
        let runs = self.knots.chunk_by(|a, b| a == b);
        runs.map(|run| (run[0], run.len()))
    }

    /// The number of spans of the domain that are not empty.
    #[must_use]
    pub fn spans(&self) -> usize {
        self.breaks().len() - 1
    }

    /// The index i with `knots[i] <= u < knots[i + 1]`, in the last span also with `u` at its end
    /// (The NURBS Book, A2.1). Outside the domain: the first or last span. The span is never empty.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    pub(crate) fn span(&self, u: f64) -> usize {
        let start = self.knots[self.degree];
        let share = (u - start) * self.cell_density;
        // Outside the domain the cast saturates, and NaN becomes 0.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let (from, to) = self.cells[(share as usize).min(self.cells.len() - 1)];
        let (from, to) = (self.degree + from as usize, self.degree + to as usize);
        let u = u.max(start);
        if self.even {
            // Behind the last span's knot stand at least two more.
            let passed = |i: usize| usize::from(self.knots[from + i] <= u);
            return (from + passed(1) + passed(2)).min(self.last_span);
        }
        from + self.knots[from + 1..=to].partition_point(|&knot| knot <= u)
    }

    /// At level `k` (1 to the degree), `1 / (knots[j] - knots[j - k])` for all j.
    #[inline]
    pub(super) fn reciprocals(&self, k: usize) -> &[f64] {
        &self.reciprocals[(k - 1) * self.knots.len()..k * self.knots.len()]
    }
}

/// Differences of knots that should be one period agree to this share of it.
const PERIOD_ROUNDING: f64 = 1e-12;

/// Checks that there are enough control points for a degree that the kernel works with.
fn check_count(degree: usize, control_points: usize) -> Result<()> {
    check_degree(degree)?;
    if control_points > degree {
        return Ok(());
    }
    let must = format!("more than the degree, {degree}");
    Err(Error::parameter("number of control points", must, control_points))
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
        assert!(message(1, &[0.0, 0.0, 5e-324, 5e-324]).contains("knots 1 and 2 are 5e-324 apart"));
        assert!(message(1, &[-1e308, -1e308, 1e308, 1e308]).contains("are inf apart"));
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
    fn spans_are_never_empty_and_found_by_table() {
        let unclamped = KnotVector::new(2, vec![0.0, 1.0, 2.0, 2.0, 3.0, 4.0, 4.0, 5.0]).unwrap();
        let clustered: Vec<f64> = (0..50).map(|i| 1e-6 * f64::from(i)).collect();
        let clustered = KnotVector::clamped(3, (0.0, 1.0), clustered[1..].to_vec()).unwrap();
        for knots in [unclamped, clustered] {
            let (t, (start, end)) = (knots.as_slice(), knots.domain());
            let mut places: Vec<f64> = (0..1000).map(|i| f64::from(i) / 999.0).collect();
            places.extend(places.clone().iter().map(|u| 1e-4 * u));
            for u in places.iter().map(|u| start + u * (end - start)) {
                let span = knots.span(u);
                assert!(t[span] <= u && (u < t[span + 1] || u == end), "{u} in {span}");
                assert!(t[span] < t[span + 1]);
            }
        }
    }

    #[test]
    fn periodic_knots_repeat() {
        for degree in 1..=MAX_DEGREE {
            let knots = KnotVector::periodic(degree, &[1.0, 1.5, 4.0]).unwrap();
            assert!(knots.is_periodic());
            // A polygon begins at its first control point, whatever the knot before it.
            assert_eq!(knots.is_clamped(), degree == 1);
            assert_eq!((knots.control_points(), knots.domain()), (degree + 2, (1.0, 4.0)));
            assert!(knots.reversed().is_periodic());
            assert!(knots.with_domain((-7.0, 0.1)).unwrap().is_periodic());
        }
        assert!(!KnotVector::clamped_uniform(3, 9).unwrap().is_periodic());
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
