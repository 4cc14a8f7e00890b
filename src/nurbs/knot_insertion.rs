//! Knot insertion, and conversion to clamped and to Bézier form.

use glam::DVec4;

use super::curve_family::{CurveFamily, concat_rows};
use super::knot_vector::KnotVector;
use super::work_blocks::row_ranges;
use crate::error::{Error, Result};
use crate::memory;
use crate::progress::InterruptCheck;

impl CurveFamily {
    /// Returns rows that are combinations of two rows each: `share` times the first
    /// plus `1 - share` times the second. A share of 1 copies the first row exactly.
    fn combined_rows(
        &self,
        count: usize,
        row: impl Fn(usize) -> (f64, usize, usize),
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Vec<DVec4>> {
        let mut points = Vec::with_capacity(count * self.width);
        for range in row_ranges(count, self.width) {
            check_interrupt()?;
            for (share, a, b) in range.map(&row) {
                let pairs = self.row(a).iter().zip(self.row(b));
                points.extend(pairs.map(|(a, b)| share * *a + (1.0 - share) * *b));
            }
        }
        Ok(points)
    }

    /// Inserts one knot, inside the domain or at its start (Boehm's algorithm; The NURBS Book,
    /// A5.1). All combinations are convex, so rounding errors do not grow.
    fn with_knot(&self, value: f64, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let (degree, span) = (self.knots.degree(), self.knots.span(value));
        let t = self.knots.as_slice();
        let combination = |i: usize| {
            if i + degree <= span {
                return (1.0, i, i);
            }
            let (from, to) = (t[i], t[(i + degree).min(t.len() - 1)]);
            if i > span || value <= from {
                return (1.0, i - 1, i - 1);
            }
            ((value - from) / (to - from), i, i - 1)
        };
        let points = self.combined_rows(self.rows() + 1, combination, check_interrupt)?;
        let mut knots = t.to_vec();
        knots.insert(span + 1, value);
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }

    /// Inserts knots (The NURBS Book, A5.4). Costs O(knots · rows · width) if there are fewer new
    /// knots than spans.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Parameter`] if a knot is not in the domain, [`crate::Error::Knots`] if the
    /// multiplicity of one would exceed the degree.
    pub(super) fn refined(
        &self,
        knots: &[f64],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (start, end) = self.knots.domain();
        if let Some(outside) = knots.iter().find(|knot| !(start..=end).contains(*knot)) {
            let must = format!("in the domain [{start}, {end}]");
            return Err(Error::parameter("knots", must, outside));
        }
        let at = |place: f64| knots.iter().filter(|knot| **knot == place).count();
        for place in [start, end].into_iter().filter(|place| at(*place) > 0) {
            let (degree, multiplicity) =
                (self.knots.degree(), self.knots.multiplicity(place) + at(place));
            if multiplicity > degree {
                let got = format!("{place} would have multiplicity {multiplicity}");
                let must = "repeat no knot more than degree times";
                return Err(Error::Knots { degree, must, got });
            }
        }
        let inside: Vec<f64> =
            knots.iter().copied().filter(|&knot| start < knot && knot < end).collect();
        self.refined_inside(&inside, check_interrupt)?
            .refined_at_start(at(start), check_interrupt)?
            .refined_at_end(at(end), check_interrupt)
    }

    /// Inserts a knot at the start of the domain several times.
    fn refined_at_start(
        self,
        times: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (start, _) = self.knots.domain();
        (0..times).try_fold(self, |family, _| family.with_knot(start, check_interrupt))
    }

    /// Inserts a knot at the end of the domain several times.
    fn refined_at_end(
        self,
        times: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        if times == 0 {
            return Ok(self);
        }
        let mirrored = self.mirrored(check_interrupt)?;
        mirrored.refined_at_start(times, check_interrupt)?.mirrored(check_interrupt)
    }

    /// Inserts knots strictly inside the domain.
    fn refined_inside(
        &self,
        knots: &[f64],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        if knots.is_empty() {
            return self.copied(check_interrupt);
        }
        let mut all = [self.knots.as_slice(), knots].concat();
        all.sort_by(f64::total_cmp);
        // Checks the multiplicities before any work.
        let refined = KnotVector::new(self.knots.degree(), all)?;
        let mut sorted = knots.to_vec();
        sorted.sort_by(f64::total_cmp);
        self.inserted(&sorted, refined, check_interrupt)
    }

    /// Inserts sorted knots in place, from the last to the first (The NURBS Book, A5.4).
    fn inserted(
        &self,
        new: &[f64],
        knots: KnotVector,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (p, width) = (self.knots.degree(), self.width);
        let t = self.knots.as_slice();
        let s = knots.as_slice();
        let total = knots.control_points();
        memory::check_net(total, width)?;
        let (first, last) = (self.knots.span(new[0]), self.knots.span(new[new.len() - 1]) + 1);
        // The rows before and after the new knots stay; those between are filled below.
        let (head, tail) = (first + 1 - p, self.rows() + 1 - last);
        let old = |row: usize| {
            if row < head {
                Some(row)
            } else {
                (row + tail >= total).then(|| row + self.rows() - total)
            }
        };
        let empty = vec![DVec4::ZERO; width];
        let row = |row| old(row).map_or(&empty[..], |row| self.row(row));
        let mut points = concat_rows((total, width), check_interrupt, row)?;
        // The next row to fill is k - p - 1; the old span to copy is i.
        let mut i = last + p - 1;
        let mut k = last + p - 1 + new.len();
        for &value in new.iter().rev() {
            check_interrupt()?;
            while value <= t[i] && i > first {
                let (to, from) = ((k - p - 1) * width, (i - p - 1) * width);
                points[to..to + width].copy_from_slice(&self.points[from..from + width]);
                (i, k) = (i - 1, k - 1);
            }
            let at = (k - p - 1) * width;
            points.copy_within(at + width..at + 2 * width, at);
            for l in 1..=p {
                let row = (k - p + l) * width;
                let ahead = s[k + l] - value;
                let share = if ahead == 0.0 { 0.0 } else { ahead / (s[k + l] - t[i - p + l]) };
                let (before, after) = points.split_at_mut(row);
                for (a, b) in before[row - width..].iter_mut().zip(&after[..width]) {
                    *a = share * *a + (1.0 - share) * *b;
                }
            }
            k -= 1;
        }
        Ok(Self { knots, points, width })
    }

    /// Clamps the knots on the same domain.
    pub(super) fn clamped(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        if self.is_clamped() {
            return self.copied(check_interrupt);
        }
        let starting = self.clamped_at_start(check_interrupt)?;
        starting
            .mirrored(check_interrupt)?
            .clamped_at_start(check_interrupt)?
            .mirrored(check_interrupt)
    }

    fn clamped_at_start(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let (start, degree) = (self.knots.domain().0, self.knots.degree());
        let mut family = self.copied(check_interrupt)?;
        while family.knots.multiplicity(start) < degree {
            family = family.with_knot(start, check_interrupt)?;
        }
        // Keeps the last `degree` knots at the start and all knots after it, and repeats one of
        // them.
        let end = family.knots.as_slice().partition_point(|&knot| knot <= start);
        let first = end - degree;
        if first == 1 && family.knots.as_slice()[0] == start {
            return Ok(family);
        }
        let mut knots = family.knots.as_slice()[first - 1..].to_vec();
        knots[0] = start;
        let points = family.rows_from(first - 1..family.rows(), check_interrupt)?;
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }

    /// Inserts every inner knot up to multiplicity `degree`: a sequence of Bézier curves.
    pub(super) fn bezier_form(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        if !self.is_clamped() {
            return self.clamped(check_interrupt)?.bezier_form(check_interrupt);
        }
        let degree = self.knots.degree();
        let missing = |value| std::iter::repeat_n(value, degree - self.knots.multiplicity(value));
        let breaks = self.knots.breaks();
        let new: Vec<f64> = breaks[1..breaks.len() - 1].iter().flat_map(|&v| missing(v)).collect();
        self.refined(&new, check_interrupt)
    }
}
