//! Bézier control points of parts of a patch: rectangles, segments and triangles of its unit
//! square.
//!
//! All come from blossoms: the weight of the i-th control point in the blossom of a curve at
//! `x₁, …, xₚ` is the coefficient of `zⁱ` in `Π (1 - xₖ + xₖ z)` (L. Ramshaw, *Blossoms are polar
//! forms*, 1989).

use std::collections::BTreeMap;
use std::ops::{Add, Mul};

use glam::{DVec2, DVec4};

use super::triangle::triples;
use crate::nurbs::MAX_ORDER;

/// The weights of a curve's control points in a blossom.
pub(super) type Weights = [f64; MAX_ORDER];

/// The weights in the blossom at these arguments, each as often as it says.
pub(super) fn blossom(arguments: &[(f64, usize)]) -> Weights {
    let mut weights = [0.0; MAX_ORDER];
    weights[0] = 1.0;
    let mut degree = 0;
    for &(x, times) in arguments {
        // The ends are the commonest arguments.
        if x == 0.0 {
            degree += times;
            continue;
        }
        if x == 1.0 {
            weights.copy_within(..=degree, times);
            weights[..times].fill(0.0);
            degree += times;
            continue;
        }
        for _ in 0..times {
            degree += 1;
            for i in (1..=degree).rev() {
                weights[i] = (1.0 - x) * weights[i] + x * weights[i - 1];
            }
            weights[0] *= 1.0 - x;
        }
    }
    weights
}

/// What every patch of the same degrees needs again: how a tensor product's coefficients become
/// those of a triangle or of a segment.
#[derive(Debug)]
pub(super) struct Bernstein {
    pub p: usize,
    pub q: usize,
    /// How often each corner of a triangle is an argument of a blossom in u.
    u: Vec<[usize; 3]>,
    /// The same in v.
    v: Vec<[usize; 3]>,
    /// For each coefficient of a triangle, the blossoms that it is the mean of; their indices are
    /// `v * u.len() + u`.
    triangle: Means,
    /// The same for the halves of the square, by the corner that they lack, in the order of
    /// [`UNIT`]; the indices are those of coefficients.
    halves: [Means; 4],
    /// For each coefficient of the diagonal from (0, 0) and of the one from (0, 1), the coefficients
    /// that it is the mean of.
    diagonals: [Means; 2],
}

/// The corners of the unit square, counter-clockwise.
pub(super) const UNIT: [DVec2; 4] =
    [DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0), DVec2::new(1.0, 1.0), DVec2::new(0.0, 1.0)];

/// The half of the unit square that lacks this corner: the right angle first, then the ends of the
/// diagonal.
pub(super) fn half(lacking: usize) -> [DVec2; 3] {
    [2, 3, 1].map(|k| UNIT[(lacking + k) % 4])
}

/// Weighted means of elements of a slice.
#[derive(Debug, Default)]
struct Means {
    /// Indices and weights, mean after mean.
    terms: Vec<(u32, f64)>,
    /// The end of each mean's terms.
    ends: Vec<usize>,
}

impl Means {
    fn push(&mut self, terms: impl IntoIterator<Item = (usize, f64)>) {
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for (index, weight) in terms {
            *sums.entry(index).or_default() += weight;
        }
        let terms =
            sums.into_iter().filter_map(|(i, weight)| Some((u32::try_from(i).ok()?, weight)));
        self.terms.extend(terms);
        self.ends.push(self.terms.len());
    }

    fn of<'a, T>(&'a self, elements: &'a [T]) -> impl Iterator<Item = T> + 'a
    where
        T: Copy + Default + Add<Output = T>,
        f64: Mul<T, Output = T>,
    {
        let mut from = 0;
        self.ends.iter().map(move |&end| {
            let terms = self.terms[from..end].iter();
            from = end;
            terms.fold(T::default(), |sum, &(i, weight)| sum + weight * elements[i as usize])
        })
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

impl Bernstein {
    /// For patches of these degrees.
    pub(super) fn new((p, q): (usize, usize)) -> Self {
        let (u, v, n) = (triples(p), triples(q), p + q);
        let (mut triangle, mut halves) = (Means::default(), <[Means; 4]>::default());
        for of in triples(n) {
            // A coefficient's arguments are dealt to u and v in all ways.
            let mut shares = vec![];
            for (i, in_u) in
                u.iter().enumerate().filter(|(_, in_u)| (0..3).all(|k| in_u[k] <= of[k]))
            {
                let in_v = [0, 1, 2].map(|k| of[k] - in_u[k]);
                let j = v.iter().position(|&counts| counts == in_v).unwrap_or(0);
                let ways: f64 = (0..3).map(|k| binomial(of[k], in_u[k])).product();
                shares.push((i, j, ways / binomial(n, p)));
            }
            triangle.push(shares.iter().map(|&(i, j, weight)| (j * u.len() + i, weight)));
            for (lacking, means) in halves.iter_mut().enumerate() {
                let corners = half(lacking);
                let ones = |counts: &[usize; 3], x: fn(&DVec2) -> f64| -> usize {
                    counts
                        .iter()
                        .zip(&corners)
                        .map(|(&n, at)| if x(at) > 0.5 { n } else { 0 })
                        .sum()
                };
                means.push(shares.iter().map(|&(i, j, weight)| {
                    let (row, col) = (ones(&u[i], |at| at.x), ones(&v[j], |at| at.y));
                    (row * (q + 1) + col, weight)
                }));
            }
        }
        let mut diagonals = <[Means; 2]>::default();
        for m in 0..=n {
            let shares = || (0..=p).filter(|&a| a <= m && m - a <= q);
            let weight = |a: usize| binomial(p, a) * binomial(q, m - a) / binomial(n, m);
            diagonals[0].push(shares().map(|a| (a * (q + 1) + m - a, weight(a))));
            diagonals[1].push(shares().map(|a| (a * (q + 1) + q - (m - a), weight(a))));
        }
        Self { p, q, u, v, triangle, halves, diagonals }
    }

    /// The part of a net over a rectangle of its square, appended to `out`.
    pub(super) fn rectangle(
        &self,
        net: &[DVec4],
        x: (f64, f64),
        y: (f64, f64),
        out: &mut Vec<DVec4>,
    ) {
        let (width, start) = (self.q + 1, out.len());
        out.extend_from_slice(net);
        let net = &mut out[start..];
        (0..width).for_each(|column| restrict(net, (column, width), self.p, x));
        (0..=self.p).for_each(|row| restrict(net, (row * width, 1), self.q, y));
    }

    /// The point of a net at a place in its square.
    pub(super) fn point(&self, net: &[DVec4], at: DVec2) -> DVec4 {
        let row = self.contracted(net, &blossom(&[(at.x, self.p)]));
        sum(&row[..=self.q], &blossom(&[(at.y, self.q)]))
    }

    /// The control points of the curve above a segment of the square, in the direction of growing
    /// x, or else y, appended to `out`.
    pub(super) fn segment(
        &self,
        net: &[DVec4],
        (from, to): (DVec2, DVec2),
        part: &mut Vec<DVec4>,
        out: &mut Vec<DVec4>,
    ) {
        let (p, width, start) = (self.p, self.q + 1, out.len());
        let (low, high) = (from.min(to), from.max(to));
        let end = |x: f64| x == 0.0 || x == 1.0;
        if low.x == high.x && end(low.x) {
            let row = if low.x == 0.0 { 0 } else { p * width };
            out.extend_from_slice(&net[row..row + width]);
            restrict(&mut out[start..], (0, 1), self.q, (low.y, high.y));
        } else if low.y == high.y && end(low.y) {
            let column = if low.y == 0.0 { 0 } else { self.q };
            out.extend((0..=p).map(|row| net[row * width + column]));
            restrict(&mut out[start..], (0, 1), p, (low.x, high.x));
        } else {
            part.clear();
            self.rectangle(net, (low.x, high.x), (low.y, high.y), part);
            let falls = (from.x < to.x) != (from.y < to.y);
            out.extend(self.diagonals[usize::from(falls)].of(part));
        }
    }

    /// The Bézier coefficients on a triangle of the square of a function with these ones, appended
    /// to `out`.
    pub(super) fn triangle(
        &self,
        of: &[DVec2],
        at: [DVec2; 3],
        blossoms: &mut Vec<DVec2>,
        out: &mut Vec<DVec2>,
    ) {
        if let Some(lacking) = (0..4).find(|&lacking| half(lacking) == at) {
            out.extend(self.halves[lacking].of(of));
            return;
        }
        let weights = |counts: &[usize; 3], x: fn(DVec2) -> f64| {
            blossom(&[0, 1, 2].map(|k| (x(at[k]), counts[k])))
        };
        // First in u: as many rows of the net's width; then each of these in v.
        let width = self.q + 1;
        blossoms.clear();
        for counts in &self.u {
            let start = blossoms.len();
            blossoms.resize(start + width, DVec2::ZERO);
            let rows = of.chunks_exact(width).zip(weights(counts, |at| at.x));
            for (of, weight) in rows.filter(|(_, weight)| *weight != 0.0) {
                for (sum, of) in blossoms[start..].iter_mut().zip(of) {
                    *sum += weight * *of;
                }
            }
        }
        let rows = blossoms.len();
        for counts in &self.v {
            let column = weights(counts, |at| at.y);
            for start in (0..rows).step_by(width) {
                let terms = blossoms[start..start + width].iter().zip(&column);
                let sum = terms.fold(DVec2::ZERO, |sum, (of, weight)| sum + *weight * *of);
                blossoms.push(sum);
            }
        }
        out.extend(self.triangle.of(&blossoms[rows..]));
    }

    /// The row of points that these weights make of the rows of a net.
    fn contracted(&self, net: &[DVec4], weights: &Weights) -> [DVec4; MAX_ORDER] {
        let mut row = [DVec4::ZERO; MAX_ORDER];
        let rows = net.chunks_exact(self.q + 1).zip(weights);
        for (points, weight) in rows.filter(|(_, weight)| **weight != 0.0) {
            row.iter_mut().zip(points).for_each(|(sum, point)| *sum += *weight * *point);
        }
        row
    }
}

/// Turns control points, which follow one another by `stride` from `start`, into those of a part of
/// their curve (de Casteljau's algorithm, once for each end).
fn restrict(
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

fn sum(points: &[DVec4], weights: &Weights) -> DVec4 {
    points.iter().zip(weights).map(|(point, weight)| *weight * *point).sum()
}

#[cfg(test)]
mod tests {
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
    fn segments_and_triangles_pass_through_their_points() {
        let inner = [DVec2::new(0.1, 0.9), DVec2::new(0.75, 0.5), DVec2::new(1.0, 0.25)];
        for (p, q) in [(1, 1), (3, 3), (2, 4)] {
            let (bernstein, net, n) = (Bernstein::new((p, q)), net(p, q), p + q);
            let halves = (0..4).map(half);
            for at in halves.chain([inner]) {
                let (mut blossoms, mut curve) = (vec![], vec![]);
                bernstein.segment(&net, (at[0], at[1]), &mut blossoms, &mut curve);
                let m = curve.len() - 1;
                let middle: DVec4 =
                    (0..=m).map(|k| binomial(m, k) / 2.0_f64.powf(m as f64) * curve[k]).sum();
                assert!(middle.distance(bernstein.point(&net, at[0].midpoint(at[1]))) < 1e-14);
                let flat: Vec<DVec2> = net.iter().map(|h| DVec2::new(h.x, h.w)).collect();
                let mut all = vec![];
                bernstein.triangle(&flat, at, &mut vec![], &mut all);
                let centre: DVec2 = triples(n)
                    .iter()
                    .zip(&all)
                    .map(|(of, &point)| {
                        let ways = binomial(n, of[0]) * binomial(n - of[0], of[1]);
                        ways / 3.0_f64.powf(n as f64) * point
                    })
                    .sum();
                let expected = bernstein.point(&net, (at[0] + at[1] + at[2]) / 3.0);
                let expected = DVec2::new(expected.x, expected.w);
                assert!(centre.distance(expected) < 1e-14, "{p} {q} {at:?}");
            }
        }
    }
}
