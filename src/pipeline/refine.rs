//! Refinement of one hypothesis: from its coarse fit to the final surface with its defects.

use glam::{DVec2, DVec3};

use super::diagnose::strays_from_points;
use super::fit_problem::FitProblem;
use super::options::ReconstructOptions;
use super::projection::Projection;
use super::ranked_cloud::RankedCloud;
use super::ranking::Model;
use super::repair::repaired;
use super::settings::SelectionSettings;
use super::surface_fit::SurfaceFit;
use super::trained_map::{TrainedMap, lattice};
use crate::chart::Kind;
use crate::cloud::{LocalObserver, items_at};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::fit::{EndedBy, MAD_TO_DEVIATION, isocurve_lengths};
use crate::numeric::rms;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::{Observer, Silent};
use crate::validate::{Comparison, DefectSettings, defects};

const SETTINGS: SelectionSettings = SelectionSettings::STANDARD;

/// The limits for finer and repaired surfaces: far fewer folds than make a surface invalid, so that
/// a finer grid finds none either.
const STRICT: DefectSettings = DefectSettings {
    max_folded: SETTINGS.residual_fold_share * DefectSettings::STANDARD.max_folded,
    ..DefectSettings::STANDARD
};

/// A refined surface with its defects.
pub(super) struct RefinedSurface {
    pub(super) kind: Kind,
    /// Axes of a height field: two in its plane, and the direction of the heights.
    pub(super) heights: Option<[DVec3; 3]>,
    pub(super) fit: SurfaceFit,
    pub(super) map: TrainedMap,
    pub(super) defects: Vec<Diagnostic>,
    /// Whether its net grew as far as the points determine it, and it is as near to the points as
    /// the coarse surface.
    pub(super) complete: bool,
}

impl RefinedSurface {
    /// Whether it has no defects, and the other has some or is farther from the points.
    ///
    /// A complete surface may be farther by the ratio of the settings.
    pub(super) fn is_better_than(&self, other: &Self) -> bool {
        let ratio = if self.complete { SETTINGS.max_error_ratio } else { 1.0 };
        let near = self.fit.error() < ratio * other.fit.error();
        self.defects.is_empty() && (near || !other.defects.is_empty())
    }
}

/// The fit of a model's initial net.
pub(super) struct FirstFit<'a> {
    model: &'a Model,
    problem: FitProblem<'a>,
    fit: SurfaceFit,
    defects: Vec<Diagnostic>,
    coarse_rms: f64,
}

/// The problem of fitting all points by a surface of this kind and these lengths.
pub(super) fn fit_problem<'a>(
    ranked: &'a RankedCloud<'_>,
    kind: Kind,
    heights: Option<[DVec3; 3]>,
    lengths: [f64; 2],
    options: &'a ReconstructOptions<'a>,
) -> FitProblem<'a> {
    FitProblem {
        points: &ranked.cloud.points,
        weights: ranked.cloud.weights.as_deref(),
        kind,
        heights,
        lengths,
        // Half of normal noise lies within its median.
        noise: ranked.observations.noise() / MAD_TO_DEVIATION,
        spacing: ranked.observations.spacing(),
        tolerance: options.tolerance.map(|length| ranked.cloud.frame.length_to_local(length)),
        options,
    }
}

/// Fits the initial net of a model to all points.
pub(super) fn first_fit<'a>(
    ranked: &'a RankedCloud<'_>,
    model: &'a Model,
    options: &'a ReconstructOptions<'a>,
    observer: &mut dyn Observer,
) -> Result<FirstFit<'a>> {
    let (kind, heights) = (model.hypothesis.kind, model.hypothesis.heights);
    let mut observer = LocalObserver { frame: ranked.cloud.frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let coarse = &model.fit.surface;
    let problem = fit_problem(ranked, kind, heights, isocurve_lengths(coarse).into(), options);
    let projection = Projection::onto_model(problem.points, ranked.sample, model, observer)?;
    let coarse_rms = rms(projection.distances.iter().copied());
    let fit = problem.fit_initial_net(&projection, observer)?;
    let (fit, defects) = with_repair(ranked, &problem, fit, observer)?;
    Ok(FirstFit { model, problem, fit, defects, coarse_rms })
}

impl FirstFit<'_> {
    /// Whether it is much nearer than the coarse surface. Then the coarse order says little, and
    /// another hypothesis may be nearer still.
    pub(super) fn is_much_nearer_than_coarse(&self) -> bool {
        SETTINGS.max_error_ratio * self.error() < self.model.fit.held_out[0]
    }

    /// Root mean square distance to be expected of held-out points; infinite with defects.
    pub(super) fn error(&self) -> f64 {
        if self.defects.is_empty() { self.fit.error() } else { f64::INFINITY }
    }
}

/// Refines a first fit: grows its net, repairs it, and follows the tolerance.
pub(super) fn refine(
    ranked: &RankedCloud<'_>,
    first: FirstFit<'_>,
    observer: &mut dyn Observer,
) -> Result<RefinedSurface> {
    let FirstFit { model, problem, fit, defects, coarse_rms } = first;
    let (kind, heights) = (problem.kind, problem.heights);
    let mut observer = LocalObserver { frame: ranked.cloud.frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let mut best = (fit, defects);
    let accept = |surface: &NurbsSurface, uv: &[DVec2]| {
        Ok(defects_on(ranked, surface, uv, kind, &STRICT)?.is_empty())
    };
    if best.1.is_empty() {
        best.0 = match problem.grow(best.0, &accept, observer)? {
            (finest, None) => finest,
            // The finest net has defects. It stays if more fairness repairs it.
            (finest, Some(accepted)) => {
                let ended_by = finest.ended_by;
                match with_repair(ranked, &problem, finest, observer)? {
                    (fit, defects) if defects.is_empty() && fit.rms() < accepted.rms() => {
                        SurfaceFit { ended_by, ..fit }
                    }
                    _ => accepted,
                }
            }
        };
    }
    let complete = best.0.ended_by != EndedBy::Defects
        && best.0.rms() <= SETTINGS.max_error_ratio * coarse_rms
        && strays_from_points(ranked, problem.options, &best.0).is_none();
    if let Some(nearer) = problem.grow_to_tolerance(&best.0, &accept, observer)? {
        let defects = defects_of(ranked, &nearer, kind)?;
        if defects.len() <= best.1.len() {
            best = (nearer, defects);
        }
    }
    let (mut fit, defects) = best;
    if fit.ended_by == EndedBy::Grid && problem.options.grid.is_none() {
        // The initial net has defects, so it did not grow.
        fit.ended_by = EndedBy::Defects;
    }
    let (coarse, shape) = (&model.fit.surface, problem.initial_shape());
    let map = TrainedMap::on_surface(problem.points, coarse, kind, shape, observer)?;
    Ok(RefinedSurface { kind, heights, fit, map, defects, complete })
}

/// Repairs a fit if more fairness may remove all of its defects. Returns it with those that are
/// left.
fn with_repair(
    ranked: &RankedCloud<'_>,
    problem: &FitProblem<'_>,
    fit: SurfaceFit,
    observer: &mut dyn Observer,
) -> Result<(SurfaceFit, Vec<Diagnostic>)> {
    let defects = defects_of(ranked, &fit, problem.kind)?;
    if !defects.is_empty()
        && defects.iter().all(fairness_may_remove)
        && problem.heights.is_none()
        && problem.options.fairness.is_none()
    {
        let has_defects = |fit: &SurfaceFit| {
            Ok(!defects_on(ranked, &fit.surface, &fit.uv, problem.kind, &STRICT)?.is_empty())
        };
        let max_rms = SETTINGS.max_error_ratio * fit.rms().max(ranked.observations.noise());
        let found = repaired(problem, &fit, max_rms, has_defects, observer)?;
        if let Some(better) = found {
            return Ok((better, Vec::new()));
        }
    }
    Ok((fit, defects))
}

/// Whether more fairness may remove a defect.
fn fairness_may_remove(defect: &Diagnostic) -> bool {
    matches!(defect, Diagnostic::Folded { .. } | Diagnostic::Overshoot { .. })
}

/// Fits a surface from given nodes: a map is trained from them, and all points are fitted from it.
pub(super) fn refine_from_nodes(
    ranked: &RankedCloud<'_>,
    nodes: &[DVec3],
    shape: (usize, usize),
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<RefinedSurface> {
    let frame = ranked.cloud.frame;
    let kind = options.kind.unwrap_or(Kind::Sheet);
    let mut observer = LocalObserver { frame, observer };
    let observer: &mut dyn Observer = &mut observer;
    let nodes = nodes.iter().map(|node| frame.to_local(*node)).collect();
    let lattice = lattice(shape, kind)?;
    let map = TrainedMap::train(&ranked.cloud.points, lattice, nodes, observer)?;
    let lengths = [shape.0 as f64, shape.1 as f64];
    let heights = (kind == Kind::Height)
        .then(|| DVec3::AXES.map(|axis| frame.direction_to_local(axis).normalize()));
    let problem = fit_problem(ranked, kind, heights, lengths, options);
    let fit = problem.fit_map(&map, observer)?;
    let defects = defects_of(ranked, &fit, kind)?;
    Ok(RefinedSurface { kind, heights, fit, map, defects, complete: true })
}

/// The defects of a surface on which all points have these parameters, found on the sample.
fn defects_on(
    ranked: &RankedCloud<'_>,
    surface: &NurbsSurface,
    uv: &[DVec2],
    kind: Kind,
    settings: &DefectSettings,
) -> Result<Vec<Diagnostic>> {
    let uv = items_at(uv, &ranked.sample_indices);
    let mut projections = vec![DVec3::ZERO; uv.len()];
    surface.evaluate(&uv, &mut projections, Outside::Refuse, &mut Silent)?;
    let pairs = projections.iter().zip(ranked.sample);
    let distances: Vec<f64> = pairs.map(|(on, point)| on.distance(*point)).collect();
    let closed = kind.closed().into();
    let compared = Comparison {
        observations: ranked.observations,
        tree: &ranked.tree,
        surface,
        closed,
        uv: &uv,
        distances: &distances,
    };
    let mut found = defects(&compared, ranked.diagonal, &ranked.settings.terms, settings)?;
    // Heights cannot fold. Along tracks, local planes may stand on edge.
    found.retain(|defect| kind != Kind::Height || !matches!(defect, Diagnostic::Folded { .. }));
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

/// The defects of a fit.
fn defects_of(ranked: &RankedCloud<'_>, fit: &SurfaceFit, kind: Kind) -> Result<Vec<Diagnostic>> {
    defects_on(ranked, &fit.surface, &fit.uv, kind, &DefectSettings::STANDARD)
}
