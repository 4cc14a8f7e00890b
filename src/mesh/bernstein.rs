//! Bézier control points of parts of a patch: rectangles, segments and triangles of its unit
//! square.
//!
//! All come from blossoms: the weight of the i-th control point in the blossom of a curve at
//! x₁, …, x_p is the coefficient of zⁱ in Π (1 - x_k + x_k z) (L. Ramshaw, *Blossoms are polar
//! forms*, 1989).

use glam::{DVec2, DVec4};

use crate::nurbs::MAX_ORDER;

/// The weights of a curve's control points in a blossom.
pub(super) type Weights = [f64; MAX_ORDER];

/// The weights in the blossom at these arguments, each as often as it says.
pub(super) fn blossom(arguments: &[(f64, usize)]) -> Weights {
    let mut weights = [0.0; MAX_ORDER];
    weights[0] = 1.0;
    let mut degree = 0;
    for &(x, times) in arguments {
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
/// those of a triangle.
#[derive(Debug)]
pub(super) struct Bernstein {
    pub p: usize,
    pub q: usize,
    /// How often each corner of a triangle is an argument of a blossom in u.
    u: Vec<[usize; 3]>,
    /// The same in v.
    v: Vec<[usize; 3]>,
    /// For each coefficient of the triangle: blossoms (u, v) and their weights in its mean.
    coefficients: Vec<Vec<(u16, u16, f64)>>,
    /// For each coefficient of a segment: the blossoms (a, b) and their weights.
    segment: Vec<Vec<(usize, usize, f64)>>,
}

/// A function over the unit square and its weight, as coefficients of a tensor product; its value
/// is their quotient.
#[derive(Clone, Debug, Default)]
pub(super) struct Quotient {
    pub values: Vec<f64>,
    pub weights: Vec<f64>,
}

/// Memory for the blossoms of a triangle.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    values: Vec<f64>,
    weights: Vec<f64>,
}

/// All triples of counts with this sum.
fn triples(sum: usize) -> Vec<[usize; 3]> {
    let pairs = (0..=sum).flat_map(|a| (0..=sum - a).map(move |b| (a, b)));
    pairs.map(|(a, b)| [a, b, sum - a - b]).collect()
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

impl Bernstein {
    /// For patches of these degrees.
    pub(super) fn new((p, q): (usize, usize)) -> Self {
        let (u, v, n) = (triples(p), triples(q), p + q);
        let place = |all: &[[usize; 3]], one: [usize; 3]| all.iter().position(|&t| t == one);
        let coefficient = |of: [usize; 3]| {
            let term = |(i, in_u): (usize, &[usize; 3])| {
                let fits = (0..3).all(|k| in_u[k] <= of[k]);
                let in_v = fits.then(|| std::array::from_fn(|k| of[k] - in_u[k]))?;
                let ways: f64 = (0..3).map(|k| binomial(of[k], in_u[k])).product();
                let (i, j) = (u16::try_from(i).ok()?, u16::try_from(place(&v, in_v)?).ok()?);
                Some((i, j, ways / binomial(n, p)))
            };
            u.iter().enumerate().filter_map(term).collect()
        };
        let on_segment = |m: usize| {
            let shares = (0..=p).filter(|&a| a <= m && m - a <= q);
            let weight = |a: usize| binomial(p, a) * binomial(q, m - a) / binomial(n, m);
            shares.map(|a| (a, m - a, weight(a))).collect()
        };
        let coefficients = triples(n).into_iter().map(coefficient).collect();
        let segment = (0..=n).map(on_segment).collect();
        Self { p, q, u, v, coefficients, segment }
    }

    /// The part of a net over a rectangle of its square, appended to `out`.
    pub(super) fn rectangle(
        &self,
        net: &[DVec4],
        (x0, x1): (f64, f64),
        (y0, y1): (f64, f64),
        out: &mut Vec<DVec4>,
    ) {
        let (p, q) = (self.p, self.q);
        let columns: [Weights; MAX_ORDER] =
            std::array::from_fn(|b| blossom(&[(y0, q.saturating_sub(b)), (y1, b.min(q))]));
        for a in 0..=p {
            let row = self.contracted(net, &blossom(&[(x0, p - a), (x1, a)]));
            out.extend(columns[..=q].iter().map(|weights| sum(&row[..=q], weights)));
        }
    }

    /// The point of a net at a place in its square.
    pub(super) fn point(&self, net: &[DVec4], at: DVec2) -> DVec4 {
        let row = self.contracted(net, &blossom(&[(at.x, self.p)]));
        sum(&row[..=self.q], &blossom(&[(at.y, self.q)]))
    }

    /// The control points of the curve above a segment of the square, appended to `out`.
    pub(super) fn segment(&self, net: &[DVec4], from: DVec2, to: DVec2, out: &mut Vec<DVec4>) {
        let start = out.len();
        self.rectangle(net, (from.x, to.x), (from.y, to.y), out);
        let width = self.q + 1;
        for terms in &self.segment {
            let terms = terms.iter().map(|&(a, b, weight)| weight * out[start + a * width + b]);
            let point = terms.sum();
            out.push(point);
        }
        out.drain(start..start + (self.p + 1) * width);
    }

    /// The largest magnitude of a function on a triangle of the square, from above: that of its
    /// Bézier coefficients there.
    pub(super) fn most(&self, f: &Quotient, at: [DVec2; 3], scratch: &mut Scratch) -> f64 {
        let unit = at.iter().all(|at| [at.x, at.y].iter().all(|&x| x == 0.0 || x == 1.0));
        let rational = !f.weights.is_empty();
        if unit {
            self.select(&f.values, at, &mut scratch.values);
            if rational {
                self.select(&f.weights, at, &mut scratch.weights);
            }
        } else {
            let (rows, columns) = self.rows(at);
            self.blossoms(&f.values, &rows, &columns, &mut scratch.values);
            if rational {
                self.blossoms(&f.weights, &rows, &columns, &mut scratch.weights);
            }
        }
        let width = self.v.len();
        let mean = |terms: &[(u16, u16, f64)], of: &[f64]| -> f64 {
            terms.iter().map(|&(i, j, share)| share * of[usize::from(i) * width + usize::from(j)]).sum()
        };
        let sizes = self.coefficients.iter().map(|terms| {
            let value = mean(terms, &scratch.values).abs();
            if rational { value / mean(terms, &scratch.weights) } else { value }
        });
        sizes.fold(0.0, f64::max)
    }

    /// The blossoms of coefficients at the corners of a triangle with corners of the square.
    fn select(&self, of: &[f64], at: [DVec2; 3], out: &mut Vec<f64>) {
        let ones = |counts: &[usize; 3], x: fn(DVec2) -> f64| -> usize {
            counts.iter().zip(at).filter(|&(_, at)| x(at) == 1.0).map(|(count, _)| count).sum()
        };
        out.clear();
        for i in &self.u {
            let row = &of[ones(i, |at| at.x) * (self.q + 1)..][..=self.q];
            out.extend(self.v.iter().map(|j| row[ones(j, |at| at.y)]));
        }
    }

    /// The weights of all blossoms at the corners of a triangle.
    fn rows(&self, at: [DVec2; 3]) -> (Vec<Weights>, Vec<Weights>) {
        let weights = |counts: &[usize; 3], x: fn(DVec2) -> f64| {
            blossom(&[0, 1, 2].map(|k| (x(at[k]), counts[k])))
        };
        (
            self.u.iter().map(|counts| weights(counts, |at| at.x)).collect(),
            self.v.iter().map(|counts| weights(counts, |at| at.y)).collect(),
        )
    }

    fn blossoms(&self, of: &[f64], rows: &[Weights], columns: &[Weights], out: &mut Vec<f64>) {
        out.clear();
        let width = self.q + 1;
        for weights in rows {
            let mut row = [0.0; MAX_ORDER];
            for (of, weight) in of.chunks_exact(width).zip(weights) {
                row.iter_mut().zip(of).for_each(|(sum, of)| *sum += weight * of);
            }
            let value = |weights: &Weights| -> f64 {
                row[..width].iter().zip(weights).map(|(of, weight)| of * weight).sum()
            };
            out.extend(columns.iter().map(value));
        }
    }

    /// The row of points that these weights make of the rows of a net.
    fn contracted(&self, net: &[DVec4], weights: &Weights) -> [DVec4; MAX_ORDER] {
        let mut row = [DVec4::ZERO; MAX_ORDER];
        for (points, weight) in net.chunks_exact(self.q + 1).zip(weights) {
            row.iter_mut().zip(points).for_each(|(sum, point)| *sum += *weight * *point);
        }
        row
    }
}

fn sum(points: &[DVec4], weights: &Weights) -> DVec4 {
    points.iter().zip(weights).map(|(point, weight)| *weight * *point).sum()
}
