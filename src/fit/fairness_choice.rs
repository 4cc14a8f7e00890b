//! The choice of the fairness by generalized cross-validation (G. Golub, M. Heath, G. Wahba, 1979;
//! P. Eilers and B. Marx, *Flexible smoothing with B-splines and penalties*, 1996).
//!
//! The input is samples with normals; output is the weight of the fairness. From the second call
//! on, its anisotropy is chosen first.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::anisotropy;
use super::band_matrix::BandMatrix;
use super::fairness_energy::Energy;
use super::held_out_groups::HeldOutGroups;
use super::normal_equations::{NormalEquations, Sample};
use super::patches::{Evaluation, Quad, add, evaluate_all};
use super::settings::{FairnessSettings, LeastSquaresSettings};
use super::sizes::{CUBIC_ORDER, POINTS_PER_TASK};
use super::spline_space::SplineSpace;
use super::validation_groups::{blocks, in_clumps};
use crate::error::{Error, Result};
use crate::nurbs::values_at;

const SETTINGS: FairnessSettings = FairnessSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// The result of cross-validation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    /// Weight of the fairness.
    pub(super) fairness: f64,
    /// The weight for each unit of the energy's trace. It has the same effect on another net.
    level: f64,
    /// Anisotropy of the energy.
    pub(super) anisotropy: f64,
    /// Expected mean squared error at a point that was left out.
    pub(super) error: f64,
    /// Mean squared error at blocks of points that were left out. Zero if points do not lie in
    /// clumps.
    pub(super) error_of_blocks: f64,
}

/// The weight with the least expected error of the points' distances along their normals. The
/// search starts near the `known` one, which may belong to another net. With a known one, the
/// anisotropy is improved first. `None` if the points do not determine the weight.
///
/// Where points lie in clumps, it is the larger of the weights by generalized cross-validation and
/// by blocks.
pub(super) fn best(
    space: &SplineSpace,
    samples: &[Sample],
    energy: Energy,
    known: Option<Score>,
) -> Result<Option<Score>> {
    let equations = NormalEquations::of_distances(space, samples, &mut || Ok(()))?;
    let point_trace = equations.matrix.trace();
    let anisotropy = match known {
        Some(Score { level, .. }) => anisotropy::improved_anisotropy(
            space,
            samples,
            &equations,
            energy,
            level * point_trace,
        )?,
        None => energy.anisotropy,
    };
    let energy = energy.with_anisotropy(anisotropy).matrix(space);
    let trace = energy.trace();
    let residuals = Residuals::of(space, samples);
    let search = Search { residuals, equations, point_trace, energy, trace, anisotropy };
    let found = search.best(known.map(|score| (score.level * trace).log10()))?;
    found.map(|found| search.with_blocks(space, samples, found)).transpose()
}

/// The equations of samples and an energy, for any weight.
struct Search<'a> {
    residuals: Residuals<'a>,
    equations: NormalEquations,
    /// Traces of the equations and of the energy.
    point_trace: f64,
    energy: BandMatrix,
    trace: f64,
    anisotropy: f64,
}

impl Search<'_> {
    fn score(&self, exponent: f64) -> Result<Option<Score>> {
        let fairness = 10.0_f64.powf(exponent);
        let (level, anisotropy) = (fairness / self.trace, self.anisotropy);
        let error = self.residuals.expected_error(
            &self.equations,
            &self.energy,
            level * self.point_trace,
        )?;
        let score = |error| Score { fairness, level, anisotropy, error, error_of_blocks: 0.0 };
        Ok(error.map(score))
    }

    fn scores(&self, exponents: &[f64]) -> Result<Vec<Option<Score>>> {
        exponents.par_iter().map(|&exponent| self.score(exponent)).collect()
    }

    /// The weight by generalized cross-validation, searched near a known exponent.
    fn best(&self, known: Option<f64>) -> Result<Option<Score>> {
        let better = |a: Option<Score>, b: Option<Score>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.error < a.error { b } else { a }),
            (a, b) => a.or(b),
        };
        let mut found = match known {
            Some(known) => self.score(known.clamp(SETTINGS.exponents.0, SETTINGS.exponents.1))?,
            None => None,
        };
        if found.is_none() {
            found = self.scores(&decades(SETTINGS.exponents.0))?.into_iter().fold(None, better);
        }
        // Continues in the direction that improves, then halves the step.
        let mut step = SETTINGS.first_exponent_step;
        while step > SETTINGS.min_exponent_step {
            let Some(middle) = found.map(|score| score.fairness.log10()) else { return Ok(None) };
            let tried =
                |exponent: &f64| (SETTINGS.exponents.0..=SETTINGS.exponents.1).contains(exponent);
            let beside: Vec<f64> =
                [middle - step, middle + step].into_iter().filter(tried).collect();
            for (mut next, mut exponent) in self.scores(&beside)?.into_iter().zip(beside) {
                let direction = exponent - middle;
                while let Some(score) =
                    next.filter(|next| found.is_none_or(|found| next.error < found.error))
                {
                    found = Some(score);
                    exponent += direction;
                    next = if tried(&exponent) { self.score(exponent)? } else { None };
                }
            }
            step /= 2.0;
        }
        Ok(found)
    }

    /// Adds the error of blocks if samples lie in clumps. Takes a larger weight if it predicts
    /// blocks better.
    fn with_blocks(&self, space: &SplineSpace, samples: &[Sample], found: Score) -> Result<Score> {
        let uv: Vec<DVec2> = samples.iter().map(|sample| sample.uv).collect();
        if !in_clumps(&uv) {
            return Ok(found);
        }
        let step = samples.len().div_ceil(LEAST_SQUARES.max_samples).max(1);
        let some: Vec<Sample> = samples.iter().step_by(step).copied().collect();
        let points: Vec<DVec3> = some.iter().map(|sample| sample.point).collect();
        let mut groups = vec![Vec::new(); SETTINGS.groups];
        for (sample, group) in some.iter().zip(blocks(&points)) {
            groups[group].push(*sample);
        }
        let all = NormalEquations::of_distances(space, &some, &mut || Ok(()))?;
        let held_out = HeldOutGroups::of(space, all, groups)?;
        let error =
            |fairness: f64| held_out.error(&self.energy, fairness / self.trace * held_out.trace());
        let mut best = Score { error_of_blocks: error(found.fairness)?, ..found };
        for exponent in decades(found.fairness.log10()).into_iter().skip(1) {
            let error_of_blocks = error(10.0_f64.powf(exponent))?;
            if error_of_blocks < best.error_of_blocks
                && let Some(score) = self.score(exponent)?
            {
                best = Score { error_of_blocks, ..score };
            }
        }
        Ok(best)
    }
}

/// Exponents from this one up, in steps of 1.
fn decades(from: f64) -> Vec<f64> {
    let exponents = std::iter::successors(Some(from), |exponent| Some(exponent + 1.0));
    exponents.take_while(|exponent| *exponent <= SETTINGS.exponents.1).collect()
}

/// Distances of samples along their normals from surfaces of one space.
struct Residuals<'a> {
    space: &'a SplineSpace,
    /// Places of the net's control points in the order of solution.
    places: Vec<usize>,
    residual_samples: Vec<ResidualSample>,
    /// Basis functions that differ from zero for each sample, in u, then in v.
    functions: Vec<f64>,
    /// Sum of the weights.
    weight: f64,
    /// Number of samples with a positive weight.
    count: f64,
}

/// The part of a sample that its distance needs, small since all are read for each weight.
#[derive(Clone, Copy)]
struct ResidualSample {
    point: DVec3,
    normal: DVec3,
    weight: f64,
    /// The first control point that the sample touches.
    first: usize,
}

impl<'a> Residuals<'a> {
    fn of(space: &'a SplineSpace, samples: &'a [Sample]) -> Self {
        let step = samples.len().div_ceil(LEAST_SQUARES.max_samples).max(1);
        let some: Vec<&Sample> = samples.iter().step_by(step).collect();
        let [rows, cols] = Self::orders(space);
        let width = space.knots[1].control_points();
        let mut functions = vec![0.0; some.len() * (rows + cols)];
        let residual_samples = |(sample, functions): (&&Sample, &mut [f64])| {
            let &&Sample { point, uv, normal, weight, .. } = sample;
            let (of_u, of_v) = functions.split_at_mut(rows);
            let [u, v] = [(0, of_u), (1, of_v)]
                .map(|(d, functions)| values_at(&space.knots[d], uv[d], functions));
            ResidualSample { point, normal, weight, first: u * width + v }
        };
        let functions_of = functions.par_chunks_mut(rows + cols);
        let some = some.par_iter().with_min_len(POINTS_PER_TASK).zip(functions_of);
        let residual_samples: Vec<ResidualSample> = some.map(residual_samples).collect();
        let weight = residual_samples.iter().map(|residual_samples| residual_samples.weight).sum();
        let count = samples.iter().filter(|sample| sample.weight > 0.0).count() as f64;
        Self { space, places: space.places(), residual_samples, functions, weight, count }
    }

    /// Number of basis functions that differ from zero, in u and in v.
    fn orders(space: &SplineSpace) -> [usize; 2] {
        [0, 1].map(|d| space.knots[d].degree() + 1)
    }

    /// The expected mean squared error with the energy multiplied by `times`. `None` if the points
    /// do not determine it.
    fn expected_error(
        &self,
        equations: &NormalEquations,
        energy: &BandMatrix,
        times: f64,
    ) -> Result<Option<f64>> {
        let mut factor = equations.matrix.clone();
        factor.add_scaled(times, energy);
        if !factor.factor::<Error>(&mut || Ok(()))? {
            return Ok(None);
        }
        let freedom = SETTINGS.freedom_factor * factor.inverse().inner_product(&equations.matrix);
        if freedom > SETTINGS.max_freedom_share * self.count {
            return Ok(None);
        }
        // A fourth number fills a register.
        let mut net: Vec<Quad> = equations.right.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        factor.solve(&mut net);
        Ok(Some(self.mean_square(&net) / (1.0 - freedom / self.count).powi(2)))
    }

    /// The mean squared distance from the surface with these control points, in the order of
    /// solution.
    fn mean_square(&self, solution: &[Quad]) -> f64 {
        let net = self.places.iter().map(|&at| solution[at]).collect();
        let squares = evaluate_all(&Squares { residuals: self, net }, self.residual_samples.len());
        squares.iter().sum::<f64>() / self.weight
    }
}

/// The weighted squared distances from a surface.
struct Squares<'a> {
    residuals: &'a Residuals<'a>,
    net: Vec<Quad>,
}

impl Evaluation for Squares<'_> {
    type Output = f64;

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn evaluate(&self, index: usize) -> f64 {
        // Loops over constant sizes are unrolled; most surfaces are bicubic.
        match Residuals::orders(self.residuals.space) {
            [CUBIC_ORDER, CUBIC_ORDER] => self.square(index, [CUBIC_ORDER; 2]),
            orders => self.square(index, orders),
        }
    }
}

impl Squares<'_> {
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn square(&self, index: usize, [rows, cols]: [usize; 2]) -> f64 {
        let Residuals { space, residual_samples, functions, .. } = self.residuals;
        let width = space.knots[1].control_points();
        let (by_row, by_col) = functions[index * (rows + cols)..][..rows + cols].split_at(rows);
        let ResidualSample { point, normal, weight, first } = residual_samples[index];
        let mut place = [0.0; 4];
        for (i, row) in by_row.iter().enumerate() {
            let mut of_row = [0.0; 4];
            let net = &self.net[first + i * width..][..cols];
            for (point, col) in net.iter().zip(by_col) {
                add(&mut of_row, *col, point);
            }
            add(&mut place, *row, &of_row);
        }
        let [x, y, z, _] = place;
        weight * (point - DVec3::new(x, y, z)).dot(normal).powi(2)
    }
}
