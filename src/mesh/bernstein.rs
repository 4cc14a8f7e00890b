//! Bézier control points of parts of a patch: rectangles, segments and triangles of its unit
//! square.
//!
//! Those of triangles come from blossoms, functions of as many arguments as the degree says, which
//! take the curve's values where all are the same (L. Ramshaw, *Blossoms are polar forms*, 1989).

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use std::ops::{Add, Mul};
use std::sync::OnceLock;

use glam::{DVec2, DVec4};
use pulp::Simd;

use super::cost::{OCTET, Octet};
use super::means::Means;
use super::triangle::{self, triples};
use crate::nurbs::{MAX_ORDER, Row};

/// What every patch of the same degrees needs again: how a tensor product's coefficients become
/// those of a triangle or of a segment.
#[derive(Debug)]
pub(super) struct Bernstein {
    pub p: usize,
    pub q: usize,
    /// How the arguments of a triangle's coefficients are dealt to u and v: for each blossom in v
    /// and, within, in u, the coefficient that takes their product, and how much of it.
    deals: Vec<(usize, f64)>,
    /// For the halves of the square, by the corner that they lack, in the order of [`UNIT`]: the
    /// coefficients of the square that those of a triangle are means of.
    halves: [Means; 4],
    /// From a triangle's coefficients to those of its halves.
    pub cuts: [Means; 2],
}

/// The corners of the unit square, counter-clockwise.
pub(super) const UNIT: [DVec2; 4] =
    [DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0), DVec2::new(1.0, 1.0), DVec2::new(0.0, 1.0)];

/// The half of the unit square that lacks this corner: the right angle first, then the ends of the
/// diagonal.
#[inline(always)]
pub(super) fn half(lacking: usize) -> [DVec2; 3] {
    [UNIT[(lacking + 2) % 4], UNIT[(lacking + 3) % 4], UNIT[(lacking + 1) % 4]]
}

/// Ways to choose k of n.
pub(super) fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

/// What has been needed so far, by degrees: making it takes as long as a small mesh.
static KNOWN: [[OnceLock<Bernstein>; MAX_ORDER]; MAX_ORDER] =
    [const { [const { OnceLock::new() }; MAX_ORDER] }; MAX_ORDER];

impl Bernstein {
    /// For patches of these degrees.
    pub(super) fn of((p, q): (usize, usize)) -> &'static Self {
        KNOWN[p][q].get_or_init(|| Self::new((p, q)))
    }

    fn new((p, q): (usize, usize)) -> Self {
        let (u, v, n) = (triples(p), triples(q), p + q);
        let of = triples(n);
        // A coefficient's arguments are dealt to u and v in all ways.
        let mut deals = vec![];
        for (in_v, in_u) in v.iter().flat_map(|in_v| u.iter().map(move |in_u| (in_v, in_u))) {
            let sum = [0, 1, 2].map(|k| in_u[k] + in_v[k]);
            let ways: f64 = (0..3).map(|k| binomial(sum[k], in_u[k])).product();
            let taker = of.iter().position(|counts| *counts == sum).unwrap_or(0);
            deals.push((taker, ways / binomial(n, p)));
        }
        let halves = [0, 1, 2, 3].map(|lacking| {
            let corners = half(lacking);
            let ones = |counts: &[usize; 3], x: fn(&DVec2) -> f64| -> usize {
                counts.iter().zip(&corners).map(|(&n, at)| if x(at) > 0.5 { n } else { 0 }).sum()
            };
            let mut means = vec![vec![]; of.len()];
            for (k, &(taker, share)) in deals.iter().enumerate() {
                let (in_v, in_u) = (&v[k / u.len()], &u[k % u.len()]);
                let (row, col) = (ones(in_u, |at| at.x), ones(in_v, |at| at.y));
                means[taker].push((row * (q + 1) + col, share));
            }
            Means::new(&means)
        });
        Self { p, q, deals, halves, cuts: triangle::halves(n) }
    }

    /// Where a corner of the unit square stands in a net; `None` for other places.
    #[inline(always)]
    pub(super) fn end(&self, at: DVec2) -> Option<usize> {
        let end = |x: f64, last: usize| match x {
            0.0 => Some(0),
            1.0 => Some(last),
            _ => None,
        };
        Some(end(at.x, self.p)? * (self.q + 1) + end(at.y, self.q)?)
    }

    /// The part of a net over a rectangle of its square, appended to `out`.
    #[inline(always)]
    pub(super) fn rectangle(
        &self,
        net: &[DVec4],
        x: (f64, f64),
        y: (f64, f64),
        out: &mut Vec<DVec4>,
    ) {
        rectangle(net, (self.p, self.q), x, y, out);
    }

    /// The point of a net at a place in its square.
    pub(super) fn point(&self, net: &[DVec4], at: DVec2) -> DVec4 {
        let (u, v) = (polynomials(self.p, at.x), polynomials(self.q, at.y));
        let mut point = DVec4::ZERO;
        for (row, share) in net.chunks_exact(self.q + 1).zip(u) {
            let mut inner = DVec4::ZERO;
            for (h, share) in row.iter().zip(v) {
                inner += share * *h;
            }
            point += share * inner;
        }
        point
    }

    /// The control points of the curve above a part of a side of the square, in the direction of
    /// growing parameters, appended to `out`.
    #[inline(always)]
    pub(super) fn segment(&self, net: &[DVec4], (from, to): (DVec2, DVec2), out: &mut Vec<DVec4>) {
        let (p, width, start) = (self.p, self.q + 1, out.len());
        let (low, high) = (from.min(to), from.max(to));
        if low.x == high.x {
            let row = if low.x == 0.0 { 0 } else { p * width };
            out.extend_from_slice(&net[row..row + width]);
            restrict(&mut out[start..], (0, 1), self.q, (low.y, high.y));
        } else {
            let column = if low.y == 0.0 { 0 } else { self.q };
            out.extend((0..=p).map(|row| net[row * width + column]));
            restrict(&mut out[start..], (0, 1), p, (low.x, high.x));
        }
    }

    /// The Bézier coefficients on a triangle of the square of a function with these ones.
    #[inline(always)]
    pub(super) fn triangle<S: Simd>(
        &self,
        simd: S,
        of: &[DVec4],
        at: [DVec2; 3],
        blossoms: &mut Blossoms,
        out: &mut Vec<Octet>,
    ) {
        out.resize(self.halves[0].octets(), [[0.0; OCTET]; 4]);
        let (low, high) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
        let place = |x: f64, low: f64, high: f64| {
            if x == low {
                0.0
            } else if x == high {
                1.0
            } else {
                0.5
            }
        };
        let mut in_box = at;
        for at in &mut in_box {
            *at = DVec2::new(place(at.x, low.x, high.x), place(at.y, low.y, high.y));
        }
        if let Some(lacking) = (0..4).find(|&lacking| half(lacking) == in_box) {
            if in_box == at {
                self.halves[lacking].of(simd, |k| of[k].to_array(), out);
                return;
            }
            let part = &mut blossoms.part;
            part.clear();
            rectangle(of, (self.p, self.q), (low.x, high.x), (low.y, high.y), part);
            self.halves[lacking].of(simd, |k| part[k].to_array(), out);
            return;
        }
        self.blossom(of, at, blossoms, out);
    }

    /// The same for any triangle.
    #[inline(always)]
    fn blossom(
        &self,
        of: &[DVec4],
        at: [DVec2; 3],
        Blossoms { u, v, points, values, sums, .. }: &mut Blossoms,
        out: &mut [Octet],
    ) {
        let (orders, width) = ((self.p + 1, self.q + 1), self.q + 1);
        blossoms(self.p, at.map(|at| at.x), u);
        blossoms(self.q, at.map(|at| at.y), v);
        // First in u, for each column; then, as one of many columns, each of these in v.
        let rows = u.len() / orders.0;
        points.clear();
        points.resize(rows * width, NOTHING);
        for (i, shares) in u.chunks_exact(orders.0).enumerate() {
            for (share, row) in shares.iter().zip(of.chunks_exact(width)) {
                if *share != 0.0 {
                    let sums = points[i..].iter_mut().step_by(rows);
                    sums.zip(row).for_each(|(sum, h)| add(sum, *share, &h.to_array()));
                }
            }
        }
        sums.clear();
        sums.resize(OCTET * out.len(), NOTHING);
        let mut last = 0;
        for (shares, deals) in v.chunks_exact(orders.1).zip(self.deals.chunks_exact(rows)) {
            values.clear();
            values.resize(4 * rows, 0.0);
            for (share, column) in shares.iter().zip(points.chunks_exact(rows)) {
                if *share != 0.0 {
                    let column: &[f64] = bytemuck::cast_slice(column);
                    values.iter_mut().zip(column).for_each(|(sum, x)| *sum += *share * x);
                }
            }
            let values: &[Lanes] = bytemuck::cast_slice(values);
            for (value, &(taker, deal)) in values.iter().zip(deals) {
                add(&mut sums[taker], deal, value);
                last = last.max(taker);
            }
        }
        // As everywhere, the last one stands in for those that are missing to eight.
        let end = sums[last];
        sums[last..].fill(end);
        for (octet, sums) in out.iter_mut().zip(sums.chunks_exact(OCTET)) {
            for (lane, sum) in sums.iter().enumerate() {
                (0..4).for_each(|axis| octet[axis][lane] = sum[axis]);
            }
        }
    }
}

/// The Bernstein polynomials of a degree (*The NURBS Book*, A1.3).
pub(super) fn polynomials(degree: usize, x: f64) -> Row {
    let mut row = [0.0; MAX_ORDER];
    row[0] = 1.0;
    for level in 1..=degree {
        let mut kept = 0.0;
        for value in &mut row[..level] {
            let before = *value;
            *value = kept + (1.0 - x) * before;
            kept = x * before;
        }
        row[level] = kept;
    }
    row
}

/// Memory that blossoms need.
#[derive(Debug, Default)]
pub(super) struct Blossoms {
    part: Vec<DVec4>,
    u: Vec<f64>,
    v: Vec<f64>,
    points: Vec<Lanes>,
    values: Vec<f64>,
    sums: Vec<Lanes>,
}

/// A homogeneous point as an array, in a form that the compiler vectorizes.
type Lanes = [f64; 4];

/// The sum of no points.
const NOTHING: Lanes = [0.0; 4];

/// Adds a multiple of a point.
#[inline(always)]
fn add(sum: &mut Lanes, factor: f64, point: &Lanes) {
    (0..4).for_each(|axis| sum[axis] += factor * point[axis]);
}

/// How much the blossoms of a degree take of each coefficient, at each of the three arguments as often
/// as [`triples`] say, in their order: a blossom of the Bernstein polynomials, of which the k-th stands
/// beside the k-th power of s, is the product of 1 - x + x s over all arguments x.
#[inline(always)]
fn blossoms(degree: usize, [x, y, z]: [f64; 3], out: &mut Vec<f64>) {
    out.clear();
    let mut first = [0.0; MAX_ORDER];
    first[0] = 1.0;
    for a in 0..=degree {
        let mut second = first;
        for b in 0..=degree - a {
            let start = out.len();
            out.extend_from_slice(&second[..=degree]);
            for known in a + b..degree {
                multiply(&mut out[start..], known, z);
            }
            multiply(&mut second, a + b, y);
        }
        multiply(&mut first, a, x);
    }
}

/// Multiplies a polynomial of a degree by 1 - x + x s.
#[inline(always)]
fn multiply(polynomial: &mut [f64], degree: usize, x: f64) {
    let Some(next) = polynomial.get_mut(degree + 1) else { return };
    *next = 0.0;
    // Corners of triangles often lie on the sides of the square.
    if x == 0.0 {
        return;
    }
    for k in (0..=degree).rev() {
        let value = polynomial[k];
        polynomial[k + 1] += x * value;
        polynomial[k] = (1.0 - x) * value;
    }
}

/// The part of a net over a rectangle of its square, appended to `out`.
#[inline(always)]
fn rectangle<T>(net: &[T], (p, q): (usize, usize), x: (f64, f64), y: (f64, f64), out: &mut Vec<T>)
where
    T: Copy + Add<Output = T>,
    f64: Mul<T, Output = T>,
{
    let (width, start) = (q + 1, out.len());
    out.extend_from_slice(net);
    let net = &mut out[start..];
    (0..width).for_each(|column| restrict(net, (column, width), p, x));
    (0..=p).for_each(|row| restrict(net, (row * width, 1), q, y));
}

/// Turns control points, which follow one another by `stride` from `start`, into those of a part of
/// their curve (de Casteljau's algorithm, once for each end).
#[inline(always)]
fn restrict<T>(of: &mut [T], (start, stride): (usize, usize), degree: usize, (from, to): (f64, f64))
where
    T: Copy + Add<Output = T>,
    f64: Mul<T, Output = T>,
{
    if from != 0.0 {
        for level in 1..=degree {
            for k in 0..=degree - level {
                let at = start + k * stride;
                of[at] = (1.0 - from) * of[at] + from * of[at + stride];
            }
        }
    }
    if to != 1.0 {
        let share = (to - from) / (1.0 - from);
        for level in 1..=degree {
            for k in (level..=degree).rev() {
                let at = start + k * stride;
                of[at] = (1.0 - share) * of[at - stride] + share * of[at];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::*;

    /// A net of random-looking points.
    fn net(p: usize, q: usize) -> Vec<DVec4> {
        let point = |k: usize| {
            let k = k as f64;
            DVec4::new((1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin(), 1.5 + (3.1 * k).sin())
        };
        (0..(p + 1) * (q + 1)).map(point).collect()
    }

    #[test]
    fn parts_agree_with_the_whole() {
        for (p, q) in [(1, 1), (3, 3), (2, 5)] {
            let (bernstein, net) = (Bernstein::new((p, q)), net(p, q));
            let mut part = vec![];
            bernstein.rectangle(&net, (0.25, 0.75), (0.5, 0.625), &mut part);
            let inside = bernstein.point(&part, DVec2::new(0.3, 0.8));
            let outside = bernstein.point(&net, DVec2::new(0.25 + 0.5 * 0.3, 0.5 + 0.125 * 0.8));
            assert!(inside.distance(outside) < 1e-14);
        }
    }

    #[test]
    fn sides_pass_through_their_points() {
        for (p, q) in [(1, 1), (3, 3), (2, 4)] {
            let (bernstein, net) = (Bernstein::new((p, q)), net(p, q));
            for side in [(0.0, 0.2, 0.0, 0.6), (1.0, 0.5, 1.0, 0.25), (0.1, 1.0, 0.9, 1.0)] {
                let (from, to) = (DVec2::new(side.0, side.1), DVec2::new(side.2, side.3));
                let mut curve = vec![];
                bernstein.segment(&net, (from, to), &mut curve);
                let share = polynomials(curve.len() - 1, 0.5);
                let middle: DVec4 = curve.iter().zip(share).map(|(h, share)| share * *h).sum();
                let expected = bernstein.point(&net, from.midpoint(to));
                assert!(middle.distance(expected) < 1e-14);
            }
        }
    }

    /// The coefficients of a net on a triangle.
    struct OnTriangle<'a>(&'a Bernstein, &'a [DVec4], [DVec2; 3]);

    impl WithSimd for OnTriangle<'_> {
        type Output = Vec<Octet>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<Octet> {
            let mut all = vec![];
            self.0.triangle(simd, self.1, self.2, &mut Blossoms::default(), &mut all);
            all
        }
    }

    #[test]
    fn triangles_pass_through_their_centres() {
        let inner = [DVec2::new(0.1, 0.9), DVec2::new(0.75, 0.5), DVec2::new(1.0, 0.25)];
        for (p, q) in [(1, 1), (3, 3), (2, 4)] {
            let (bernstein, net, n) = (Bernstein::new((p, q)), net(p, q), p + q);
            for at in (0..4).map(half).chain([inner]) {
                let all = Arch::new().dispatch(OnTriangle(&bernstein, &net, at));
                let centre: DVec4 = triples(n)
                    .iter()
                    .enumerate()
                    .map(|(k, of)| {
                        let ways = binomial(n, of[0]) * binomial(n - of[0], of[1]);
                        let point = all[k / OCTET].map(|row| row[k % OCTET]);
                        ways / 3.0_f64.powf(n as f64) * DVec4::from_array(point)
                    })
                    .sum();
                let expected = bernstein.point(&net, (at[0] + at[1] + at[2]) / 3.0);
                assert!(centre.distance(expected) < 1e-14, "{p} {q} {at:?}");
            }
        }
    }
}
