//! Families of curves over the same knots: the common form of surfaces and curves in knot
//! algorithms.
//!
//! The net of a surface is a family of curves in either direction; a curve is a family of one. So
//! each algorithm is written once. Points are homogeneous: an algorithm for polynomial curves in
//! four dimensions also holds for rational curves in three.

use std::ops::Range;

use glam::DVec4;

use super::knot_vector::KnotVector;
use super::work_blocks::{collect_in_steps, row_ranges};
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

/// Curves over the same knots. Row i contains the i-th control points of all curves.
#[derive(Clone, Debug)]
pub(super) struct CurveFamily {
    pub knots: KnotVector,
    /// Homogeneous control points, row by row.
    pub points: Vec<DVec4>,
    /// Number of curves.
    pub width: usize,
}

impl CurveFamily {
    /// Number of rows, the control points of each curve.
    pub(super) fn rows(&self) -> usize {
        self.knots.control_points()
    }

    /// The i-th control points of all curves.
    pub(super) fn row(&self, i: usize) -> &[DVec4] {
        &self.points[i * self.width..][..self.width]
    }

    /// Checks that a parameter is strictly inside the domain.
    pub(super) fn check_inside(&self, name: &'static str, value: f64) -> Result<()> {
        let (start, end) = self.knots.domain();
        if start < value && value < end {
            return Ok(());
        }
        let must = format!("strictly inside the domain ({start}, {end})");
        Err(Error::parameter(name, must, value))
    }

    /// Whether the first and last knot are the ends of the domain.
    pub(super) fn is_clamped(&self) -> bool {
        let t = self.knots.as_slice();
        (t[0], t[t.len() - 1]) == self.knots.domain()
    }

    /// Copies the family, with interrupt checks.
    pub(super) fn copied(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let points = self.rows_from(0..self.rows(), check_interrupt)?;
        Ok(Self { knots: self.knots.clone(), points, width: self.width })
    }

    /// Copies some of the rows.
    pub(super) fn rows_from(
        &self,
        rows: Range<usize>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Vec<DVec4>> {
        let points = &self.points[rows.start * self.width..rows.end * self.width];
        collect_in_steps((points.len(), 1), check_interrupt, |part| points[part].iter().copied())
    }

    /// Negates all parameters; negation is exact.
    pub(super) fn mirrored(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let knots = self.knots.as_slice().iter().rev().map(|knot| -knot).collect();
        let knots = KnotVector::new(self.knots.degree(), knots)?;
        Ok(Self { knots, ..self.reversed(check_interrupt)? })
    }

    /// Reverses the direction of the curves, on the same domain.
    pub(super) fn reversed(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let count = self.rows();
        let points =
            concat_rows((count, self.width), check_interrupt, |row| self.row(count - 1 - row))?;
        Ok(Self { knots: self.knots.reversed(), points, width: self.width })
    }
}

/// Concatenates `rows` rows of this width.
pub(super) fn concat_rows<'a>(
    (rows, width): (usize, usize),
    check_interrupt: &mut InterruptCheck<'_>,
    row: impl Fn(usize) -> &'a [DVec4],
) -> Result<Vec<DVec4>> {
    let mut points = Vec::with_capacity(rows * width);
    for range in row_ranges(rows, width) {
        check_interrupt()?;
        range.for_each(|k| points.extend_from_slice(row(k)));
    }
    Ok(points)
}
