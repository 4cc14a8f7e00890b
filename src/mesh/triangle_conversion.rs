//! Bézier control points of parts of a patch: rectangles, segments and triangles of its unit
//! square.
//!
//! Those of triangles come from blossoms, functions of as many arguments as the degree says, which
//! take the curve's values where all are the same (L. Ramshaw, *Blossoms are polar forms*, 1989).

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use std::sync::OnceLock;

use glam::{DVec2, DVec4};
use pulp::Simd;

use super::cost::{Eight, OCTET};
use super::means::Means;
use super::triangle::{self, triples};
use crate::nurbs::{MAX_ORDER, Row, halve};

/// What every patch of the same degrees needs again: how a tensor product's coefficients become
/// those of a triangle or of a segment.
#[derive(Debug)]
pub(super) struct Bernstein {
    pub p: usize,
    pub q: usize,
    /// How the arguments of a triangle's coefficients are dealt to u and v: for each blossom in v
    /// and, within, in u, the coefficient that takes their product, and how much of it.
    deals: Vec<(usize, f64)>,
    /// For each [`shape`], once it has been met: the coefficients of the square that those of the
    /// triangle are means of.
    shapes: Vec<OnceLock<Means>>,
    /// From a triangle's coefficients to those of its halves.
    pub cuts: [Means; 2],
}

/// The corners of the unit square, counter-clockwise.
pub(super) const UNIT: [DVec2; 4] =
    [DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0), DVec2::new(1.0, 1.0), DVec2::new(0.0, 1.0)];

/// Triangles with corners at nine places.
const SHAPES: usize = 9 * 9 * 9;

/// The number of a triangle whose corners are corners of the unit square, middles of its sides or its
/// centre, as those have that come from halving.
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
        let shapes = vec![OnceLock::new(); SHAPES];
        Self { p, q, deals, shapes, cuts: triangle::halves(n) }
    }

    /// How the coefficients on a triangle follow from those of the square.
    fn means(&self, at: [DVec2; 3]) -> Means {
        let (mut u, mut v) = (vec![], vec![]);
        blossoms(self.p, at.map(|at| at.x), &mut u);
        blossoms(self.q, at.map(|at| at.y), &mut v);
        let (u, v) = (u.chunks_exact(self.p + 1), v.chunks_exact(self.q + 1));
        let mut means = vec![vec![]; triangle::count(self.p + self.q)];
        let pairs = v.flat_map(|v| u.clone().map(move |u| (u, v)));
        for ((u, v), &(taker, deal)) in pairs.zip(&self.deals) {
            let shares = u.iter().flat_map(|u| v.iter().map(move |v| u * v)).enumerate();
            means[taker].extend(shares.map(|(point, share)| (point, deal * share)));
        }
        Means::new(&means)
    }

    /// How many times eight coefficients a triangle has.
    #[inline(always)]
    pub(super) fn octets(&self) -> usize {
        self.cuts[0].octets()
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

    /// Turns a net with rows of so many control points into that of its part over a rectangle of its
    /// square, which must have all of it in a direction in which it is of several patches.
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

    /// The first coordinates of the Bézier coefficients on a triangle of the square of a function with
    /// these ones.
    #[inline(always)]
    pub(super) fn triangle<S: Simd, const N: usize>(
        &self,
        simd: S,
        of: &[DVec4],
        at: [DVec2; 3],
        blossoms: &mut Blossoms,
        out: &mut [[Eight; N]],
    ) {
        let out = &mut out[..self.octets()];
        if let Some(shape) = shape(at) {
            let means = self.shapes[shape].get_or_init(|| self.means(at));
            means.of(simd, |k| of[k].to_array(), out);
            return;
        }
        let (low, high) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
        let in_box = at.map(|at| (at - low) / (high - low));
        if let Some(shape) = shape(in_box) {
            let means = self.shapes[shape].get_or_init(|| self.means(in_box));
            let part = &mut blossoms.part;
            part.clear();
            part.extend_from_slice(of);
            self.rectangle(part, self.q + 1, (low.x, high.x), (low.y, high.y));
            means.of(simd, |k| part[k].to_array(), out);
            return;
        }
        self.blossom(of, at, blossoms, out);
    }

    /// The same for any triangle.
    #[inline(always)]
    fn blossom<const N: usize>(
        &self,
        of: &[DVec4],
        at: [DVec2; 3],
        Blossoms { u, v, points, sums, .. }: &mut Blossoms,
        out: &mut [[Eight; N]],
    ) {
        let (orders, width) = ((self.p + 1, self.q + 1), self.q + 1);
        blossoms(self.p, at.map(|at| at.x), u);
        blossoms(self.q, at.map(|at| at.y), v);
        // First in u, for each column; then each of these in v.
        let rows = u.len() / orders.0;
        points.clear();
        points.resize(rows * width, NOTHING);
        for (sums, shares) in points.chunks_exact_mut(width).zip(u.chunks_exact(orders.0)) {
            for (share, row) in shares.iter().zip(of.chunks_exact(width)) {
                if *share != 0.0 {
                    let both = sums.iter_mut().zip(row);
                    both.for_each(|(sum, h)| add(sum, *share, &h.to_array()));
                }
            }
        }
        sums.clear();
        sums.resize(OCTET * out.len(), NOTHING);
        let mut last = 0;
        for (shares, deals) in v.chunks_exact(orders.1).zip(self.deals.chunks_exact(rows)) {
            for (row, &(taker, deal)) in points.chunks_exact(width).zip(deals) {
                let mut value = NOTHING;
                shares.iter().zip(row).for_each(|(share, point)| add(&mut value, *share, point));
                add(&mut sums[taker], deal, &value);
                last = last.max(taker);
            }
        }
        // As everywhere, the last one stands in for those that are missing to eight.
        let end = sums[last];
        sums[last..].fill(end);
        for (octet, sums) in out.iter_mut().zip(sums.chunks_exact(OCTET)) {
            for (lane, sum) in sums.iter().enumerate() {
                (0..N).for_each(|axis| octet[axis].0[lane] = sum[axis]);
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

/// Makes the control points of the quarters of a patch of these degrees the only ones in `out`.
#[inline(always)]
pub(super) fn quarters(net: &[DVec4], (p, q): (usize, usize), out: &mut Vec<DVec4>) {
    out.clear();
    (0..4).for_each(|_| out.extend_from_slice(net));
    let size = net.len();
    let (first, second) = out.split_at_mut(2 * size);
    halve(&mut first[..size], &mut second[..size], p, q + 1, 0..=q);
    for half in [first, second] {
        half.copy_within(..size, size);
        let (first, second) = half.split_at_mut(size);
        halve(first, second, q, 1, (0..=p).map(|row| row * (q + 1)));
    }
}

/// Turns control points, which follow one another by `stride` from `start`, into those of a part of
/// their curve (de Casteljau's algorithm, once for each end).
#[inline(always)]
pub(super) fn restrict(
    of: &mut [DVec4],
    (start, stride): (usize, usize),
    degree: usize,
    (from, to): (f64, f64),
) {
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

    use super::super::cost::Octet;
    use super::*;

    /// A net of random-looking points.
    fn net(p: usize, q: usize) -> Vec<DVec4> {
        let point = |k: usize| {
            let k = k as f64;
            DVec4::new((1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin(), 1.5 + (3.1 * k).sin())
        };
        (0..(p + 1) * (q + 1)).map(point).collect()
    }

    /// The point of a net at a place in its square.
    fn point(net: &[DVec4], (p, q): (usize, usize), at: DVec2) -> DVec4 {
        let (u, v) = (polynomials(p, at.x), polynomials(q, at.y));
        let row = |row: &[DVec4]| row.iter().zip(v).map(|(h, share)| share * *h).sum::<DVec4>();
        net.chunks_exact(q + 1).zip(u).map(|(points, share)| share * row(points)).sum()
    }

    #[test]
    fn parts_agree_with_the_whole() {
        for (p, q) in [(1, 1), (3, 3), (2, 5)] {
            let (bernstein, net) = (Bernstein::new((p, q)), net(p, q));
            let mut part = net.clone();
            bernstein.rectangle(&mut part, q + 1, (0.25, 0.75), (0.5, 0.625));
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

    /// The coefficients of a net on a triangle.
    struct OnTriangle<'a>(&'a Bernstein, &'a [DVec4], [DVec2; 3]);

    impl WithSimd for OnTriangle<'_> {
        type Output = Vec<Octet>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<Octet> {
            let mut all = vec![[Eight::default(); 4]; self.0.octets()];
            self.0.triangle(simd, self.1, self.2, &mut Blossoms::default(), &mut all);
            all
        }
    }

    #[test]
    fn triangles_pass_through_their_centres() {
        let triangles = [
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)],
            [(1.0, 1.0), (0.0, 1.0), (0.5, 0.0)],
            [(0.5, 0.75), (0.5, 0.25), (0.75, 0.75)],
            [(0.1, 0.9), (0.75, 0.5), (1.0, 0.25)],
        ];
        for (p, q) in [(1, 1), (3, 3), (2, 4)] {
            let (bernstein, net, n) = (Bernstein::new((p, q)), net(p, q), p + q);
            for at in triangles.map(|corners| corners.map(DVec2::from)) {
                let all = Arch::new().dispatch(OnTriangle(&bernstein, &net, at));
                let centre: DVec4 = triples(n)
                    .iter()
                    .enumerate()
                    .map(|(k, of)| {
                        let ways = binomial(n, of[0]) * binomial(n - of[0], of[1]);
                        let point = all[k / OCTET].map(|row| row.0[k % OCTET]);
                        ways / 3.0_f64.powf(n as f64) * DVec4::from_array(point)
                    })
                    .sum();
                let expected = point(&net, (p, q), (at[0] + at[1] + at[2]) / 3.0);
                assert!(centre.distance(expected) < 1e-14, "{p} {q} {at:?}");
            }
        }
    }
}
