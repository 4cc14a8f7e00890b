//! A polynomial surface in a form that evaluates points and tangents fast, by SIMD and threads.

use std::ops::Range;

use glam::{DVec2, DVec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::settings::LeastSquaresSettings;
use super::sizes::{BATCH, CUBIC, POINTS_PER_TASK};
use crate::nurbs::{BasisDerivatives, KnotVector, MAX_ORDER, NurbsSurface};

const SETTINGS: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// A point and its tangents on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tangents {
    pub(super) point: DVec3,
    pub(super) u: DVec3,
    pub(super) v: DVec3,
}

impl Tangents {
    /// The unit normal, zero where there is none.
    #[inline]
    pub(super) fn normal(&self) -> DVec3 {
        let cross = self.u.cross(self.v);
        let least = SETTINGS.zero_ratio * self.u.length() * self.v.length();
        if cross.length() > least { cross.normalize_or_zero() } else { DVec3::ZERO }
    }
}

/// A control point and a zero, which fill a vector register.
pub(super) type Quad = [f64; 4];

/// A polynomial surface. Beyond the domain the outermost patches are extrapolated.
pub(super) struct Patches<'a> {
    knots: [&'a KnotVector; 2],
    net: Vec<Quad>,
    width: usize,
    /// For a bicubic surface, the coefficients of each patch by powers of u, then of v, relative to
    /// the patch's corner and sides. They take a third of the time.
    cubics: Vec<[[Quad; 4]; 4]>,
}

/// A computation at many points of a surface.
pub(super) trait Evaluation: Sync {
    type Output: Copy + Default + Send;

    /// The result for the point of this index. It must always be inlined, to become part of what
    /// SIMD dispatch compiles.
    fn evaluate(&self, index: usize) -> Self::Output;
}

/// The results for all indices, in order.
pub(super) fn evaluate_all<Q: Evaluation>(question: &Q, count: usize) -> Vec<Q::Output> {
    let arch = Arch::new();
    // Each thread writes results where they stay: for a million points, allocation takes as long as
    // a projection.
    let tasks = (0..count.div_ceil(BATCH)).into_par_iter().with_min_len(BATCH);
    let outputs = tasks.map(|task| {
        let from = task * BATCH;
        arch.dispatch(Task { question, range: from..count.min(from + BATCH) })
    });
    let mut outputs = outputs.collect::<Vec<_>>().into_flattened();
    outputs.truncate(count);
    outputs
}

struct Task<'a, Q: Evaluation> {
    question: &'a Q,
    range: Range<usize>,
}

impl<Q: Evaluation> WithSimd for Task<'_, Q> {
    type Output = [Q::Output; BATCH];

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut outputs = [Q::Output::default(); BATCH];
        for (output, index) in outputs.iter_mut().zip(self.range) {
            *output = self.question.evaluate(index);
        }
        outputs
    }
}

/// A computation from the tangents at one parameter for each index.
struct Each<'a, P, F> {
    patches: &'a Patches<'a>,
    uv: P,
    output: F,
}

impl<A, P, F> Evaluation for Each<'_, P, F>
where
    A: Copy + Default + Send,
    P: Fn(usize) -> DVec2 + Sync,
    F: Fn(usize, Tangents) -> A + Sync,
{
    type Output = A;

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn evaluate(&self, index: usize) -> A {
        (self.output)(index, self.patches.at((self.uv)(index)))
    }
}

impl<'a> Patches<'a> {
    pub(super) fn of(surface: &'a NurbsSurface) -> Self {
        let net = surface.control_points().iter().map(|point| point.extend(0.0).to_array());
        let knots = [surface.knots_u(), surface.knots_v()];
        let width = surface.shape().1;
        let mut patches = Self { knots, net: net.collect(), width, cubics: Vec::new() };
        if knots.iter().all(|knots| knots.degree() == CUBIC) {
            let [rows, cols] = knots.map(powers);
            let cubic = |at: usize| {
                let (row, col) = (at / cols.len(), at % cols.len());
                patches.cubic((row, col), &rows[row], &cols[col])
            };
            let all = (0..rows.len() * cols.len()).into_par_iter();
            patches.cubics = all.with_min_len(POINTS_PER_TASK).map(cubic).collect();
        }
        patches
    }

    /// The coefficients of a patch, from those of its basis functions.
    fn cubic(&self, (row, col): (usize, usize), by_u: &Powers, by_v: &Powers) -> [[Quad; 4]; 4] {
        let mut cubic = [[[0.0; 4]; 4]; 4];
        for (i, by_u) in by_u.iter().enumerate() {
            let mut along = [[0.0; 4]; 4];
            let net = &self.net[(row + i) * self.width + col..][..4];
            for (point, by_v) in net.iter().zip(by_v) {
                along.iter_mut().zip(by_v).for_each(|(sum, power)| add(sum, *power, point));
            }
            for (sums, power) in cubic.iter_mut().zip(by_u) {
                sums.iter_mut().zip(&along).for_each(|(sum, along)| add(sum, *power, along));
            }
        }
        cubic
    }

    /// The results of `output` for the index and the tangents at each of `count` parameters.
    pub(super) fn each<A: Copy + Default + Send>(
        &self,
        count: usize,
        uv: impl Fn(usize) -> DVec2 + Sync,
        output: impl Fn(usize, Tangents) -> A + Sync,
    ) -> Vec<A> {
        evaluate_all(&Each { patches: self, uv, output }, count)
    }

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn at(&self, uv: DVec2) -> Tangents {
        if self.cubics.is_empty() {
            return self.of_any_degree(uv);
        }
        let [u, v] = self.knots;
        let (row, col) = (u.span(uv.x), v.span(uv.y));
        let share = |knots: &KnotVector, span: usize, at: f64| {
            let scale = knots.reciprocals(1)[span + 1];
            ((at - knots.as_slice()[span]) * scale, scale)
        };
        let ((s, scale_u), (t, scale_v)) = (share(u, row, uv.x), share(v, col, uv.y));
        let cols = v.control_points() - 3;
        let [mut point, mut along_u, mut along_v] = [[0.0; 4]; 3];
        for coefficients in self.cubics[(row - 3) * cols + col - 3].iter().rev() {
            let [mut value, mut slope] = [[0.0; 4]; 2];
            for coefficient in coefficients.iter().rev() {
                horner(&mut slope, t, &value);
                horner(&mut value, t, coefficient);
            }
            horner(&mut along_u, s, &point);
            horner(&mut point, s, &value);
            horner(&mut along_v, s, &slope);
        }
        let [point, u, v] = [point, along_u, along_v].map(|[x, y, z, _]| DVec3::new(x, y, z));
        Tangents { point, u: scale_u * u, v: scale_v * v }
    }

    fn of_any_degree(&self, uv: DVec2) -> Tangents {
        let [u, v] = self.knots;
        let (rows, cols) = (
            BasisDerivatives::<2, MAX_ORDER>::at(u, uv.x),
            BasisDerivatives::<2, MAX_ORDER>::at(v, uv.y),
        );
        let (p, q) = (u.degree(), v.degree());
        let firsts = (rows.first, cols.first);
        let [rows, cols] = [rows.rows, cols.rows];
        self.sums(firsts, [&rows[0][..=p], &rows[1][..=p]], [&cols[0][..=q], &cols[1][..=q]])
    }

    fn sums(
        &self,
        firsts: (usize, usize),
        [values_u, slopes_u]: [&[f64]; 2],
        [values_v, slopes_v]: [&[f64]; 2],
    ) -> Tangents {
        let [mut place, mut along_u, mut along_v] = [[0.0; 4]; 3];
        for (i, (value, slope)) in values_u.iter().zip(slopes_u).enumerate() {
            let row = &self.net[(firsts.0 + i) * self.width + firsts.1..][..values_v.len()];
            let [mut along, mut across] = [[0.0; 4]; 2];
            for ((point, value), slope) in row.iter().zip(values_v).zip(slopes_v) {
                add(&mut along, *value, point);
                add(&mut across, *slope, point);
            }
            add(&mut place, *value, &along);
            add(&mut along_u, *slope, &along);
            add(&mut along_v, *value, &across);
        }
        let [point, u, v] = [place, along_u, along_v].map(|[x, y, z, _]| DVec3::new(x, y, z));
        Tangents { point, u, v }
    }
}

#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
pub(super) fn add(sum: &mut Quad, factor: f64, quad: &Quad) {
    for (sum, value) in sum.iter_mut().zip(quad) {
        *sum += factor * value;
    }
}

/// A step of Horner's rule.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn horner(sum: &mut Quad, at: f64, next: &Quad) {
    for (sum, next) in sum.iter_mut().zip(next) {
        *sum = *sum * at + next;
    }
}

/// The coefficients of each cubic basis function of a span.
type Powers = [[f64; 4]; 4];

/// The coefficients of all spans, in the parameter from 0 to 1 of each span.
fn powers(knots: &KnotVector) -> Vec<Powers> {
    let ends = knots.as_slice()[3..=knots.control_points()].windows(2);
    let powers = |ends: &[f64]| {
        let length = ends[1] - ends[0];
        if length == 0.0 {
            return Powers::default();
        }
        let basis = BasisDerivatives::<4, MAX_ORDER>::at(knots, ends[0]);
        // Taylor series: derivatives times powers of the length, divided by factorials.
        let factors = [1.0, length, length * length / 2.0, length.powi(3) / 6.0];
        std::array::from_fn(|i| std::array::from_fn(|k| factors[k] * basis.rows[k][i]))
    };
    ends.map(powers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_tangents_match_the_surface() {
        for degree in [2, 3] {
            let knots = KnotVector::clamped_uniform(degree, 6).unwrap();
            let point = |i: usize| {
                let (x, y) = (i as f64 / 6.0, (i % 6) as f64);
                DVec3::new(x, y, (x * y).sin())
            };
            let net = (0..36).map(point).collect();
            let surface = NurbsSurface::new(net, None, knots.clone(), knots).unwrap();
            let patches = Patches::of(&surface);
            for uv in (0..100).map(|i| DVec2::new(f64::from(i % 10), f64::from(i / 10)) / 9.0) {
                let Tangents { point, u, v } = patches.at(uv);
                assert!(point.distance(surface.point(uv.x, uv.y)) < 1e-13);
                let normal = surface.normal(uv.x, uv.y);
                assert!(u.cross(v).normalize().distance(normal) < 1e-12);
            }
        }
    }
}
