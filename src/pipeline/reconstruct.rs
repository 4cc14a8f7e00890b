//! The whole job, stage by stage.

use std::time::Instant;

use glam::DVec3;

use super::candidate::Candidate;
use super::diagnose::diagnose;
use super::measure::Measured;
use super::options::{ReconstructOptions, Start as Init};
use super::orientation::oriented;
use super::ranked::{Ranked, ranked};
use super::reconstruction::Reconstruction;
use super::refined::{Begun, Refined, begin, from_nodes, refine, refinement};
use super::report::{Deviations, Report, TrainingReport};
use super::select::Model;
use super::whole::{Part, before};
use crate::cloud::{self, Bounds};
use crate::diagnostic::Diagnostic;
use crate::error::{Error, Result};
use crate::fit::EndedBy;
use crate::progress::Observer;
use crate::worker_pool;

/// Hypotheses that are refined, at most, and how much higher than the best their scores may be: a
/// surface without defects that is far from the points is no better than one with defects.
const REFINED: usize = 5;
const MARGIN: f64 = 3.0;

/// How much higher than the best the scores of hypotheses may be between which first fits decide.
const LIKE: f64 = 1.0;

/// Turns scattered points into a NURBS surface; [`Reconstruction::tessellate`] turns that into
/// triangles.
///
/// Charts propose how points may lie on a surface. Coarse fits of their hypotheses are scored. The
/// best is refined: a map learns the points from it, and least squares with fairness and parameter
/// correction fit a net that grows.
///
/// # Errors
///
/// Those of [`cloud::check`]; [`crate::Error::Parameter`] for an option out of its range;
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn reconstruct(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let started = Instant::now();
    options.check(points.len())?;
    let mut found = worker_pool::run_observed(points.len(), observer, |observer| {
        let bounds = cloud::checked_bounds(points, &mut before(observer))?;
        ranked(points, options, observer, |ranked, observer| {
            finish(points, &bounds, ranked, options, observer)
        })
    })?;
    found.report.account_for(started.elapsed());
    Ok(found)
}

/// Refines and validates hypotheses until one has no defects, and measures all points.
fn finish(
    points: &[DVec3],
    bounds: &Bounds,
    mut ranked: Ranked<'_>,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let mut candidates = ranked.candidates();
    let seen = ranked.sample.len();
    let mut part = Part::Refine.observed(points.len(), seen, observer);
    let refined = best(&ranked, options, &mut candidates, &mut part)?;
    ranked.clock.lap("refine");
    let Refined { kind, heights, mut fitted, map, defects, .. } = refined;
    let frame = ranked.cloud.frame;
    let observer: &mut dyn Observer = &mut Part::Measure.observed(points.len(), seen, observer);
    if options.rational {
        let job = refinement(&ranked, kind, heights, [1.0; 2], options);
        fitted = job.rational(fitted, observer)?;
    }
    let surface = fitted.surface.map_control_points(|point| frame.to_given(point))?;
    let surface = oriented(surface, &mut fitted.uv, kind, observer)?;
    let measured = Measured::of(points, ranked.cloud, &fitted, &surface, kind.closed(), observer)?;
    let mut diagnostics = defects;
    diagnostics.extend(diagnose(points, &ranked, options, kind, &fitted, &measured));
    let som = map.in_given_frame(&frame, observer)?;
    ranked.clock.lap("measure");
    let counted = measured.counted();
    let far = |tolerance: f64| counted.iter().filter(|off| **off > tolerance).count();
    let missed = options.tolerance.map(far);
    let inliers = counted.len();
    let report = Report {
        points: points.len(),
        inliers,
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        deviations: Deviations::of(counted),
        tolerance: options.tolerance,
        within: missed.map(|missed| 1.0 - missed as f64 / inliers as f64),
        ended_by: if missed == Some(0) { EndedBy::Tolerance } else { fitted.ended_by },
        fairness: Some(fitted.fairness),
        iterations: fitted.iterations,
        kind,
        direction: heights.map(|axes| ranked.given_direction(axes[2])),
        axis_scale: ranked.axis_scale,
        valid: !diagnostics.iter().any(Diagnostic::is_defect),
        converged: missed.unwrap_or(0) == 0,
        candidates,
        diagnostics,
        duplicates: ranked.cloud.merged.len(),
        outliers: measured.outliers(ranked.cloud).len()
            + ranked.cloud.no_data.as_ref().map_or(0, |found| found.count),
        training: TrainingReport::of(&som, som.error.unwrap_or(f64::NAN)),
        seconds: ranked.clock.seconds(),
    };
    let Measured { uv, deviations, inliers } = measured;
    Ok(Reconstruction { surface, som, uv, deviations, inliers, report })
}

/// The first hypothesis of the ranking whose refined surface is whole, has no defects and is about
/// as near as those before; else the nearest without defects; else the first.
fn best(
    ranked: &Ranked<'_>,
    options: &ReconstructOptions<'_>,
    candidates: &mut [Candidate],
    observer: &mut dyn Observer,
) -> Result<Refined> {
    if let Init::Given { nodes, shape } = options.init {
        return from_nodes(ranked, nodes, shape, options, observer);
    }
    let models = &ranked.ranking.models;
    let behind = |model: &Model| model.score.total() - models[0].score.total();
    let near = models.iter().take(REFINED).take_while(|model| behind(model) <= MARGIN).count();
    let alike = models[..near].iter().take_while(|model| behind(model) <= LIKE);
    let mut first_fits: Vec<Result<Begun<'_>>> = Vec::new();
    // Where the first fit is much nearer than the coarse one, the coarse order says little.
    for model in alike {
        match begin(ranked, model, options, observer) {
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            first_fit => first_fits.push(first_fit),
        }
        if first_fits[0].as_ref().is_ok_and(|first| !first.tells_more()) {
            break;
        }
    }
    let mut order: Vec<usize> = (0..near).collect();
    let first = nearest(&first_fits, ranked);
    order.sort_by_key(|place| *place != first);
    let mut first_fits: Vec<Option<_>> = first_fits.into_iter().map(Some).collect();
    first_fits.resize_with(near, || None);
    let (mut best, mut failed): (Option<(usize, Refined)>, Option<Error>) = (None, None);
    for place in order {
        let begun = match first_fits[place].take() {
            Some(begun) => begun,
            None => begin(ranked, &models[place], options, observer),
        };
        let refined = match begun.and_then(|begun| refine(ranked, begun, observer)) {
            Ok(refined) => refined,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(error) => {
                candidates[place].outcome = format!("not fitted: {error}");
                failed = Some(error);
                continue;
            }
        };
        candidates[place].outcome = match refined.defects.first() {
            None if refined.whole => {
                "refined, but farther from the points than another".to_string()
            }
            None => {
                "refined, but a finer net has defects or is farther from the points".to_string()
            }
            Some(defect) => format!("refined, with the defect {}", defect.code()),
        };
        if best.as_ref().is_none_or(|(_, best)| refined.is_better_than(best)) {
            let done = refined.whole && refined.defects.is_empty();
            best = Some((place, refined));
            if done {
                break;
            }
        }
    }
    let Some((place, refined)) = best else {
        let (must, got) = ("enough for a surface", ranked.cloud.points.len());
        return Err(failed.unwrap_or_else(|| Error::parameter("points", must, got)));
    };
    candidates[place].outcome = match (refined.defects.is_empty(), refined.whole) {
        (true, true) => "chosen",
        (true, false) => "chosen, grown no further: no other candidate is better",
        (false, _) => "chosen, with defects: no other candidate is better",
    }
    .to_string();
    Ok(refined)
}

/// The place of the nearest of first fits, if it is nearer than the first by more than chance; else 0.
fn nearest(first_fits: &[Result<Begun<'_>>], ranked: &Ranked<'_>) -> usize {
    let points = ranked.sample.len() as f64;
    let chance = (ranked.settings.score.free / points.sqrt()).exp();
    let error = |place: usize| first_fits[place].as_ref().map_or(f64::INFINITY, Begun::error);
    let nearest = (0..first_fits.len()).min_by(|&a, &b| error(a).total_cmp(&error(b)));
    nearest.filter(|&place| chance * error(place) < error(0)).unwrap_or(0)
}
