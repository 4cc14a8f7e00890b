//! Bézier extraction: the control nets of all Bézier patches of a surface, in one array.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use std::fmt;
use std::ops::Range;
use std::sync::OnceLock;

use glam::DVec4;
use pulp::{Arch, Simd, WithSimd};

use super::basis::{order_of, with_order};
use super::bending::{Bending, in_space};
use super::control_net::HomogeneousPoint;
use super::knot_vector::KnotVector;

/// Maximal number of sampled patches along each direction.
const MAX_SAMPLED_LINES: usize = 12;

/// A surface divided into Bézier patches at its knots and at additional parameters.
#[derive(Clone)]
pub(crate) struct PatchNets {
    /// The breaks in u, ends included.
    pub u: Vec<f64>,
    /// The breaks in v, ends included.
    pub v: Vec<f64>,
    /// Degrees in u and v.
    pub degrees: (usize, usize),
    /// Homogeneous control points, row by row; neighboring patches share their boundary.
    points: Vec<DVec4>,
    cols: usize,
    /// Computed on first use.
    sampled_bending: OnceLock<Vec<Bending>>,
}

/// Omits the control points: the surface that caches its nets prints its own.
impl fmt::Debug for PatchNets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut nets = f.debug_struct("PatchNets");
        nets.field("u", &self.u).field("v", &self.v).field("degrees", &self.degrees);
        nets.finish_non_exhaustive()
    }
}

impl PatchNets {
    /// Divides a homogeneous control net at its knots and at `more` parameters inside the domain.
    pub(super) fn new(net: &[DVec4], knots: [&KnotVector; 2], more: [&[f64]; 2]) -> Self {
        let (u, v) =
            (BezierExtraction::of(knots[0], more[0]), BezierExtraction::of(knots[1], more[1]));
        let (arch, cols) = (Arch::new(), v.firsts.len());
        let along_v = with_order!(v.order - 1, ORDER => {
            arch.dispatch(AlongV::<ORDER> { net, knots, extraction: &v })
        });
        let points = with_order!(u.order - 1, ORDER => {
            arch.dispatch(AlongU::<ORDER> { points: &along_v, cols, extraction: &u })
        });
        let degrees = (u.order - 1, v.order - 1);
        Self { u: u.breaks, v: v.breaks, degrees, points, cols, sampled_bending: OnceLock::new() }
    }

    /// Returns the rows and columns of all patches or, if they are many, of an evenly spaced
    /// sample.
    pub(crate) fn sampled_patches(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (rows, cols) = (self.u.len() - 1, self.v.len() - 1);
        let (sampled_rows, sampled_cols) =
            (rows.min(MAX_SAMPLED_LINES), cols.min(MAX_SAMPLED_LINES));
        let middle = |k: usize, samples: usize, all: usize| (2 * k + 1) * all / (2 * samples);
        (0..sampled_rows * sampled_cols).map(move |k| {
            let (i, j) = (k / sampled_cols, k % sampled_cols);
            (middle(i, sampled_rows, rows), middle(j, sampled_cols, cols))
        })
    }

    /// The bending of [`PatchNets::sampled_patches`], in their order.
    pub(crate) fn sampled_bending(&self) -> &[Bending] {
        self.sampled_bending.get_or_init(|| {
            let mut points = vec![];
            let bending = |(row, col): (usize, usize)| {
                points.clear();
                for row in self.rows(row..row + 1, col..col + 1) {
                    points.extend(row.iter().map(|h| in_space(*h)));
                }
                Bending::of(&points, self.degrees)
            };
            self.sampled_patches().map(bending).collect()
        })
    }

    /// Number of control points.
    pub(crate) fn control_points(&self) -> usize {
        self.points.len()
    }

    /// Returns a weighted sum of control points as a homogeneous point.
    ///
    /// Each argument is the first index in a direction and the weights from there on.
    pub(crate) fn point(
        &self,
        (from_u, u): (usize, &[f64]),
        (from_v, v): (usize, &[f64]),
    ) -> DVec4 {
        // Many of these points are control points.
        if u.len() == 1 && v.len() == 1 {
            return self.points[from_u * self.cols + from_v];
        }
        let mut point = DVec4::ZERO;
        for (i, coefficient) in u.iter().enumerate() {
            let row = &self.points[(from_u + i) * self.cols + from_v..][..v.len()];
            let mut inner = DVec4::ZERO;
            for (h, coefficient) in row.iter().zip(v) {
                inner += *coefficient * *h;
            }
            point += *coefficient * inner;
        }
        point
    }

    /// The homogeneous control points of a rectangle of patches, row by row.
    pub(crate) fn rows(
        &self,
        rows: Range<usize>,
        cols: Range<usize>,
    ) -> impl Iterator<Item = &[DVec4]> {
        let (p, q) = self.degrees;
        let (start, width) = (cols.start * q, cols.len() * q + 1);
        (rows.start * p..=rows.end * p).map(move |i| &self.points[i * self.cols + start..][..width])
    }

    /// Appends the homogeneous control points of a rectangle of patches, row by row.
    pub(crate) fn append(&self, rows: Range<usize>, cols: Range<usize>, net: &mut Vec<DVec4>) {
        self.rows(rows, cols).for_each(|row| net.extend_from_slice(row));
    }
}

/// The Bézier extraction operator of a knot vector: control points of consecutive Bézier curves as
/// combinations of spline control points.
struct BezierExtraction {
    /// The parameters at the ends of the Bézier curves.
    breaks: Vec<f64>,
    order: usize,
    /// For each Bézier control point, the index of its first spline control point.
    firsts: Vec<usize>,
    /// For each Bézier control point, the coefficients of `order` spline control points; zeros up
    /// to the order of [`with_order`].
    coefficients: Vec<f64>,
}

impl BezierExtraction {
    fn of(knots: &KnotVector, more: &[f64]) -> Self {
        with_order!(knots.degree(), ORDER => Self::new::<ORDER>(knots, more))
    }

    /// Computes the operator with `ORDER` coefficients for each point.
    fn new<const ORDER: usize>(knots: &KnotVector, more: &[f64]) -> Self {
        let (degree, mut breaks) = (knots.degree(), knots.breaks());
        if !more.is_empty() {
            breaks.extend_from_slice(more);
            breaks.sort_unstable_by(f64::total_cmp);
            breaks.dedup();
        }
        let count = (breaks.len() - 1) * degree + 1;
        let mut firsts = Vec::with_capacity(count);
        let mut coefficients = Vec::with_capacity(count * ORDER);
        for (index, ends) in breaks.windows(2).enumerate() {
            let span = knots.span(ends[0]);
            // The last point of a curve is the first point of the next curve.
            let end = if index + 2 == breaks.len() { degree } else { degree - 1 };
            for k in 0..=end {
                firsts.push(span - degree);
                coefficients.extend(blossom::<ORDER>(knots, span, (ends[0], ends[1]), k));
            }
        }
        Self { breaks, order: degree + 1, firsts, coefficients }
    }

    /// The first index and the coefficients for each Bézier control point.
    #[inline(always)]
    fn iter<const ORDER: usize>(&self) -> impl Iterator<Item = (usize, &[f64; ORDER])> {
        self.firsts.iter().copied().zip(self.coefficients.as_chunks().0)
    }
}

/// Returns the coefficients of the k-th Bézier control point over `(from, to)` in the control
/// points of the span.
///
/// This is the blossom with k arguments `to` and the others `from` (L. Ramshaw, *Blossoms are polar
/// forms*, 1989): de Boor's algorithm run backwards. All coefficients are nonnegative.
fn blossom<const ORDER: usize>(
    knots: &KnotVector,
    span: usize,
    (from, to): (f64, f64),
    k: usize,
) -> [f64; ORDER] {
    let (degree, t) = (knots.degree(), knots.as_slice());
    let mut coefficients = [0.0; ORDER];
    coefficients[degree] = 1.0;
    for level in (1..=degree).rev() {
        let x = if level > k { from } else { to };
        for j in level..=degree {
            let start = t[span - degree + j];
            let coefficient = (x - start) / (t[span + 1 + j - level] - start);
            let value = coefficients[j];
            coefficients[j - 1] += (1.0 - coefficient) * value;
            coefficients[j] = coefficient * value;
        }
    }
    coefficients
}

/// Applies the extraction in v to each row of a surface's net.
struct AlongV<'a, const ORDER: usize> {
    net: &'a [DVec4],
    knots: [&'a KnotVector; 2],
    extraction: &'a BezierExtraction,
}

impl<const ORDER: usize> WithSimd for AlongV<'_, ORDER> {
    type Output = Vec<HomogeneousPoint>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<HomogeneousPoint> {
        let [rows, cols] = self.knots.map(KnotVector::control_points);
        let net: &[HomogeneousPoint] = bytemuck::cast_slice(self.net);
        let (width, order) =
            (self.extraction.firsts.len(), order_of::<ORDER>(self.extraction.order - 1));
        let mut all = vec![[0.0; 4]; rows * width];
        for (row, out) in net.chunks_exact(cols).zip(all.chunks_exact_mut(width)) {
            for ((first, coefficients), out) in self.extraction.iter::<ORDER>().zip(out) {
                let (points, mut sum) = (&row[first..][..order], [0.0; 4]);
                for k in 0..order {
                    (0..4).for_each(|axis| sum[axis] += coefficients[k] * points[k][axis]);
                }
                *out = sum;
            }
        }
        all
    }
}

/// Applies the extraction in u to the result of [`AlongV`].
struct AlongU<'a, const ORDER: usize> {
    points: &'a [HomogeneousPoint],
    cols: usize,
    extraction: &'a BezierExtraction,
}

impl<const ORDER: usize> WithSimd for AlongU<'_, ORDER> {
    type Output = Vec<DVec4>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<DVec4> {
        let cols = self.cols;
        let mut all = vec![DVec4::ZERO; self.extraction.firsts.len() * cols];
        for (row, (first, coefficients)) in
            all.chunks_exact_mut(cols).zip(self.extraction.iter::<ORDER>())
        {
            let mut from = self.points[first * cols..].chunks_exact(cols);
            // Coefficients after the first `order` are zero; their rows may be missing.
            let any = &self.points[..cols];
            let from = coefficients.map(|_| from.next().unwrap_or(any));
            let from = from.map(|row| S::as_simd_f64s(bytemuck::cast_slice(row)));
            let (sums, rest) = S::as_mut_simd_f64s(bytemuck::cast_slice_mut(row));
            let from = from.map(|(wide, narrow)| (&wide[..sums.len()], &narrow[..rest.len()]));
            for (k, out) in sums.iter_mut().enumerate() {
                // Summed in a register: unaligned memory is slow to reload.
                let mut sum = simd.splat_f64s(0.0);
                for (coefficient, (from, _)) in coefficients.iter().zip(from) {
                    sum = simd.add_f64s(sum, simd.mul_f64s(simd.splat_f64s(*coefficient), from[k]));
                }
                *out = sum;
            }
            for (k, sum) in rest.iter_mut().enumerate() {
                coefficients
                    .iter()
                    .zip(from)
                    .for_each(|(coefficient, (_, from))| *sum += coefficient * from[k]);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::bezier_patch::bernstein;
    use super::super::surface::NurbsSurface;
    use super::*;

    #[test]
    fn patches_match_the_surface() {
        let point = |k: usize| {
            let k = k as f64;
            DVec3::new((1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin())
        };
        let weights = (0..35).map(|k| 1.5 + (3.1 * f64::from(k)).sin()).collect();
        // Unclamped and not uniform, with a knot of multiplicity `degree`.
        let u = KnotVector::new(2, vec![0.0, 0.2, 0.5, 1.0, 1.0, 1.7, 2.0, 3.0]).unwrap();
        let v = KnotVector::new(3, vec![-1.0, 0.0, 0.5, 0.6, 1.0, 1.0, 3.0, 4.0, 4.0, 4.0, 4.0]);
        let net = (0..35).map(point).collect();
        let surface = NurbsSurface::new(net, Some(weights), u, v.unwrap()).unwrap();
        let nets = surface.patch_nets_cut_at(&[0.7, 1.6], &[2.0]);
        let middle = |degree| bernstein::<4>(degree, 0.3)[0];
        let (rows, cols) = (middle(2), middle(3));
        for (i, ends_u) in nets.u.windows(2).enumerate() {
            for (j, ends_v) in nets.v.windows(2).enumerate() {
                let inside = nets.point((2 * i, &rows[..3]), (3 * j, &cols)).project();
                let at = |ends: &[f64]| ends[0] + 0.3 * (ends[1] - ends[0]);
                assert!(inside.distance(surface.point(at(ends_u), at(ends_v))) < 1e-14);
            }
        }
        assert_eq!((nets.u.len(), nets.v.len()), (5, 5));
    }

    #[test]
    fn small_patch_nets_are_cached_and_large_ones_are_not() {
        for (side, kept) in [(4, true), (20, true), (100, false)] {
            let net =
                (0..side * side).map(|k| DVec3::new((k / side) as f64, (k % side) as f64, 0.0));
            let surface = NurbsSurface::clamped(net.collect(), (side, side), 3).unwrap();
            let copy = surface.clone();
            let [first, second] = [(); 2].map(|()| surface.patch_nets());
            assert_eq!(std::sync::Arc::ptr_eq(&first, &second), kept);
            assert_eq!((first.points == second.points, surface == copy), (true, true));
            assert_eq!(first.sampled_bending().len(), first.sampled_patches().count());
        }
    }

    #[test]
    fn patch_corners_lie_on_the_surface() {
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let nets = torus.patch_nets_cut_at(&[0.1], &[0.6, 0.7]);
        assert_eq!((nets.u.len(), nets.v.len(), nets.degrees), (6, 7, (2, 2)));
        for (i, ends_u) in nets.u.windows(2).enumerate() {
            for (j, ends_v) in nets.v.windows(2).enumerate() {
                let mut net = vec![];
                nets.append(i..i + 1, j..j + 1, &mut net);
                let corners = [(0, 0, 0), (2, 0, 1), (6, 1, 0), (8, 1, 1)];
                for (k, at_u, at_v) in corners {
                    let point = torus.point(ends_u[at_u], ends_v[at_v]);
                    assert!(point.distance(net[k].truncate() / net[k].w) < 1e-14);
                }
            }
        }
    }
}
