//! A lookup table for the span of a parameter (The NURBS Book, A2.1), instead of a binary search.

/// Cells of the table per span. For evenly spaced knots, three neighboring cells then contain at
/// most [`MAX_KNOTS_PER_CELL`] knots.
const CELLS_PER_SPAN: usize = 2;

/// Number of knots that are compared without branches; random parameters would mispredict branches.
const MAX_KNOTS_PER_CELL: u32 = 2;

/// A uniform division of the domain; each cell has the range of spans of its parameters.
#[derive(Clone, Debug)]
pub(super) struct SpanTable {
    cells: Vec<(u32, u32)>,
    /// Whether every cell has at most [`MAX_KNOTS_PER_CELL`] knots to compare with.
    even: bool,
    /// Cells per unit of the parameter.
    density: f64,
    /// Index of the last span: of the last knot before the end of the domain.
    last: usize,
}

impl SpanTable {
    /// Builds the table for valid knots of this degree.
    pub(super) fn new(degree: usize, knots: &[f64]) -> Self {
        let control_points = knots.len() - degree - 1;
        let (start, end) = (knots[degree], knots[control_points]);
        let count = CELLS_PER_SPAN * (control_points - degree);
        // One more cell on both sides, because the cell of a parameter is rounded.
        let border = |i: f64| start + i / count as f64 * (end - start);
        let last = knots.partition_point(|&knot| knot < end) - 1;
        let inner = &knots[degree + 1..=last];
        let before = |u: f64| u32::try_from(inner.partition_point(|&knot| knot <= u));
        let cell = |i: usize| {
            let (i, most) = (i as f64, inner.len());
            let most = u32::try_from(most).unwrap_or(u32::MAX);
            (before(border(i - 1.0)).unwrap_or(0), before(border(i + 2.0)).unwrap_or(most))
        };
        let cells: Vec<(u32, u32)> = (0..count).map(cell).collect();
        let even = cells.iter().all(|(from, to)| to - from <= MAX_KNOTS_PER_CELL);
        Self { cells, even, density: count as f64 / (end - start), last }
    }

    /// Returns the index i with `knots[i] <= u < knots[i + 1]`; in the last span also for `u` at
    /// its end (The NURBS Book, A2.1).
    ///
    /// Outside the domain it is the first or last span. The span is never empty.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn span(&self, degree: usize, knots: &[f64], u: f64) -> usize {
        let start = knots[degree];
        let share = (u - start) * self.density;
        // Outside the domain the cast saturates; NaN becomes 0.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let (from, to) = self.cells[(share as usize).min(self.cells.len() - 1)];
        let (from, to) = (degree + from as usize, degree + to as usize);
        let u = u.max(start);
        if self.even {
            // At least two more knots follow the last span.
            let passed = |i: usize| usize::from(knots[from + i] <= u);
            return (from + passed(1) + passed(2)).min(self.last);
        }
        from + knots[from + 1..=to].partition_point(|&knot| knot <= u)
    }
}

#[cfg(test)]
mod tests {
    use crate::nurbs::KnotVector;

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
}
