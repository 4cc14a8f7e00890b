//! How smooth the points want their surface: the weight of the fairness by generalized
//! cross-validation (G. Golub, M. Heath, G. Wahba, 1979; P. Eilers and B. Marx, *Flexible smoothing
//! with B-splines and penalties*, 1996), and before that, from the second time on, its anisotropy.

use glam::DVec3;
use rayon::prelude::*;

use super::anisotropy;
use super::band::Band;
use super::fairness::Energy;
use super::normal_equations::{NormalEquations, Sample};
use super::patches::{Quad, Question, add, answers};
use super::space::SplineSpace;
use crate::error::{Error, Result};
use crate::nurbs::{Row, padded};

/// Decimal logarithms of the weights that are tried: 1 gives the energy as large a say as the
/// points. Below the least of them it would no longer hold what points leave open; with the
/// largest, little more than a quadratic is left.
const TRIED: (f64, f64) = (-4.0, 3.0);

/// Steps between weights tried first, and how close the search comes, in decades; the first ones
/// from a weight that was best before, and from one that was so just before, with the same net.
const STEPS: (f64, f64) = (1.0, 0.2);
pub(super) const FROM_KNOWN: f64 = 0.5;
pub(super) const FROM_NEAR: f64 = 0.25;

/// The surface may not have more than this share of as many degrees of freedom as there are
/// points: it would pass through them and know nothing of their noise.
const MOST_FREEDOM: f64 = 0.9;

/// Samples whose heights are judged by, at equal steps: more would not say more.
const JUDGED: usize = 20_000;

/// What cross-validation says of a weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    /// Weight of the fairness.
    pub(super) fairness: f64,
    /// The weight for each unit of the energy's trace: with it the energy has as large a say on
    /// another net.
    level: f64,
    /// Of the energy.
    pub(super) anisotropy: f64,
    /// Mean square of the error to be expected at a point that was left out.
    pub(super) error: f64,
}

/// The weight that generalized cross-validation finds best, from the heights of the points over
/// the surface along their normals, near the `known` one, which may be of another net; `None` if the
/// points cannot tell. What is known already makes the anisotropy more likely first. The search begins
/// with steps of so many decades from there.
pub(super) fn best(
    space: &SplineSpace,
    samples: &[Sample],
    energy: Energy,
    (known, mut step): (Option<Score>, f64),
) -> Result<Option<Score>> {
    let equations = NormalEquations::of_distances(space, samples, &mut || Ok(()))?;
    let heights = Heights::of(space, samples);
    let said = equations.matrix.trace();
    let anisotropy = match known {
        Some(Score { level, .. }) => {
            anisotropy::more_likely(space, samples, &equations, energy, level * said)?
        }
        None => energy.anisotropy,
    };
    let energy = energy.with_anisotropy(anisotropy).matrix(space);
    let trace = energy.trace();
    let score_at = |exponent: f64| -> Result<Option<Score>> {
        let fairness = 10.0_f64.powf(exponent);
        let level = fairness / trace;
        let error = heights.expected_error(&equations, &energy, level * said)?;
        Ok(error.map(|error| Score { fairness, level, anisotropy, error }))
    };
    let better = |a: Option<Score>, b: Option<Score>| match (a, b) {
        (Some(a), Some(b)) => Some(if b.error < a.error { b } else { a }),
        (a, b) => a.or(b),
    };
    let scores = |exponents: &[f64]| -> Result<Vec<Option<Score>>> {
        exponents.par_iter().map(|&exponent| score_at(exponent)).collect()
    };
    let mut found = match known {
        Some(Score { level, .. }) => score_at((level * trace).log10().clamp(TRIED.0, TRIED.1))?,
        None => None,
    };
    if found.is_none() {
        step = STEPS.0;
        let mut exponents = vec![TRIED.0];
        while exponents[exponents.len() - 1] + step <= TRIED.1 {
            exponents.push(exponents[exponents.len() - 1] + step);
        }
        found = scores(&exponents)?.into_iter().fold(None, better);
        step /= 2.0;
    }
    // Goes on in the direction that improves, then looks closer.
    while step > STEPS.1 {
        let Some(middle) = found.map(|score| score.fairness.log10()) else { return Ok(None) };
        let tried = |exponent: &f64| (TRIED.0..=TRIED.1).contains(exponent);
        let beside: Vec<f64> = [middle - step, middle + step].into_iter().filter(tried).collect();
        for (mut next, mut exponent) in scores(&beside)?.into_iter().zip(beside) {
            let direction = exponent - middle;
            while let Some(score) =
                next.filter(|next| found.is_none_or(|found| next.error < found.error))
            {
                found = Some(score);
                exponent += direction;
                next = if tried(&exponent) { score_at(exponent)? } else { None };
            }
        }
        step /= 2.0;
    }
    Ok(found)
}

/// The heights of samples over surfaces of one space.
struct Heights<'a> {
    space: &'a SplineSpace,
    judged: Vec<Judged<'a>>,
    /// How many samples count.
    count: f64,
}

/// A sample whose height is asked for, and the basis functions at its parameters.
struct Judged<'a> {
    sample: &'a Sample,
    firsts: [usize; 2],
    rows: Row,
    cols: Row,
}

impl<'a> Heights<'a> {
    fn of(space: &'a SplineSpace, samples: &'a [Sample]) -> Self {
        let judged = |i: usize| {
            let sample = &samples[i];
            let [u, v] = [0, 1].map(|d| padded(&space.knots[d], sample.uv[d]));
            Judged { sample, firsts: [u.first, v.first], rows: u.values, cols: v.values }
        };
        let step = samples.len().div_ceil(JUDGED).max(1);
        let judged = (0..samples.len()).into_par_iter().step_by(step).map(judged).collect();
        let count = samples.iter().filter(|sample| sample.weight > 0.0).count() as f64;
        Self { space, judged, count }
    }

    /// The mean square of the error to be expected with so many times this energy; `None` if the
    /// points cannot tell.
    fn expected_error(
        &self,
        equations: &NormalEquations,
        energy: &Band,
        times: f64,
    ) -> Result<Option<f64>> {
        let mut factor = equations.matrix.clone();
        factor.add_scaled(times, energy);
        if !factor.factor::<Error>(&mut || Ok(()))? {
            return Ok(None);
        }
        let freedom = factor.inverse().inner_product(&equations.matrix);
        if freedom > MOST_FREEDOM * self.count {
            return Ok(None);
        }
        // A fourth number fills a register.
        let mut net: Vec<Quad> = equations.right.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        factor.solve(&mut net);
        Ok(Some(self.mean_square(&net) / (1.0 - freedom / self.count).powi(2)))
    }

    /// The mean square of the heights over the surface with these control points, in the order of
    /// solution.
    fn mean_square(&self, solution: &[Quad]) -> f64 {
        let net = self.space.places().into_iter().map(|at| solution[at]).collect();
        let squares = answers(&Squares { heights: self, net }, self.judged.len());
        let weights: f64 = self.judged.iter().map(|judged| judged.sample.weight).sum();
        squares.iter().sum::<f64>() / weights
    }
}

/// The weighted squares of the heights over a surface.
struct Squares<'a> {
    heights: &'a Heights<'a>,
    net: Vec<Quad>,
}

impl Question for Squares<'_> {
    type Answer = f64;

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn answer(&self, index: usize) -> f64 {
        let Heights { space, judged, .. } = self.heights;
        let [rows, cols] = [0, 1].map(|d| space.knots[d].degree() + 1);
        let width = space.knots[1].control_points();
        let Judged { sample, firsts: [first, left], rows: by_row, cols: by_col } = &judged[index];
        let mut place = [0.0; 4];
        for (i, row) in by_row[..rows].iter().enumerate() {
            let mut along = [0.0; 4];
            let net = &self.net[(first + i) * width + left..][..cols];
            for (point, col) in net.iter().zip(by_col) {
                add(&mut along, *col, point);
            }
            add(&mut place, *row, &along);
        }
        let Sample { point, normal, weight, .. } = sample;
        let [x, y, z, _] = place;
        weight * (point - DVec3::new(x, y, z)).dot(*normal).powi(2)
    }
}
