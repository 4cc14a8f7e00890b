//! K-fold cross-validation at fixed parameters: errors at the samples of each group.
//!
//! The equations of all samples minus those of a group give the surface of the other groups.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use rayon::prelude::*;

use super::band_matrix::BandMatrix;
use super::normal_equations::{NormalEquations, Sample};
use super::patches::Patches;
use super::settings::FairnessSettings;
use super::spline_space::SplineSpace;
use crate::error::{Error, Result};
use crate::worker_pool;

const SETTINGS: FairnessSettings = FairnessSettings::STANDARD;

/// Groups of samples, with the normal equations of each and of all samples.
pub(super) struct HeldOutGroups<'a> {
    space: &'a SplineSpace,
    groups: Vec<Vec<Sample>>,
    parts: Vec<NormalEquations>,
    all: NormalEquations,
}

impl<'a> HeldOutGroups<'a> {
    /// The groups of samples, beside the equations of all samples.
    pub(super) fn of(
        space: &'a SplineSpace,
        all: NormalEquations,
        groups: Vec<Vec<Sample>>,
    ) -> Result<Self> {
        // The equations of each group and of all, the energy, and one factor for each thread.
        space.check_memory(1, SETTINGS.groups + 3 + worker_pool::num_threads())?;
        let equations =
            |samples: &Vec<Sample>| NormalEquations::of_distances(space, samples, &mut || Ok(()));
        let parts = groups.par_iter().map(equations).collect::<Result<Vec<_>>>()?;
        Ok(Self { space, groups, parts, all })
    }

    /// The trace of the matrix of all samples.
    pub(super) fn trace(&self) -> f64 {
        self.all.matrix.trace()
    }

    /// The mean squared distance along normals from the surfaces of the other groups, with the
    /// energy multiplied by `times`. Infinite if a group's complement does not determine the
    /// surface.
    pub(super) fn error(&self, energy: &BandMatrix, times: f64) -> Result<f64> {
        self.mean(energy, times, |distance| distance * distance)
    }

    /// The mean squared distance of normal errors with the same mean distance, on which a few wide
    /// gaps have little influence.
    pub(super) fn robust_error(&self, energy: &BandMatrix, times: f64) -> Result<f64> {
        Ok(FRAC_PI_2 * self.mean(energy, times, f64::abs)?.powi(2))
    }

    /// The mean over samples of a function of their distances.
    fn mean(&self, energy: &BandMatrix, times: f64, of: fn(f64) -> f64) -> Result<f64> {
        let of_group = |(samples, part): (&Vec<Sample>, &NormalEquations)| -> Result<f64> {
            let NormalEquations { mut matrix, mut right } = self.all.clone();
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
            let surface = self.space.surface(&net)?;
            let term = |i: usize, point: DVec3| {
                let Sample { point: wanted, normal, weight, .. } = samples[i];
                weight * of((wanted - point).dot(normal))
            };
            let patches = Patches::of(&surface);
            let terms =
                patches.each(samples.len(), |i| samples[i].uv, |i, place| term(i, place.point));
            Ok(terms.iter().sum())
        };
        let groups = self.groups.par_iter().zip(&self.parts);
        let sums = groups.map(of_group).collect::<Result<Vec<f64>>>()?;
        let weight: f64 = self.groups.iter().flatten().map(|sample| sample.weight).sum();
        Ok(sums.iter().sum::<f64>() / weight)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::fairness_energy::{Energy, ORDER};
    use super::super::validation_groups::{blocks, in_turn};
    use super::*;
    use crate::nurbs::KnotVector;

    #[test]
    fn blocks_measure_gaps_and_samples_in_turn_do_not() {
        // Five tracks with many samples each, over waves along them.
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
        let all = NormalEquations::of_distances(&space, &samples, &mut || Ok(())).unwrap();
        let held_out = |groups: Vec<usize>| {
            let mut members = vec![Vec::new(); SETTINGS.groups];
            groups.iter().zip(&samples).for_each(|(&group, sample)| members[group].push(*sample));
            HeldOutGroups::of(&space, all.clone(), members).unwrap()
        };
        let points: Vec<DVec3> = samples.iter().map(|sample| sample.point).collect();
        let (turn, block) = (held_out(in_turn(samples.len())), held_out(blocks(&points)));
        let times = 1e-6 * turn.trace() / energy.trace();
        let errors = [&turn, &block].map(|held_out| held_out.error(&energy, times).unwrap());
        assert!(errors[0] < 1e-3 && errors[1] > 10.0 * errors[0], "{errors:?}");
    }
}
