//! Reconstruction: scattered points in, a NURBS surface out.

use std::time::Instant;

use glam::DVec3;

use super::axis_scale::choose_axes;
use super::diagnose::diagnose;
use super::options::ReconstructOptions;
use super::orientation::oriented;
use super::overall_progress::{Phase, before_phases};
use super::point_deviations::PointDeviations;
use super::ranked_cloud::{RankedCloud, with_ranked_cloud};
use super::reconstruction::Reconstruction;
use super::refine::{RefinedSurface, fit_problem};
use super::report::{Report, SurfaceFindings};
use super::select::select_best;
use super::trimmed::Trimmed;
use crate::cloud::{self, Bounds};
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

/// Turns scattered points into a NURBS surface; [`Reconstruction::tessellate`] turns that into
/// triangles.
///
/// Charts propose how points may lie on a surface. Coarse fits of their hypotheses are scored. The
/// best is refined: a map is trained from it, and least squares with fairness and parameter
/// correction fit a net that grows. Loops around the points bound the faces.
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
    let mut result = worker_pool::run_observed(points.len(), observer, |observer| {
        let bounds = cloud::checked_extent(points, &mut before_phases(observer))?;
        let axes = choose_axes(points, options, observer)?;
        with_ranked_cloud(points, axes, options, observer, |ranked, observer| {
            finish(points, &bounds, ranked, options, observer)
        })
    })?;
    result.report.add_other_time(started.elapsed());
    Ok(result)
}

/// The stages after the ranking: refine, move to the given frame, orient, measure, diagnose, trim,
/// report.
fn finish(
    points: &[DVec3],
    bounds: &Bounds,
    mut ranked: RankedCloud<'_>,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let mut candidates = ranked.candidates();
    let sampled = ranked.sample.len();
    let mut phase = Phase::Refine.observed(points.len(), sampled, observer);
    let refined = select_best(&ranked, options, &mut candidates, &mut phase)?;
    // Selection refines the candidates, so both are one stage.
    ranked.times.end_stage("refine");

    let RefinedSurface { kind, heights, mut fit, map, defects, .. } = refined;
    let frame = ranked.cloud.frame;
    let observer: &mut dyn Observer = &mut Phase::Measure.observed(points.len(), sampled, observer);
    if options.rational {
        let problem = fit_problem(&ranked, kind, heights, [1.0; 2], options);
        fit = problem.fit_weights(fit, observer)?;
    }
    let surface = fit.surface.map_control_points(|point| frame.to_given(point))?;
    let surface = oriented(surface, &mut fit.uv, kind, observer)?;
    let closed = kind.closed();
    let measured = PointDeviations::of(points, ranked.cloud, &fit, &surface, closed, observer)?;
    let mut diagnostics = defects;
    diagnostics.extend(diagnose(points, &ranked, options, kind, &fit, &measured));
    let (som, som_options) = map.in_given_frame(&frame, observer)?;
    ranked.times.end_stage("measure");

    let observer: &mut dyn Observer = &mut Phase::Trim.observed(points.len(), sampled, observer);
    let (uv, scale) = (measured.inlier_parameters(), ranked.axis_scale);
    let trimmed = Trimmed::of(&surface, scale, &uv, options.trim, observer)?;
    diagnostics.extend(trimmed.diagnostics);
    ranked.times.end_stage("trim");

    let findings = SurfaceFindings {
        bounds,
        kind,
        direction: heights.map(|axes| ranked.given_direction(axes[2])),
        surface: &surface,
        fit: &fit,
        som: &som,
        measured: &measured,
        candidates,
        diagnostics,
        trim: trimmed.report,
    };
    let report = Report::of(findings, ranked, options.tolerance);
    let PointDeviations { uv, deviations, inliers } = measured;
    let shell = trimmed.shell;
    Ok(Reconstruction { surface, shell, som, som_options, uv, deviations, inliers, report })
}
