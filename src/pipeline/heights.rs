//! Heights over a plane: the parameters are known, and the net grows evenly.

use glam::{DVec2, DVec3};

use super::counted::every;
use super::feet::below;
use super::job::{Fit, Job};
use super::measured::PORTION;
use super::outline::bounds;
use super::region::Region;
use super::start::{TELLING as TELLING_OUTLINE, whole};
use super::strip::Sides;
use crate::cloud::{Plane, area, hull, least_rectangle};
use crate::error::{Error, Result};
use crate::fit::{
    Arms, Base, EXACT, EndedBy, Growth, HeightFit, HeightOptions, Near, cosines, diameter,
    fit_heights_over, fit_heights_with, project,
};
use crate::progress::{self, Observer, Progress, Stage};
use crate::topology::{self, HeightField};

/// How much longer the sides of the net become at a time.
const LONGER: f64 = 1.5;

/// Control points for each of few points at most: where what predicts best says when to stop, more of
/// them than points do no harm, but of many no good either.
const MOST_PER_POINT: usize = 2;
const MANY: usize = 512;

/// Share of the error expected of unseen points that may be left after growing, for the growth to
/// go on.
const LEAST_GAIN: f64 = 0.95;

/// Share of what the convex hull of as many points fills of the rectangle around them, were they
/// scattered evenly over one, that theirs fills at least, where the heights were found out: a surface
/// over the rectangle hardly goes on beyond the points then.
const FILLED: f64 = 0.93;

/// In how many n-ths n points scattered over a rectangle hardly ever leave more of it than the rectangle of
/// least area around them does.
const BY_CHANCE: f64 = 4.0;

/// Cosine of the angle that a plane leans by at least for its rectangles to be no longer those of x and y.
const UPRIGHT: f64 = 0.98;

/// Fewer points than that do not tell what they fill, nor hold a surface that bends across where they end.
pub(super) const FEW: usize = 100;

/// Points to a cell of that rectangle on average, and cells along a side at most; and the share of them
/// without points from which on a bent strip is looked for: a U, whose hull is a rectangle, leaves more.
const POINTS_PER_CELL: usize = 5;
const MOST_CELLS: usize = 32;
const EMPTY: f64 = 0.05;

/// Points by which an outline is found, and those by which its straight sides are.
const OUTLINED: usize = 1_500;
const BOUNDING: usize = 20_000;

/// Points for each control point that tell how steep a surface is, and how many at least.
const TELLING: usize = 16;
const LEAST_TELLING: usize = 20_000;

/// Parameters of points in the unit square, and how many times longer what they fill is than wide.
pub(super) fn places(points: &[DVec3], base: &Base) -> (Vec<DVec2>, f64) {
    if let Some(strip) = &base.strip {
        let uv = points.iter().map(|&point| base.along_strip(strip, point)).collect();
        return (uv, strip.aspect());
    }
    let places = base.places(points);
    let (low, high) = bounds(&places);
    let size = high - low;
    (places.into_iter().map(|place| (place - low) / size).collect(), size.x / size.y)
}

/// The rectangle around the points' places in the plane across heights that were found out: the one of
/// least area, or along x and y where those are the plane's axes and chance may have made it larger.
pub(super) fn rectangle(points: &[DVec3], up: DVec3) -> Base {
    let straight = Base::over(points, up);
    let places = straight.places(points);
    let (along, size) = least_rectangle(&places);
    let (low, high) = bounds(&places);
    let turned = size.element_product() < by_chance(points.len()) * (high - low).element_product();
    if turned || up != DVec3::Z { straight.turned(along) } else { straight }
}

/// What heights stand on that were found out: the rectangle around the points' places in the plane across
/// them, if they fill it, or a bent strip that they fill, if it is one of those that are `wanted`.
pub(super) fn base(points: &[DVec3], up: DVec3, wanted: impl Fn(&Arms) -> bool) -> Option<Base> {
    let rectangle = rectangle(points, up);
    if points.len() < FEW {
        return Some(rectangle);
    }
    let places = places(points, &rectangle).0;
    let filled = filled(&places) >= FILLED * evenly_filled(places.len());
    if filled && empty(&places) < EMPTY {
        return Some(rectangle);
    }
    let fits = |base: &Base| !filled || empty(&self::places(points, base).0) < EMPTY;
    let strip = strip(points, &rectangle).filter(wanted);
    let strip = strip.map(|strip| Base { strip: Some(strip), ..rectangle.clone() });
    match strip.filter(fits) {
        Some(strip) => Some(strip),
        None => filled.then_some(rectangle),
    }
}

/// Heights over the plane nearest to points, and what they stand on, if they fill it clearly better than
/// heights along z fill theirs: a sheet that leans stands on no rectangle of x and y.
pub(super) fn leaning(
    points: &[DVec3],
    along_z: Option<&Base>,
    wanted: impl Fn(&Arms) -> bool,
    observer: &mut dyn Observer,
) -> Result<Option<(HeightField, Base)>> {
    let up = Plane::of(points.iter().copied()).upward();
    if up.z > UPRIGHT {
        return Ok(None);
    }
    let base = match along_z {
        None => {
            let Some(height) = topology::heights_along(points, up, observer)? else {
                return Ok(None);
            };
            return Ok(base(points, height.up, wanted).map(|base| (height, base)));
        }
        Some(along_z) if points.len() < FEW => {
            let over_plane = rectangle(points, up);
            let [filled_along_z, filled_over_plane] =
                [along_z, &over_plane].map(|base| filled(&places(points, base).0));
            let better = filled_along_z < by_chance(points.len()) * filled_over_plane;
            better.then_some(over_plane)
        }
        Some(_) => None,
    };
    let Some(base) = base else { return Ok(None) };
    let found = topology::heights_along(points, up, observer)?;
    Ok(found.map(|height| (height, base)))
}

/// Share of the unit square that the convex hull of places fills.
fn filled(places: &[DVec2]) -> f64 {
    area(&hull(places))
}

/// The share of a rectangle under which so many points scattered over it hardly ever leave that of least area.
fn by_chance(count: usize) -> f64 {
    1.0 - BY_CHANCE / count as f64
}

/// Share of the rectangle around so many points that their convex hull fills on average if they are
/// scattered evenly over one (A. Rényi, R. Sulanke, *Über die konvexe Hülle von n zufällig gewählten
/// Punkten*, 1963), as is the share of that which the rectangle around them fills.
fn evenly_filled(count: usize) -> f64 {
    let n = count as f64;
    let around = ((n - 1.0) / (n + 1.0)).powi(2);
    ((1.0 - 8.0 / 3.0 * n.ln() / n) / around).min(1.0)
}

/// Share of the unit square without any of these places.
fn empty(places: &[DVec2]) -> f64 {
    let side = (places.len() / POINTS_PER_CELL).isqrt().clamp(1, MOST_CELLS);
    let mut empty = vec![true; side * side];
    for place in places {
        let [row, col] = [place.x, place.y].map(|at| whole(at * side as f64).min(side - 1));
        empty[row * side + col] = false;
    }
    empty.iter().filter(|empty| **empty).count() as f64 / empty.len() as f64
}

/// The bent strip with straight sides that the points' places in the plane across the heights fill, if
/// they fill one.
fn strip(points: &[DVec3], base: &Base) -> Option<Arms> {
    if points.len() < TELLING_OUTLINE {
        return None;
    }
    let few: Vec<DVec3> = every(points, OUTLINED).copied().collect();
    let few = base.places(&few);
    let region = Region::of(&few)?;
    let flat: Vec<DVec3> = few.iter().map(|place| place.extend(0.0)).collect();
    let arms = region.strip(&few, &flat, Sides::Straight)?;
    let bounding: Vec<DVec3> = every(points, BOUNDING).copied().collect();
    arms.around(&base.places(&bounding), 0.0)
}

/// The base of points with noise of this size: a strip ends where they end without it.
fn under(job: &Job<'_>, base: &Base, noise: f64) -> Base {
    let around = |strip: &Arms| {
        let bounding: Vec<DVec3> = every(&job.counted(), BOUNDING).copied().collect();
        strip.around(&base.places(&bounding), noise).unwrap_or_else(|| strip.clone())
    };
    Base { strip: base.strip.as_ref().map(around), ..base.clone() }
}

/// The surface of heights, growing until nothing is gained. A fit that is `known` already says how
/// steep the first surface is, and which fairness to take unless it is given.
pub(super) fn fit(
    job: &Job<'_>,
    base: &Base,
    net: (usize, usize),
    growth: Option<Growth>,
    fairness: Option<f64>,
    known: Option<&Fit>,
    observer: &mut dyn Observer,
) -> Result<Fit> {
    let (mut iterations, mut near, mut known) = (0, None, known);
    let mut solve = |net: (usize, usize)| -> Result<(HeightFit, Base)> {
        let most = growth.map_or(0, |growth| growth.most) as u64;
        let step = ((net.0 * net.1) as u64).min(most);
        let progress = Progress::of_stage(Stage::Fitting, step, most, job.points.len());
        progress::report(observer, &progress)?;
        iterations += 1;
        let degree = (job.degree(net.0), job.degree(net.1));
        let options = HeightOptions { net, degree, fairness };
        let (steepness, found, base) = if let Some(known) = known.take() {
            let steepness =
                (!job.shape.straight).then(|| cosines(&known.surface, &known.uv, base.up));
            let base = known.base.clone().unwrap_or_else(|| base.clone());
            let fairness = fairness.unwrap_or(known.fairness);
            (steepness, Near::of(fairness, job.points.len()), base)
        } else {
            let (steepness, found, noise) = steepness(job, base, &options, near, observer)?;
            (steepness, found, under(job, base, noise))
        };
        // Noise has no direction, so what counts is the distance from the slope, not the height.
        let flat = |i: usize| steepness.as_ref().map_or(1.0, |cosines| cosines[i]);
        let weight = |i: usize| job.weight(i) * flat(i) * flat(i);
        let weights: Vec<f64> = (0..job.points.len()).map(weight).collect();
        let (points, weights) = (job.points, Some(weights.as_slice()));
        let fit = if growth.is_none() {
            fit_heights_with(points, weights, &base, &options, found, observer)?
        } else {
            let fairness = Some(found.beside(points.len()));
            let options = HeightOptions { fairness, ..options };
            fit_heights_over(points, weights, &base, &options, Some(found), observer)?
        };
        near = Some(Near::from(&fit));
        Ok((fit, base))
    };
    let mut net = net;
    let (mut fit, mut base) = solve(net)?;
    let counted = (0..job.points.len()).filter(|&i| job.weight(i) > 0.0).count();
    let ended_by = loop {
        let Some(growth) = growth else { break EndedBy::Grid };
        match growth.tolerance {
            Some(tolerance) if job.largest(&fit.residuals) <= tolerance => {
                break EndedBy::Tolerance;
            }
            None if fit.expected.sqrt() <= EXACT * diameter(job.points) => {
                break EndedBy::Exact;
            }
            _ => {}
        }
        let longer = |side: usize| whole((side as f64 * LONGER).ceil());
        let next = (longer(net.0), longer(net.1));
        let held = counted.max(MANY.min(MOST_PER_POINT * counted));
        if next.0 * next.1 > growth.most.min(held) {
            break if held < growth.most { EndedBy::Points } else { EndedBy::MaxControlPoints };
        }
        let (finer, finer_base) = match solve(next) {
            Ok(finer) => finer,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            // Between lines that lie far apart no point holds a control point.
            Err(_) => break EndedBy::Points,
        };
        if finer.expected > LEAST_GAIN * LEAST_GAIN * fit.expected {
            break EndedBy::Noise;
        }
        (net, fit, base) = (next, finer, finer_base);
    };
    let HeightFit { surface, uv, residuals, fairness, .. } = fit;
    if job.shape.straight {
        let distances = residuals.into_iter().map(f64::abs).collect();
        return Ok(Fit {
            surface,
            base: Some(base),
            uv,
            distances,
            fairness,
            iterations,
            ended_by,
        });
    }
    // The nearest place is not the one straight below.
    let (mut feet, mut distances) = (Vec::with_capacity(uv.len()), Vec::with_capacity(uv.len()));
    let mut listen = progress::listener(observer, Stage::Fitting, job.points.len());
    for (points, uv) in job.points.chunks(PORTION).zip(uv.chunks(PORTION)) {
        listen()?;
        let (uv, apart) = project(&surface, (false, false), points, uv);
        feet.extend(uv);
        distances.extend(apart);
    }
    Ok(Fit { surface, base: Some(base), uv: feet, distances, fairness, iterations, ended_by })
}

/// How steep the surface is at the points, as the cosine of its slope, if that counts, and the fairness that it
/// wants, looked for near one that is known: by a first fit to as many of them as tell. And by how much
/// this misses them.
fn steepness(
    job: &Job<'_>,
    base: &Base,
    options: &HeightOptions,
    near: Option<Near>,
    observer: &mut dyn Observer,
) -> Result<(Option<Vec<f64>>, Near, f64)> {
    let enough = (TELLING * options.net.0 * options.net.1).max(LEAST_TELLING);
    let points: Vec<DVec3> = every(job.points, enough).copied().collect();
    let weights: Option<Vec<f64>> =
        job.weights.as_ref().map(|weights| every(weights, enough).copied().collect());
    let weights = weights.as_deref();
    let first = match options.fairness {
        Some(fairness) => {
            let known = Near::of(fairness, job.points.len()).with_reach_of(near);
            fit_heights_with(&points, weights, base, options, known, observer)?
        }
        None => fit_heights_over(&points, weights, base, options, near, observer)?,
    };
    let squares = first.residuals.iter().map(|residual| residual * residual);
    let noise = (squares.sum::<f64>() / first.residuals.len() as f64).sqrt();
    let near = match options.fairness {
        Some(fairness) => {
            Near::of(fairness, job.points.len()).with_reach_of(Some(Near::from(&first)))
        }
        None => Near::from(&first),
    };
    if job.shape.straight {
        return Ok((None, near, noise));
    }
    let uv: Vec<DVec2> = if let Some(strip) = &base.strip {
        job.points.iter().map(|&point| base.along_strip(strip, point)).collect()
    } else {
        below(&first.surface, job.points, base)
    };
    Ok((Some(cosines(&first.surface, &uv, base.up)), near, noise))
}
