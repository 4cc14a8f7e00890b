//! Conversion of a tensor-product Bézier patch to its parts over triangles and rectangles.
//!
//! The coefficients over triangles are values of the blossom (L. Ramshaw, *Blossoms are polar
//! forms*, 1989): a function of as many arguments as the degree, equal to the polynomial where all
//! agree.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use std::sync::OnceLock;

use glam::{DVec2, DVec4};
use pulp::Simd;

use super::bernstein::{binomial, blossom_weights};
use super::bezier_triangle::{
    coefficient_count, coefficient_index, halving_matrices, multi_indices,
};
use super::de_casteljau::restrict;
use super::lanes::{BATCH, Batch};
use super::sparse_matrix::SparseMatrix;
use crate::nurbs::MAX_ORDER;

/// The conversion of all patches of the same degrees, with precomputed matrices.
#[derive(Debug)]
pub(super) struct TriangleConversion {
    /// The degree in u.
    pub p: usize,
    /// The degree in v.
    pub q: usize,
    /// For each pair of blossoms, in v and (inner loop) in u: the coefficient of the triangle that
    /// their product contributes to, and the factor.
    terms: Vec<(usize, f64)>,
    /// For each [`shape`], the matrix from a patch to the triangle, computed on first use.
    shapes: Vec<OnceLock<SparseMatrix>>,
    /// The matrices from a triangle's coefficients to those of its halves.
    pub halvings: [SparseMatrix; 2],
}

/// Number of [`shape`]s: three corners at nine points each.
const SHAPES: usize = 9 * 9 * 9;

/// The index of a triangle whose corners are at multiples of 1/2 in the unit square; else `None`.
///
/// Triangles from halving have this form.
#[inline(always)]
fn shape(corners: [DVec2; 3]) -> Option<usize> {
    let mut shape = 0.0;
    let mut known = true;
    for at in corners {
        let halves = 2.0 * at;
        known &= halves == halves.trunc();
        shape = 9.0 * shape + 3.0 * halves.x + halves.y;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number")]
    known.then_some(shape as usize)
}

/// The conversions used so far, by degrees: making one takes as long as a small mesh.
static CONVERSIONS: [[OnceLock<Box<TriangleConversion>>; MAX_ORDER]; MAX_ORDER] =
    [const { [const { OnceLock::new() }; MAX_ORDER] }; MAX_ORDER];

impl TriangleConversion {
    /// The conversion of patches of these degrees.
    pub(super) fn of((p, q): (usize, usize)) -> &'static Self {
        CONVERSIONS[p][q].get_or_init(|| Box::new(Self::new((p, q))))
    }

    fn new((p, q): (usize, usize)) -> Self {
        let (u, v, n) = (multi_indices(p), multi_indices(q), p + q);
        // The blossom averages over all ways to distribute its arguments to u and v.
        let mut terms = vec![];
        for (in_v, in_u) in v.iter().flat_map(|in_v| u.iter().map(move |in_u| (in_v, in_u))) {
            let sum = [0, 1, 2].map(|k| in_u[k] + in_v[k]);
            let ways: f64 = (0..3).map(|k| binomial(sum[k], in_u[k])).product();
            terms.push((coefficient_index(sum), ways / binomial(n, p)));
        }
        let shapes = vec![OnceLock::new(); SHAPES];
        Self { p, q, terms, shapes, halvings: halving_matrices(n) }
    }

    /// The matrix from the coefficients of a patch to those over a triangle.
    fn matrix(&self, at: [DVec2; 3]) -> SparseMatrix {
        let (mut u, mut v) = (vec![], vec![]);
        blossom_weights(self.p, at.map(|at| at.x), &mut u);
        blossom_weights(self.q, at.map(|at| at.y), &mut v);
        let (u, v) = (u.chunks_exact(self.p + 1), v.chunks_exact(self.q + 1));
        let points = (self.p + 1) * (self.q + 1);
        let mut rows = vec![vec![0.0; points]; coefficient_count(self.p + self.q)];
        let pairs = v.flat_map(|v| u.clone().map(move |u| (u, v)));
        for ((u, v), &(target, factor)) in pairs.zip(&self.terms) {
            let sums = rows[target].chunks_exact_mut(self.q + 1);
            for (sums, u) in sums.zip(u).filter(|(_, u)| **u != 0.0) {
                sums.iter_mut().zip(v).for_each(|(sum, v)| *sum += factor * (u * v));
            }
        }
        let entries = |row: Vec<f64>| row.into_iter().enumerate().collect();
        SparseMatrix::new(&rows.into_iter().map(entries).collect::<Vec<_>>())
    }

    /// Batches of coefficients of a triangle.
    #[inline(always)]
    pub(super) fn batches(&self) -> usize {
        self.halvings[0].batches()
    }

    /// The index of the control point at a corner of the unit square; `None` for other points.
    #[inline(always)]
    pub(super) fn corner_index(&self, at: DVec2) -> Option<usize> {
        let end = |x: f64, last: usize| match x {
            0.0 => Some(0),
            1.0 => Some(last),
            _ => None,
        };
        Some(end(at.x, self.p)? * (self.q + 1) + end(at.y, self.q)?)
    }

    /// Replaces a net by that of its part over x × y; its rows have `width` points.
    ///
    /// In a direction with several patches, the interval must be (0, 1).
    #[inline(always)]
    pub(super) fn rectangle(&self, net: &mut [DVec4], width: usize, x: (f64, f64), y: (f64, f64)) {
        let all = (0.0, 1.0);
        if x != all {
            for column in 0..width {
                restrict(net, (column, width), self.p, x);
            }
        }
        if y != all {
            for start in (0..net.len()).step_by(width) {
                restrict(net, (start, 1), self.q, y);
            }
        }
    }

    /// Writes the first N coordinates of the coefficients over a triangle of the unit square.
    #[inline(always)]
    pub(super) fn triangle<S: Simd, const N: usize>(
        &self,
        simd: S,
        of: &[DVec4],
        at: [DVec2; 3],
        buffers: &mut Buffers,
        out: &mut [[Batch; N]],
    ) {
        let out = &mut out[..self.batches()];
        if let Some(shape) = shape(at) {
            let matrix = self.shapes[shape].get_or_init(|| self.matrix(at));
            matrix.multiply(simd, |k| of[k].to_array(), out);
            return;
        }
        let (low, high) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
        let in_box = at.map(|at| (at - low) / (high - low));
        if let Some(shape) = shape(in_box) {
            let matrix = self.shapes[shape].get_or_init(|| self.matrix(in_box));
            let part = &mut buffers.part;
            part.clear();
            part.extend_from_slice(of);
            self.rectangle(part, self.q + 1, (low.x, high.x), (low.y, high.y));
            matrix.multiply(simd, |k| part[k].to_array(), out);
            return;
        }
        self.triangle_by_blossoms(of, at, buffers, out);
    }

    /// The same for any triangle, without a precomputed matrix.
    #[inline(always)]
    fn triangle_by_blossoms<const N: usize>(
        &self,
        of: &[DVec4],
        at: [DVec2; 3],
        Buffers { u, v, points, sums, .. }: &mut Buffers,
        out: &mut [[Batch; N]],
    ) {
        let (orders, width) = ((self.p + 1, self.q + 1), self.q + 1);
        blossom_weights(self.p, at.map(|at| at.x), u);
        blossom_weights(self.q, at.map(|at| at.y), v);
        // First the blossoms in u of each column, then those in v.
        let rows = u.len() / orders.0;
        points.clear();
        points.resize(rows * width, ZERO);
        for (sums, weights) in points.chunks_exact_mut(width).zip(u.chunks_exact(orders.0)) {
            for (weight, row) in weights.iter().zip(of.chunks_exact(width)) {
                if *weight != 0.0 {
                    let both = sums.iter_mut().zip(row);
                    both.for_each(|(sum, h)| add(sum, *weight, &h.to_array()));
                }
            }
        }
        sums.clear();
        sums.resize(BATCH * out.len(), ZERO);
        let mut last = 0;
        for (weights, terms) in v.chunks_exact(orders.1).zip(self.terms.chunks_exact(rows)) {
            for (row, &(target, factor)) in points.chunks_exact(width).zip(terms) {
                let mut value = ZERO;
                weights.iter().zip(row).for_each(|(weight, point)| add(&mut value, *weight, point));
                add(&mut sums[target], factor, &value);
                last = last.max(target);
            }
        }
        // The last coefficient is repeated to complete the last batch.
        let end = sums[last];
        sums[last..].fill(end);
        for (batch, sums) in out.iter_mut().zip(sums.chunks_exact(BATCH)) {
            for (lane, sum) in sums.iter().enumerate() {
                (0..N).for_each(|axis| batch[axis].0[lane] = sum[axis]);
            }
        }
    }
}

/// Scratch memory for [`TriangleConversion::triangle`].
#[derive(Debug, Default)]
pub(super) struct Buffers {
    part: Vec<DVec4>,
    u: Vec<f64>,
    v: Vec<f64>,
    points: Vec<Lanes>,
    sums: Vec<Lanes>,
}

/// A homogeneous point as an array, which the compiler vectorizes.
type Lanes = [f64; 4];

/// The empty sum.
const ZERO: Lanes = [0.0; 4];

/// Adds a multiple of a point.
#[inline(always)]
fn add(sum: &mut Lanes, factor: f64, point: &Lanes) {
    (0..4).for_each(|axis| sum[axis] += factor * point[axis]);
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::super::bernstein::polynomials;
    use super::super::de_casteljau::quarters;
    use super::super::lanes::{self, PointBatch};
    use super::*;

    /// A net of pseudorandom points.
    fn net(p: usize, q: usize) -> Vec<DVec4> {
        let point = |k: usize| {
            let k = k as f64;
            DVec4::new((1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin(), 1.5 + (3.1 * k).sin())
        };
        (0..(p + 1) * (q + 1)).map(point).collect()
    }

    /// The surface point of a net at parameters of the unit square.
    fn point(net: &[DVec4], (p, q): (usize, usize), at: DVec2) -> DVec4 {
        let (mut u, mut v) = (vec![0.0; p + 1], vec![0.0; q + 1]);
        polynomials(p, at.x, &mut u);
        polynomials(q, at.y, &mut v);
        let row = |row: &[DVec4]| row.iter().zip(&v).map(|(h, weight)| *weight * *h).sum::<DVec4>();
        net.chunks_exact(q + 1).zip(&u).map(|(points, weight)| *weight * row(points)).sum()
    }

    #[test]
    fn parts_have_the_points_of_the_patch() {
        for (p, q) in [(1, 1), (3, 3), (2, 5), (12, 25)] {
            let (conversion, net) = (TriangleConversion::new((p, q)), net(p, q));
            let mut part = net.clone();
            conversion.rectangle(&mut part, q + 1, (0.25, 0.75), (0.5, 0.625));
            let inside = point(&part, (p, q), DVec2::new(0.3, 0.8));
            let outside = point(&net, (p, q), DVec2::new(0.25 + 0.5 * 0.3, 0.5 + 0.125 * 0.8));
            assert!(inside.distance(outside) < 1e-14);
            let mut parts = vec![];
            quarters(&net, (p, q), &mut parts);
            let corners = [(0.0, 0.0), (0.0, 0.5), (0.5, 0.0), (0.5, 0.5)].map(DVec2::from);
            for (part, corner) in parts.chunks_exact(net.len()).zip(corners) {
                let at = DVec2::new(0.3, 0.8);
                let outside = point(&net, (p, q), corner + 0.5 * at);
                assert!(point(part, (p, q), at).distance(outside) < 1e-14);
            }
        }
    }

    /// The coefficients of a net over a triangle.
    struct OnTriangle<'a>(&'a TriangleConversion, &'a [DVec4], [DVec2; 3]);

    impl WithSimd for OnTriangle<'_> {
        type Output = Vec<PointBatch>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<PointBatch> {
            let mut all = vec![[Batch::default(); 4]; self.0.batches()];
            self.0.triangle(simd, self.1, self.2, &mut Buffers::default(), &mut all);
            all
        }
    }

    #[test]
    fn triangles_have_the_surface_point_at_their_center() {
        let triangles = [
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)],
            [(1.0, 1.0), (0.0, 1.0), (0.5, 0.0)],
            [(0.5, 0.75), (0.5, 0.25), (0.75, 0.75)],
            [(0.1, 0.9), (0.75, 0.5), (1.0, 0.25)],
        ];
        for (p, q) in [(1, 1), (3, 3), (2, 4), (25, 11)] {
            let (conversion, net, n) = (TriangleConversion::new((p, q)), net(p, q), p + q);
            for at in triangles.map(|corners| corners.map(DVec2::from)) {
                let all = Arch::new().dispatch(OnTriangle(&conversion, &net, at));
                let center: DVec4 = multi_indices(n)
                    .iter()
                    .enumerate()
                    .map(|(k, of)| {
                        let ways = binomial(n, of[0]) * binomial(n - of[0], of[1]);
                        ways / 3.0_f64.powf(n as f64) * DVec4::from_array(lanes::point(&all, k))
                    })
                    .sum();
                let expected = point(&net, (p, q), (at[0] + at[1] + at[2]) / 3.0);
                assert!(center.distance(expected) < 1e-14, "{p} {q} {at:?}");
            }
        }
    }
}
