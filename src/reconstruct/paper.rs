//! The paper's method: the trained lattice becomes the surface.

use glam::DVec3;

use super::report::{Clock, Distances, Report, TrainingReport};
use super::{ReconstructOptions, Reconstruction};
use crate::error::Result;
use crate::fit::EndedBy;
use crate::nurbs::{ClosestPointSearch, ClosestPointSlices, MAX_DEGREE, OrderedSurface};
use crate::point_cloud::Bounds;
use crate::progress::Observer;
use crate::som::{Lattice, SelfOrganizingMap, SomOptions};

/// A Kohonen network learns the points (the paper's section 4), and its lattice becomes the control
/// net of a clamped B-spline surface, a grid to interpolate, or a Bézier net (section 5).
pub(super) fn reconstruct(
    points: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let mut clock = Clock::start();
    let som = learn(points, bounds, options, observer)?;
    let quantization_error = som.quantization_error(points, observer)?;
    clock.lap("training");
    let surface = options.surface.through(som.codebook(), som.lattice.shape(), options.degree)?;
    let count = points.len();
    let (mut uv, mut feet) = (vec![Default::default(); count], vec![DVec3::ZERO; count]);
    let (mut distances, mut converged) = (vec![0.0; count], vec![false; count]);
    let found = ClosestPointSlices {
        uv: &mut uv,
        points: &mut feet,
        distances: &mut distances,
        converged: &mut converged,
    };
    ClosestPointSearch::new(&surface)?.closest_points(points, found, observer)?;
    clock.lap("measuring");
    let report = Report {
        points: points.len(),
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        distances: Distances::of(&distances),
        tolerance: None,
        within: None,
        ended_by: EndedBy::Grid,
        fairness: None,
        iterations: 0,
        training: TrainingReport::of(&som, quantization_error),
        warnings: Vec::new(),
        times: clock.times(),
    };
    Ok(Reconstruction { surface, som, uv, distances, report })
}

fn learn(
    points: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let lattice = match options.grid {
        Some((rows, cols)) => Lattice::quad(rows, cols)?,
        None if options.surface == OrderedSurface::Bezier => {
            let (rows, cols) = Lattice::for_points(points.len()).shape();
            Lattice::quad(rows.min(MAX_DEGREE + 1), cols.min(MAX_DEGREE + 1))?
        }
        None => Lattice::for_points(points.len()),
    };
    options.surface.check_shape(lattice.shape())?;
    let som_options = SomOptions {
        seed: options.seed,
        max_steps: options.max_steps,
        reach: options.reach,
        min_change: options.min_change,
        ..SomOptions::paper()
    };
    SelfOrganizingMap::fit_within(bounds, points, lattice, &som_options, observer)
}
