//! The paper's method: the codebook of a trained lattice becomes the surface.

use std::time::Instant;

use glam::DVec3;

use super::reconstruction::Reconstruction;
use super::report::{Deviations, Report, TrainingReport};
use super::stage_times::StageTimes;
use crate::brep::Shell;
use crate::chart::Kind;
use crate::cloud::{self, Bounds};
use crate::diagnostic::Diagnostic;
use crate::error::Result;
use crate::fit::EndedBy;
use crate::nurbs::{ClosestPointSearch, OrderedSurface, check_degree};
use crate::progress::Observer;
use crate::som::{Lattice, SelfOrganizingMap, SomOptions, StoppedBy};
use crate::worker_pool;

/// Rows and columns of the default lattice of a Bézier surface, at most. With more, the surface
/// stays far from its nodes, since each node moves most of it.
const MAX_BEZIER_SIDE: usize = 10;

/// Options of [`reconstruct_paper`]. The default derives everything from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperOptions {
    /// Rows and columns of the lattice; `None`: those of [`Lattice::for_points`], for a Bézier
    /// surface up to 10.
    pub grid: Option<(usize, usize)>,
    /// Degree of the surface in both directions, lowered where the lattice has too few rows or
    /// columns for it. A Bézier surface's degrees are one less than rows and columns.
    pub degree: usize,
    /// How the surface is made from the lattice.
    pub surface: OrderedSurface,
    /// See [`SomOptions::max_steps`].
    pub max_steps: Option<u64>,
    /// See [`SomOptions::reach`]; in the points' unit.
    pub reach: Option<f64>,
    /// See [`SomOptions::min_change`]; in the points' unit.
    pub min_change: Option<f64>,
    /// Seed of the random numbers; the same seed gives the same bits.
    pub seed: u64,
}

impl Default for PaperOptions {
    fn default() -> Self {
        Self {
            grid: None,
            degree: 3,
            surface: OrderedSurface::ControlNet,
            max_steps: None,
            reach: None,
            min_change: None,
            seed: 0,
        }
    }
}

/// Reconstructs by the paper's method alone.
///
/// A Kohonen network is trained on the points (the paper's section 4). Its lattice becomes the
/// control net of a clamped B-spline surface, a grid to interpolate, or a Bézier net (section 5).
/// Ordered points need no network: use [`OrderedSurface::through`].
///
/// # Errors
///
/// Those of [`cloud::check`]; [`crate::Error::Parameter`] for an option out of its range;
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn reconstruct_paper(
    points: &[DVec3],
    options: &PaperOptions,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let started = Instant::now();
    check_degree(options.degree)?;
    let mut found = worker_pool::run_observed(points.len(), observer, |observer| {
        let bounds = cloud::checked_bounds(points, observer)?;
        run(points, &bounds, options, observer)
    })?;
    found.report.add_other_time(started.elapsed());
    Ok(found)
}

/// Trains the network, makes the surface and measures the deviations.
fn run(
    points: &[DVec3],
    bounds: &Bounds,
    options: &PaperOptions,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let mut times = StageTimes::start();
    let som_options = SomOptions {
        seed: options.seed,
        max_steps: options.max_steps,
        reach: options.reach,
        min_change: options.min_change,
        ..SomOptions::paper()
    };
    let som = train(points, bounds, options, &som_options, observer)?;
    let quantization_error = som.quantization_error(points, observer)?;
    times.end_stage("train");
    let surface = options.surface.through(som.codebook(), som.lattice.shape(), options.degree)?;
    let (uv, deviations) =
        ClosestPointSearch::new(&surface)?.closest_parameters(points, observer)?;
    times.end_stage("measure");
    let converged = som.stopped_by != StoppedBy::MaxSteps;
    let not_settled = Diagnostic::NotSettled { steps: som.steps, change: som.change };
    let report = Report {
        points: points.len(),
        inliers: points.len(),
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        deviations: Deviations::of(deviations.clone()),
        tolerance: None,
        within: None,
        ended_by: EndedBy::Grid,
        fairness: None,
        iterations: 0,
        training: TrainingReport::of(&som, quantization_error),
        kind: Kind::Sheet,
        direction: None,
        axis_scale: DVec3::ONE,
        valid: true,
        converged,
        candidates: Vec::new(),
        diagnostics: if converged { Vec::new() } else { vec![not_settled] },
        duplicates: 0,
        outliers: 0,
        trim: None,
        seconds: times.seconds(),
    };
    let inliers = vec![true; points.len()];
    let shell = Shell::whole(surface.clone())?;
    Ok(Reconstruction { surface, shell, som, som_options, uv, deviations, inliers, report })
}

/// Trains the network on the points.
fn train(
    points: &[DVec3],
    bounds: &Bounds,
    options: &PaperOptions,
    som_options: &SomOptions,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let lattice = match options.grid {
        Some((rows, cols)) => Lattice::quad(rows, cols)?,
        None if options.surface == OrderedSurface::Bezier => {
            let (rows, cols) = Lattice::for_points(points.len()).shape();
            Lattice::quad(rows.min(MAX_BEZIER_SIDE), cols.min(MAX_BEZIER_SIDE))?
        }
        None => Lattice::for_points(points.len()),
    };
    options.surface.check_shape(lattice.shape())?;
    SelfOrganizingMap::fit_within(bounds, points, lattice, som_options, observer)
}
