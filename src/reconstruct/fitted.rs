//! The method "fit": an ordered map gives parameters, least squares give the surface.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use super::outline;
use super::report::{Clock, Distances, Report, TrainingReport};
use super::{Aspect, ReconstructOptions, Reconstruction};
use crate::error::Result;
use crate::fit::{ApproximateOptions, EndedBy, Growth, approximate, bounded};
use crate::point_cloud::{self, Bounds, Normalization};
use crate::progress::Observer;
use crate::som::{self, Init, Kernel, Lattice, Schedule, SelfOrganizingMap, SomOptions, Topology};

/// Points that the map learns from: more would not move it visibly.
const MAP_POINTS: usize = 20_000;

/// Points that distances along the surface are found for.
const UNROLLED: usize = 1000;

/// Least number of points to a node, so that the map does not follow single ones.
const POINTS_PER_NODE: usize = 3;

/// Epochs of the map from its ordered start, and the radius it begins and ends with, in cells.
const EPOCHS: u64 = 10;
const RADIUS: (f64, f64) = (1.0, 0.7);

/// How far beyond the lattice's border points may lie, in cells.
const EXTRAPOLATION: f64 = 0.75;

/// How far the surface goes on beyond the points by default, in their mean spacings.
const BORDER: f64 = 0.5;

/// Points for each control point of the net that growth begins with, and its longest side.
const POINTS_PER_FIRST: f64 = 20.0;
const FIRST_SIDE: usize = 12;

/// Least number of control points in a direction for which a degree is kept.
const LEAST_SIDE: usize = 4;

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

/// The order of the points by their distance from the centroid, the farthest first: equal steps in
/// it are spread evenly over the cloud, and depend neither on how the points were ordered nor on how
/// they lie in space.
fn outwards(points: &[DVec3], frame: &Normalization) -> Vec<u32> {
    let centre = point_cloud::centroid(points);
    let key = |(index, point): (u32, &DVec3)| {
        let local = frame.scale * (*point - centre);
        (local.length_squared(), index)
    };
    let mut keyed: Vec<(f64, u32)> = (0..).zip(points).map(key).collect();
    let coordinates = |index: u32| points[index as usize].to_array();
    keyed.par_sort_unstable_by(|a, b| {
        let [x, y] = [a, b].map(|key| coordinates(key.1));
        let places = x.iter().zip(&y).map(|(x, y)| x.total_cmp(y));
        let equal = b.0.total_cmp(&a.0);
        places.fold(equal, Ordering::then).then(a.1.cmp(&b.1))
    });
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Brings what belongs to points in an order back into that of the points.
fn restored<T: Copy + Default>(values: &[T], order: &[u32]) -> Vec<T> {
    let mut restored = vec![T::default(); values.len()];
    for (value, &index) in values.iter().zip(order) {
        restored[index as usize] = *value;
    }
    restored
}

/// At most `count` items at equal steps.
fn every<T>(items: &[T], count: usize) -> impl Iterator<Item = &T> {
    let taken = items.len().min(count);
    (0..taken).map(move |i| &items[i * items.len() / taken])
}

/// Where the lattice lies before it learns, and the net that the surface will have.
struct OrderedStart {
    lattice: Lattice,
    nodes: Vec<DVec3>,
    net: (usize, usize),
}

impl OrderedStart {
    fn of(
        sample: &[DVec3],
        budget: (usize, usize),
        options: &ReconstructOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let split = |aspect: f64| match options.aspect {
            Aspect::Data => split(budget.0 * budget.1, aspect),
            Aspect::Fixed => budget,
        };
        if options.topology == Topology::Sheet {
            let few: Vec<DVec3> = every(sample, UNROLLED).copied().collect();
            if let Some(places) = som::unroll(&few, observer)? {
                let (uv, aspect) = outline::unit_square(&places);
                let net = split(aspect);
                let lattice = lattice(net, sample.len(), options.topology)?;
                let nodes = som::spread_out(&few, &uv, &lattice, observer)?;
                return Ok(Self { lattice, nodes, net });
            }
        }
        let net = split(1.0);
        let lattice = lattice(net, sample.len(), options.topology)?;
        let start = SomOptions { init: Init::Pca, seed: options.seed, ..SomOptions::default() };
        let nodes = SelfOrganizingMap::new(sample, lattice.clone(), &start, observer)?.codebook();
        Ok(Self { lattice, nodes, net })
    }
}

/// A budget of control points in rows and columns, for a surface so many times longer than wide.
fn split(budget: usize, aspect: f64) -> (usize, usize) {
    let most = (budget / LEAST_SIDE).max(LEAST_SIDE);
    let rows = ((budget as f64 * aspect).sqrt().round() as usize).clamp(LEAST_SIDE, most);
    let cols = (budget / rows).max(LEAST_SIDE);
    // What is left over may be enough for another row.
    ((budget / cols).max(LEAST_SIDE), cols)
}

/// A lattice like the net, but with few enough nodes for the points.
fn lattice(net: (usize, usize), points: usize, topology: Topology) -> Result<Lattice> {
    let most = (points / POINTS_PER_NODE).max(9) as f64;
    let shrink = (most / (net.0 * net.1) as f64).sqrt().min(1.0);
    let side = |count: usize| ((count as f64 * shrink) as usize).max(3);
    Lattice::grid(side(net.0), side(net.1), som::Cells::Quad, topology)
}

fn learn(
    sample: &[DVec3],
    start: &OrderedStart,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let options = SomOptions {
        init: Init::Given(start.nodes.clone()),
        kernel: Some(Kernel::Mean),
        radius: Some(Schedule::Exponential { start: RADIUS.0, end: RADIUS.1 }),
        epochs: Some(EPOCHS),
        min_change: Some(f64::MIN_POSITIVE),
        ..SomOptions::default()
    };
    SelfOrganizingMap::fit(sample, start.lattice.clone(), &options, observer)
}

/// The map in the points' own frame, as it would have been learned there.
fn in_own_frame(
    map: &SelfOrganizingMap,
    sample: &[DVec3],
    frame: &Normalization,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let points: Vec<DVec3> = sample.iter().map(|&point| frame.undo(point)).collect();
    let nodes = map.codebook().into_iter().map(|node| frame.undo(node)).collect();
    let options = SomOptions { init: Init::Given(nodes), ..SomOptions::default() };
    let mut own = SelfOrganizingMap::new(&points, map.lattice.clone(), &options, observer)?;
    own.steps = map.steps;
    own.stopped_by = map.stopped_by;
    own.reached = map.reached;
    own.change = map.change.map(|change| change / frame.scale);
    own.error = map.error.map(|error| error / frame.scale);
    Ok(own)
}
