//! Fairness: the energy of a surface's second or third derivatives, as a matrix.

use super::band_matrix::BandMatrix;
use super::normal_equations::{Cells, Sample};
use super::settings::LeastSquaresSettings;
use super::spline_space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{BasisDerivatives, KnotVector, MAX_ORDER, gauss};
use crate::progress::InterruptCheck;

const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Order of the derivatives in the energy, and the highest one. Third derivatives leave quadratics
/// free, the local shape of most surfaces.
pub(super) const ORDER: usize = 3;

/// Binomial coefficients: the multiplicity of mixed derivatives in the energy of each order.
const MIXED: [&[f64]; ORDER + 1] = [&[1.0], &[1.0, 1.0], &[1.0, 2.0, 1.0], &[1.0, 3.0, 3.0, 1.0]];

/// The energy of a surface: the integral of all squared derivatives of one order, mixed ones with
/// their multiplicity, over a domain of these lengths in space. Order 2 is the thin plate's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Energy {
    /// The domain's length along v divided by that along u.
    ratio: f64,
    pub(super) order: usize,
    /// Factor of the derivatives along u alone; those along v alone are divided by it.
    pub(super) anisotropy: f64,
}

impl Energy {
    /// The energy in which all directions have the same weight.
    pub(super) fn new(lengths: (f64, f64), order: usize) -> Self {
        Self { ratio: lengths.1 / lengths.0, order, anisotropy: 1.0 }
    }

    pub(super) fn with_anisotropy(self, anisotropy: f64) -> Self {
        Self { anisotropy, ..self }
    }

    /// The factor of each squared derivative by its order along v, without anisotropy, up to a
    /// common factor.
    pub(super) fn factors(&self) -> [f64; ORDER + 1] {
        // With x = length_u u and y = length_v v.
        let mut factors = [0.0; ORDER + 1];
        for ((factor, count), by_v) in factors.iter_mut().zip(MIXED[self.order]).zip(0_i32..) {
            *factor = count * self.ratio.powi(i32::try_from(self.order).unwrap_or(0) - 2 * by_v);
        }
        factors
    }

    /// The energy as a matrix over the unknowns.
    pub(super) fn matrix(&self, space: &SplineSpace) -> BandMatrix {
        let mut matrix = space.matrix(1);
        self.each_entry(space, |[a, b], [along_u, mixed, along_v]| {
            let value = self.anisotropy * along_u + mixed + along_v / self.anisotropy;
            matrix.add(a, b, value);
        });
        matrix
    }

    /// The traces of the products of matrices with the energies of derivatives along u alone and
    /// along v alone, both without anisotropy.
    pub(super) fn traces<const COUNT: usize>(
        &self,
        space: &SplineSpace,
        matrices: [&BandMatrix; COUNT],
    ) -> [[f64; 2]; COUNT] {
        let mut traces = [[0.0; 2]; COUNT];
        self.each_entry(space, |[a, b], [along_u, _, along_v]| {
            let times = if a == b { 1.0 } else { 2.0 };
            for ([of_u, of_v], matrix) in traces.iter_mut().zip(matrices) {
                let factor = times * matrix.entry(a, b);
                *of_u += factor * along_u;
                *of_v += factor * along_v;
            }
        });
        traces
    }

    /// Calls `call` once for each pair of unknowns, with their places and with the energies of
    /// derivatives along u alone, mixed, and along v alone.
    fn each_entry(&self, space: &SplineSpace, mut call: impl FnMut([usize; 2], [f64; 3])) {
        let (order, factors) = (self.order, self.factors());
        let [u, v] = &space.knots;
        let (gram_u, gram_v) = (Gram::of(u), Gram::of(v));
        let (rows, cols) = (u.control_points(), v.control_points());
        for i in 0..rows {
            for k in i..(i + u.degree() + 1).min(rows) {
                let mut by_u = [0.0; ORDER + 1];
                for (d, by_u) in by_u.iter_mut().enumerate().take(order + 1) {
                    *by_u = factors[d] * gram_u[order - d].at(i, k);
                }
                for j in 0..cols {
                    let place = space.place(i, j);
                    let first = if k > i { j.saturating_sub(v.degree()) } else { j };
                    for l in first..(j + v.degree() + 1).min(cols) {
                        let term = |d: usize| by_u[d] * gram_v[d].at(j, l);
                        let mixed = (1..order).map(term).sum();
                        call([place, space.place(k, l)], [term(0), mixed, term(order)]);
                    }
                }
            }
        }
    }
}

/// Integrals of products of basis functions over the domain, for one order of differentiation. That
/// of the functions i and i + k is at `i * (degree + 1) + k`.
struct Gram {
    width: usize,
    products: Vec<f64>,
}

impl Gram {
    /// The integrals for the functions and their derivatives, by Gauss quadrature with `degree + 1`
    /// points in each span, which is exact.
    fn of(knots: &KnotVector) -> [Self; ORDER + 1] {
        let (degree, count) = (knots.degree(), knots.control_points());
        let width = degree + 1;
        let rule = gauss::rule(width);
        let mut products = [(); ORDER + 1].map(|()| vec![0.0; count * width]);
        for span in knots.breaks().windows(2) {
            let length = span[1] - span[0];
            for (place, weight) in &rule {
                let basis = BasisDerivatives::<{ ORDER + 1 }, MAX_ORDER>::at(
                    knots,
                    span[0] + place * length,
                );
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

/// Sums over pairs of neighboring samples, by which the lengths of the domain in space are
/// estimated. With them the energy does not depend on the scale of the parameters.
///
/// Successive samples in the order of the spans are neighbors. Least squares over these pairs fit
/// `|Δx|² = (a Δu)² + (b Δv)²`.
#[derive(Clone, Default)]
pub(super) struct LengthSums {
    uu: f64,
    uv: f64,
    vv: f64,
    ru: f64,
    rv: f64,
}

impl LengthSums {
    pub(super) fn of(
        space: &SplineSpace,
        samples: &[Sample],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let step = samples.len().div_ceil(LEAST_SQUARES.max_samples).max(1);
        let samples: Vec<Sample> = samples.iter().step_by(step).copied().collect();
        let cells = Cells::of(space, &samples, check_interrupt)?;
        let mut sums = Self::default();
        for ends in cells.starts.windows(2) {
            for pair in cells.order[ends[0]..ends[1]].windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|index| &samples[index as usize]);
                let step = a.uv - b.uv;
                let (du, dv) = (step.x * step.x, step.y * step.y);
                let square = a.point.distance_squared(b.point);
                let (uu, uv, vv) = (du * du, du * dv, dv * dv);
                sums.merge(&Self { uu, uv, vv, ru: du * square, rv: dv * square });
            }
        }
        Ok(sums)
    }

    /// Sums that give these lengths.
    pub(super) fn known((along_u, along_v): (f64, f64)) -> Self {
        Self { uu: 1.0, uv: 0.0, vv: 1.0, ru: along_u * along_u, rv: along_v * along_v }
    }

    /// The sums as numbers for [`Self::from_array`].
    pub(super) fn to_array(&self) -> [f64; 5] {
        let Self { uu, uv, vv, ru, rv } = *self;
        [uu, uv, vv, ru, rv]
    }

    pub(super) fn from_array([uu, uv, vv, ru, rv]: [f64; 5]) -> Self {
        Self { uu, uv, vv, ru, rv }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.uu += other.uu;
        self.uv += other.uv;
        self.vv += other.vv;
        self.ru += other.ru;
        self.rv += other.rv;
    }

    /// The lengths along u and along v, up to a common factor. They are equal if the pairs do not
    /// determine them, as on a line.
    pub(super) fn lengths(&self) -> (f64, f64) {
        let &Self { uu, uv, vv, ru, rv } = self;
        let det = uu * vv - uv * uv;
        let (a, b) = ((vv * ru - uv * rv) / det, (uu * rv - uv * ru) / det);
        let known = a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite();
        if known { (a.sqrt(), b.sqrt()) } else { (1.0, 1.0) }
    }
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
    fn anisotropy_changes_the_energy_by_its_traces() {
        for closed in [false, true] {
            let u = KnotVector::clamped_uniform(3, 6).unwrap();
            let v =
                if closed { KnotVector::periodic_uniform(2, 7) } else { Ok(u.clone()) }.unwrap();
            let space = SplineSpace::new([u, v], [false, closed]).unwrap();
            let energy = Energy::new((1.0, 1.3), 2);
            let other = Energy::new((2.0, 1.0), 1).matrix(&space);
            let trace = |energy: Energy| other.inner_product(&energy.matrix(&space));
            let [[along_u, along_v]] = energy.traces(&space, [&other]);
            let got = trace(energy.with_anisotropy(3.0)) - trace(energy);
            let wanted = 2.0 * along_u - 2.0 / 3.0 * along_v;
            assert!((got - wanted).abs() < 1e-12 * trace(energy), "{got} {wanted}");
        }
    }

    #[test]
    fn lengths_follow_space_not_parameters() {
        let sample = |i: u32| {
            let uv = DVec2::new(f64::from(i) / 500.0, f64::from(i * 37 % 500) / 500.0);
            let point = DVec3::new(2.0 * uv.x, 0.0, 10.0 * uv.y);
            Sample::plain(point, uv, 1.0)
        };
        let samples: Vec<Sample> = (0..500).map(sample).collect();
        let knots = KnotVector::clamped_uniform(3, 5).unwrap();
        let space = SplineSpace::new([knots.clone(), knots], [false; 2]).unwrap();
        let (u, v) = LengthSums::of(&space, &samples, &mut || Ok(())).unwrap().lengths();
        assert!((v / u - 5.0).abs() < 1e-8, "{u} {v}");
    }
}
