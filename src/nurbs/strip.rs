//! The algebra of knots, on many curves side by side.
//!
//! The net of a surface is a strip in either direction, and the control points of a curve are a
//! strip one point wide; so every algorithm is written once. Points are homogeneous: what holds
//! for polynomial curves in four dimensions holds for rational ones in three.

use std::ops::Range;

use glam::DVec4;

use super::batch::{in_steps, steps};
use super::elevate::difference;
use super::knot_vector::KnotVector;
use super::remove::deviation;
use crate::error::{Error, Result};
use crate::progress::Listen;

/// Curves side by side over the same knots: row i holds their i-th control points.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    pub knots: KnotVector,
    /// As many rows as the knots have control points, one after the other.
    pub points: Vec<DVec4>,
    /// Number of curves.
    pub width: usize,
}

impl Strip {
    /// How many rows there are.
    pub(super) fn rows(&self) -> usize {
        self.knots.control_points()
    }

    pub(super) fn row(&self, i: usize) -> &[DVec4] {
        &self.points[i * self.width..][..self.width]
    }

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

    fn check_inside(&self, name: &'static str, value: f64) -> Result<()> {
        let (start, end) = self.knots.domain();
        if start < value && value < end {
            return Ok(());
        }
        let must = format!("strictly inside the domain ({start}, {end})");
        Err(Error::parameter(name, must, value))
    }

    /// Whether the domain is all that the knots span.
    fn is_clamped(&self) -> bool {
        let t = self.knots.as_slice();
        (t[0], t[t.len() - 1]) == self.knots.domain()
    }

    /// The same curves with clamped knots on the same domain.
    pub(super) fn clamped(&self, listen: &mut Listen<'_>) -> Result<Self> {
        if self.is_clamped() {
            return self.copied(listen);
        }
        let starting = self.clamped_at_start(listen)?;
        starting.mirrored(listen)?.clamped_at_start(listen)?.mirrored(listen)
    }

    /// The same curves once more.
    pub(super) fn copied(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let points = self.rows_from(0..self.rows(), listen)?;
        Ok(Self { knots: self.knots.clone(), points, width: self.width })
    }

    /// Some of the rows.
    fn rows_from(&self, rows: Range<usize>, listen: &mut Listen<'_>) -> Result<Vec<DVec4>> {
        let points = &self.points[rows.start * self.width..rows.end * self.width];
        in_steps((points.len(), 1), listen, |part| points[part].iter().copied())
    }

    /// The same curves with all parameters negated, which loses no bit of a knot.
    fn mirrored(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let knots = self.knots.as_slice().iter().rev().map(|knot| -knot).collect();
        let knots = KnotVector::new(self.knots.degree(), knots)?;
        Ok(Self { knots, ..self.reversed(listen)? })
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

    /// The same curves run through backwards, on the same domain.
    pub(super) fn reversed(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let count = self.rows();
        let points = gathered((count, self.width), listen, |row| self.row(count - 1 - row))?;
        Ok(Self { knots: self.knots.reversed(), points, width: self.width })
    }

    /// The parts before and after a parameter inside the domain, clamped.
    pub(super) fn split(&self, at: f64, listen: &mut Listen<'_>) -> Result<(Self, Self)> {
        self.check_inside("split", at)?;
        let degree = self.knots.degree();
        let missing = degree.saturating_sub(self.knots.multiplicity(at));
        let strip = self.clamped(listen)?.refined(&vec![at; missing], listen)?;
        let t = strip.knots.as_slice();
        let (first, end) =
            (t.partition_point(|&knot| knot < at), t.partition_point(|&knot| knot <= at));
        let before: Vec<f64> = t[..end].iter().copied().chain([at]).collect();
        let after: Vec<f64> = [at].into_iter().chain(t[first..].iter().copied()).collect();
        let mut part = |knots: Vec<f64>, rows| -> Result<Self> {
            let (knots, points) = (KnotVector::new(degree, knots)?, strip.rows_from(rows, listen)?);
            Ok(Self { knots, points, width: self.width })
        };
        let cut = first - 1;
        Ok((part(before, 0..cut + 1)?, part(after, cut..strip.rows())?))
    }

    /// The part between two parameters of the domain, clamped.
    pub(super) fn between(&self, (from, to): (f64, f64), listen: &mut Listen<'_>) -> Result<Self> {
        let (start, end) = self.knots.domain();
        if !(start <= from && from < to && to <= end) {
            let must = format!("an increasing pair inside the domain [{start}, {end}]");
            return Err(Error::parameter("range", must, format!("({from}, {to})")));
        }
        let tail = if from > start { self.split(from, listen)?.1 } else { self.clamped(listen)? };
        if to < end { Ok(tail.split(to, listen)?.0) } else { Ok(tail) }
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

    /// This and the strip that follows it, which begins where this one ends and has the same
    /// degree; the knots of the second are moved behind those of the first.
    pub(super) fn joined(&self, next: &Self, listen: &mut Listen<'_>) -> Result<Self> {
        let (first, next) = (self.clamped(listen)?, next.clamped(listen)?);
        let degree = first.knots.degree();
        let ((_, end), (start, _)) = (first.knots.domain(), next.knots.domain());
        let shift = end - start;
        let t = first.knots.as_slice();
        let tail = next.knots.as_slice()[degree + 1..].iter().map(|knot| knot + shift);
        let knots = t[..t.len() - 1].iter().copied().chain(tail).collect();
        let mut points = first.points;
        points.extend(next.rows_from(1..next.rows(), listen)?);
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }
}

/// So many rows of this width, one after the other.
fn gathered<'a>(
    (rows, width): (usize, usize),
    listen: &mut Listen<'_>,
    row: impl Fn(usize) -> &'a [DVec4],
) -> Result<Vec<DVec4>> {
    let mut points = Vec::with_capacity(rows * width);
    for range in steps(rows, width) {
        listen()?;
        range.for_each(|k| points.extend_from_slice(row(k)));
    }
    Ok(points)
}

/// Whether two rows of homogeneous points are the same place, within a tolerance.
pub(super) fn same_row(a: &[DVec4], b: &[DVec4], tolerance: f64) -> bool {
    // Most rows that are not begin in different places.
    if a[0].project().distance(b[0].project()) > tolerance {
        return false;
    }
    // Weights count only up to a factor.
    let factor = a[0].w / b[0].w;
    let b: Vec<DVec4> = b.iter().map(|point| *point * factor).collect();
    deviation(a, &b) <= tolerance
}

/// Raises strips to the highest degree among them, clamped.
pub(super) fn unify_degrees(strips: &mut [Strip], listen: &mut Listen<'_>) -> Result<()> {
    let degree = strips.iter().map(|strip| strip.knots.degree()).max().unwrap_or(0);
    strips.iter_mut().try_for_each(|strip| {
        *strip = strip.elevated(degree - strip.knots.degree(), listen)?;
        Ok(())
    })
}

/// Gives strips of the same domain the same degree and the same knots: those of all of them.
///
/// # Errors
///
/// [`Error::Parameter`] if the domains differ.
pub(super) fn unify(strips: &mut [Strip], listen: &mut Listen<'_>) -> Result<()> {
    unify_degrees(strips, listen)?;
    let domain = strips[0].knots.domain();
    if let Some(other) = strips.iter().map(|strip| strip.knots.domain()).find(|d| *d != domain) {
        return Err(Error::parameter("domain", format!("{domain:?} of all"), format!("{other:?}")));
    }
    let mut all: Vec<f64> = Vec::new();
    for strip in &*strips {
        listen()?;
        let new = difference(strip.knots.inner(), &intersection(strip.knots.inner(), &all));
        all.extend(new);
        all.sort_by(f64::total_cmp);
    }
    strips.iter_mut().try_for_each(|strip| {
        *strip = strip.refined(&difference(&all, strip.knots.inner()), listen)?;
        Ok(())
    })
}

/// What two sorted sequences have in common, with repetitions.
fn intersection(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut b = b.iter().peekable();
    let mut common = Vec::new();
    for value in a {
        while b.next_if(|other| *other < value).is_some() {}
        common.extend(b.next_if(|other| *other == value));
    }
    common
}
