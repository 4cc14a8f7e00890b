//! The Bézier nets of a surface over a grid of its parameters, side by side in one array.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use std::fmt;
use std::ops::Range;
use std::sync::OnceLock;

use glam::DVec4;
use pulp::{Arch, Simd, WithSimd};

use super::basis::{window, with_order};
use super::bending::{Bending, in_space};
use super::knot_vector::KnotVector;

/// Patches along each direction of which it is asked how they bend, at most.
const MOST_LINES: usize = 12;

/// A surface cut along its knots, and wherever else it was asked for, into Bézier patches.
#[derive(Clone)]
pub(crate) struct PatchNets {
    /// The parameters of the cuts in u, ends included.
    pub u: Vec<f64>,
    /// The parameters of the cuts in v, ends included.
    pub v: Vec<f64>,
    /// Degrees in u and v.
    pub degrees: (usize, usize),
    /// Homogeneous control points, row by row; neighbours share their border.
    points: Vec<DVec4>,
    cols: usize,
    /// Made when it is first asked for.
    bends: OnceLock<Vec<Bending>>,
}

/// Without the control points: a surface that keeps its nets prints its own.
impl fmt::Debug for PatchNets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut nets = f.debug_struct("PatchNets");
        nets.field("u", &self.u).field("v", &self.v).field("degrees", &self.degrees);
        nets.finish_non_exhaustive()
    }
}

impl PatchNets {
    /// Cuts a homogeneous control net at its knots and at `more` parameters inside the domain.
    pub(super) fn new(net: &[DVec4], knots: [&KnotVector; 2], more: [&[f64]; 2]) -> Self {
        let (u, v) = (Cuts::of(knots[0], more[0]), Cuts::of(knots[1], more[1]));
        let (arch, cols) = (Arch::new(), v.firsts.len());
        let along_v = with_order!(v.order - 1, ORDER => {
            arch.dispatch(AlongV::<ORDER> { net, knots, cuts: &v })
        });
        let points = with_order!(u.order - 1, ORDER => {
            arch.dispatch(AlongU::<ORDER> { points: &along_v, cols, cuts: &u })
        });
        let degrees = (u.order - 1, v.order - 1);
        Self { u: u.breaks, v: v.breaks, degrees, points, cols, bends: OnceLock::new() }
    }

    /// The rows and columns of all patches or, of many, of those in the middle of as many equal parts.
    pub(crate) fn some(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (rows, cols) = (self.u.len() - 1, self.v.len() - 1);
        let (some_rows, some_cols) = (rows.min(MOST_LINES), cols.min(MOST_LINES));
        let middle = |k: usize, some: usize, all: usize| (2 * k + 1) * all / (2 * some);
        (0..some_rows * some_cols).map(move |k| {
            let (i, j) = (k / some_cols, k % some_cols);
            (middle(i, some_rows, rows), middle(j, some_cols, cols))
        })
    }

    /// How [`PatchNets::some`] bend, in their order.
    pub(crate) fn bends(&self) -> &[Bending] {
        self.bends.get_or_init(|| {
            let mut points = vec![];
            let bending = |(row, col): (usize, usize)| {
                points.clear();
                for row in self.rows(row..row + 1, col..col + 1) {
                    points.extend(row.iter().map(|h| in_space(*h)));
                }
                Bending::of(&points, self.degrees)
            };
            self.some().map(bending).collect()
        })
    }

    /// How many control points they have.
    pub(crate) fn control_points(&self) -> usize {
        self.points.len()
    }

    /// The homogeneous point that is the sum of these shares of control points: in each row from
    /// the first start on, of those from the second start on.
    pub(crate) fn point(
        &self,
        (from_u, u): (usize, &[f64]),
        (from_v, v): (usize, &[f64]),
    ) -> DVec4 {
        // Many points are control points.
        if u.len() == 1 && v.len() == 1 {
            return self.points[from_u * self.cols + from_v];
        }
        let mut point = DVec4::ZERO;
        for (i, share) in u.iter().enumerate() {
            let row = &self.points[(from_u + i) * self.cols + from_v..][..v.len()];
            let mut inner = DVec4::ZERO;
            for (h, share) in row.iter().zip(v) {
                inner += *share * *h;
            }
            point += *share * inner;
        }
        point
    }

    /// The rows of the homogeneous control points of the patches in these rows and columns.
    pub(crate) fn rows(
        &self,
        rows: Range<usize>,
        cols: Range<usize>,
    ) -> impl Iterator<Item = &[DVec4]> {
        let (p, q) = self.degrees;
        let (start, width) = (cols.start * q, cols.len() * q + 1);
        (rows.start * p..=rows.end * p).map(move |i| &self.points[i * self.cols + start..][..width])
    }

    /// Appends the homogeneous control points of the patches in these rows and columns, row by row.
    pub(crate) fn append(&self, rows: Range<usize>, cols: Range<usize>, net: &mut Vec<DVec4>) {
        self.rows(rows, cols).for_each(|row| net.extend_from_slice(row));
    }
}

/// How the control points of Bézier curves, one behind the other, follow from those of a spline.
struct Cuts {
    /// The parameters where the curves begin and end.
    breaks: Vec<f64>,
    order: usize,
    /// The first control point that each takes something of.
    firsts: Vec<usize>,
    /// How much each takes of that and the next ones, as many as the order.
    shares: Vec<f64>,
}

impl Cuts {
    fn of(knots: &KnotVector, more: &[f64]) -> Self {
        with_order!(knots.degree(), ORDER => Self::new::<ORDER>(knots, more))
    }

    /// For knots whose order is at most this one.
    fn new<const ORDER: usize>(knots: &KnotVector, more: &[f64]) -> Self {
        let (degree, mut breaks) = (knots.degree(), knots.breaks());
        if !more.is_empty() {
            breaks.extend_from_slice(more);
            breaks.sort_unstable_by(f64::total_cmp);
            breaks.dedup();
        }
        let count = (breaks.len() - 1) * degree + 1;
        let mut firsts = Vec::with_capacity(count);
        let mut shares = Vec::with_capacity(count * (degree + 1));
        for (index, ends) in breaks.windows(2).enumerate() {
            let span = knots.span(ends[0]);
            // The last point of a curve is the first one of the next.
            let end = if index + 2 == breaks.len() { degree } else { degree - 1 };
            for k in 0..=end {
                firsts.push(span - degree);
                let row = blossom::<ORDER>(knots, span, (ends[0], ends[1]), k);
                shares.extend_from_slice(&row[..=degree]);
            }
        }
        Self { breaks, order: degree + 1, firsts, shares }
    }

    /// The first control point, and how much of each from there on, of each.
    #[inline(always)]
    fn iter<const ORDER: usize>(&self) -> impl Iterator<Item = (usize, &[f64; ORDER])> {
        self.firsts.iter().copied().zip(self.shares.as_chunks().0)
    }
}

/// How much the k-th control point over a part of a span takes of those of the span: the blossom at
/// the part's start, and k times at its end (L. Ramshaw, *Blossoms are polar forms*, 1989). That is
/// de Boor's algorithm from its result to what it begins with; all shares are positive.
fn blossom<const ORDER: usize>(
    knots: &KnotVector,
    span: usize,
    (from, to): (f64, f64),
    k: usize,
) -> [f64; ORDER] {
    let (degree, t) = (knots.degree(), knots.as_slice());
    let mut shares = [0.0; ORDER];
    shares[degree] = 1.0;
    for level in (1..=degree).rev() {
        let x = if level > k { from } else { to };
        for j in level..=degree {
            let start = t[span - degree + j];
            let share = (x - start) / (t[span + 1 + j - level] - start);
            let value = shares[j];
            shares[j - 1] += (1.0 - share) * value;
            shares[j] = share * value;
        }
    }
    shares
}

/// A homogeneous point as an array, in a form that the compiler vectorizes.
type Lanes = [f64; 4];

/// The control points of the curves along v that stand for the rows of a surface's net.
struct AlongV<'a, const ORDER: usize> {
    net: &'a [DVec4],
    knots: [&'a KnotVector; 2],
    cuts: &'a Cuts,
}

impl<const ORDER: usize> WithSimd for AlongV<'_, ORDER> {
    type Output = Vec<Lanes>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<Lanes> {
        let [rows, cols] = self.knots.map(KnotVector::control_points);
        let net: &[Lanes] = bytemuck::cast_slice(self.net);
        let width = self.cuts.firsts.len();
        let mut all = vec![[0.0; 4]; rows * width];
        for (row, out) in net.chunks_exact(cols).zip(all.chunks_exact_mut(width)) {
            for ((first, shares), out) in self.cuts.iter::<ORDER>().zip(out) {
                let (points, mut sum) = (window::<_, ORDER>(row, first), [0.0; 4]);
                for k in 0..ORDER {
                    (0..4).for_each(|axis| sum[axis] += shares[k] * points[k][axis]);
                }
                *out = sum;
            }
        }
        all
    }
}

/// The control points of patches, row by row, from those of curves along v.
struct AlongU<'a, const ORDER: usize> {
    points: &'a [Lanes],
    cols: usize,
    cuts: &'a Cuts,
}

impl<const ORDER: usize> WithSimd for AlongU<'_, ORDER> {
    type Output = Vec<DVec4>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<DVec4> {
        let cols = self.cols;
        let mut all = vec![DVec4::ZERO; self.cuts.firsts.len() * cols];
        for (row, (first, shares)) in all.chunks_exact_mut(cols).zip(self.cuts.iter::<ORDER>()) {
            let mut from = self.points[first * cols..].chunks_exact(cols);
            let from = shares.map(|_| from.next().unwrap_or_default());
            let from = from.map(|row| S::as_simd_f64s(bytemuck::cast_slice(row)));
            let (sums, rest) = S::as_mut_simd_f64s(bytemuck::cast_slice_mut(row));
            let from = from.map(|(wide, narrow)| (&wide[..sums.len()], &narrow[..rest.len()]));
            for (k, out) in sums.iter_mut().enumerate() {
                // In a register: memory that crosses the lines of the cache is slow to come back.
                let mut sum = simd.splat_f64s(0.0);
                for (share, (from, _)) in shares.iter().zip(from) {
                    sum = simd.add_f64s(sum, simd.mul_f64s(simd.splat_f64s(*share), from[k]));
                }
                *out = sum;
            }
            for (k, sum) in rest.iter_mut().enumerate() {
                shares.iter().zip(from).for_each(|(share, (_, from))| *sum += share * from[k]);
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
    fn patches_are_the_surface() {
        let point = |k: usize| {
            let k = k as f64;
            DVec3::new((1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin())
        };
        let weights = (0..35).map(|k| 1.5 + (3.1 * f64::from(k)).sin()).collect();
        // Neither clamped nor uniform, with a knot of the degree's multiplicity.
        let u = KnotVector::new(2, vec![0.0, 0.2, 0.5, 1.0, 1.0, 1.7, 2.0, 3.0]).unwrap();
        let v = KnotVector::new(3, vec![-1.0, 0.0, 0.5, 0.6, 1.0, 1.0, 3.0, 4.0, 4.0, 4.0, 4.0]);
        let net = (0..35).map(point).collect();
        let surface = NurbsSurface::new(net, Some(weights), u, v.unwrap()).unwrap();
        let nets = surface.patch_nets_cut_at(&[0.7, 1.6], &[2.0]);
        let middle = |degree| bernstein(degree, 0.3)[0];
        let (rows, cols) = (middle(2), middle(3));
        for (i, ends_u) in nets.u.windows(2).enumerate() {
            for (j, ends_v) in nets.v.windows(2).enumerate() {
                let inside = nets.point((2 * i, &rows[..3]), (3 * j, &cols[..4])).project();
                let at = |ends: &[f64]| ends[0] + 0.3 * (ends[1] - ends[0]);
                assert!(inside.distance(surface.point(at(ends_u), at(ends_v))) < 1e-14);
            }
        }
        assert_eq!((nets.u.len(), nets.v.len()), (5, 5));
    }

    #[test]
    fn a_surface_keeps_the_nets_of_its_patches_unless_they_are_many() {
        for (side, kept) in [(4, true), (20, true), (100, false)] {
            let net =
                (0..side * side).map(|k| DVec3::new((k / side) as f64, (k % side) as f64, 0.0));
            let surface = NurbsSurface::clamped(net.collect(), (side, side), 3).unwrap();
            let copy = surface.clone();
            let [first, second] = [(); 2].map(|()| surface.patch_nets());
            assert_eq!(std::sync::Arc::ptr_eq(&first, &second), kept);
            assert_eq!((first.points == second.points, surface == copy), (true, true));
            assert_eq!(first.bends().len(), first.some().count());
        }
    }

    #[test]
    fn patches_begin_and_end_on_the_surface() {
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
