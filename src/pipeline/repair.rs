//! One rule for surfaces that fold or overshoot: more fairness.

use super::fitted::Fitted;
use super::refine::Refinement;
use crate::error::Result;
use crate::progress::Observer;

/// Factor between neighbouring steps of fairness, and how many steps there are.
const STEP: f64 = 8.0;
const STEPS: i32 = 7;

/// The surface with the least fairness, of steps that grow eightfold, with which nothing is wrong;
/// `None` if none does or the points are farther from it than the limit then, by root mean square.
///
/// Bisection over the steps: the more fairness, the fewer folds and bulges.
pub(super) fn repaired(
    refinement: &Refinement<'_>,
    first: &Fitted,
    limit: f64,
    wrong: impl Fn(&Fitted) -> Result<bool>,
    observer: &mut dyn Observer,
) -> Result<Option<Fitted>> {
    let (mut low, mut high, mut found) = (0, STEPS + 1, None);
    while high - low > 1 {
        let step = i32::midpoint(low, high);
        let fairness = first.fairness * STEP.powi(step);
        let smoother = refinement.smoother(first, fairness, observer)?;
        if smoother.rms() > limit {
            high = step;
        } else if wrong(&smoother)? {
            low = step;
        } else {
            (high, found) = (step, Some(smoother));
        }
    }
    Ok(found)
}
