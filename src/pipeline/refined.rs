//! The refined surface of a hypothesis, and its defects.

use glam::{DVec2, DVec3};

use super::diagnose::astray;
use super::fitted::Fitted;
use super::map::{LearnedMap, grid};
use super::options::ReconstructOptions;
use super::ranked::Ranked;
use super::refine::Refinement;
use super::repair::repaired;
use super::select::Model;
use super::start::Start;
use crate::chart::Kind;
use crate::cloud::{LocalObserver, items_at};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::fit::{EndedBy, MAD_TO_DEVIATION, isocurve_lengths};
use crate::numeric::rms;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::{Observer, Silent};
use crate::som::Init as MapInit;
use crate::validate::{Compared, DefectSettings, defects};

/// Distance of the points from a surface, in that from another, from which on it is worse.
const WORSE: f64 = 1.2;

/// Share of the folds that make a surface invalid which may be left after a repair.
const HARDLY: f64 = 0.25;

/// A refined surface with what is wrong with it.
pub(super) struct Refined {
    pub(super) kind: Kind,
    pub(super) heights: Option<[DVec3; 3]>,
    pub(super) fitted: Fitted,
    pub(super) map: LearnedMap,
    pub(super) defects: Vec<Diagnostic>,
    /// Whether it has grown as far as the points hold, follows them, and is no farther from them than
    /// the coarse surface that it comes from.
    pub(super) whole: bool,
}

impl Refined {
    /// Whether it has no defects where another has; or neither has, and it is nearer, or whole and
    /// about as near.
    pub(super) fn is_better_than(&self, other: &Self) -> bool {
        let least = if self.whole { WORSE } else { 1.0 };
        let near = self.fitted.error() < least * other.fitted.error();
        self.defects.is_empty() && (near || !other.defects.is_empty())
    }
}

/// The surface with the net that growth begins with, beside what it comes from.
pub(super) struct Begun<'a> {
    model: &'a Model,
    job: Refinement<'a>,
    small: Fitted,
    defects: Vec<Diagnostic>,
    coarse_rms: f64,
}

pub(super) fn refinement<'a>(
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
        noise: ranked.seen.noise() / MAD_TO_DEVIATION,
        spacing: ranked.seen.spacing(),
        tolerance: options.tolerance.map(|length| ranked.cloud.frame.length_to_local(length)),
        options,
    }
}

/// The first fit of a model.
pub(super) fn begin<'a>(
    ranked: &'a Ranked<'_>,
    model: &'a Model,
    options: &'a ReconstructOptions<'a>,
    observer: &mut dyn Observer,
) -> Result<Begun<'a>> {
    let (kind, heights) = (model.hypothesis.kind, model.hypothesis.heights);
    let mut observer = LocalObserver { frame: ranked.cloud.frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let coarse = &model.fit.surface;
    let job = refinement(ranked, kind, heights, isocurve_lengths(coarse).into(), options);
    let start = Start::of(job.points, ranked.sample, model, observer)?;
    let coarse_rms = rms(start.distances.iter().copied());
    let small = job.fit(&start, observer)?;
    let (small, defects) = mended(ranked, &job, small, observer)?;
    Ok(Begun { model, job, small, defects, coarse_rms })
}

impl Begun<'_> {
    /// Whether it is much nearer than the coarse surface: others may be nearer still.
    pub(super) fn tells_more(&self) -> bool {
        WORSE * self.error() < self.model.fit.held_out[0]
    }

    /// Root mean square distance to be expected of points left out, of a surface without defects.
    pub(super) fn error(&self) -> f64 {
        if self.defects.is_empty() { self.small.error() } else { f64::INFINITY }
    }
}

/// The refined surface that a first fit becomes.
pub(super) fn refine(
    ranked: &Ranked<'_>,
    begun: Begun<'_>,
    observer: &mut dyn Observer,
) -> Result<Refined> {
    let Begun { model, job, small, defects, coarse_rms } = begun;
    let (kind, heights) = (job.kind, job.heights);
    let mut observer = LocalObserver { frame: ranked.cloud.frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let mut best = (small, defects);
    // A finer net must bring no defects, or none that more fairness does not mend.
    let accept = |surface: &NurbsSurface, uv: &[DVec2]| {
        Ok(defects_on(ranked, surface, uv, kind, &sure())?.is_empty())
    };
    if best.1.is_empty() {
        best.0 = match job.grown(best.0, &accept, observer)? {
            (all, None) => all,
            (all, Some(accepted)) => match mended(ranked, &job, all, observer)? {
                (all, defects) if defects.is_empty() && all.rms() < accepted.rms() => all,
                _ => accepted,
            },
        };
    }
    let whole = best.0.ended_by != EndedBy::Defects
        && best.0.rms() <= WORSE * coarse_rms
        && astray(ranked, job.options, &best.0).is_none();
    if let Some(nearer) = job.within_tolerance(&best.0, &accept, observer)? {
        let defects = defects_of(ranked, &nearer, kind)?;
        if defects.len() <= best.1.len() {
            best = (nearer, defects);
        }
    }
    let (fitted, defects) = best;
    let map = LearnedMap::on_surface(job.points, &model.fit.surface, kind, job.net(), observer)?;
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
        let limit = WORSE * fitted.rms().max(ranked.seen.noise());
        let found = repaired(job, &fitted, limit, wrong, observer)?;
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
pub(super) fn from_nodes(
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
        diagonal: ranked.diagonal,
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
