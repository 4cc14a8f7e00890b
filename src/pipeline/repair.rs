//! Repair of a surface that folds or overshoots: more fairness.

use super::fit_problem::FitProblem;
use super::settings::RepairSettings;
use super::surface_fit::SurfaceFit;
use crate::error::Result;
use crate::progress::Observer;

const SETTINGS: RepairSettings = RepairSettings::STANDARD;

/// Refits a surface with more fairness, as little as removes its defects.
///
/// Returns `None` if no step of fairness removes them, or only one that moves the surface farther
/// than `max_rms` from the points. More fairness means fewer folds and bulges, so the step is found
/// by bisection.
pub(super) fn repaired(
    problem: &FitProblem<'_>,
    first: &SurfaceFit,
    max_rms: f64,
    has_defects: impl Fn(&SurfaceFit) -> Result<bool>,
    observer: &mut dyn Observer,
) -> Result<Option<SurfaceFit>> {
    let (mut low, mut high, mut found) = (0, SETTINGS.steps + 1, None);
    while high - low > 1 {
        let step = i32::midpoint(low, high);
        let fairness = first.fairness * SETTINGS.fairness_factor.powi(step);
        let smoother = problem.refit_with_fairness(first, fairness, observer)?;
        if smoother.rms() > max_rms {
            high = step;
        } else if has_defects(&smoother)? {
            low = step;
        } else {
            (high, found) = (step, Some(smoother));
        }
    }
    Ok(found)
}
