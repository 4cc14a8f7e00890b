//! K-fold cross-validation of a height field: the fairness that best predicts points that were left
//! out.

use std::collections::BTreeMap;

use glam::DVec3;

use super::height_field::HeightField;
use super::held_out_groups::HeldOutGroups;
use super::least_squares::Equations;
use super::normal_equations::Sample;
use super::settings::{HeightSettings, LeastSquaresSettings};
use super::validation_groups::{blocks, in_clumps, in_turn};
use super::warm_start::WarmStart;
use crate::error::Result;
use crate::progress::InterruptCheck;

const SETTINGS: HeightSettings = HeightSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// A fairness, and the mean squared errors that are expected with it.
pub(super) struct Choice {
    /// The equations with their energy.
    pub(super) equations: Equations,
    pub(super) fairness: f64,
    /// Error at points left out in turn.
    pub(super) expected: f64,
    /// Error at blocks of points; zero if points do not lie in clumps.
    pub(super) expected_of_blocks: f64,
}

impl HeightField<'_> {
    /// The given fairness, or the one that predicts best, searched near a known one.
    ///
    /// Where points lie in clumps, blocks choose the anisotropy. The fairness is then the larger of
    /// those that best predict points in turn and in blocks.
    pub(super) fn choose(
        &self,
        equations: Equations,
        given: Option<f64>,
        near: Option<WarmStart>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Choice> {
        let sample = |i: usize| {
            let plain = Sample::plain(self.local[i], self.uv[i], self.weight(i));
            Sample { normal: DVec3::Z, ..plain }
        };
        let samples: Vec<Sample> = (0..self.local.len()).map(sample).collect();
        let known = near.map(|near| near.fairness_for(self.local.len()));
        let space = equations.space().clone();
        let turn = HeldOutGroups::of(&space, &samples, LEAST_SQUARES.enough_points, |samples| {
            in_turn(samples.len())
        })?;
        let mut choose = |held_out: &HeldOutGroups<'_>, equations: &Equations| {
            let error = |fairness| error(held_out, equations, fairness);
            let fairness = match given {
                Some(fairness) => fairness,
                None => best(known, error, check_interrupt)?,
            };
            Result::Ok((fairness, error(fairness)?))
        };
        if !in_clumps(self.uv.iter().copied()) {
            let (fairness, expected) = choose(&turn, &equations)?;
            return Ok(Choice { equations, fairness, expected, expected_of_blocks: 0.0 });
        }
        let block = HeldOutGroups::of(&space, &samples, usize::MAX, |samples| {
            blocks(&samples.iter().map(|sample| sample.point).collect::<Vec<_>>())
        })?;
        let (mut found, mut least) = (None, f64::INFINITY);
        for anisotropy in SETTINGS.anisotropies {
            let equations = equations.with_anisotropy(anisotropy);
            let (fairness, error) = choose(&block, &equations)?;
            if error < least || found.is_none() {
                (found, least) = (Some((equations, fairness)), error);
            }
        }
        let (equations, fairness) = found.unwrap_or((equations, 1.0));
        let fairness = choose(&turn, &equations)?.0.max(fairness);
        let expected = error(&turn, &equations, fairness)?;
        let expected_of_blocks = error(&block, &equations, fairness)?;
        Ok(Choice { equations, fairness, expected, expected_of_blocks })
    }
}

fn error(held_out: &HeldOutGroups<'_>, equations: &Equations, fairness: f64) -> Result<f64> {
    held_out.error(&equations.energy, equations.times(fairness))
}

/// The fairness with the least error, in steps of half a decade. Near a known one, the error has a
/// single minimum.
fn best(
    known: Option<f64>,
    error: impl Fn(f64) -> Result<f64>,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<f64> {
    let fairness = |k: i32| 10.0_f64.powf(0.5 * f64::from(k));
    let all = 2 * SETTINGS.exponents.0..=2 * SETTINGS.exponents.1;
    let mut errors = BTreeMap::new();
    let mut walk = |errors: &mut BTreeMap<i32, f64>, from: i32, step: i32, worse: f64| {
        let mut k = from;
        while all.contains(&k) {
            check_interrupt()?;
            let found = match errors.get(&k) {
                Some(found) => *found,
                None => error(fairness(k))?,
            };
            errors.insert(k, found);
            if found > worse * least(errors) {
                break;
            }
            k += step;
        }
        Result::Ok(())
    };
    if let Some(known) = known {
        #[expect(clippy::cast_possible_truncation, reason = "a logarithm")]
        let nearest = ((2.0 * known.log10()).round() as i32).clamp(*all.start(), *all.end());
        walk(&mut errors, nearest, 1, SETTINGS.max_error_ratio)?;
        walk(&mut errors, nearest, -1, SETTINGS.max_error_ratio)?;
    } else {
        walk(&mut errors, *all.start(), 2, 2.0)?;
        if let Some(found) = smoothest(&errors) {
            walk(&mut errors, found + 1, *all.end() - *all.start(), 1.0)?;
        }
    }
    Ok(smoothest(&errors).map_or_else(|| known.unwrap_or(1.0), fairness))
}

fn least(errors: &BTreeMap<i32, f64>) -> f64 {
    errors.values().copied().fold(f64::INFINITY, f64::min)
}

/// The largest exponent whose error is close to the least.
fn smoothest(errors: &BTreeMap<i32, f64>) -> Option<i32> {
    let least = least(errors);
    let good = |(_, error): &(&i32, &f64)| {
        **error <= SETTINGS.max_error_ratio * least && least.is_finite()
    };
    errors.iter().rev().find(good).map(|(k, _)| *k)
}
