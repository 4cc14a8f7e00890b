//! Where a place lies among the control points of the nets.

use super::bernstein::polynomials;
use super::piece::PATCH;
use crate::nurbs::Row;

/// Where a place of a block lies along one direction of the nets.
#[derive(Debug)]
pub(super) enum Located {
    /// Between patches: at this control point.
    Between(usize),
    /// Inside a patch: its first control point, and how much of each.
    Inside(usize, Row, usize),
}

impl Located {
    /// Where a place of a block lies that begins with this row or column of patches.
    pub(super) fn of(place: u32, first: usize, degree: usize) -> Self {
        let (patch, rest) = (first + (place / PATCH) as usize, place % PATCH);
        if rest == 0 {
            return Self::Between(patch * degree);
        }
        let row = polynomials(degree, f64::from(rest) / f64::from(PATCH));
        Self::Inside(patch * degree, row, degree + 1)
    }

    /// The first control point, and how much of each from there on.
    pub(super) fn shares(&self) -> (usize, &[f64]) {
        match self {
            Self::Between(at) => (*at, &[1.0]),
            Self::Inside(start, row, order) => (*start, &row[..*order]),
        }
    }
}
