//! How smooth the points want their surface: the weight of the fairness by generalized
//! cross-validation (G. Golub, M. Heath, G. Wahba, 1979; P. Eilers and B. Marx, *Flexible smoothing
//! with B-splines and penalties*, 1996).

use glam::DVec3;
use rayon::prelude::*;

use super::band::Band;
use super::normal_equations::{NormalEquations, Sample};
use super::patches::{Patches, Tangents};
use super::space::SplineSpace;
use crate::error::{Error, Result};

/// Decimal logarithms of the weights that are tried: 1 gives the energy as large a say as the
/// points. Below the least of them it would no longer hold what points leave open; with the
/// largest, little more than a quadratic is left.
const TRIED: (f64, f64) = (-4.0, 3.0);

/// Steps between weights tried first, and how close the search comes, in decades.
const STEPS: (f64, f64) = (1.0, 0.2);

/// The surface may not have more than this share of as many degrees of freedom as there are
/// points: it would pass through them and know nothing of their noise.
const MOST_FREEDOM: f64 = 0.9;

/// What cross-validation says of a weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    /// Weight of the fairness.
    pub(super) fairness: f64,
    /// Mean square of the error to be expected at a point that was left out.
    pub(super) error: f64,
}

/// The weight that generalized cross-validation finds best, from the heights of the points over
/// the surface along their normals; `None` if the points cannot tell.
pub(super) fn best(
    space: &SplineSpace,
    samples: &[Sample],
    energy: &Band,
    near: Option<f64>,
) -> Result<Option<Score>> {
    let equations = NormalEquations::of_distances(space, samples, &mut || Ok(()))?;
    let unit = equations.matrix.trace() / energy.trace();
    let score = |exponent: f64| score(space, samples, &equations, energy, exponent, unit);
    let better = |a: Option<Score>, b: Option<Score>| match (a, b) {
        (Some(a), Some(b)) => Some(if b.error < a.error { b } else { a }),
        (a, b) => a.or(b),
    };
    let mut found = match near {
        Some(fairness) => score(fairness.log10().clamp(TRIED.0, TRIED.1))?,
        None => None,
    };
    let mut step = STEPS.0;
    if found.is_none() {
        let mut exponents = vec![TRIED.0];
        while exponents[exponents.len() - 1] + step <= TRIED.1 {
            exponents.push(exponents[exponents.len() - 1] + step);
        }
        let scores: Vec<_> = exponents.into_par_iter().map(score).collect::<Result<_>>()?;
        found = scores.into_iter().fold(None, better);
        step /= 2.0;
    }
    // Goes on in the direction that improves, then looks closer.
    while step > STEPS.1 {
        let Some(middle) = found.map(|score| score.fairness.log10()) else { return Ok(None) };
        for direction in [-step, step] {
            let mut exponent = middle + direction;
            while (TRIED.0..=TRIED.1).contains(&exponent) {
                let next = score(exponent)?;
                let before = found.map(|score| score.fairness);
                found = better(found, next);
                if found.map(|score| score.fairness) == before {
                    break;
                }
                exponent += direction;
            }
        }
        step /= 2.0;
    }
    Ok(found)
}

fn score(
    space: &SplineSpace,
    samples: &[Sample],
    equations: &NormalEquations,
    energy: &Band,
    exponent: f64,
    unit: f64,
) -> Result<Option<Score>> {
    let fairness = 10.0_f64.powf(exponent);
    let mut factor = equations.matrix.clone();
    factor.add_scaled(fairness * unit, energy);
    if !factor.factor::<Error>(&mut || Ok(()))? {
        return Ok(None);
    }
    let freedom = factor.inverse().inner_product(&equations.matrix);
    let count = samples.iter().map(|sample| f64::from(u8::from(sample.weight > 0.0))).sum::<f64>();
    if freedom > MOST_FREEDOM * count {
        return Ok(None);
    }
    let mut net = equations.right.clone();
    factor.solve(&mut net);
    let net: Vec<DVec3> = net.into_iter().map(DVec3::from_array).collect();
    let surface = space.surface(&net)?;
    let square = |i: usize, place: Tangents| {
        let sample = &samples[i];
        sample.weight * (sample.point - place.point).dot(sample.normal).powi(2)
    };
    let heights = Patches::of(&surface).each(samples.len(), |i| samples[i].uv, square);
    let weights: f64 = samples.iter().map(|sample| sample.weight).sum();
    let error = heights.iter().sum::<f64>() / weights / (1.0 - freedom / count).powi(2);
    Ok(Some(Score { fairness, error }))
}
