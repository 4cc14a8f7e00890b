//! K-fold cross-validation of a height field: the fairness that best predicts points that were left
//! out.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::height_field::HeightField;
use super::held_out_groups::HeldOutGroups;
use super::least_squares::Equations;
use super::normal_equations::Sample;
use super::settings::{HeightSettings, LeastSquaresSettings};
use super::validation_groups::{GapCells, points_in_turn};
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
    /// See [`Equations::with_anisotropy`].
    pub(super) anisotropy: f64,
    /// Error at points left out in turn.
    pub(super) expected: f64,
    /// Error at points whose places are left out as wide as the gaps between the others.
    pub(super) expected_in_gaps: f64,
}

impl HeightField<'_> {
    /// The given fairness, or the one that best predicts points that are left out, searched near a
    /// known one.
    ///
    /// These points leave gaps as wide as those between the others. Where points lie in rows,
    /// tracks or clumps, they choose the anisotropy as well.
    pub(super) fn choose(
        &self,
        equations: &Equations,
        given: Option<f64>,
        near: Option<WarmStart>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Choice> {
        let sample = |i: usize| {
            let plain = Sample::plain(self.local[i], self.uv[i], self.weight(i));
            Sample { normal: DVec3::Z, ..plain }
        };
        let known = near.map(|near| near.fairness_for(self.local.len()));
        let space = equations.space().clone();
        let size = self.ground.size();
        let places: Vec<DVec2> = self.uv.iter().map(|uv| *uv * size).collect();
        let cells = GapCells::of(&places, size);
        let held_out = |groups: Vec<Vec<usize>>| {
            let samples = |group: &Vec<usize>| group.iter().map(|&i| sample(i)).collect();
            let groups = groups.iter().map(samples).collect();
            HeldOutGroups::of(&space, equations.of_points().clone(), groups)
        };
        let enough = LEAST_SQUARES.enough_points;
        let in_turn = points_in_turn(self.uv.len(), enough);
        // Of two sweeps, none predicts the other.
        let groups = Some(cells.groups(enough)).filter(|groups| !groups.is_empty());
        let in_cells = held_out(groups.unwrap_or_else(|| in_turn.clone()))?;
        let in_turn = held_out(in_turn)?;
        let mut choose = |anisotropy: f64| {
            let equations = equations.with_anisotropy(anisotropy);
            let error =
                |fairness| in_cells.robust_error(&equations.energy, equations.times(fairness));
            let fairness = match given {
                Some(fairness) => fairness,
                None => best(known, error, check_interrupt)?,
            };
            let expected_in_gaps = error(fairness)?;
            let expected = f64::INFINITY;
            Result::Ok(Choice { equations, fairness, anisotropy, expected, expected_in_gaps })
        };
        let mut found = choose(near.map_or(1.0, |near| near.anisotropy))?;
        for step in SETTINGS.anisotropy_steps.into_iter().filter(|_| cells.has_gaps) {
            loop {
                let other = choose(step * found.anisotropy)?;
                let limit = SETTINGS.significant_ratio() * found.expected_in_gaps;
                let gains = other.expected_in_gaps < limit;
                if !gains {
                    break;
                }
                found = other;
            }
        }
        let Choice { equations, fairness, .. } = &found;
        let expected = in_turn.error(&equations.energy, equations.times(*fairness))?;
        Ok(Choice { expected, ..found })
    }
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
