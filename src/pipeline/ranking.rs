//! The ranking of hypotheses: charts propose them, coarse fits are scored, the lowest score is
//! best.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::score::Score;
use super::settings::RankingSettings;
use crate::chart::{Chart, ChartInput, Hypothesis, Kind};
use crate::error::Result;
use crate::fit::{CoarseFit, CoarseProblem, ValidationGroups, coarse, quick_error};
use crate::numeric::rms;
use crate::observe::Observations;
use crate::progress::{self, Observer, Progress, Stage};
use crate::validate::{Comparison, Terms};
use crate::worker_pool;

/// A hypothesis with its coarse fit.
#[derive(Clone, Debug)]
pub struct Model {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// Its coarse fit.
    pub fit: CoarseFit,
    /// Its error terms.
    pub terms: Terms,
    /// Its score.
    pub score: Score,
}

/// A hypothesis that was dropped before it was scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropped {
    /// The chart that proposed it.
    pub chart: &'static str,
    /// Its kind.
    pub kind: Kind,
    /// Its quick error over that of the best hypothesis.
    pub error_ratio: f64,
}

/// The hypotheses of all charts.
#[derive(Clone, Debug, Default)]
pub struct Ranking {
    /// The models, best first.
    pub models: Vec<Model>,
    /// Hypotheses that were dropped, smallest error first.
    pub dropped: Vec<Dropped>,
}

/// Ranks the hypotheses of charts for observed points.
///
/// `given` are the axes x, y and z of the points in the frame of the observations. With
/// `requested`, only hypotheses of that kind are ranked. A height field that fits well enough ends
/// the search.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn rank(
    observations: &Observations<'_>,
    given: DMat3,
    requested: Option<Kind>,
    charts: &[&dyn Chart],
    settings: &RankingSettings,
    observer: &mut dyn Observer,
) -> Result<Ranking> {
    let input = ChartInput::new(observations, given, requested);
    let groups = ValidationGroups::of(observations.points());
    let fits = |hypothesis: &Hypothesis| requested.is_none_or(|kind| kind == hypothesis.kind);
    let mut report = |step: usize| {
        let (step, total) = (step as u64, charts.len() as u64 + 1);
        progress::report(
            observer,
            &Progress::of_stage(Stage::Fitting, step, total, observations.points().len()),
        )
    };
    let (mut waiting, mut fitted): (Vec<Hypothesis>, Vec<Model>) = (Vec::new(), Vec::new());
    let apply = |chart: &&&dyn Chart| requested.is_none_or(|kind| chart.kinds().contains(&kind));
    for (step, chart) in charts.iter().filter(apply).enumerate() {
        report(step)?;
        for hypothesis in chart.propose(&input).into_iter().filter(fits) {
            let free = requested.is_none()
                && observations.points().len() >= settings.search.end_search_min_points;
            if !free
                || !is_gentle(
                    &hypothesis,
                    observations,
                    settings.search.end_search_min_cosine,
                    settings,
                )
            {
                waiting.push(hypothesis);
                continue;
            }
            let Some(model) = coarse_model(hypothesis, observations, &groups, settings)? else {
                continue;
            };
            if ends_search(&model, observations, settings.search.end_search_min_cosine, settings) {
                return Ok(scored(vec![model], observations, settings, Vec::new()));
            }
            fitted.push(model);
        }
    }
    report(charts.len())?;
    let (kept, dropped) = drop_poor(waiting, &fitted, observations, settings);
    for batch in kept.chunks(worker_pool::num_threads()) {
        report(charts.len())?;
        let fit = |hypothesis: &Hypothesis| {
            coarse_model(hypothesis.clone(), observations, &groups, settings)
        };
        let found: Vec<Option<Model>> = batch.par_iter().map(fit).collect::<Result<_>>()?;
        fitted.extend(found.into_iter().flatten());
    }
    Ok(scored(fitted, observations, settings, dropped))
}

/// Whether the hypothesis is a height field and nearly all local planes are within the slope that
/// `min_cosine` allows.
fn is_gentle(
    hypothesis: &Hypothesis,
    observations: &Observations<'_>,
    min_cosine: f64,
    settings: &RankingSettings,
) -> bool {
    let up = hypothesis.heights.map(|axes| axes[2]);
    up.is_some_and(|up: DVec3| {
        observations.share_along(up, min_cosine) >= settings.search.end_search_min_share
    })
}

/// Whether a model is a height field that no other hypothesis can beat by much.
pub(super) fn ends_search(
    model: &Model,
    observations: &Observations<'_>,
    min_cosine: f64,
    settings: &RankingSettings,
) -> bool {
    let (limits, terms) = (&settings.score, &model.terms);
    let torn = terms.torn * (observations.points().len() as f64).sqrt();
    let thickness = &observations.planes().thickness;
    let held_out = model.fit.left_out.iter().zip(thickness);
    let relative = rms(held_out.map(|(error, around)| error / around.max(observations.noise())));
    is_gentle(&model.hypothesis, observations, min_cosine, settings)
        && relative <= settings.search.end_search_max_error
        && torn <= limits.torn_scale
        && terms.misaligned <= limits.misaligned_scale
        && terms.folded <= limits.folded_scale
        && model.hypothesis.unfilled <= limits.unfilled_scale
}

/// Drops hypotheses whose quick error is far above the best. Returns those that are kept, smallest
/// error first, and those that are dropped.
fn drop_poor(
    waiting: Vec<Hypothesis>,
    fitted: &[Model],
    observations: &Observations<'_>,
    settings: &RankingSettings,
) -> (Vec<Hypothesis>, Vec<Dropped>) {
    let quick = |hypothesis: &Hypothesis| {
        quick_error(&problem(hypothesis, observations), &settings.coarse).unwrap_or(f64::INFINITY)
    };
    let errors: Vec<f64> = waiting.par_iter().map(quick).collect();
    let mut all: Vec<(f64, Hypothesis)> = errors.into_iter().zip(waiting).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let known = fitted.iter().map(|model| model.fit.held_out[0]);
    let best =
        all.first().map(|first| first.0).into_iter().chain(known).fold(f64::INFINITY, f64::min);
    let limit = (settings.search.max_error_ratio * best)
        .max(settings.search.max_noise_ratio * observations.noise());
    // Without reliable local planes a height field is as likely as surfaces that follow noise.
    let (mut free, unreliable) = (0, !observations.planes().reliable);
    let is_kept = |(error, hypothesis): &(f64, Hypothesis)| {
        let heights = unreliable && hypothesis.kind == Kind::Height;
        free += usize::from(!heights);
        *error <= limit && (heights || free <= settings.search.max_hypotheses)
    };
    let (all, rest): (Vec<_>, Vec<_>) = all.into_iter().partition(is_kept);
    let dropped = rest.into_iter().map(|(error, h)| Dropped {
        chart: h.chart,
        kind: h.kind,
        error_ratio: error / best,
    });
    (all.into_iter().map(|(_, hypothesis)| hypothesis).collect(), dropped.collect())
}

/// The coarse fit problem of a hypothesis.
fn problem<'a>(
    hypothesis: &'a Hypothesis,
    observations: &'a Observations<'_>,
) -> CoarseProblem<'a> {
    CoarseProblem {
        points: observations.points(),
        uv: &hypothesis.uv,
        lengths: hypothesis.lengths,
        closed: hypothesis.closed(),
        fixed: hypothesis.kind == Kind::Height,
        noise: observations.noise(),
    }
}

/// Fits a hypothesis coarsely and finds its error terms; its score is still empty. `None` if the
/// points do not determine the fit.
fn coarse_model(
    hypothesis: Hypothesis,
    observations: &Observations<'_>,
    groups: &ValidationGroups,
    settings: &RankingSettings,
) -> Result<Option<Model>> {
    let Ok(fit) = coarse(&problem(&hypothesis, observations), groups, &settings.coarse) else {
        return Ok(None);
    };
    let compared = Comparison {
        observations,
        tree: observations.tree(),
        surface: &fit.surface,
        closed: hypothesis.closed(),
        uv: &fit.uv,
        distances: &fit.distances,
    };
    let terms = compared.terms(&settings.terms)?;
    let score = Score { terms: [("", 0.0); 9] };
    Ok(Some(Model { hypothesis, fit, terms, score }))
}

/// Scores models and sorts them, the best first. The best error or the noise, if it is smaller, is
/// the floor below which errors do not differ.
fn scored(
    mut models: Vec<Model>,
    observations: &Observations<'_>,
    settings: &RankingSettings,
    dropped: Vec<Dropped>,
) -> Ranking {
    let best = models.iter().map(|model| model.fit.held_out[0]).fold(f64::INFINITY, f64::min);
    let floor = best.min(observations.noise()).max(f64::EPSILON.sqrt() * observations.size());
    for model in &mut models {
        let (kind, points) = (model.hypothesis.kind, observations.points().len());
        let held_out = model.fit.held_out;
        model.score = Score::of(
            kind,
            model.hypothesis.unfilled,
            held_out,
            floor,
            &model.terms,
            points,
            &settings.score,
        );
    }
    models.sort_by(|a, b| a.score.compare(&b.score));
    Ranking { models, dropped }
}
