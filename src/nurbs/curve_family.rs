//! The algebra of knots, on many curves side by side.
//!
//! The net of a surface is a strip in either direction, and the control points of a curve are a
//! strip one point wide; so every algorithm is written once. Points are homogeneous: what holds
//! for polynomial curves in four dimensions holds for rational ones in three.

use std::ops::Range;

use glam::DVec4;

use super::knot_vector::KnotVector;
use super::work_blocks::{in_steps, steps};
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

    pub(super) fn check_inside(&self, name: &'static str, value: f64) -> Result<()> {
        let (start, end) = self.knots.domain();
        if start < value && value < end {
            return Ok(());
        }
        let must = format!("strictly inside the domain ({start}, {end})");
        Err(Error::parameter(name, must, value))
    }

    /// Whether the domain is all that the knots span.
    pub(super) fn is_clamped(&self) -> bool {
        let t = self.knots.as_slice();
        (t[0], t[t.len() - 1]) == self.knots.domain()
    }

    /// The same curves once more.
    pub(super) fn copied(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let points = self.rows_from(0..self.rows(), listen)?;
        Ok(Self { knots: self.knots.clone(), points, width: self.width })
    }

    /// Some of the rows.
    pub(super) fn rows_from(
        &self,
        rows: Range<usize>,
        listen: &mut Listen<'_>,
    ) -> Result<Vec<DVec4>> {
        let points = &self.points[rows.start * self.width..rows.end * self.width];
        in_steps((points.len(), 1), listen, |part| points[part].iter().copied())
    }

    /// The same curves with all parameters negated, which loses no bit of a knot.
    pub(super) fn mirrored(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let knots = self.knots.as_slice().iter().rev().map(|knot| -knot).collect();
        let knots = KnotVector::new(self.knots.degree(), knots)?;
        Ok(Self { knots, ..self.reversed(listen)? })
    }

    /// The same curves run through backwards, on the same domain.
    pub(super) fn reversed(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let count = self.rows();
        let points = gathered((count, self.width), listen, |row| self.row(count - 1 - row))?;
        Ok(Self { knots: self.knots.reversed(), points, width: self.width })
    }
}

/// So many rows of this width, one after the other.
pub(super) fn gathered<'a>(
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
