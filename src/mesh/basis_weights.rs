//! Where a place lies among the control points of the nets.

use super::bernstein::polynomials;
use super::piece::PATCH;
use crate::nurbs::Row;

/// Where a place of a block lies along one direction of the nets.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Located {
    /// The first control point that counts there.
    first: usize,
    /// How many do: between patches only one.
    count: usize,
    /// How much each of them does.
    shares: Row,
}

impl Located {
    /// Where a place of a block lies that begins with this row or column of patches.
    pub(super) fn of(place: u32, first: usize, degree: usize) -> Self {
        let mut this = Self::default();
        this.find(place, first, degree);
        this
    }

    /// Makes it [`Located::of`] this place.
    pub(super) fn find(&mut self, place: u32, first: usize, degree: usize) {
        let (patch, rest) = (first + (place / PATCH) as usize, place % PATCH);
        (self.first, self.count) = (patch * degree, 1);
        self.shares[0] = 1.0;
        if rest != 0 {
            self.count = degree + 1;
            self.shares = polynomials(degree, f64::from(rest) / f64::from(PATCH));
        }
    }

    /// The first control point, and how much of each from there on.
    pub(super) fn shares(&self) -> (usize, &[f64]) {
        (self.first, &self.shares[..self.count])
    }
}
