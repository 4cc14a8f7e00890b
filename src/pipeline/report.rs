//! The report of a reconstruction: kind, deviations, candidates, diagnostics, times.

use std::time::Duration;

use glam::DVec3;

use super::candidates::Candidate;
use super::point_deviations::{PointDeviations, count_missed};
use super::ranked_cloud::RankedCloud;
use super::surface_fit::SurfaceFit;
use crate::chart::Kind;
use crate::cloud::Bounds;
use crate::diagnostic::Diagnostic;
use crate::fit::EndedBy;
use crate::nurbs::NurbsSurface;
use crate::som::{SelfOrganizingMap, StoppedBy};
use crate::trim::Trim;

/// The report of a reconstruction. Lengths are in the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of points.
    pub points: usize,
    /// Number of points used in the fit, merged duplicates among them.
    pub inliers: usize,
    /// Length of the diagonal of the points' bounding box.
    pub diagonal: f64,
    /// Rows and columns of the control net.
    pub grid: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// Distances of the inliers from the surface.
    pub deviations: Deviations,
    /// The tolerance of the options.
    pub tolerance: Option<f64>,
    /// Share of the inliers that lie within the tolerance; `None` without one.
    pub within: Option<f64>,
    /// The reason why the net stopped growing.
    pub ended_by: EndedBy,
    /// Weight of the fairness in the final fit; `None` if nothing was fitted.
    pub fairness: Option<f64>,
    /// Number of solutions for the control net.
    pub iterations: usize,
    /// The kind of surface.
    pub kind: Kind,
    /// The direction of the heights in the points' frame; `None` unless it is a height field.
    pub direction: Option<DVec3>,
    /// Divisor of each coordinate for the fit; 1 unless the axes have different units.
    pub axis_scale: DVec3,
    /// Whether the surface has no defects.
    pub valid: bool,
    /// Whether the tolerance is reached; true without one. For the paper's method: whether training
    /// ended before `max_steps`.
    pub converged: bool,
    /// Every candidate with its score and its outcome, the best first.
    pub candidates: Vec<Candidate>,
    /// Findings about the points and the surface.
    pub diagnostics: Vec<Diagnostic>,
    /// Number of points that were merged with others at the same place.
    pub duplicates: usize,
    /// Number of points left out: outliers far from their neighbors or from the surface, and points
    /// with a no-data value.
    pub outliers: usize,
    /// The training of the map.
    pub training: TrainingReport,
    /// The trimmed faces; `None` if trimming was not asked for.
    pub trim: Option<TrimReport>,
    /// Wall time of each stage in seconds; their sum is that of the whole job.
    pub seconds: Vec<(&'static str, f64)>,
}

/// The results of the stages after the ranking, for the report.
pub(super) struct SurfaceFindings<'a> {
    pub(super) bounds: &'a Bounds,
    pub(super) kind: Kind,
    pub(super) direction: Option<DVec3>,
    pub(super) surface: &'a NurbsSurface,
    pub(super) fit: &'a SurfaceFit,
    pub(super) som: &'a SelfOrganizingMap,
    pub(super) measured: &'a PointDeviations,
    pub(super) candidates: Vec<Candidate>,
    pub(super) diagnostics: Vec<Diagnostic>,
    pub(super) trim: Option<TrimReport>,
}

impl Report {
    /// The report of a reconstruction with these findings.
    pub(super) fn of(
        found: SurfaceFindings<'_>,
        ranked: RankedCloud<'_>,
        tolerance: Option<f64>,
    ) -> Self {
        let SurfaceFindings { surface, fit, measured, som, diagnostics, .. } = found;
        let deviations = measured.inlier_deviations();
        let missed = tolerance.map(|tolerance| count_missed(&deviations, tolerance));
        let inliers = deviations.len();
        let no_data = ranked.cloud.no_data.as_ref().map_or(0, |found| found.count);
        Self {
            points: measured.deviations.len(),
            inliers,
            diagonal: found.bounds.diagonal(),
            grid: surface.shape(),
            degree: (surface.knots_u().degree(), surface.knots_v().degree()),
            deviations: Deviations::of(deviations),
            tolerance,
            within: missed.map(|missed| 1.0 - missed as f64 / inliers as f64),
            ended_by: if missed == Some(0) { EndedBy::Tolerance } else { fit.ended_by },
            fairness: Some(fit.fairness),
            iterations: fit.iterations,
            kind: found.kind,
            direction: found.direction,
            axis_scale: ranked.axis_scale,
            valid: !diagnostics.iter().any(Diagnostic::is_defect),
            converged: missed.unwrap_or(0) == 0,
            candidates: found.candidates,
            diagnostics,
            duplicates: ranked.cloud.merged.len(),
            outliers: measured.outliers(ranked.cloud).len() + no_data,
            training: TrainingReport::of(som, som.error.unwrap_or(f64::NAN)),
            trim: found.trim,
            seconds: ranked.times.seconds(),
        }
    }

    /// Adds the rest of the whole job's time as the stage `"other"`.
    pub(super) fn add_other_time(&mut self, elapsed: Duration) {
        let known: f64 = self.seconds.iter().map(|(_, seconds)| seconds).sum();
        self.seconds.push(("other", (elapsed.as_secs_f64() - known).max(0.0)));
    }
}

/// The faces of a surface, beside the points. Areas are in the square of the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimReport {
    /// Area of the faces.
    pub area: f64,
    /// Area of the whole surface.
    pub surface_area: f64,
    /// Area of each hole, the largest first.
    pub holes: Vec<f64>,
    /// Share of the points that lie more than 0.75 spacings outside of the faces. A spacing is the
    /// side of a square with one point.
    pub outside: f64,
    /// Share of the faces' area that is farther than 1.5 spacings from every point; `None` if
    /// there are too few points for a spacing.
    pub beyond: Option<f64>,
    /// The same share of the whole surface.
    pub beyond_untrimmed: Option<f64>,
}

impl TrimReport {
    /// The report of an untrimmed surface.
    pub(super) fn whole(area: f64, beyond: Option<f64>) -> Self {
        let (surface_area, beyond_untrimmed) = (area, beyond);
        Self { area, surface_area, holes: vec![], outside: 0.0, beyond, beyond_untrimmed }
    }

    /// The report of trimmed faces with these areas.
    pub(super) fn of(found: &Trim, (area, surface_area): (f64, f64), holes: Vec<f64>) -> Self {
        let &Trim { outside, beyond, beyond_untrimmed, .. } = found;
        Self { area, surface_area, holes, outside, beyond, beyond_untrimmed }
    }
}

/// The training of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingReport {
    /// Steps made: presentations of online training, epochs of batch training.
    pub steps: u64,
    /// The paper's t₀; see [`SelfOrganizingMap::ordered_at`].
    pub ordered_at: u64,
    /// The reason why training ended.
    pub stopped_by: StoppedBy,
    /// Number of points on the lattice at the end; see [`SelfOrganizingMap::reached`].
    pub reached: usize,
    /// Largest move of a node during the last epoch; `None` if no epoch was finished.
    pub change: Option<f64>,
    /// Mean distance from a point to its nearest node.
    pub quantization_error: f64,
}

impl TrainingReport {
    /// The training of this map.
    pub(super) fn of(som: &SelfOrganizingMap, quantization_error: f64) -> Self {
        Self {
            steps: som.steps,
            ordered_at: som.ordered_at,
            stopped_by: som.stopped_by,
            reached: som.reached,
            change: som.change,
            quantization_error,
        }
    }
}

/// The percentiles of [`Deviations::percentiles`], in percent.
pub const PERCENTILES: [u32; 4] = [50, 90, 95, 99];

/// Statistics of many distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviations {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest distance.
    pub max: f64,
    /// The distances that are not exceeded by each of [`PERCENTILES`] percent of the points.
    pub percentiles: [f64; 4],
}

impl Deviations {
    /// Statistics of these distances; zeros if there are none.
    pub(super) fn of(mut distances: Vec<f64>) -> Self {
        if distances.is_empty() {
            return Self { rms: 0.0, max: 0.0, percentiles: [0.0; 4] };
        }
        let count = distances.len();
        let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
        let max = distances.iter().copied().fold(0.0, f64::max);
        let mut rank = |percent: u32| {
            let place = (count * percent as usize).div_ceil(100) - 1;
            *distances.select_nth_unstable_by(place, f64::total_cmp).1
        };
        let percentiles = PERCENTILES.map(&mut rank);
        Self { rms: (squares / count as f64).sqrt(), max, percentiles }
    }
}
