//! The paper's method: the trained lattice becomes the surface.

use glam::DVec3;

use super::feet::feet;
use super::report::{Clock, Distances, Report, TrainingReport};
use super::{ReconstructOptions, Reconstruction};
use crate::cloud::Bounds;
use crate::error::Result;
use crate::fit::EndedBy;
use crate::nurbs::{MAX_DEGREE, OrderedSurface};
use crate::progress::Observer;
use crate::som::{Lattice, SelfOrganizingMap, SomOptions};
use crate::topology::Kind;

/// A Kohonen network learns the points (the paper's section 4), and its lattice becomes the control
/// net of a clamped B-spline surface, a grid to interpolate, or a Bézier net (section 5).
pub(super) fn reconstruct(
    points: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let mut clock = Clock::start();
    let som = learn(points, bounds, options, observer)?;
    let quantization_error = som.quantization_error(points, observer)?;
    clock.lap("training");
    let surface = options.surface.through(som.codebook(), som.lattice.shape(), options.degree)?;
    let (uv, distances) = feet(&surface, points, observer)?;
    clock.lap("measuring");
    let report = Report {
        points: points.len(),
        inliers: points.len(),
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        distances: Distances::of(distances.clone()),
        tolerance: None,
        within: None,
        ended_by: EndedBy::Grid,
        fairness: None,
        iterations: 0,
        training: TrainingReport::of(&som, quantization_error),
        topology: Kind::Sheet,
        topology_reason: None,
        duplicates: 0,
        outliers: 0,
        warnings: Vec::new(),
        times: clock.times(),
    };
    let inliers = vec![true; points.len()];
    Ok(Reconstruction { surface, som, uv, distances, inliers, report })
}

fn learn(
    points: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions<'_>,
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
