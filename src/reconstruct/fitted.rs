//! The method "fit": an ordered map gives parameters, least squares give the surface.

use std::time::Instant;

use glam::DVec3;

use super::counted::{Apart, Counted, Layers, every, of};
use super::feet::{self, feet};
use super::job::{Job, Shape};
use super::measured::{Feet, Measured};
use super::own_frame::{Frame, OwnFrame};
use super::report::{Clock, Distances, Report, TrainingReport};
use super::start::{LEAST_SIDE, OrderedStart, in_own_frame, learn, net, whole};
use super::units::Units;
use super::unwound::Unwound;
use super::{ReconstructOptions, Reconstruction, Start, heights};
use crate::error::{Error, Result};
use crate::fit::{EndedBy, Growth, bounded};
use crate::inspection::not_followed;
use crate::point_cloud::{Bounds, NoData, Normalization, no_data};
use crate::progress::Observer;
use crate::som::SelfOrganizingMap;
use crate::topology::{Kind, Topology, detect, detect_wanted};

/// Points that the map learns from: more would not move it visibly.
const MAP_POINTS: usize = 20_000;

/// How far beyond the lattice's border points may lie, in cells.
const EXTRAPOLATION: f64 = 0.75;

/// Topographic error of a map from an ordered start that shows a short circuit between layers, or a surface
/// that has no flat map: of two dozen maps in order, of noisy sheets too, none has any, nor half of it of two
/// that are stretched over more than half a sphere.
const TORN: f64 = 0.005;

/// So many points may be out of order by chance, and the map still be the better one, up to this error.
const BY_CHANCE: (f64, f64) = (5.0, 0.02);

/// Points for each control point of the net that growth begins with, and its longest side.
const POINTS_PER_FIRST: f64 = 2.0;
const FIRST_SIDE: usize = 12;

/// The stages in which only surfaces with flaws were found in other units, and through all pieces.
const OTHER_UNITS: &str = "other units";
const SPANNING: &str = "spanning pieces";

/// The surface near all points, in other units if it folds over or runs away in those that they seem to
/// have, or, where they are in pieces and it does so whatever is done, or lies between them, near those of
/// the largest of which that is not so.
pub(super) fn reconstruct(
    cloud: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let started = Instant::now();
    let no_data = if options.clean { no_data(cloud) } else { None };
    let (units, others) = match &no_data {
        None => Units::of(cloud, options, observer)?,
        Some(no_data) => {
            let has_data = |point: &&DVec3| !no_data.has(**point);
            let data: Vec<DVec3> = cloud.iter().filter(has_data).copied().collect();
            Units::of(&data, options, observer)?
        }
    };
    let mut attempt = |units: Units, options: &ReconstructOptions<'_>| {
        attempt(cloud, bounds, no_data, units, options, observer)
    };
    let Attempt { found, apart, spoilt } = attempt(units, options)?;
    if let Some(units) = others.filter(|_| spoilt) {
        let spent = started.elapsed();
        if let Some(mut other) = unspoilt(attempt(units, options))? {
            other.report.times.insert(0, (OTHER_UNITS, spent));
            return Ok(other);
        }
    }
    let given = options.fairness.is_some() || matches!(options.init, Start::Given { .. });
    let wanted = spoilt && !given && options.topology != Some(Kind::Height);
    let Some(apart) = apart.filter(|_| wanted) else { return Ok(found) };
    for piece in 0..apart.large {
        let spent = started.elapsed();
        let options = ReconstructOptions { piece: Some(piece), ..*options };
        if let Some(mut alone) = unspoilt(attempt(units, &options))? {
            alone.report.times.insert(0, (SPANNING, spent));
            let warning = format!(
                "{}; through all of them goes no surface that neither folds over, runs away nor \
                 passes between them: this is one of the largest alone; choose a piece, or fit each",
                apart.told
            );
            alone.report.warnings.insert(0, warning);
            return Ok(alone);
        }
    }
    Ok(found)
}

/// What was found of points.
struct Attempt {
    found: Reconstruction,
    /// What is known of their pieces, if they do not hang together.
    apart: Option<Apart>,
    /// Whether the surface has flaws that no tolerance excuses.
    spoilt: bool,
}

/// What another attempt has found, if that is better than a surface with flaws; a piece, say, may be too
/// small for one.
fn unspoilt(attempt: Result<Attempt>) -> Result<Option<Reconstruction>> {
    match attempt {
        Ok(Attempt { found, spoilt, .. }) => Ok(Some(found).filter(|_| !spoilt)),
        Err(Error::Interrupted) => Err(Error::Interrupted),
        Err(_) => Ok(None),
    }
}

fn attempt(
    cloud: &[DVec3],
    bounds: &Bounds,
    no_data: Option<NoData>,
    units: Units,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Attempt> {
    let mut clock = Clock::start();
    let mut counted = Counted::of(cloud, no_data, &units, options, observer)?;
    clock.lap("cleaning");
    let known = units.heights().filter(|_| options.topology.is_none());
    let mut found = match known {
        Some(heights) => heights,
        None => kind(&counted.telling, options, observer)?,
    };
    if found.kind != Kind::Height {
        counted.look_for_layers(observer)?;
    }
    let frame = Frame { units, counted: Normalization::of(&counted.points) };
    let local: Vec<DVec3> =
        counted.points.iter().map(|&point| frame.counted.apply(point)).collect();
    let budget = options.grid.unwrap_or_else(|| default_grid(local.len()));
    let shape = Shape::of(&mut found, &local, &units, budget, options, observer)?;
    clock.lap("topology");

    let sample: Vec<DVec3> = every(&local, MAP_POINTS).copied().collect();
    let told: &mut dyn Observer = &mut OwnFrame { frame, observer };
    let mut start = if let Some(base) = &shape.base {
        let (uv, aspect) = heights::places(&sample, base);
        OrderedStart::over(sample.len(), &sample, &uv, net(budget, aspect, options), told)?
    } else {
        let chart = found.chart.as_ref().filter(|_| shape.kind == found.kind);
        OrderedStart::of(&sample, budget, shape.closed(), chart, &frame, options, told)?
    };
    clock.lap("ordering");
    let map = learned(&sample, &mut start, &shape, budget, &frame, options, told)?;
    start.split_as(&map, budget, options);
    let uv = if shape.base.is_some() {
        Vec::new()
    } else {
        let places = map.parametrize(&local, EXTRAPOLATION, told)?;
        bounded(&places, shape.closed().closed())
    };
    clock.lap("training");

    let growth = growth(options, &frame);
    let creases = start.creases;
    let weights = counted.weights.clone();
    let layers = counted.apart.as_ref().map(|apart| apart.layers);
    let layers = layers.map(|layers| Layers { gap: layers.gap * frame.counted.scale, ..layers });
    let mut job = Job { points: &local, weights, uv, creases, shape, layers, options };
    let (fit, flaws) = job.done(start.net, growth, told)?;
    let spoilt = flaws.spoil(&fit) || !job.through_pieces(&fit);
    clock.lap("fitting");

    let surface = fit.surface.map_control_points(|point| frame.undo(point))?;
    let straight = job.shape.straight;
    let (uv, own) = if straight {
        feet::heights(&surface, &of(cloud, &counted.indices))
    } else if units.differ() {
        feet(&surface, &of(cloud, &counted.indices), observer)?
    } else {
        (fit.uv, fit.distances.iter().map(|&distance| frame.length(distance)).collect())
    };
    let counts: Vec<bool> = (0..own.len()).map(|i| job.weight(i) > 0.0).collect();
    let shown = counts.iter().filter(|counts| !**counts).count();
    let mut measured = Measured::of_fitted(&counted, cloud.len(), &uv, &own, &counts);
    let how = Feet { closed: job.shape.closed().closed(), straight };
    measured.add_others(cloud, &counted, &surface, how, observer)?;
    let som = in_own_frame(&map, &sample, &frame, observer)?;
    clock.lap("measuring");

    let near = measured.near();
    let far = |tolerance| near.iter().filter(|distance| **distance > tolerance).count();
    let within = options.tolerance.map(|tolerance| 1.0 - far(tolerance) as f64 / near.len() as f64);
    let missed = options.tolerance.map_or(0, far);
    let (count, off) = (near.len(), Distances::of(near));
    let mut warnings = counted.warnings;
    if !(counted.double || counted.apart.is_some() || units.differ()) {
        warnings.extend(not_followed(&counted.telling, off.rms, observer)?);
    }
    warnings.extend(counted.apart.iter().map(|apart| apart.warning.clone()));
    warnings
        .extend(found.warning.filter(|_| options.topology.is_none_or(|kind| kind == found.kind)));
    warnings.extend(shortcoming(fit.ended_by, options.tolerance, missed));
    warnings.extend(flaws.warnings(&frame));
    let report = Report {
        points: cloud.len(),
        inliers: count,
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        distances: off,
        tolerance: options.tolerance,
        within,
        ended_by: fit.ended_by,
        fairness: Some(fit.fairness),
        iterations: fit.iterations,
        topology: job.shape.kind,
        topology_reason: Some(found.reason).filter(|_| job.shape.kind == found.kind),
        duplicates: counted.duplicates,
        outliers: counted.outliers + shown,
        training: TrainingReport::of(&som, som.error.unwrap_or(f64::NAN)),
        warnings,
        times: clock.times(),
    };
    let Measured { uv, distances, inliers } = measured;
    let found = Reconstruction { surface, som, uv, distances, inliers, report };
    Ok(Attempt { found, apart: counted.apart, spoilt })
}

/// The map from an ordered start, or, where that is torn, from another that is less so: of a sheet from the
/// principal plane, from more points or from end to end, as it may be wound up, or from a disc, as it may
/// go around a body.
fn learned(
    sample: &[DVec3],
    start: &mut OrderedStart,
    shape: &Shape,
    budget: (usize, usize),
    frame: &Frame,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<SelfOrganizingMap> {
    let mut map = learn(sample, start, observer)?;
    if options.init != Start::Auto || shape.kind != Kind::Sheet {
        return Ok(map);
    }
    let mut torn = map.topographic_error(sample, observer)?;
    let (stray, most) = BY_CHANCE;
    if torn <= (stray / sample.len() as f64).clamp(TORN, most) {
        return Ok(map);
    }
    let flat = ReconstructOptions { init: Start::Pca, ..*options };
    let mut others =
        vec![OrderedStart::of(sample, budget, shape.closed(), None, frame, &flat, observer)?];
    let count = sample.len();
    let sheet = if let Some(sheet) = start.unwound.take() {
        sheet
    } else {
        let sheet = Unwound::closely(sample, observer)?;
        others.extend(sheet.unrolled(count, budget, options, observer)?);
        sheet
    };
    others.extend(OrderedStart::over_disc(sample, budget, options, observer)?);
    others.extend(sheet.lengthwise(count, budget, options, observer)?);
    for other in others {
        let learned = learn(sample, &other, observer)?;
        let error = learned.topographic_error(sample, observer)?;
        if error < torn {
            (*start, map, torn) = (other, learned, error);
        }
    }
    Ok(map)
}

/// What kind of surface the points lie on, as far as that is not known.
fn kind(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Topology> {
    match options.topology {
        Some(wanted) => detect_wanted(points, wanted, observer),
        None => detect(points, observer),
    }
}

/// The net that growth begins with: few control points, but no fewer than the degree needs.
fn default_grid(count: usize) -> (usize, usize) {
    let side = whole((count as f64 / POINTS_PER_FIRST).sqrt()).clamp(LEAST_SIDE, FIRST_SIDE);
    (side, side)
}

/// How far the net grows, in the frame; not at all where its size was given without a tolerance.
fn growth(options: &ReconstructOptions<'_>, frame: &Frame) -> Option<Growth> {
    let counted = |tolerance| frame.units.distance(tolerance) * frame.counted.scale;
    let tolerance = options.tolerance.map(counted);
    let free = options.grid.is_none() || tolerance.is_some();
    free.then_some(Growth { tolerance, most: options.max_control_points })
}

/// What is to be said of a fit that did not come out as it was asked for.
fn shortcoming(ended_by: EndedBy, tolerance: Option<f64>, far: usize) -> Option<String> {
    let tolerance = tolerance?;
    let why = match ended_by {
        EndedBy::Noise => "a larger net would follow the noise of the points: raise the tolerance",
        EndedBy::Points => "the points hold no more control points: raise the tolerance",
        EndedBy::MaxControlPoints => "the net may have no more: raise max_control_points",
        EndedBy::Tolerance | EndedBy::Exact | EndedBy::Grid => return None,
    };
    Some(format!(
        "{far} points lie farther than the tolerance {tolerance:?} from the surface; {why}"
    ))
}
