//! The fairness with which heights predict points best that were left out.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::height::{HeightFit, Heights};
use super::patches::Patches;
use super::{Equations, FitOptions};
use crate::error::{Error, Result};
use crate::progress::Listen;

/// Weights of the fairness among which cross-validation chooses.
const FAIRNESS: [f64; 15] =
    [1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 1e-1, 1.0, 3.0, 10.0, 30.0];

/// A heavier fairness is preferred while it predicts hardly worse than the best: it is the smoother
/// surface.
const HARDLY_WORSE: f64 = 1.01;

/// How many times worse than the best a fairness predicts where none that is farther off is tried: with
/// the lightest ones errors are about as large as one another.
const MUCH_WORSE: f64 = 2.0;

/// Parts of the points at least, each predicted from the others.
const FOLDS: usize = 4;

/// Points that cross-validation looks at, and about how many of them it predicts: so many tell as much as
/// all, but the more the others are, the larger a net they hold.
const JUDGED: usize = 1 << 17;
const PREDICTED: usize = 5_000;

/// Share of as many cells of the ground as points that these fill at least, if they do not lie in rows with
/// empty ground between: scattered by chance they fill 1 - 1 / e. And how many such cells on a side are
/// predicted together, if they do.
const ROWS: f64 = 0.45;
const TOGETHER: f64 = 4.0;

/// Control points up to which a solution takes a few milliseconds.
const SMALL: usize = 1_000;

/// What was best with another net, or of other points of the same surface.
#[derive(Clone, Copy)]
pub(crate) struct Near {
    fairness: f64,
    /// Of so many points: beside more, as much counts less.
    points: usize,
    pub(super) reach: Option<f64>,
}

impl Near {
    pub(crate) fn of(fairness: f64, points: usize) -> Self {
        Self { fairness, points, reach: None }
    }

    pub(crate) fn with_reach_of(self, other: Option<Self>) -> Self {
        Self { reach: other.and_then(|other| other.reach), ..self }
    }

    /// The fairness that counts as much beside so many points.
    pub(crate) fn beside(&self, points: usize) -> f64 {
        if points == self.points {
            return self.fairness;
        }
        self.fairness * self.points as f64 / points as f64
    }
}

impl From<&HeightFit> for Near {
    fn from(fit: &HeightFit) -> Self {
        Self { fairness: fit.fairness, points: fit.uv.len(), reach: fit.reach }
    }
}

impl Heights<'_> {
    /// Cross-validation: the weight with which the points of each part are predicted best from the
    /// other parts, and the mean square of the error then. Near one that is known, errors have one
    /// minimum.
    pub(super) fn best_fairness(
        &self,
        given: Option<f64>,
        near: Option<Near>,
        listen: &mut Listen<'_>,
    ) -> Result<(f64, f64)> {
        let step = self.local.len().div_ceil(JUDGED).max(1);
        let looked_at: Vec<usize> = (0..self.local.len()).step_by(step).collect();
        let (all, judged) = (self.local.len(), looked_at.len());
        let given_there = given.map(|fairness| Near::of(fairness, all).beside(judged));
        let tried = given_there.map_or(FAIRNESS.to_vec(), |fairness| vec![fairness]);
        let far = |near: Near, fairness: f64| (near.beside(judged) / fairness).ln().abs();
        let known = near.and_then(|near| {
            (0..tried.len()).min_by(|&a, &b| far(near, tried[a]).total_cmp(&far(near, tried[b])))
        });
        let parts = (judged / PREDICTED).max(FOLDS);
        let count = (PREDICTED * parts / judged).clamp(1, FOLDS);
        let part = self.parts(&looked_at, parts);
        let fold = |fold: usize, listen: &mut Listen<'_>| {
            Fold::of(self, &looked_at, |at| part[at] == fold, listen)
        };
        let folds = self.of_each_fold(count, listen, fold)?;
        let worse = if known.is_some() { HARDLY_WORSE } else { MUCH_WORSE };
        let (mut errors, mut least) = (vec![f64::INFINITY; tried.len()], f64::INFINITY);
        let first = known.unwrap_or(0);
        let (lighter, heavier) = ((0..first).rev(), first..tried.len());
        for direction in [heavier.collect::<Vec<_>>(), lighter.collect()] {
            for i in direction {
                listen()?;
                let error = |fold: usize, listen: &mut Listen<'_>| match &folds[fold] {
                    Some(fold) => fold.error(tried[i], listen),
                    None => Ok(DVec2::new(f64::INFINITY, 1.0)),
                };
                let sum: DVec2 = self.of_each_fold(count, listen, error)?.into_iter().sum();
                errors[i] = sum.x / sum.y;
                least = least.min(errors[i]);
                if errors[i] > worse * least {
                    break;
                }
            }
        }
        let smoothest = (0..tried.len()).rev().find(|&i| errors[i] <= HARDLY_WORSE * least);
        let found = smoothest.filter(|_| least.is_finite()).unwrap_or(first);
        let here = given.unwrap_or_else(|| Near::of(tried[found], judged).beside(all));
        Ok((here, errors[found]))
    }

    /// Which of so many parts each of the points that are looked at is of. Of points that lie in rows, with
    /// empty ground between, those that are near one another are of the same: a surface that predicts a
    /// point from the next of its row says nothing of what lies between rows.
    fn parts(&self, looked_at: &[usize], parts: usize) -> Vec<usize> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
        let cell = |i: usize, side: f64| (self.uv[i] * side).to_array().map(|at| at as usize);
        let side = (looked_at.len() as f64).sqrt();
        let mut cells: Vec<[usize; 2]> = looked_at.iter().map(|&i| cell(i, side)).collect();
        cells.sort_unstable();
        cells.dedup();
        if (cells.len() as f64) < ROWS * looked_at.len() as f64 {
            // Of four parts and more, none has two squares beside one another.
            let square = |&i: &usize| cell(i, side / TOGETHER);
            return looked_at.iter().map(square).map(|[u, v]| (u + 2 * v) % parts).collect();
        }
        // Taken by a stride that is prime to rows of grids, points of a part lie among the others.
        (0..looked_at.len()).map(|i| (i * 7 + i / 5) % parts).collect()
    }

    /// Does a job for each fold. Small nets are solved for before anybody would listen: their folds
    /// are looked at side by side, those of large nets one after the other.
    fn of_each_fold<T: Send>(
        &self,
        count: usize,
        listen: &mut Listen<'_>,
        job: impl Fn(usize, &mut Listen<'_>) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        let FitOptions { knots_u, knots_v, .. } = &self.options;
        if knots_u.control_points() * knots_v.control_points() <= SMALL {
            return (0..count).into_par_iter().map(|fold| job(fold, &mut || Ok(()))).collect();
        }
        (0..count).map(|fold| job(fold, listen)).collect()
    }
}

/// A part of the points, and the surface of the other parts.
struct Fold<'a> {
    heights: &'a Heights<'a>,
    equations: Equations,
    left_out: Vec<usize>,
}

impl<'a> Fold<'a> {
    /// A part of the points that are looked at; `None` if the others hold no surface.
    fn of(
        heights: &'a Heights<'a>,
        looked_at: &[usize],
        is_left_out: impl Fn(usize) -> bool,
        listen: &mut Listen<'_>,
    ) -> Result<Option<Self>> {
        let pick = |left_out: bool| -> Vec<usize> {
            let places = looked_at.iter().enumerate();
            let wanted = places.filter(|(at, _)| is_left_out(*at) == left_out);
            wanted.map(|(_, &index)| index).collect()
        };
        let (seen, left_out) = (pick(false), pick(true));
        let points: Vec<DVec3> = seen.iter().map(|&i| heights.local[i]).collect();
        let places: Vec<DVec2> = seen.iter().map(|&i| heights.uv[i]).collect();
        let own: Vec<f64> = seen.iter().map(|&i| heights.weight(i)).collect();
        let Heights { options, order, .. } = heights;
        match Equations::of(&points, &places, Some(&own), options, *order, listen) {
            Ok(equations) => Ok(Some(Self { heights, equations, left_out })),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            Err(_) => Ok(None),
        }
    }

    /// The sum of the squared heights of the points left out, each with its weight, and that of the weights.
    fn error(&self, fairness: f64, listen: &mut Listen<'_>) -> Result<DVec2> {
        let surface = match self.equations.solve(fairness, listen) {
            Ok(surface) => surface,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(_) => return Ok(DVec2::new(f64::INFINITY, 1.0)),
        };
        let (heights, patches) = (self.heights, Patches::of(&surface));
        let rest = |i: usize| heights.local[i].z - patches.at(heights.uv[i]).point.z;
        let counted = |&i: &usize| heights.weight(i) * DVec2::new(rest(i).powi(2), 1.0);
        Ok(self.left_out.iter().map(counted).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::super::HeightOptions;
    use super::super::ground::Base;
    use super::*;

    #[test]
    fn rows_are_predicted_from_other_rows() {
        // Eight rows of many points each, over waves and as many of noise that no row shares.
        let row = |i: u32| f64::from(i % 8);
        let points: Vec<DVec3> = (0..4000)
            .map(|i| {
                let (x, y) = (f64::from(i) / 4000.0, row(i) / 7.0);
                let own = 0.2 * (40.0 * x + 2.4 * row(i) * row(i)).sin();
                DVec3::new(x, y, (3.0 * x).sin() * (2.0 * y).cos() + own)
            })
            .collect();
        let options = HeightOptions { net: (20, 20), degree: (3, 3), fairness: None };
        let base = Base::over(&points, DVec3::Z);
        let heights = Heights::of(&points, None, &base, &options).unwrap();
        let all: Vec<usize> = (0..points.len()).collect();
        let part = heights.parts(&all, 4);
        let beside = (0..3992).filter(|&i| part[i] == part[i + 8]).count();
        assert!(beside > 3600, "{beside}");
    }
}
