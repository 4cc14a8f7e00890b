//! Heights over a plane: the parameters are known, and the net grows evenly.

use glam::{DVec2, DVec3};

use super::job::{Fit, Job};
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

/// The surface of heights, growing until nothing is gained, at first with this fairness if it is
/// known.
pub(super) fn fit(
    job: &Job<'_>,
    up: DVec3,
    net: (usize, usize),
    growth: Option<Growth>,
    mut fairness: Option<f64>,
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
        let options = HeightOptions { net, degree, fairness: job.options.fairness };
        let first = fairness.take().or(options.fairness);
        let weights = job.weights.as_deref();
        let fit = match first {
            Some(fairness) => fit_heights_with(job.points, weights, up, &options, fairness)?,
            None => fit_heights(job.points, weights, up, &options)?,
        };
        // Noise has no direction, so what counts is the distance from the slope, not the height.
        let weight = |(i, cosine): (usize, f64)| job.weight(i) * cosine * cosine;
        let cosines = cosines(&fit.surface, &fit.uv, up);
        let weights: Vec<f64> = cosines.into_iter().enumerate().map(weight).collect();
        if growth.is_none() {
            return fit_heights_with(job.points, Some(&weights), up, &options, fit.fairness);
        }
        let options = HeightOptions { fairness: Some(fit.fairness), ..options };
        fit_heights(job.points, Some(&weights), up, &options)
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
    let (uv, distances) = project(&surface, (false, false), job.points, &uv);
    Ok(Fit { surface, uv, distances, fairness, iterations, ended_by })
}
