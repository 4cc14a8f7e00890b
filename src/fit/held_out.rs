//! Errors at samples that were left out, with fixed parameters: the equations of all samples less those of a
//! fold give the surface of the others.

use glam::DVec3;
use rayon::prelude::*;

use super::band::Band;
use super::blocks::FOLDS;
use super::limits::{ENOUGH_POINTS, ENOUGH_SAMPLES};
use super::normal_equations::{NormalEquations, Sample};
use super::patches::Patches;
use super::space::SplineSpace;
use crate::error::{Error, Result};

/// Samples in folds, with the normal equations of each.
pub(super) struct HeldOut<'a> {
    space: &'a SplineSpace,
    folds: Vec<Vec<Sample>>,
    all: NormalEquations,
    /// The equations of those folds that are left out, the first ones.
    parts: Vec<NormalEquations>,
}

impl<'a> HeldOut<'a> {
    /// Of samples with normals, at most 20,000 of them, by the folds that a rule finds for these.
    pub(super) fn of(
        space: &'a SplineSpace,
        samples: &[Sample],
        rule: impl FnOnce(&[Sample]) -> Vec<usize>,
    ) -> Result<Self> {
        let (_, folds) = dealt(samples, rule);
        let equations =
            |samples: &Vec<Sample>| NormalEquations::of_distances(space, samples, &mut || Ok(()));
        let parts = folds.par_iter().map(equations).collect::<Result<Vec<_>>>()?;
        let mut all = parts[0].clone();
        parts[1..].iter().for_each(|part| all.add_scaled(1.0, part));
        Ok(Self { space, folds, all, parts })
    }

    /// As [`HeldOut::of`], but only as many folds are left out as have enough samples together.
    pub(super) fn of_enough(
        space: &'a SplineSpace,
        samples: &[Sample],
        rule: impl FnOnce(&[Sample]) -> Vec<usize>,
    ) -> Result<Self> {
        let (samples, folds) = dealt(samples, rule);
        let mut count = 0;
        let asked = folds.iter().take_while(|fold| {
            let more = count < ENOUGH_POINTS;
            count += fold.len();
            more
        });
        let asked = asked.count();
        let equations =
            |samples: &[Sample]| NormalEquations::of_distances(space, samples, &mut || Ok(()));
        let all = equations(&samples)?;
        let parts =
            folds[..asked].par_iter().map(|fold| equations(fold)).collect::<Result<Vec<_>>>()?;
        Ok(Self { space, folds, all, parts })
    }

    /// The trace of the matrix of all samples.
    pub(super) fn trace(&self) -> f64 {
        self.all.matrix.trace()
    }

    /// The mean square of the distances along normals from the surface of the other folds, with so many
    /// times this energy; infinite if these do not hold it.
    pub(super) fn error(&self, energy: &Band, times: f64) -> Result<f64> {
        let of_fold = |fold: usize| -> Result<f64> {
            let NormalEquations { mut matrix, mut right } = self.all.clone();
            let part = &self.parts[fold];
            matrix.add_scaled(-1.0, &part.matrix);
            matrix.add_scaled(times, energy);
            if !matrix.factor::<Error>(&mut || Ok(()))? {
                return Ok(f64::INFINITY);
            }
            for (sum, value) in right.as_flattened_mut().iter_mut().zip(part.right.as_flattened()) {
                *sum -= value;
            }
            matrix.solve(&mut right);
            let net: Vec<DVec3> = right.into_iter().map(DVec3::from_array).collect();
            let (surface, samples) = (self.space.surface(&net)?, &self.folds[fold]);
            let square = |i: usize, point: DVec3| {
                let Sample { point: wanted, normal, weight, .. } = samples[i];
                weight * (wanted - point).dot(normal).powi(2)
            };
            let patches = Patches::of(&surface);
            let squares =
                patches.each(samples.len(), |i| samples[i].uv, |i, place| square(i, place.point));
            Ok(squares.iter().sum())
        };
        let sums =
            (0..self.parts.len()).into_par_iter().map(of_fold).collect::<Result<Vec<f64>>>()?;
        let weight: f64 =
            self.folds[..self.parts.len()].iter().flatten().map(|sample| sample.weight).sum();
        Ok(sums.iter().sum::<f64>() / weight)
    }
}

/// At most 20,000 of some samples, and the same in folds.
fn dealt(
    samples: &[Sample],
    rule: impl FnOnce(&[Sample]) -> Vec<usize>,
) -> (Vec<Sample>, Vec<Vec<Sample>>) {
    let step = samples.len().div_ceil(ENOUGH_SAMPLES).max(1);
    let samples: Vec<Sample> = samples.iter().step_by(step).copied().collect();
    let mut folds = vec![Vec::new(); FOLDS];
    for (sample, fold) in samples.iter().zip(rule(&samples)) {
        folds[fold].push(*sample);
    }
    (samples, folds)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::blocks::{blocks, in_turn};
    use super::super::fairness::{Energy, ORDER};
    use super::*;
    use crate::nurbs::KnotVector;

    #[test]
    fn blocks_tell_of_gaps_that_samples_in_turn_do_not() {
        // Five tracks, each of many samples, over waves across them.
        let sample = |i: u32| {
            let at = f64::from(i);
            let jitter = 0.01 * (at * 0.754_877_666_246).fract();
            let uv = DVec2::new(0.2 * f64::from(i % 5) + 0.1 + jitter, (at * 0.618_034).fract());
            let z = uv.x * (9.0 * uv.y).sin() + 0.01 * (at * at * 0.569_840_290_998).fract();
            Sample { normal: DVec3::Z, ..Sample::plain(uv.extend(z), uv, 1.0) }
        };
        let samples: Vec<Sample> = (0..500).map(sample).collect();
        let knots = KnotVector::clamped_uniform(3, 14).unwrap();
        let space = SplineSpace::new([knots.clone(), knots], [false; 2]).unwrap();
        let energy = Energy::new((1.0, 1.0), ORDER).matrix(&space);
        let turn = HeldOut::of(&space, &samples, |samples| in_turn(samples.len())).unwrap();
        let places = |samples: &[Sample]| samples.iter().map(|sample| sample.point).collect();
        let block = HeldOut::of(&space, &samples, |samples| {
            let points: Vec<DVec3> = places(samples);
            blocks(&points)
        });
        let block = block.unwrap();
        let times = 1e-6 * turn.trace() / energy.trace();
        let errors = [&turn, &block].map(|held_out| held_out.error(&energy, times).unwrap());
        assert!(errors[0] < 1e-3 && errors[1] > 10.0 * errors[0], "{errors:?}");
    }
}
