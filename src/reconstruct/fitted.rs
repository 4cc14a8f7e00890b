//! The method "fit": an ordered map gives parameters, least squares give the surface.

use glam::DVec3;

use super::order::{every, outwards, restored};
use super::report::{Clock, Distances, Report, TrainingReport};
use super::start::{LEAST_SIDE, OrderedStart, in_own_frame, learn};
use super::{ReconstructOptions, Reconstruction};
use crate::error::Result;
use crate::fit::{ApproximateOptions, EndedBy, Growth, approximate, bounded};
use crate::point_cloud::{Bounds, Normalization};
use crate::progress::Observer;

/// Points that the map learns from: more would not move it visibly.
const MAP_POINTS: usize = 20_000;

/// How far beyond the lattice's border points may lie, in cells.
const EXTRAPOLATION: f64 = 0.75;

/// How far the surface goes on beyond the points by default, in their mean spacings.
const BORDER: f64 = 0.5;

/// Points for each control point of the net that growth begins with, and its longest side.
const POINTS_PER_FIRST: f64 = 20.0;
const FIRST_SIDE: usize = 12;

pub(super) fn reconstruct(
    points: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let mut clock = Clock::start();
    let frame = Normalization::of(points);
    let order = outwards(points, &frame);
    let local: Vec<DVec3> =
        order.iter().map(|&index| frame.apply(points[index as usize])).collect();
    let sample: Vec<DVec3> = every(&local, MAP_POINTS).copied().collect();
    let budget = options.grid.unwrap_or_else(|| default_grid(points.len()));
    let start = OrderedStart::of(&sample, budget, options, observer)?;
    clock.lap("ordering");
    let map = learn(&sample, &start, observer)?;
    let places = map.parametrize(&local, EXTRAPOLATION, observer)?;
    let uv = bounded(&places, options.topology.closed());
    clock.lap("training");
    let degree = |side: usize| options.degree.min(side - 1);
    let approximation = ApproximateOptions {
        net: start.net,
        degree: (degree(start.net.0), degree(start.net.1)),
        closed: options.topology.closed(),
        fairness: options.fairness,
        border: options.border.unwrap_or(BORDER),
        growth: growth(options, &frame),
        ..ApproximateOptions::default()
    };
    let found = approximate(&local, &uv, None, &approximation, observer)?;
    clock.lap("fitting");
    let surface = found.surface.map_control_points(|point| frame.undo(point))?;
    let distances: Vec<f64> = found.distances.iter().map(|d| d / frame.scale).collect();
    let (uv, distances) = (restored(&found.uv, &order), restored(&distances, &order));
    let som = in_own_frame(&map, &sample, &frame, observer)?;
    let far = |tolerance| distances.iter().filter(|distance| **distance > tolerance).count();
    let warnings =
        shortcomings(found.ended_by, options.tolerance, options.tolerance.map_or(0, far));
    let within = |tolerance| 1.0 - far(tolerance) as f64 / points.len() as f64;
    let report = Report {
        points: points.len(),
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        distances: Distances::of(&distances),
        tolerance: options.tolerance,
        within: options.tolerance.map(within),
        ended_by: found.ended_by,
        fairness: Some(found.fairness),
        iterations: found.iterations,
        training: TrainingReport::of(&som, map.error.unwrap_or(f64::NAN) / frame.scale),
        warnings,
        times: clock.times(),
    };
    Ok(Reconstruction { surface, som, uv, distances, report })
}

/// The net that growth begins with: few control points, but no fewer than the degree needs.
fn default_grid(count: usize) -> (usize, usize) {
    let side = ((count as f64 / POINTS_PER_FIRST).sqrt() as usize).clamp(LEAST_SIDE, FIRST_SIDE);
    (side, side)
}

/// How far the net grows, in the frame; not at all where its size was given without a tolerance.
fn growth(options: &ReconstructOptions, frame: &Normalization) -> Option<Growth> {
    let tolerance = options.tolerance.map(|tolerance| tolerance * frame.scale);
    let free = options.grid.is_none() || tolerance.is_some();
    free.then_some(Growth { tolerance, most: options.max_control_points })
}

/// What is to be said of a fit that did not come out as it was asked for.
fn shortcomings(ended_by: EndedBy, tolerance: Option<f64>, far: usize) -> Vec<String> {
    let Some(tolerance) = tolerance else { return Vec::new() };
    let why = match ended_by {
        EndedBy::Noise => "a larger net would follow the noise of the points: raise the tolerance",
        EndedBy::Points => "the points hold no more control points: raise the tolerance",
        EndedBy::MaxControlPoints => "the net may have no more: raise max_control_points",
        EndedBy::Tolerance | EndedBy::Exact | EndedBy::Grid => return Vec::new(),
    };
    vec![format!("{far} points lie farther than the tolerance {tolerance} from the surface; {why}")]
}
