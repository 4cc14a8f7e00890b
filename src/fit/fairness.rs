//! Fairness: the energy of a surface's second or third derivatives.

use super::POINTS_PER_LOOK;
use super::band::Band;
use super::normal_equations::{Cells, Sample};
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{BasisDerivatives, KnotVector, gauss};
use crate::progress::Listen;

/// Highest derivatives whose energy can be asked for.
const MOST_ORDER: usize = 3;

/// Binomial coefficients: how often a mixed derivative stands in the energy of each order.
const MIXED: [&[f64]; MOST_ORDER + 1] =
    [&[1.0], &[1.0, 1.0], &[1.0, 2.0, 1.0], &[1.0, 3.0, 3.0, 1.0]];

/// The energy as a matrix over the unknowns: the integral of all squared derivatives of one order,
/// mixed ones as often as they occur, over a domain of these lengths in space. Order 2 is the thin
/// plate's.
pub(super) fn energy(space: &SplineSpace, lengths: (f64, f64), order: usize) -> Band {
    let [u, v] = &space.knots;
    let (gram_u, gram_v) = (Gram::of(u), Gram::of(v));
    // With x = length_u u and y = length_v v, up to a factor.
    let ratio = lengths.1 / lengths.0;
    let mut shares = [0.0; MOST_ORDER + 1];
    for ((share, count), by_v) in shares.iter_mut().zip(MIXED[order]).zip(0_i32..) {
        *share = count * ratio.powi(i32::try_from(order).unwrap_or(0) - 2 * by_v);
    }
    let (rows, cols) = (u.control_points(), v.control_points());
    let mut matrix = space.matrix(1);
    for i in 0..rows {
        for k in i..(i + u.degree() + 1).min(rows) {
            let along: [f64; MOST_ORDER + 1] =
                std::array::from_fn(|d| if d <= order { gram_u[order - d].at(i, k) } else { 0.0 });
            for j in 0..cols {
                let first = if k > i { j.saturating_sub(v.degree()) } else { j };
                for l in first..(j + v.degree() + 1).min(cols) {
                    let terms = (0..=order).map(|d| shares[d] * along[d] * gram_v[d].at(j, l));
                    matrix.add(space.place(i, j), space.place(k, l), terms.sum());
                }
            }
        }
    }
    matrix
}

/// Integrals of products of basis functions over the domain, for one order of differentiation: at
/// `i * (degree + 1) + k` that of the functions i and i + k.
struct Gram {
    width: usize,
    products: Vec<f64>,
}

impl Gram {
    /// Those of the functions themselves and of their derivatives: by quadrature with `degree + 1`
    /// points in each span, which is exact.
    fn of(knots: &KnotVector) -> [Self; MOST_ORDER + 1] {
        let (degree, count) = (knots.degree(), knots.control_points());
        let width = degree + 1;
        let rule = gauss::rule(width);
        let mut products = [(); MOST_ORDER + 1].map(|()| vec![0.0; count * width]);
        for span in knots.breaks().windows(2) {
            let length = span[1] - span[0];
            for (place, weight) in &rule {
                let basis =
                    BasisDerivatives::<{ MOST_ORDER + 1 }>::at(knots, span[0] + place * length);
                for (products, row) in products.iter_mut().zip(&basis.rows) {
                    for i in 0..width {
                        for k in i..width {
                            products[(basis.first + i) * width + k - i] +=
                                weight * length * row[i] * row[k];
                        }
                    }
                }
            }
        }
        products.map(|products| Self { width, products })
    }

    /// The product of the functions i and j.
    fn at(&self, i: usize, j: usize) -> f64 {
        let (low, high) = (i.min(j), i.max(j));
        self.products[low * self.width + high - low]
    }
}

/// Samples that the lengths of the domain are measured on: more would not change them.
const MEASURED: usize = 1 << 16;

/// The lengths of the domain in space, along u and along v, up to a common factor: so that the
/// energy does not depend on how parameters were scaled.
///
/// Points that follow one another in the order of the spans are neighbours; least squares over
/// such pairs fit `|Δx|² = (a Δu)² + (b Δv)²`. Where pairs do not tell (all on one line), both
/// directions count alike.
pub(super) fn lengths(
    space: &SplineSpace,
    samples: &[Sample],
    listen: &mut Listen<'_>,
) -> Result<(f64, f64)> {
    let step = samples.len().div_ceil(MEASURED).max(1);
    let samples: Vec<Sample> = samples.iter().step_by(step).copied().collect();
    let cells = Cells::of(space, &samples, listen)?;
    let (mut uu, mut uv_sum, mut vv, mut ru, mut rv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let pairs = cells.starts.windows(2).flat_map(|ends| cells.order[ends[0]..ends[1]].windows(2));
    for (number, pair) in pairs.enumerate() {
        if number.is_multiple_of(POINTS_PER_LOOK) {
            listen()?;
        }
        let [a, b] = [pair[0], pair[1]].map(|index| &samples[index as usize]);
        let step = a.uv - b.uv;
        let (du, dv) = (step.x * step.x, step.y * step.y);
        let square = a.point.distance_squared(b.point);
        uu += du * du;
        uv_sum += du * dv;
        vv += dv * dv;
        ru += du * square;
        rv += dv * square;
    }
    let det = uu * vv - uv_sum * uv_sum;
    let (a, b) = ((vv * ru - uv_sum * rv) / det, (uu * rv - uv_sum * ru) / det);
    if a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite() {
        return Ok((a.sqrt(), b.sqrt()));
    }
    Ok((1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    #[test]
    fn integrals_are_those_of_bernstein_polynomials() {
        let knots = KnotVector::clamped_uniform(2, 3).unwrap();
        let [values, slopes, bends, _] = Gram::of(&knots);
        // ∫ (1-t)⁴ = 1/5, ∫ (1-t)² 2t(1-t) = 1/10, ∫ (2t-2)² = 4/3, ∫ 2 · -4 = -8.
        for (got, wanted) in [
            (values.at(0, 0), 0.2),
            (values.at(1, 0), 0.1),
            (slopes.at(0, 0), 4.0 / 3.0),
            (bends.at(0, 1), -8.0),
        ] {
            assert!((got - wanted).abs() < 1e-14, "{got} {wanted}");
        }
    }

    #[test]
    fn lengths_follow_space_not_parameters() {
        let sample = |i: u32| {
            let uv = DVec2::new(f64::from(i) / 500.0, f64::from(i * 37 % 500) / 500.0);
            let point = DVec3::new(2.0 * uv.x, 0.0, 10.0 * uv.y);
            Sample { point, uv, weight: 1.0, normal: DVec3::ZERO, tangential: 1.0 }
        };
        let samples: Vec<Sample> = (0..500).map(sample).collect();
        let knots = KnotVector::clamped_uniform(3, 5).unwrap();
        let space = SplineSpace::new([knots.clone(), knots], [false; 2]).unwrap();
        let (u, v) = lengths(&space, &samples, &mut || Ok(())).unwrap();
        assert!((v / u - 5.0).abs() < 1e-8, "{u} {v}");
    }
}
