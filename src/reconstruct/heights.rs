//! Heights over a plane: the parameters are known, and the net grows evenly.

use glam::{DVec2, DVec3};

use super::counted::every;
use super::job::{Fit, Job};
use super::measured::PORTION;
use super::outline::{area, bounds};
use super::start::whole;
use crate::error::Result;
use crate::fit::{
    EXACT, EndedBy, Growth, HeightFit, HeightOptions, POINTS_PER_CONTROL_POINT, cosines,
    fit_heights, fit_heights_with, height_axes, project,
};
use crate::point_cloud::Bounds;
use crate::progress::{self, Observer, Progress, Stage};
use crate::som;

/// How much longer the sides of the net become at a time.
const LONGER: f64 = 1.5;

/// Share of the error expected of unseen points that may be left after growing, for the growth to
/// go on.
const LEAST_GAIN: f64 = 0.95;

/// Share of the rectangle around the points that their convex hull fills at least, where the
/// heights were found out: a surface over the rectangle hardly goes on beyond the points then.
const FILLED: f64 = 0.93;

/// Points for each control point that tell how steep a surface is, and how many at least.
const TELLING: usize = 16;
const LEAST_TELLING: usize = 20_000;

/// Places in the plane across the heights, in the unit square, and the lengths of its sides.
pub(super) fn places(points: &[DVec3], up: DVec3) -> (Vec<DVec2>, DVec2) {
    let [along, across] = height_axes(points, up);
    let places: Vec<DVec2> =
        points.iter().map(|p| DVec2::new(along.dot(*p), across.dot(*p))).collect();
    let (low, high) = bounds(&places);
    let size = high - low;
    (places.into_iter().map(|place| (place - low) / size).collect(), size)
}

/// Whether the convex hull of the points' places in the plane across the heights fills most of the
/// rectangle around them.
pub(super) fn fill_a_rectangle(points: &[DVec3], up: DVec3) -> bool {
    area(&som::hull(&places(points, up).0)) >= FILLED
}

/// The surface of heights, growing until nothing is gained. A fit that is `known` already says how
/// steep the surface is, and which fairness to take unless it is given.
pub(super) fn fit(
    job: &Job<'_>,
    up: DVec3,
    net: (usize, usize),
    growth: Option<Growth>,
    fairness: Option<f64>,
    known: Option<&Fit>,
    observer: &mut dyn Observer,
) -> Result<Fit> {
    let mut iterations = 0;
    let mut solve = |net: (usize, usize)| {
        let most = growth.map_or(0, |growth| growth.most) as u64;
        let step = ((net.0 * net.1) as u64).min(most);
        let progress = Progress::of_stage(Stage::Fitting, step, most, job.points.len());
        progress::report(observer, &progress)?;
        iterations += 1;
        let degree = (job.degree(net.0), job.degree(net.1));
        let options = HeightOptions { net, degree, fairness };
        let (steepness, fairness) = match known {
            Some(known) => {
                let steepness = cosines(&known.surface, &known.uv, up);
                (steepness, fairness.unwrap_or(known.fairness))
            }
            None => steepness(job, up, &options, observer)?,
        };
        // Noise has no direction, so what counts is the distance from the slope, not the height.
        let weight = |(i, cosine): (usize, f64)| job.weight(i) * cosine * cosine;
        let weights: Vec<f64> = steepness.into_iter().enumerate().map(weight).collect();
        if growth.is_none() {
            return fit_heights_with(job.points, Some(&weights), up, &options, fairness, observer);
        }
        let options = HeightOptions { fairness: Some(fairness), ..options };
        fit_heights(job.points, Some(&weights), up, &options, observer)
    };
    let mut net = net;
    let mut fit = solve(net)?;
    let counted = (0..job.points.len()).filter(|&i| job.weight(i) > 0.0).count();
    let ended_by = loop {
        let Some(growth) = growth else { break EndedBy::Grid };
        match growth.tolerance {
            Some(tolerance) if job.largest(&fit.residuals) <= tolerance => {
                break EndedBy::Tolerance;
            }
            None if fit.expected.sqrt() <= EXACT * Bounds::of(job.points).diagonal() => {
                break EndedBy::Exact;
            }
            _ => {}
        }
        let longer = |side: usize| whole((side as f64 * LONGER).ceil());
        let next = (longer(net.0), longer(net.1));
        let held = counted / POINTS_PER_CONTROL_POINT;
        if next.0 * next.1 > growth.most.min(held) {
            break if held < growth.most { EndedBy::Points } else { EndedBy::MaxControlPoints };
        }
        let finer = solve(next)?;
        if finer.expected > LEAST_GAIN * LEAST_GAIN * fit.expected {
            break EndedBy::Noise;
        }
        (net, fit) = (next, finer);
    };
    let HeightFit { surface, uv, fairness, .. } = fit;
    // The nearest place is not the one straight below.
    let (mut feet, mut distances) = (Vec::with_capacity(uv.len()), Vec::with_capacity(uv.len()));
    let mut listen = progress::listener(observer, Stage::Fitting, job.points.len());
    for (points, uv) in job.points.chunks(PORTION).zip(uv.chunks(PORTION)) {
        listen()?;
        let (uv, apart) = project(&surface, (false, false), points, uv);
        feet.extend(uv);
        distances.extend(apart);
    }
    Ok(Fit { surface, uv: feet, distances, fairness, iterations, ended_by })
}

/// How steep the surface is at the points, as the cosine of its slope, and the fairness that it
/// wants: by a first fit to as many of them as tell.
fn steepness(
    job: &Job<'_>,
    up: DVec3,
    options: &HeightOptions,
    observer: &mut dyn Observer,
) -> Result<(Vec<f64>, f64)> {
    let enough = (TELLING * options.net.0 * options.net.1).max(LEAST_TELLING);
    let points: Vec<DVec3> = every(job.points, enough).copied().collect();
    let weights: Option<Vec<f64>> =
        job.weights.as_ref().map(|weights| every(weights, enough).copied().collect());
    let weights = weights.as_deref();
    let first = match options.fairness {
        Some(fairness) => fit_heights_with(&points, weights, up, options, fairness, observer)?,
        None => fit_heights(&points, weights, up, options, observer)?,
    };
    let axes = height_axes(&points, up);
    let place = |point: DVec3| DVec2::from_array(axes.map(|axis| axis.dot(point)));
    let (low, high) = (place(first.surface.point(0.0, 0.0)), place(first.surface.point(1.0, 1.0)));
    let inside = |point: &DVec3| (place(*point) - low) / (high - low);
    let uv: Vec<DVec2> =
        job.points.iter().map(|p| inside(p).clamp(DVec2::ZERO, DVec2::ONE)).collect();
    Ok((cosines(&first.surface, &uv, up), first.fairness))
}
