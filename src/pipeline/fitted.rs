//! The method "fit": an ordered map gives parameters, least squares give the surface.

use std::borrow::Cow;
use std::time::Instant;

use glam::DVec3;

use super::candidate::{Candidate, Placed, Wanted};
use super::counted::{Apart, Counted, of};
use super::feet::{self, feet};
use super::measured::{Feet, Measured};
use super::own_frame::Frame;
use super::reconstruction::Reconstruction;
use super::report::{Clock, Deviations, Report, TrainingReport};
use super::shape::Shape;
use super::start::{LEAST_SIDE, POINTS_PER_FIRST, in_own_frame};
use super::units::Units;
use super::{ReconstructOptions, Start};
use crate::chart::Kind;
use crate::cloud::{Bounds, NoData, no_data};
use crate::diagnostic::{Cause, Diagnostic};
use crate::error::{Error, Result};
use crate::fit::{EndedBy, Growth, diameter};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::topology::{Cloud, Topology, detect_among};
use crate::validate::{defects, not_followed};

/// The longest side of the net that growth begins with.
const FIRST_SIDE: usize = 12;

/// Distance of a surface from points, by root mean square, as a share of their diameter, from which on it has nothing
/// of their shape.
const SHAPELESS: f64 = 0.1;

/// The stages in which only surfaces with flaws were found in other units, and through all pieces.
const OTHER_UNITS: &str = "other units";
const SPANNING: &str = "spanning pieces";

/// The surface near all points, in other units if it folds over, runs away or is far from them in those that
/// they seem to have, or, where they are in pieces and it does so whatever is done, or lies between them, near
/// those of the largest of which that is not so.
pub(super) fn reconstruct(
    cloud: &[DVec3],
    bounds: &Bounds,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let started = Instant::now();
    let no_data = if options.clean { no_data(cloud) } else { None };
    let data = || match &no_data {
        None => Cow::Borrowed(cloud),
        Some(no_data) => cloud.iter().filter(|point| !no_data.has(**point)).copied().collect(),
    };
    let (units, others) = Units::of(&data(), options, observer)?;
    let attempt = |units: Units, options: &ReconstructOptions<'_>, observer: &mut dyn Observer| {
        attempt(cloud, bounds, no_data, units, options, Gaps::Kept, observer)
    };
    let Attempt { found, apart, spoilt, wild, unlike } = attempt(units, options, observer)?;
    let others = match others.filter(|_| spoilt || unlike) {
        Some(others) => others.of(&data(), options, observer)?,
        None => None,
    };
    if let Some(units) = others {
        let spent = started.elapsed();
        if let Some(mut other) = unspoilt(attempt(units, options, observer))? {
            other.report.seconds.insert(0, (OTHER_UNITS, spent.as_secs_f64()));
            return Ok(other);
        }
    }
    let given = options.fairness.is_some() || matches!(options.init, Start::Given { .. });
    let wanted = (spoilt || wild) && !given && options.kind != Some(Kind::Height);
    let Some(apart) = apart.filter(|_| wanted) else { return Ok(found) };
    for piece in 0..apart.large {
        let spent = started.elapsed();
        let options = ReconstructOptions { component: Some(piece), ..*options };
        if let Some(mut alone) = unspoilt(attempt(units, &options, observer))? {
            alone.report.seconds.insert(0, (SPANNING, spent.as_secs_f64()));
            return Ok(alone);
        }
    }
    if !wild {
        return Ok(found);
    }
    let spent = started.elapsed();
    let tame = self::attempt(cloud, bounds, no_data, units, options, Gaps::Spanned, observer)?;
    let mut found = tame.found;
    found.report.seconds.insert(0, (SPANNING, spent.as_secs_f64()));
    Ok(found)
}

/// What is made of the gaps between pieces.
#[derive(Clone, Copy, PartialEq)]
enum Gaps {
    /// They are spanned only by what is near all pieces, though it may be wild: one piece alone may be better.
    Kept,
    /// They are spanned by what is not wild, wherever that passes.
    Spanned,
}

/// What was found of points.
struct Attempt {
    found: Reconstruction,
    /// What is known of their pieces, if they do not hang together.
    apart: Option<Apart>,
    /// Whether the surface has flaws that no tolerance excuses.
    spoilt: bool,
    /// Whether it is wild.
    wild: bool,
    /// Whether the points are hardly the heights that they seemed to be in other units.
    unlike: bool,
}

/// What another attempt has found, if that is better than a surface with flaws; a piece, say, may be too
/// small for one.
fn unspoilt(attempt: Result<Attempt>) -> Result<Option<Reconstruction>> {
    match attempt {
        Ok(Attempt { found, spoilt, wild, unlike, .. }) => {
            Ok(Some(found).filter(|_| !(spoilt || wild || unlike)))
        }
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
    gaps: Gaps,
    observer: &mut dyn Observer,
) -> Result<Attempt> {
    let mut clock = Clock::start();
    let mut counted = Counted::of(cloud, no_data, &units, options, observer)?;
    clock.lap("cleaning");
    let known = units.heights().filter(|_| options.kind.is_none());
    let (mut found, mut seen) = kind(&counted, known, options, observer)?;
    let ground = found.height.is_some_and(|height| height.ground);
    let mut in_lines = false;
    if found.kind != Kind::Height {
        counted.look_for_layers(observer)?;
        in_lines = counted.look_across_lines();
        if in_lines {
            // What goes around an axis, all of them show better.
            (found, seen) = (kind(&counted, None, options, observer)?.0, None);
        }
    } else if ground {
        // Roofs and crowns are apart from the ground, but no other pieces to choose.
        counted.apart = None;
    }
    let upright = Frame::upright(units, &counted.points);
    let budget = options.grid.unwrap_or_else(|| default_grid(counted.points.len()));
    let local = upright.counted(&counted.points);
    let shape = Shape::of(&mut found, &local, &units, budget, options, observer)?;
    drop(local);
    clock.lap("topology");

    let first = shape.kind;
    let chart = found.chart.as_ref().filter(|_| shape.kind == found.kind);
    let (placed, beside) = placed(&mut counted, upright, &shape, in_lines);
    let apart = counted.apart.as_ref().filter(|_| gaps == Gaps::Kept);
    let wanted = |placed| Wanted {
        placed,
        weights: counted.weights.as_deref(),
        layers: apart.map(|apart| apart.layers.within(&placed.frame)),
        seen: seen.as_ref(),
        budget,
        growth: growth(options, &placed.frame, first),
        options,
    };
    let candidate = wanted(&placed).candidate(shape, chart, &mut clock, observer)?;
    let candidate = match &beside {
        Some(beside) => wanted(beside).or_sheet(candidate, &mut clock, observer)?,
        None => wanted(&placed).or_better(candidate, &mut clock, observer)?,
    };
    let (wild, Candidate { placed, map, job, fit, flaws }) = (candidate.is_wild(), candidate);
    let frame = &placed.frame;
    let spoilt = flaws.spoil(&fit) || !job.through_pieces(&fit);
    let unexplained = job.misses_heights(&fit);

    let surface = fit.surface.map_control_points(|point| frame.undo(point))?;
    let (straight, points) = (job.shape.straight, of(cloud, &counted.indices));
    let (uv, own) = if straight {
        feet::heights(&surface, &points)
    } else if units.differ() {
        feet(&surface, &points, observer)?
    } else {
        let own = feet::apart(&surface, &fit.uv, &points);
        (fit.uv, own)
    };
    let counts: Vec<bool> = (0..own.len()).map(|i| job.weight(i) > 0.0).collect();
    let shown = counts.iter().filter(|counts| !**counts).count();
    let mut measured = Measured::of_fitted(&counted, cloud.len(), &uv, &own, &counts);
    let how = Feet { closed: job.shape.closed().closed(), straight };
    measured.add_others(cloud, &counted, &surface, how, observer)?;
    let som = in_own_frame(&map, &placed.sample, frame, observer)?;
    clock.lap("measuring");

    let near = measured.near();
    let far = |tolerance| near.iter().filter(|distance| **distance > tolerance).count();
    let missed = options.tolerance.map(far);
    let (count, off) = (near.len(), Deviations::of(near));
    let within = missed.map(|missed| 1.0 - missed as f64 / count as f64);
    // Growth asks for more of heights, and of feet that are still on their way, than the distances in the end.
    let ended_by = if missed == Some(0) { EndedBy::Tolerance } else { fit.ended_by };
    let astray = gone_astray(&counted, ground || units.differ(), off.rms, observer)?;
    let spoilt = spoilt || astray;
    let mut diagnostics = diagnosed(cloud, &counted, &measured, &surface, straight, observer)?;
    diagnostics.extend(shortcoming(ended_by, options.tolerance, missed.unwrap_or(0), count));
    let height = job.shape.kind == Kind::Height;
    let report = Report {
        points: cloud.len(),
        inliers: count,
        diagonal: bounds.diagonal(),
        grid: surface.shape(),
        degree: (surface.knots_u().degree(), surface.knots_v().degree()),
        deviations: off,
        tolerance: options.tolerance,
        within,
        ended_by,
        fairness: Some(fit.fairness),
        iterations: fit.iterations,
        kind: job.shape.kind,
        direction: found.height.map(|height| height.up).filter(|_| height),
        axis_scale: units.by.recip(),
        valid: !diagnostics.iter().any(Diagnostic::is_defect),
        converged: missed.unwrap_or(0) == 0,
        candidates: Vec::new(),
        diagnostics,
        duplicates: counted.duplicates,
        outliers: counted.outliers + shown,
        training: TrainingReport::of(&som, som.error.unwrap_or(f64::NAN)),
        seconds: clock.seconds(),
    };
    let Measured { uv, distances: deviations, inliers } = measured;
    let found = Reconstruction { surface, som, uv, deviations, inliers, report };
    Ok(Attempt { found, apart: counted.apart, spoilt, wild, unlike: straight && unexplained })
}

/// The points along their own axes, or upright where they are heights, and where these are steep beside that
/// along their own.
fn placed(
    counted: &mut Counted,
    upright: Frame,
    shape: &Shape,
    in_lines: bool,
) -> (Placed, Option<Placed>) {
    let turning = shape.base.is_none() || shape.steep;
    let own = turning.then(|| {
        let frame = Frame::own(upright.units, &counted.points);
        (frame, counted.outwards_in(&frame))
    });
    let across_lines = in_lines.then_some(&counted.telling[..]);
    let own = own.map(|(frame, points)| Placed::new(frame, points, across_lines));
    match own {
        Some(own) if shape.base.is_none() => (own, None),
        beside => {
            let points = upright.counted(&counted.points);
            (Placed::new(upright, points, across_lines), beside)
        }
    }
}

/// Whether a surface is so far off the points that it has nothing of their shape, or passes between two layers.
fn gone_astray(
    counted: &Counted,
    known: bool,
    off: f64,
    observer: &mut dyn Observer,
) -> Result<bool> {
    if known {
        return Ok(false);
    }
    if off > SHAPELESS * diameter(&counted.telling) {
        return Ok(true);
    }
    if counted.double || counted.apart.is_some() {
        return Ok(false);
    }
    Ok(not_followed(&counted.telling, off, observer)?.is_some())
}

/// What kind of surface the points lie on, and those that have shown it, if that was not known already.
fn kind(
    counted: &Counted,
    known: Option<Topology>,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<(Topology, Option<Cloud>)> {
    if let Some(known) = known {
        return Ok((known, None));
    }
    let (points, around) = (&counted.telling, counted.known.as_ref());
    let (found, seen) = detect_among(points, &counted.points, options.kind, around, observer)?;
    Ok((found, Some(seen)))
}

/// The net that growth begins with: few control points, but no fewer than the degree needs.
pub(super) fn default_grid(count: usize) -> (usize, usize) {
    let side = (count / POINTS_PER_FIRST).isqrt().clamp(LEAST_SIDE, FIRST_SIDE);
    (side, side)
}

/// How far the net grows, in the frame; not at all where its size was given without a tolerance.
fn growth(options: &ReconstructOptions<'_>, frame: &Frame, kind: Kind) -> Option<Growth> {
    let counted = |tolerance| frame.counted_length(frame.units.distance(tolerance, kind));
    let tolerance = options.tolerance.map(counted);
    let free = options.grid.is_none() || tolerance.is_some();
    free.then_some(Growth { tolerance, most: options.max_control_points })
}

/// What is to be said of the points, and of the surface unless its axes have different units.
fn diagnosed(
    cloud: &[DVec3],
    counted: &Counted,
    measured: &Measured,
    surface: &NurbsSurface,
    straight: bool,
    observer: &mut dyn Observer,
) -> Result<Vec<Diagnostic>> {
    let mut found = counted.diagnostics.clone();
    if let Some(Apart { sizes, .. }) = &counted.apart {
        found.push(Diagnostic::Components { sizes: sizes.clone(), fitted: None });
    }
    if !straight {
        let all = cloud.iter().zip(&measured.inliers);
        let points: Vec<DVec3> = all.filter(|(_, inlier)| **inlier).map(|(p, _)| *p).collect();
        found.extend(defects(surface, &points, Deviations::of(measured.near()).rms, observer)?);
    }
    Ok(found)
}

/// A tolerance that was missed, and why.
fn shortcoming(
    ended_by: EndedBy,
    tolerance: Option<f64>,
    missed: usize,
    points: usize,
) -> Option<Diagnostic> {
    let tolerance = tolerance.filter(|_| missed > 0)?;
    let cause = match ended_by {
        EndedBy::Noise => Cause::Noise,
        EndedBy::Points => Cause::Points,
        EndedBy::MaxControlPoints => Cause::MaxControlPoints,
        EndedBy::Tolerance | EndedBy::Exact | EndedBy::Grid => Cause::Defects,
    };
    Some(Diagnostic::ToleranceMissed { tolerance, missed, points, cause })
}
