//! One rule for surfaces that fold: more fairness.

use super::fitted::Fitted;
use super::refine::Refinement;
use crate::error::Result;
use crate::progress::Observer;

/// Factor between neighbouring steps of fairness, and how many steps there are.
const STEP: f64 = 8.0;
const STEPS: i32 = 7;

/// Error after the repair, in that before or in the noise, from which on the hypothesis is wrong.
const WORSE: f64 = 2.0;

/// The surface with the least fairness, of steps that grow eightfold, with which it does not fold;
/// `None` if none does or the points are far from it then.
///
/// Bisection over the steps: the more fairness, the fewer folds.
pub(super) fn repaired(
    refinement: &Refinement<'_>,
    folded: &Fitted,
    noise: f64,
    folds: impl Fn(&Fitted) -> Result<bool>,
    observer: &mut dyn Observer,
) -> Result<Option<Fitted>> {
    let limit = WORSE * folded.rms().max(noise);
    let (mut low, mut high, mut found) = (0, STEPS + 1, None);
    while high - low > 1 {
        let step = i32::midpoint(low, high);
        let fairness = folded.fairness * STEP.powi(step);
        let smoother = refinement.smoother(folded, fairness, observer)?;
        if smoother.rms() > limit {
            high = step;
        } else if folds(&smoother)? {
            low = step;
        } else {
            (high, found) = (step, Some(smoother));
        }
    }
    Ok(found)
}
