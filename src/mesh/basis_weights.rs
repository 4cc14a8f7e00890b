//! The control points that determine a surface point, and their weights, along one direction.

use super::bernstein::polynomials;
use super::block::PATCH_STEPS;
use crate::nurbs::Row;

/// The nonzero Bernstein weights at an integer coordinate of a block, along one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BasisWeights {
    /// The first control point with a nonzero weight.
    first: usize,
    /// The number of nonzero weights: between patches only one.
    count: usize,
    weights: Row,
}

impl BasisWeights {
    /// The weights at a coordinate of a block whose first row or column of patches is `first`.
    pub(super) fn of(step: u32, first: usize, degree: usize) -> Self {
        let mut this = Self::default();
        this.set(step, first, degree);
        this
    }

    /// Replaces these by [`BasisWeights::of`] the arguments.
    pub(super) fn set(&mut self, step: u32, first: usize, degree: usize) {
        let (patch, rest) = (first + (step / PATCH_STEPS) as usize, step % PATCH_STEPS);
        (self.first, self.count) = (patch * degree, 1);
        self.weights[0] = 1.0;
        if rest != 0 {
            self.count = degree + 1;
            polynomials(degree, f64::from(rest) / f64::from(PATCH_STEPS), &mut self.weights);
        }
    }

    /// The first control point, and the weights from there on.
    pub(super) fn weights(&self) -> (usize, &[f64]) {
        (self.first, &self.weights[..self.count])
    }
}
