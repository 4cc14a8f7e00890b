//! Selection of the result: ranked hypotheses are refined until one has no defects.

use super::candidates::{Candidate, Outcome};
use super::options::{ReconstructOptions, Start};
use super::ranked_cloud::RankedCloud;
use super::ranking::Model;
use super::refine::{FirstFit, RefinedSurface, first_fit, refine, refine_from_nodes};
use super::settings::SelectionSettings;
use crate::error::{Error, Result};
use crate::progress::Observer;

const SETTINGS: SelectionSettings = SelectionSettings::STANDARD;

/// Refines the ranked hypotheses and returns the best surface. Sets the outcome of each candidate.
///
/// The selection ends at the first surface that has no defects, could grow, and is about as near to
/// the points as those before. Else the nearest without defects is returned, or the first.
pub(super) fn select_best(
    ranked: &RankedCloud<'_>,
    options: &ReconstructOptions<'_>,
    candidates: &mut [Candidate],
    observer: &mut dyn Observer,
) -> Result<RefinedSurface> {
    if let Start::Given { nodes, shape } = options.init {
        return refine_from_nodes(ranked, nodes, shape, options, observer);
    }
    let models = best_models(ranked);
    let Order { places, mut first_fits } = refinement_order(ranked, models, options, observer)?;
    let (mut best, mut failed): (Option<(usize, RefinedSurface)>, Option<Error>) = (None, None);
    for place in places {
        let first = match first_fits[place].take() {
            Some(first) => first,
            None => first_fit(ranked, &models[place], options, observer),
        };
        let refined = match first.and_then(|first| refine(ranked, first, observer)) {
            Ok(refined) => refined,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(error) => {
                candidates[place].outcome = Outcome::NotFitted(&error).to_string();
                failed = Some(error);
                continue;
            }
        };
        candidates[place].outcome = outcome_if_lost(&refined).to_string();
        if best.as_ref().is_none_or(|(_, best)| refined.is_better_than(best)) {
            let done = refined.complete && refined.defects.is_empty();
            best = Some((place, refined));
            if done {
                break;
            }
        }
    }
    let Some((place, refined)) = best else {
        let must = "enough for a surface of this kind (add points, or use kind 'auto')";
        let got = ranked.cloud.points.len();
        return Err(failed.unwrap_or_else(|| Error::parameter("points", must, got)));
    };
    candidates[place].outcome = outcome_if_chosen(&refined).to_string();
    Ok(refined)
}

/// The models that may be refined: those whose scores are near the best one's, up to a limit.
fn best_models<'a>(ranked: &'a RankedCloud<'_>) -> &'a [Model] {
    let models = &ranked.ranking.models;
    let near = models
        .iter()
        .take(SETTINGS.max_refined)
        .take_while(|model| score_above_best(model, models) <= SETTINGS.score_margin);
    &models[..near.count()]
}

fn score_above_best(model: &Model, models: &[Model]) -> f64 {
    model.score.total() - models[0].score.total()
}

/// The order in which models are refined.
struct Order<'a> {
    /// Places in the ranking.
    places: Vec<usize>,
    /// For each place, the first fit that was made to find the order.
    first_fits: Vec<Option<Result<FirstFit<'a>>>>,
}

/// Finds the order in which models are refined.
///
/// Models of similar score are ordered by their first fits if the best one's is much nearer than
/// its coarse fit. Only the nearest model moves to the front.
fn refinement_order<'a>(
    ranked: &'a RankedCloud<'_>,
    models: &'a [Model],
    options: &'a ReconstructOptions<'a>,
    observer: &mut dyn Observer,
) -> Result<Order<'a>> {
    let mut found: Vec<Result<FirstFit<'a>>> = Vec::new();
    let similar = |model: &&Model| score_above_best(model, models) <= SETTINGS.similar_score;
    for model in models.iter().take_while(similar) {
        match first_fit(ranked, model, options, observer) {
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            fit => found.push(fit),
        }
        if found[0].as_ref().is_ok_and(|first| !first.is_much_nearer_than_coarse()) {
            break;
        }
    }
    let mut places: Vec<usize> = (0..models.len()).collect();
    let nearest = nearest(&found, ranked);
    places.sort_by_key(|place| *place != nearest);
    let mut first_fits: Vec<Option<_>> = found.into_iter().map(Some).collect();
    first_fits.resize_with(models.len(), || None);
    Ok(Order { places, first_fits })
}

/// The place of the nearest first fit, if it is nearer than the first one by more than chance; else
/// 0.
fn nearest(first_fits: &[Result<FirstFit<'_>>], ranked: &RankedCloud<'_>) -> usize {
    let points = ranked.sample.len() as f64;
    let chance = (ranked.settings.score.free_cost / points.sqrt()).exp();
    let error = |place: usize| first_fits[place].as_ref().map_or(f64::INFINITY, FirstFit::error);
    let nearest = (0..first_fits.len()).min_by(|&a, &b| error(a).total_cmp(&error(b)));
    nearest.filter(|&place| chance * error(place) < error(0)).unwrap_or(0)
}

fn outcome_if_lost(refined: &RefinedSurface) -> Outcome<'_> {
    match refined.defects.first() {
        None if refined.complete => Outcome::Farther,
        None => Outcome::NotGrown,
        Some(defect) => Outcome::Defect(defect),
    }
}

fn outcome_if_chosen(refined: &RefinedSurface) -> Outcome<'_> {
    match (refined.defects.is_empty(), refined.complete) {
        (true, true) => Outcome::Chosen,
        (true, false) => Outcome::ChosenNotGrown,
        (false, _) => Outcome::ChosenWithDefects,
    }
}
