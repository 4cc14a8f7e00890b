//! Which hypothesis is refined: charts propose, coarse fits are scored, the lowest score wins.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::score::{Score, ScoreSettings};
use crate::chart::{Chart, ChartInput, Hypothesis, Kind};
use crate::error::Result;
use crate::fit::{CoarseFit, CoarseProblem, CoarseSettings, Folds, coarse, quick_error};
use crate::numeric::rms;
use crate::observe::Observations;
use crate::progress::{self, Observer, Progress, Stage};
use crate::validate::{Compared, TermSettings, Terms};

/// How hypotheses are compared. Sources: the study that the scoreboard repeats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SelectSettings {
    /// The coarse fits.
    pub coarse: CoarseSettings,
    /// The comparison with the points.
    pub terms: TermSettings,
    /// The score.
    pub score: ScoreSettings,
    /// Which hypotheses are dropped early, and when one is taken at once.
    pub drop: DropSettings,
}

/// When a hypothesis is dropped before it is scored, and when one ends the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DropSettings {
    /// Hypotheses that are scored at most; heights come beside where noise leaves no local plane flat.
    pub most: usize,
    /// Quick error, in that of the best, from which on a hypothesis is dropped.
    pub error: f64,
    /// Quick error, in the noise of the points, up to which none is dropped.
    pub noise: f64,
    /// Points from which on heights may end the search.
    pub exit_points: usize,
    /// Error of left-out points, in the noise and curvature around each, up to which heights end it.
    pub exit_error: f64,
    /// Cosine of the steepest slope, 53 degrees: noise along the plane makes steeper heights worse
    /// than sheets.
    pub exit_steep: f64,
    /// The same where heights in scaled units are accepted, 78 degrees.
    pub steep: f64,
    /// Share of the local normals that must be no steeper.
    pub exit_upright: f64,
}

impl Default for DropSettings {
    fn default() -> Self {
        Self {
            most: 8,
            error: 5.0,
            noise: 2.0,
            exit_points: 100,
            exit_error: 1.5,
            exit_steep: 0.6,
            steep: 0.2,
            exit_upright: 0.95,
        }
    }
}

/// A hypothesis with its coarse fit.
#[derive(Clone, Debug)]
pub struct Model {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// Its coarse fit.
    pub fit: CoarseFit,
    /// What is wrong with it.
    pub terms: Terms,
    /// Its score.
    pub score: Score,
}

/// What the charts have proposed.
#[derive(Clone, Debug, Default)]
pub struct Ranking {
    /// The models, best first.
    pub models: Vec<Model>,
    /// Chart and kind of hypotheses that were dropped, with their quick error in that of the best.
    pub dropped: Vec<(&'static str, Kind, f64)>,
}

/// Ranks what charts propose for points.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn rank(
    seen: &Observations<'_>,
    given: DMat3,
    asked: Option<Kind>,
    charts: &[&dyn Chart],
    settings: &SelectSettings,
    observer: &mut dyn Observer,
) -> Result<Ranking> {
    let input = ChartInput::new(seen, given, asked);
    let folds = Folds::of(seen.points());
    let fits = |hypothesis: &Hypothesis| asked.is_none_or(|kind| kind == hypothesis.kind);
    let mut look = |step: usize| {
        let (step, total) = (step as u64, charts.len() as u64 + 1);
        progress::report(
            observer,
            &Progress::of_stage(Stage::Fitting, step, total, seen.points().len()),
        )
    };
    let (mut waiting, mut tried): (Vec<Hypothesis>, Vec<Model>) = (Vec::new(), Vec::new());
    let apply = |chart: &&&dyn Chart| asked.is_none_or(|kind| chart.kinds().contains(&kind));
    for (step, chart) in charts.iter().filter(apply).enumerate() {
        look(step)?;
        for hypothesis in chart.propose(&input).into_iter().filter(fits) {
            let free = asked.is_none() && seen.points().len() >= settings.drop.exit_points;
            if !free || !upright(&hypothesis, seen, settings.drop.exit_steep, settings) {
                waiting.push(hypothesis);
                continue;
            }
            let Some(model) = model(hypothesis, seen, &folds, settings)? else { continue };
            if ends_search(&model, seen, settings.drop.exit_steep, settings) {
                return Ok(scored(vec![model], seen, settings, Vec::new()));
            }
            tried.push(model);
        }
    }
    look(charts.len())?;
    let (hopeful, dropped) = drop_hopeless(waiting, &tried, seen, settings);
    for some in hopeful.chunks(rayon::current_num_threads()) {
        look(charts.len())?;
        let fit = |hypothesis: &Hypothesis| model(hypothesis.clone(), seen, &folds, settings);
        let found: Vec<Option<Model>> = some.par_iter().map(fit).collect::<Result<_>>()?;
        tried.extend(found.into_iter().flatten());
    }
    Ok(scored(tried, seen, settings, dropped))
}

/// Whether these are heights that hardly any local plane is too steep for.
fn upright(
    hypothesis: &Hypothesis,
    seen: &Observations<'_>,
    steep: f64,
    settings: &SelectSettings,
) -> bool {
    let up = hypothesis.heights.map(|axes| axes[2]);
    up.is_some_and(|up: DVec3| seen.share_along(up, steep) >= settings.drop.exit_upright)
}

/// Whether no other hypothesis can be much better than these heights.
pub(super) fn ends_search(
    model: &Model,
    seen: &Observations<'_>,
    steep: f64,
    settings: &SelectSettings,
) -> bool {
    let (scale, terms) = (&settings.score, &model.terms);
    let torn = terms.torn * (seen.points().len() as f64).sqrt();
    let thickness = &seen.planes().thickness;
    let left_out = model.fit.left_out.iter().zip(thickness);
    let relative = rms(left_out.map(|(error, around)| error / around.max(seen.noise())));
    upright(&model.hypothesis, seen, steep, settings)
        && relative <= settings.drop.exit_error
        && torn <= scale.torn.1
        && terms.misaligned <= scale.misaligned
        && terms.folded <= scale.folded
        && model.hypothesis.unfilled <= scale.unfilled
}

/// The hypotheses whose quick errors are within reach of the best, fewest errors first, and the
/// others.
fn drop_hopeless(
    waiting: Vec<Hypothesis>,
    tried: &[Model],
    seen: &Observations<'_>,
    settings: &SelectSettings,
) -> (Vec<Hypothesis>, Vec<(&'static str, Kind, f64)>) {
    let quick = |hypothesis: &Hypothesis| {
        quick_error(&problem(hypothesis, seen), &settings.coarse).unwrap_or(f64::INFINITY)
    };
    let errors: Vec<f64> = waiting.par_iter().map(quick).collect();
    let mut all: Vec<(f64, Hypothesis)> = errors.into_iter().zip(waiting).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let known = tried.iter().map(|model| model.fit.held_out[0]);
    let best =
        all.first().map(|first| first.0).into_iter().chain(known).fold(f64::INFINITY, f64::min);
    let limit = (settings.drop.error * best).max(settings.drop.noise * seen.noise());
    // Where planes say nothing, heights are as likely as others that follow noise.
    let (mut free, blind) = (0, !seen.planes().tell);
    let hopeful = |(error, hypothesis): &(f64, Hypothesis)| {
        let heights = blind && hypothesis.kind == Kind::Height;
        free += usize::from(!heights);
        *error <= limit && (heights || free <= settings.drop.most)
    };
    let (all, rest): (Vec<_>, Vec<_>) = all.into_iter().partition(hopeful);
    let dropped = rest.into_iter().map(|(error, h)| (h.chart, h.kind, error / best));
    (all.into_iter().map(|(_, hypothesis)| hypothesis).collect(), dropped.collect())
}

fn problem<'a>(hypothesis: &'a Hypothesis, seen: &'a Observations<'_>) -> CoarseProblem<'a> {
    CoarseProblem {
        points: seen.points(),
        uv: &hypothesis.uv,
        lengths: hypothesis.lengths,
        closed: hypothesis.closed(),
        fixed: hypothesis.kind == Kind::Height,
        noise: seen.noise(),
    }
}

/// The coarse fit of a hypothesis, its score yet to come; `None` if the points cannot hold it.
fn model(
    hypothesis: Hypothesis,
    seen: &Observations<'_>,
    folds: &Folds,
    settings: &SelectSettings,
) -> Result<Option<Model>> {
    let Ok(fit) = coarse(&problem(&hypothesis, seen), folds, &settings.coarse) else {
        return Ok(None);
    };
    let compared = Compared {
        seen,
        tree: seen.tree(),
        surface: &fit.surface,
        closed: hypothesis.closed(),
        uv: &fit.uv,
        distances: &fit.distances,
        diagonal: seen.size(),
    };
    let terms = compared.terms(&settings.terms)?;
    let score = Score { terms: [("", 0.0); 9] };
    Ok(Some(Model { hypothesis, fit, terms, score }))
}

/// Scores models against the best of them, and sorts them.
fn scored(
    mut models: Vec<Model>,
    seen: &Observations<'_>,
    settings: &SelectSettings,
    dropped: Vec<(&'static str, Kind, f64)>,
) -> Ranking {
    let best = models.iter().map(|model| model.fit.held_out[0]).fold(f64::INFINITY, f64::min);
    let floor = best.min(seen.noise()).max(f64::EPSILON.sqrt() * seen.size());
    for model in &mut models {
        let (kind, points) = (model.hypothesis.kind, seen.points().len());
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
