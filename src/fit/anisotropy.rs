//! Anisotropy of the fairness: how much more derivatives along one direction count, by the marginal
//! likelihood of the points.
//!
//! The fairness energy, the sum of `lambda_j` times the energy of each part j, is minus the
//! logarithm of a prior probability. The likelihood of the points under this prior, integrated over
//! all surfaces, depends on the `lambda_j`. The generalized Fellner-Schall update increases it (S.
//! Wood, M. Fasiolo, *A generalized Fellner-Schall method for smoothing parameter optimization with
//! application to Tweedie location, scale and shape models*, 2017): up to a common factor it
//! multiplies `lambda_j` by `(tr(P⁻ E_j) - tr((A + P)⁻¹ E_j)) / c·E_j c`. `E_j` are the matrices of
//! the parts, `P` is their weighted sum, `A` is the matrix of the points, and c is the solution.
//!
//! Only the anisotropy is taken from it: the ratio of the parts of derivatives along u alone and
//! along v alone. Mixed derivatives keep their weight. Cross-validation chooses the common factor,
//! since it depends less on whether the prior is right.

use glam::DVec3;
use rayon::prelude::*;

use super::band_matrix::BandMatrix;
use super::fairness_energy::Energy;
use super::normal_equations::{NormalEquations, Sample};
use super::settings::{FairnessSettings, LeastSquaresSettings};
use super::spline_space::SplineSpace;
use crate::error::{Error, Result};
use crate::nurbs::{BasisDerivatives, MAX_ORDER};

const SETTINGS: FairnessSettings = FairnessSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// An anisotropy that makes the points more likely than that of `energy`, whose matrix is
/// multiplied by `times`. It is 1, isotropic, if the points do not determine it or rounding
/// prevents it.
///
/// It takes at most two factorizations and inverses within the band, as much as cross-validation of
/// two weights.
pub(super) fn improved_anisotropy(
    space: &SplineSpace,
    samples: &[Sample],
    equations: &NormalEquations,
    energy: Energy,
    times: f64,
) -> Result<f64> {
    let (matrix, size) = (energy.matrix(space), space.unknowns());
    let factor = |mut matrix: BandMatrix| -> Result<Option<BandMatrix>> {
        Ok(matrix.factor::<Error>(&mut || Ok(()))?.then_some(matrix))
    };
    let mut posterior = equations.matrix.clone();
    posterior.add_scaled(times, &matrix);
    let Some(posterior) = factor(posterior)? else { return Ok(1.0) };
    let inverse = posterior.inverse();
    if times * inverse.inner_product(&matrix) < SETTINGS.min_freedom_removed * size as f64 {
        return Ok(1.0);
    }
    let ridge = SETTINGS.anisotropy_ridge * matrix.trace() / size as f64;
    let mut prior = matrix;
    (0..size).for_each(|i| prior.add(i, i, ridge));
    let Some(prior) = factor(prior)? else { return Ok(1.0) };
    let [before, after] = energy.traces(space, [&prior.inverse(), &inverse]);
    let freedom_removed = [energy.anisotropy * before[0], before[1] / energy.anisotropy];
    if !freedom_removed.iter().all(|freedom_removed| (0.0..=size as f64).contains(freedom_removed))
    {
        // The energy cannot remove more freedom than there is. Rounding causes this, where control
        // points are much denser along one direction than along the other.
        return Ok(1.0);
    }
    let mut solution = equations.right.clone();
    posterior.solve(&mut solution);
    let bending = bending(space, samples, energy, &solution);
    let [along_u, along_v] = [0, 1].map(|d| ((before[d] - times * after[d]) / bending[d]).ln());
    // The ratio of both parts is the anisotropy squared. One update falls short of the optimum:
    // twice the step reaches as far as three updates.
    let anisotropy = energy.anisotropy * (along_u - along_v).exp();
    // Rounded, since the ridge amplifies rounding errors.
    let anisotropy =
        ((anisotropy.ln() / SETTINGS.anisotropy_step).round() * SETTINGS.anisotropy_step).exp();
    Ok(if anisotropy.is_finite() {
        anisotropy.clamp(1.0 / SETTINGS.max_anisotropy, SETTINGS.max_anisotropy)
    } else {
        1.0
    })
}

/// The energies of derivatives along u alone and along v alone, without anisotropy, up to a common
/// factor. The surface has these control points, in the order of solution.
///
/// Only the components along the samples' normals count: third derivatives of an arc are tangential
/// and unrelated to noise.
fn bending(
    space: &SplineSpace,
    samples: &[Sample],
    energy: Energy,
    solution: &[[f64; 3]],
) -> [f64; 2] {
    let net = space.places().into_iter().map(|place| DVec3::from_array(solution[place]));
    let (net, width): (Vec<DVec3>, _) = (net.collect(), space.knots[1].control_points());
    let (order, factors) = (energy.order, energy.factors());
    let square = |sample: &Sample| {
        let [u, v] =
            [0, 1].map(|d| BasisDerivatives::<4, MAX_ORDER>::at(&space.knots[d], sample.uv[d]));
        let [p, q] = [0, 1].map(|d| space.knots[d].degree());
        let (mut along_u, mut along_v) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..=p {
            let row = &net[(u.first + i) * width + v.first..][..=q];
            let sum = |by_v: &[f64]| row.iter().zip(by_v).map(|(p, value)| *value * *p).sum();
            let (value, derivative): (DVec3, DVec3) = (sum(&v.rows[0]), sum(&v.rows[order]));
            along_u += u.rows[order][i] * value;
            along_v += u.rows[0][i] * derivative;
        }
        [along_u, along_v].map(|along| sample.weight * along.dot(sample.normal).powi(2))
    };
    let step = samples.len().div_ceil(LEAST_SQUARES.max_samples).max(1);
    let squares: Vec<[f64; 2]> =
        (0..samples.len()).into_par_iter().step_by(step).map(|i| square(&samples[i])).collect();
    let sum = |d: usize| squares.iter().map(|squares| squares[d]).sum::<f64>();
    [factors[0] * sum(0), factors[order] * sum(1)]
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, Vec2Swizzles};

    use super::*;
    use crate::nurbs::KnotVector;

    /// Noise of standard deviation 1: the sum of twelve numbers by `SplitMix64` (G. Steele, D. Lea,
    /// C. Flood, 2014).
    fn noise(i: u64) -> f64 {
        let draw = |k: u64| {
            let mut bits = (12 * i + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(draw).sum::<f64>() - 6.0
    }

    /// Points scattered over a square, displaced along its normal.
    fn samples(height: impl Fn(DVec2) -> f64, deviation: f64) -> Vec<Sample> {
        let sample = |i: u32| {
            let at = f64::from(i);
            let uv = DVec2::new(
                (at * 0.754_877_666_246_692_7).fract(),
                (at * 0.569_840_290_998_053_2).fract(),
            );
            let point = uv.extend(height(uv) + deviation * noise(u64::from(i)));
            Sample { point, uv, weight: 1.0, normal: DVec3::Z, tangential: 1.0 }
        };
        (0..1500).map(sample).collect()
    }

    /// The anisotropy after some updates from 1, with a weight of the fairness.
    fn found(samples: &[Sample], closed: [bool; 2], fairness: f64, steps: usize) -> f64 {
        let knots = closed.map(|closed| {
            if closed {
                KnotVector::periodic_uniform(3, 10).unwrap()
            } else {
                KnotVector::clamped_uniform(3, 10).unwrap()
            }
        });
        let space = SplineSpace::new(knots, closed).unwrap();
        let equations = NormalEquations::of_distances(&space, samples, &mut || Ok(())).unwrap();
        let mut energy = Energy::new((1.0, 1.0), 3);
        for _ in 0..steps {
            let times = fairness * equations.matrix.trace() / energy.matrix(&space).trace();
            let better = improved_anisotropy(&space, samples, &equations, energy, times).unwrap();
            energy = energy.with_anisotropy(better);
        }
        energy.anisotropy
    }

    /// Waves along u, almost straight along v.
    fn waves(uv: DVec2) -> f64 {
        0.1 * (9.0 * uv.x).sin() * (1.0 + 0.2 * uv.y)
    }

    #[test]
    fn waves_along_u_raise_the_weight_of_derivatives_along_v() {
        let waves = samples(waves, 0.02);
        let (once, often) = (found(&waves, [false; 2], 1.0, 1), found(&waves, [false; 2], 1.0, 6));
        assert!(once < 0.7, "{once}");
        assert!(often <= once && often >= 1.0 / SETTINGS.max_anisotropy, "{often}");
    }

    #[test]
    fn swapped_directions_give_the_inverse_anisotropy() {
        let one = samples(waves, 0.02);
        let mut other = one.clone();
        for sample in &mut other {
            sample.uv = sample.uv.yx();
        }
        for closed in [[false, false], [true, false], [true, true]] {
            let got = found(&one, closed, 1.0, 1);
            let [u, v] = closed;
            let swapped = found(&other, [v, u], 1.0, 1);
            assert!((got * swapped - 1.0).abs() < 1e-4, "{closed:?} {got} {swapped}");
        }
    }

    #[test]
    fn isotropic_points_give_an_anisotropy_near_one() {
        let round = |uv: DVec2| 0.1 * (-12.0 * uv.distance_squared(DVec2::splat(0.5))).exp();
        let got = found(&samples(round, 0.02), [false; 2], 1.0, 1);
        assert!((0.6..1.6).contains(&got), "{got}");
    }

    #[test]
    fn points_without_noise_give_no_anisotropy() {
        let got = found(&samples(waves, 0.0), [false; 2], 1e-4, 1);
        assert!(got == 1.0, "{got}");
    }

    #[test]
    fn tangential_derivatives_do_not_matter() {
        // Uneven parameters along v give third derivatives within the plane.
        let mut uneven = samples(waves, 0.02);
        let even = found(&uneven, [false; 2], 1.0, 1);
        for sample in &mut uneven {
            sample.point.y += 0.1 * (9.0 * sample.uv.y).sin();
        }
        let got = found(&uneven, [false; 2], 1.0, 1);
        assert!((got / even - 1.0).abs() < 1e-9, "{got} {even}");
    }
}
