//! The whole job, stage by stage.

use std::time::Instant;

use glam::{DVec2, DVec3};

use super::candidate::Candidate;
use super::diagnose::diagnose;
use super::fitted::Fitted;
use super::map::{LearnedMap, grid};
use super::measure::Measured;
use super::options::{ReconstructOptions, Start as Init};
use super::orientation::oriented;
use super::ranked::{Ranked, ranked};
use super::reconstruction::Reconstruction;
use super::refine::Refinement;
use super::relay;
use super::repair::repaired;
use super::report::{Deviations, Report, TrainingReport};
use super::select::Model;
use super::start::Start;
use crate::chart::Kind;
use crate::cloud::{self, Bounds, LocalObserver, items_at};
use crate::diagnostic::Diagnostic;
use crate::error::{Error, Result};
use crate::fit::{EndedBy, lengths};
use crate::numeric::rms;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::{Observer, Silent};
use crate::som::Init as MapInit;
use crate::validate::{Compared, DefectSettings, defects};

/// Hypotheses that are refined, at most, and how much higher than the best their scores may be: a
/// surface without defects that is far from the points is no better than one with defects.
const REFINED: usize = 5;
const MARGIN: f64 = 3.0;

/// Distance of the points from a refined surface, in that from the coarse one, from which on it is
/// worse.
const WORSE: f64 = 1.2;

/// Share of the folds that make a surface invalid which may be left after a repair.
const HARDLY: f64 = 0.25;

/// The median of normal noise's distances, in its standard deviation.
const MEDIAN: f64 = 0.6745;

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
    let mut found = relay::in_pool(points.len(), observer, |observer| {
        let bounds = cloud::checked_bounds(points, observer)?;
        ranked(points, options, observer, |ranked, observer| {
            finish(points, &bounds, ranked, options, observer)
        })
    })?;
    found.report.account_for(started.elapsed());
    Ok(found)
}

/// A refined surface with what is wrong with it.
struct Refined {
    kind: Kind,
    heights: Option<[DVec3; 3]>,
    fitted: Fitted,
    map: LearnedMap,
    defects: Vec<Diagnostic>,
    /// Whether it has grown as far as the points hold, and is no farther from them than the coarse
    /// surface that it comes from.
    whole: bool,
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
    let refined = best(&ranked, options, &mut candidates, observer)?;
    ranked.clock.lap("refine");
    let Refined { kind, heights, mut fitted, map, defects, .. } = refined;
    let frame = ranked.cloud.frame;
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

/// The first hypothesis of the ranking whose refined surface is whole and has no defects; else the
/// first without defects; else the first.
fn best(
    ranked: &Ranked<'_>,
    options: &ReconstructOptions<'_>,
    candidates: &mut [Candidate],
    observer: &mut dyn Observer,
) -> Result<Refined> {
    if let Init::Given { nodes, shape } = options.init {
        return from_nodes(ranked, nodes, shape, options, observer);
    }
    let mut first = None;
    let models = &ranked.ranking.models;
    let limit = models.first().map_or(0.0, |model| model.score.total()) + MARGIN;
    let near = models.iter().take_while(|model| model.score.total() <= limit);
    for (place, model) in near.take(REFINED).enumerate() {
        let refined = match refine(ranked, model, options, observer) {
            Ok(refined) => refined,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(error) if place + 1 == models.len() && first.is_none() => {
                return Err(error);
            }
            Err(error) => {
                candidates[place].outcome = format!("not fitted: {error}");
                continue;
            }
        };
        candidates[place].outcome = match refined.defects.first() {
            None if refined.whole => {
                candidates[place].outcome = "chosen".to_string();
                return Ok(refined);
            }
            None => {
                "refined, but a finer net has defects or is farther from the points".to_string()
            }
            Some(defect) => format!("refined, with the defect {}", defect.code()),
        };
        let sound = refined.defects.is_empty();
        if first
            .as_ref()
            .is_none_or(|(_, first): &(usize, Refined)| sound && !first.defects.is_empty())
        {
            first = Some((place, refined));
        }
    }
    let Some((place, refined)) = first else {
        let (must, got) = ("enough for a surface", ranked.cloud.points.len());
        return Err(Error::parameter("points", must, got));
    };
    let shortcoming = if refined.defects.is_empty() { "grown no further" } else { "with defects" };
    candidates[place].outcome = format!("chosen, {shortcoming}: no other candidate is better");
    Ok(refined)
}

fn refinement<'a>(
    ranked: &'a Ranked<'_>,
    kind: Kind,
    heights: Option<[DVec3; 3]>,
    lengths: [f64; 2],
    options: &'a ReconstructOptions<'a>,
) -> Refinement<'a> {
    Refinement {
        points: &ranked.cloud.points,
        weights: ranked.cloud.weights.as_deref(),
        kind,
        heights,
        lengths,
        // Half of normal noise lies within its median.
        noise: ranked.seen.noise() * MEDIAN,
        spacing: ranked.seen.spacing(),
        tolerance: options.tolerance.map(|length| ranked.cloud.frame.length_to_local(length)),
        options,
    }
}

/// The refined surface of a model.
fn refine(
    ranked: &Ranked<'_>,
    model: &Model,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Refined> {
    let hypothesis = &model.hypothesis;
    let (kind, heights) = (hypothesis.kind, hypothesis.heights);
    let mut observer = LocalObserver { frame: ranked.cloud.frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let job = refinement(ranked, kind, heights, lengths(&model.fit.surface).into(), options);
    let start = Start::of(job.points, ranked.sample, model, observer)?;
    let coarse = &model.fit.surface;
    let map = LearnedMap::on_surface(job.points, coarse, kind, job.net(), observer)?;
    let coarse_rms = rms(start.distances.iter().copied());
    let small = job.fit(&start, &map, observer)?;
    let mut best = mended(ranked, &job, small, observer)?;
    // A finer net must bring no defects, or none that more fairness does not mend.
    let accept = |surface: &NurbsSurface, uv: &[DVec2]| {
        Ok(defects_on(ranked, surface, uv, kind, &sure())?.is_empty())
    };
    if best.1.is_empty() {
        let grown = job.grown(best.0.clone(), &accept, observer)?;
        let all = if grown.ended_by == EndedBy::Defects {
            let all = job.grown(best.0, &|_, _| Ok(true), observer)?;
            Some(mended(ranked, &job, all, observer)?)
        } else {
            None
        };
        best.0 = match all {
            Some((all, defects)) if defects.is_empty() && all.rms() < grown.rms() => all,
            _ => grown,
        };
    }
    let whole = best.0.ended_by != EndedBy::Defects && best.0.rms() <= WORSE * coarse_rms;
    if let Some(nearer) = job.within_tolerance(&best.0, &accept, observer)? {
        let defects = defects_of(ranked, &nearer, kind)?;
        if defects.len() <= best.1.len() {
            best = (nearer, defects);
        }
    }
    let (fitted, defects) = best;
    Ok(Refined { kind, heights, fitted, map, defects, whole })
}

/// A surface, repaired if it folds or overshoots and more fairness mends that, and its defects.
fn mended(
    ranked: &Ranked<'_>,
    job: &Refinement<'_>,
    fitted: Fitted,
    observer: &mut dyn Observer,
) -> Result<(Fitted, Vec<Diagnostic>)> {
    let defects = defects_of(ranked, &fitted, job.kind)?;
    if !defects.is_empty()
        && defects.iter().all(smoothed)
        && job.heights.is_none()
        && job.options.fairness.is_none()
    {
        let wrong = |fitted: &Fitted| {
            let Fitted { surface, uv, .. } = fitted;
            Ok(!defects_on(ranked, surface, uv, job.kind, &sure())?.is_empty())
        };
        let found = repaired(job, &fitted, ranked.seen.noise(), wrong, observer)?;
        if let Some(better) = found {
            return Ok((better, Vec::new()));
        }
    }
    Ok((fitted, defects))
}

/// The defects that finer and repaired surfaces must not have: hardly any folds are left, so that no
/// finer look finds them.
fn sure() -> DefectSettings {
    let settings = DefectSettings::default();
    DefectSettings { folded: HARDLY * settings.folded, ..settings }
}

/// Whether more fairness may mend a defect.
fn smoothed(defect: &Diagnostic) -> bool {
    matches!(defect, Diagnostic::Folded { .. } | Diagnostic::Overshoot { .. })
}

/// The surface from nodes that were given, on which all points are projected.
fn from_nodes(
    ranked: &Ranked<'_>,
    nodes: &[DVec3],
    shape: (usize, usize),
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Refined> {
    let frame = ranked.cloud.frame;
    let kind = options.kind.unwrap_or(Kind::Sheet);
    let mut observer = LocalObserver { frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let nodes = nodes.iter().map(|node| frame.to_local(*node)).collect();
    let lattice = grid(shape, kind)?;
    let map = LearnedMap::learn(&ranked.cloud.points, lattice, MapInit::Given(nodes), observer)?;
    let lengths = [shape.0 as f64, shape.1 as f64];
    let heights = (kind == Kind::Height)
        .then(|| DVec3::AXES.map(|axis| frame.direction_to_local(axis).normalize()));
    let job = refinement(ranked, kind, heights, lengths, options);
    let fitted = job.fit_map(&map, observer)?;
    let defects = defects_of(ranked, &fitted, kind)?;
    Ok(Refined { kind, heights, fitted, map, defects, whole: true })
}

/// The defects of a surface on which all points have these parameters.
fn defects_on(
    ranked: &Ranked<'_>,
    surface: &NurbsSurface,
    uv: &[DVec2],
    kind: Kind,
    settings: &DefectSettings,
) -> Result<Vec<Diagnostic>> {
    let uv = items_at(uv, &ranked.chosen);
    let mut feet = vec![DVec3::ZERO; uv.len()];
    surface.evaluate(&uv, &mut feet, Outside::Refuse, &mut Silent)?;
    let distances: Vec<f64> =
        feet.iter().zip(ranked.sample).map(|(foot, point)| foot.distance(*point)).collect();
    let closed = kind.closed().into();
    let compared = Compared {
        seen: ranked.seen,
        tree: &ranked.tree,
        surface,
        closed,
        uv: &uv,
        distances: &distances,
    };
    let mut found = defects(&compared, &ranked.settings.terms, settings)?;
    let frame = &ranked.cloud.frame;
    for defect in &mut found {
        if let Diagnostic::Overshoot { distance: length, diagonal }
        | Diagnostic::Thick { rms: length, diagonal } = defect
        {
            *length = frame.length_to_given(*length);
            *diagonal = frame.length_to_given(*diagonal);
        }
    }
    Ok(found)
}

fn defects_of(ranked: &Ranked<'_>, fitted: &Fitted, kind: Kind) -> Result<Vec<Diagnostic>> {
    defects_on(ranked, &fitted.surface, &fitted.uv, kind, &DefectSettings::default())
}
