//! The normal equations of a fit, as sums over points and spans.
//!
//! A point touches (degree + 1)² control points and adds a block of products of its basis
//! functions. Points are sorted by span; a row of spans touches `degree + 1` rows of control
//! points, so rows that lie as far apart are summed in parallel, each sum by one owner in one
//! order: any number of threads gives the same bits.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::FitOptions;
use super::fairness::Gram;
use super::solve::{Entry, positive_definite};
use crate::nurbs::{KnotVector, padded};

/// Matrix and right-hand side, over the net with the repeated rows and columns of closed
/// directions, which are folded together when the system is solved.
pub(super) struct NormalEquations<'a> {
    options: &'a FitOptions,
    shape: (usize, usize),
    /// For each control point its products with those 0 to `degree` rows below it and `-degree` to
    /// `degree` columns beside it.
    products: Vec<f64>,
    right: Vec<DVec3>,
}

impl<'a> NormalEquations<'a> {
    pub(super) fn new(options: &'a FitOptions) -> Self {
        let shape = (options.knots_u.control_points(), options.knots_v.control_points());
        let count = shape.0 * shape.1;
        let stencil = (options.knots_u.degree() + 1) * (2 * options.knots_v.degree() + 1);
        let (products, right) = (vec![0.0; count * stencil], vec![DVec3::ZERO; count]);
        Self { options, shape, products, right }
    }

    fn degrees(&self) -> (usize, usize) {
        (self.options.knots_u.degree(), self.options.knots_v.degree())
    }

    /// Numbers per control point in `products`.
    fn stencil(&self) -> usize {
        let (p, q) = self.degrees();
        (p + 1) * (2 * q + 1)
    }

    /// Adds the squared distances of points from a centre.
    pub(super) fn add_points(
        &mut self,
        points: &[DVec3],
        centre: DVec3,
        uv: &[DVec2],
        weights: Option<&[f64]>,
    ) {
        let ((p, q), cols, stencil) = (self.degrees(), self.shape.1, self.stencil());
        let (knots_u, knots_v) = (&self.options.knots_u, &self.options.knots_v);
        let by_row = sorted_by_row(knots_u, uv);
        for colour in 0..=p {
            let products =
                self.products[colour * cols * stencil..].par_chunks_mut((p + 1) * cols * stencil);
            let right = self.right[colour * cols..].par_chunks_mut((p + 1) * cols);
            let rows = products.zip(right).enumerate();
            rows.for_each(|(k, (products, right))| {
                let row = colour + k * (p + 1);
                let own = by_row.get(row).map_or(&[][..], |points| points);
                for &index in own {
                    let weight = weights.map_or(1.0, |weights| weights[index]);
                    let (rows, columns) =
                        (padded(knots_u, uv[index].x), padded(knots_v, uv[index].y));
                    let point = points[index] - centre;
                    for i in 0..=p {
                        for j in 0..=q {
                            let value = weight * rows.values[i] * columns.values[j];
                            let at = i * cols + columns.first + j;
                            right[at] += value * point;
                            for di in 0..=p - i {
                                let value = value * rows.values[i + di];
                                let line = at * stencil + di * (2 * q + 1) + q - j;
                                let line = &mut products[line..=line + q];
                                for (sum, other) in line.iter_mut().zip(&columns.values) {
                                    *sum += value * other;
                                }
                            }
                        }
                    }
                }
            });
        }
    }

    /// Adds the thin-plate energy over a domain of these lengths in space, with a weight in units
    /// of the points' say.
    pub(super) fn add_fairness(&mut self, fairness: f64, (length_u, length_v): (f64, f64)) {
        let ((p, q), (rows, cols), stencil) = (self.degrees(), self.shape, self.stencil());
        let (gram_u, gram_v) = (Gram::of(&self.options.knots_u), Gram::of(&self.options.knots_v));
        // ∫∫ S_xx² + 2 S_xy² + S_yy² with x = length_u u and y = length_v v, up to a factor.
        let ratio = length_v / length_u;
        let shares = [ratio * ratio, 2.0, 1.0 / (ratio * ratio)];
        let energy = |(i, j): (usize, usize), (k, l): (usize, usize)| {
            (0..3).map(|d| shares[d] * gram_u[2 - d].at(i, k) * gram_v[d].at(j, l)).sum::<f64>()
        };
        let diagonal = |at: usize| self.products[at * stencil + q];
        let said: f64 = (0..rows * cols).map(diagonal).sum();
        let bent: f64 =
            (0..rows * cols).map(|at| energy((at / cols, at % cols), (at / cols, at % cols))).sum();
        if bent == 0.0 {
            // Of degree 1 in both directions and in one span: nothing bends.
            return;
        }
        let scale = fairness * said / bent;
        self.products.par_chunks_mut(stencil).enumerate().for_each(|(at, products)| {
            let (i, j) = (at / cols, at % cols);
            for (slot, sum) in products.iter_mut().enumerate() {
                let (k, l) = (i + slot / (2 * q + 1), j + slot % (2 * q + 1));
                if k < rows && k - i <= p && (q..cols + q).contains(&l) {
                    *sum += scale * energy((i, j), (k, l - q));
                }
            }
        });
    }

    /// Rows and columns of unknown control points.
    pub(super) fn unknowns(&self) -> (usize, usize) {
        let ((p, q), (rows, cols)) = (self.degrees(), self.shape);
        let closed = self.options.closed;
        (rows - usize::from(closed.0) * p, cols - usize::from(closed.1) * q)
    }

    /// The net that solves the equations; `None` if several do.
    pub(super) fn solve(&self) -> Option<Vec<DVec3>> {
        let ((_, q), (rows, cols), stencil) = (self.degrees(), self.shape, self.stencil());
        let (unknown_rows, unknown_cols) = self.unknowns();
        let unknown = |i: usize, j: usize| (i % unknown_rows) * unknown_cols + j % unknown_cols;
        let mut entries = Vec::with_capacity(self.products.len());
        let mut right = vec![DVec3::ZERO; unknown_rows * unknown_cols];
        for at in 0..rows * cols {
            let (i, j) = (at / cols, at % cols);
            let own = unknown(i, j);
            right[own] += self.right[at];
            for (slot, &value) in self.products[at * stencil..][..stencil].iter().enumerate() {
                let (di, l) = (slot / (2 * q + 1), j + slot % (2 * q + 1));
                // Of a control point's own row only it and what lies behind it: pairs count once.
                let counted = di > 0 || l >= j + q;
                if value == 0.0 || !counted {
                    continue;
                }
                let other = unknown(i + di, l - q);
                let twice = other == own && (di, l) != (0, j + q);
                let val = if twice { 2.0 * value } else { value };
                entries.push(Entry { row: own.max(other), col: own.min(other), val });
            }
        }
        let solved = positive_definite(&entries, &right)?;
        Some((0..rows * cols).map(|at| solved[unknown(at / cols, at % cols)]).collect())
    }
}

/// The points by the first row of control points that they touch, in their order.
fn sorted_by_row(knots: &KnotVector, uv: &[DVec2]) -> Vec<Vec<usize>> {
    let mut rows = vec![Vec::new(); knots.control_points() - knots.degree()];
    for (index, at) in uv.iter().enumerate() {
        rows[knots.span(at.x) - knots.degree()].push(index);
    }
    rows
}
