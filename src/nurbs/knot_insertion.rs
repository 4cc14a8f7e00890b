//! Knot insertion, and the forms that follow from it: clamped curves and Bézier curves.

use glam::DVec4;

use super::curve_family::{Strip, gathered};
use super::knot_vector::KnotVector;
use super::work_blocks::steps;
use crate::error::Result;
use crate::progress::Listen;

impl Strip {
    /// The strip whose row i is a mixture of two rows of this one, `share` of the first and the
    /// rest of the second; a share of 1 copies the first row to the last bit.
    fn mixed(
        &self,
        count: usize,
        row: impl Fn(usize) -> (f64, usize, usize),
        listen: &mut Listen<'_>,
    ) -> Result<Vec<DVec4>> {
        let mut points = Vec::with_capacity(count * self.width);
        for range in steps(count, self.width) {
            listen()?;
            for (share, a, b) in range.map(&row) {
                let pairs = self.row(a).iter().zip(self.row(b));
                points.extend(pairs.map(|(a, b)| share * *a + (1.0 - share) * *b));
            }
        }
        Ok(points)
    }

    /// With one knot more, inside the domain or at its start (Boehm's algorithm; The NURBS Book,
    /// A5.1). All mixtures are convex, so rounding does not grow.
    fn with_knot(&self, value: f64, listen: &mut Listen<'_>) -> Result<Self> {
        let (degree, span) = (self.knots.degree(), self.knots.span(value));
        let t = self.knots.as_slice();
        let mixture = |i: usize| {
            if i + degree <= span {
                return (1.0, i, i);
            }
            let (from, to) = (t[i], t[(i + degree).min(t.len() - 1)]);
            if i > span || value <= from {
                return (1.0, i - 1, i - 1);
            }
            ((value - from) / (to - from), i, i - 1)
        };
        let points = self.mixed(self.rows() + 1, mixture, listen)?;
        let mut knots = t.to_vec();
        knots.insert(span + 1, value);
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }

    /// With more knots (The NURBS Book, A5.4 in its effect): as long as there are fewer of them
    /// than spans, O(knots · rows · width).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a knot lies outside the open domain, [`Error::Knots`] if one would
    /// stand more often than the degree.
    pub(super) fn refined(&self, knots: &[f64], listen: &mut Listen<'_>) -> Result<Self> {
        knots.iter().try_for_each(|&knot| self.check_inside("knots", knot))?;
        if knots.is_empty() {
            return self.copied(listen);
        }
        let mut all = [self.knots.as_slice(), knots].concat();
        all.sort_by(f64::total_cmp);
        // Refuses knots that stand too often, before any work.
        let refined = KnotVector::new(self.knots.degree(), all)?;
        let mut sorted = knots.to_vec();
        sorted.sort_by(f64::total_cmp);
        self.inserted(&sorted, refined, listen)
    }

    /// Inserts sorted knots, from the last to the first, in place (The NURBS Book, A5.4).
    fn inserted(&self, new: &[f64], knots: KnotVector, listen: &mut Listen<'_>) -> Result<Self> {
        let (p, width) = (self.knots.degree(), self.width);
        let t = self.knots.as_slice();
        let s = knots.as_slice();
        let total = knots.control_points();
        let (first, last) = (self.knots.span(new[0]), self.knots.span(new[new.len() - 1]) + 1);
        // The rows before and behind stay; those between are filled below.
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
        let mut points = gathered((total, width), listen, row)?;
        // Row k - p - 1 is the next to be filled; i is the old span that is being copied.
        let mut i = last + p - 1;
        let mut k = last + p - 1 + new.len();
        for &value in new.iter().rev() {
            listen()?;
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

    /// The same curves with clamped knots on the same domain.
    pub(super) fn clamped(&self, listen: &mut Listen<'_>) -> Result<Self> {
        if self.is_clamped() {
            return self.copied(listen);
        }
        let starting = self.clamped_at_start(listen)?;
        starting.mirrored(listen)?.clamped_at_start(listen)?.mirrored(listen)
    }

    fn clamped_at_start(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let (start, degree) = (self.knots.domain().0, self.knots.degree());
        let mut strip = self.copied(listen)?;
        while strip.knots.multiplicity(start) < degree {
            strip = strip.with_knot(start, listen)?;
        }
        // The last `degree` knots of this value and what follows; one of them once more.
        let end = strip.knots.as_slice().partition_point(|&knot| knot <= start);
        let first = end - degree;
        if first == 1 && strip.knots.as_slice()[0] == start {
            return Ok(strip);
        }
        let mut knots = strip.knots.as_slice()[first - 1..].to_vec();
        knots[0] = start;
        let points = strip.rows_from(first - 1..strip.rows(), listen)?;
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }

    /// The same curves with every inner knot as often as the degree: Bézier curves, end to end.
    pub(super) fn bezier(&self, listen: &mut Listen<'_>) -> Result<Self> {
        if !self.is_clamped() {
            return self.clamped(listen)?.bezier(listen);
        }
        let degree = self.knots.degree();
        let missing = |value| std::iter::repeat_n(value, degree - self.knots.multiplicity(value));
        let breaks = self.knots.breaks();
        let new: Vec<f64> = breaks[1..breaks.len() - 1].iter().flat_map(|&v| missing(v)).collect();
        self.refined(&new, listen)
    }
}
