//! Heights over a plane: z = f(x, y) as a surface.
//!
//! The parameters are the places in the plane, so one least squares is the whole fit. With control
//! points at the Greville abscissae the plane's coordinates are linear in the parameters, and the
//! surface's heights are the tensor-product spline function of x and y.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::dense::Dense;
use super::ground::{Base, Ground};
use super::left_out::Near;
use super::patches::Patches;
use super::trend::Trend;
use super::{Equations, FitOptions};
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsSurface};
use crate::progress::{self, Listen, Observer, Stage};

/// Order of the derivatives whose energy is kept small, as far as the degree allows: third ones
/// leave quadratics free, which bend as most surfaces do.
const ORDER: usize = 3;

/// Order for so few points that a quadratic through them, which has six coefficients, would be far off
/// in the corners: second derivatives leave planes free.
const ORDER_OF_FEW: usize = 2;
const FEW: usize = 30;

/// Share of a square of places that is no quadratic of them under which all lie on one conic, on which a quadratic
/// vanishes that nothing else holds then: a circle, or two lines.
const CONIC: f64 = 1e-4;

/// Places that tell that, at equal steps.
const TELLING: usize = 5000;

/// How far beyond the heights of the points a surface may go where none are, as a share of their range, both
/// over the plane nearest to them.
const BEYOND: f64 = 0.5;

/// Gaps over which slopes end, as shares of the ground's side, where a surface goes farther: one after the
/// other.
const REACHES: [f64; 3] = [1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0];

/// Places to a span at which a surface is asked how far it goes.
const PLACES: usize = 2;

/// How heights are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightOptions {
    /// Rows and columns of the control net: along the plane's first and second axis.
    pub net: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// See [`FitOptions::fairness`]; `None`: the one among fifteen from 1e-12 to 30 that predicts
    /// points best which it has not seen.
    pub fairness: Option<f64>,
}

/// A surface of heights.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightFit {
    /// The surface, over a rectangle of the plane: see [`fit_heights`].
    pub surface: NurbsSurface,
    /// The points' parameters.
    pub uv: Vec<DVec2>,
    /// Heights of the points above the surface, in the points' unit.
    pub residuals: Vec<f64>,
    /// The weight of the fairness that was used.
    pub fairness: f64,
    /// Gaps over which slopes end, as a share of the ground's side, where bends alone would have let the
    /// surface go too far.
    pub reach: Option<f64>,
    /// Mean square of the error that cross-validation expects at a point that was left out, in the
    /// points' unit squared.
    pub expected: f64,
}

/// The surface z = f(x, y) closest to points in the sense of least squares, or the like along
/// another direction of length 1. Each squared height counts with its weight (1 without weights).
///
/// The surface ends at the rectangle around the points' places in the plane where more than two of
/// them lie on a side, as those of grids do. Where one or two do, the points are scattered and their
/// ground goes on: so does the surface, by two mean gaps between n points along the side's normal (2 /
/// n of the rectangle, 0.02 of it at most).
///
/// Where there are no points the fairness decides: the surface spans holes like a thin plate. Heights over the
/// plane nearest to all points are held within their range there, and half of it beyond on either side: where a
/// plate would go farther, its slopes count as well, over ever shorter ways, down to a 64th of the ground's
/// side.
/// O(points · degree⁴), a few times that where fairness is to be found (for 131,072 points at most).
///
/// ```
/// use neurbs::{DVec3, fit::{HeightOptions, fit_heights}, progress::Silent};
/// let points: Vec<DVec3> = (0..900)
///     .map(|i| (f64::from(i % 30) / 29.0, f64::from(i / 30) / 29.0))
///     .map(|(x, y)| DVec3::new(x, y, (2.0 * x).sin() * y))
///     .collect();
/// let options = HeightOptions { net: (8, 8), degree: (3, 3), fairness: None };
/// let found = fit_heights(&points, None, DVec3::Z, &options, &mut Silent)?;
/// assert!(found.residuals.iter().all(|height| height.abs() < 1e-4));
/// assert!((found.surface.point(0.25, 0.5).x - 0.25).abs() < 1e-14);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] if the direction has not the length 1 or the points have no extent across
/// it, and those of [`fit`](super::fit).
pub fn fit_heights(
    points: &[DVec3],
    weights: Option<&[f64]>,
    up: DVec3,
    options: &HeightOptions,
    observer: &mut dyn Observer,
) -> Result<HeightFit> {
    fit_heights_over(points, weights, &Base::over(points, up), options, None, observer)
}

/// As [`fit_heights`], but over what the base says; where it bends the surface has creases along v, if
/// the net has room for them. The fairness is looked for near one that was best with another net, and slopes
/// count as they did there.
pub(crate) fn fit_heights_over(
    points: &[DVec3],
    weights: Option<&[f64]>,
    base: &Base,
    options: &HeightOptions,
    near: Option<Near>,
    observer: &mut dyn Observer,
) -> Result<HeightFit> {
    let mut listen = progress::listener(observer, Stage::Fitting, points.len());
    let heights = Heights::of(points, weights, base, options)?;
    let (fairness, expected) = heights.best_fairness(options.fairness, near, &mut listen)?;
    let reach = near.and_then(|near| near.reach);
    let fit = heights.fitted(fairness, reach, &mut listen)?;
    Ok(HeightFit { expected, ..fit })
}

/// As [`fit_heights_over`] with this fairness, but nothing is expected of points left out, which takes
/// several times as long.
pub(crate) fn fit_heights_with(
    points: &[DVec3],
    weights: Option<&[f64]>,
    base: &Base,
    options: &HeightOptions,
    known: Near,
    observer: &mut dyn Observer,
) -> Result<HeightFit> {
    let fairness = known.beside(points.len());
    let options = HeightOptions { fairness: Some(fairness), ..*options };
    let mut listen = progress::listener(observer, Stage::Fitting, points.len());
    Heights::of(points, weights, base, &options)?.fitted(fairness, known.reach, &mut listen)
}

/// Points by their places in the unit square of a plane and their heights over it.
pub(super) struct Heights<'a> {
    axes: [DVec3; 3],
    ground: Ground,
    /// Their heights are those over the trend.
    pub(super) local: Vec<DVec3>,
    trend: Trend,
    pub(super) uv: Vec<DVec2>,
    weights: Option<&'a [f64]>,
    pub(super) options: FitOptions,
    /// Of the derivatives whose energy is kept small.
    pub(super) order: usize,
}

impl<'a> Heights<'a> {
    pub(super) fn of(
        points: &[DVec3],
        weights: Option<&'a [f64]>,
        base: &Base,
        options: &HeightOptions,
    ) -> Result<Self> {
        if !base.up.is_normalized() {
            return Err(Error::parameter("up", "a vector of length 1", base.up));
        }
        let Base { axes: [along, across], up, strip } = base;
        let turned = |p: &DVec3| DVec3::new(along.dot(*p), across.dot(*p), up.dot(*p));
        let mut local: Vec<DVec3> = points.par_iter().map(turned).collect();
        let counts = |i: usize| weights.is_none_or(|weights| weights.get(i) != Some(&0.0));
        let ground = match strip {
            Some(arms) => Ground::Strip(arms.clone()),
            None => Ground::around(&local, counts)?,
        };
        let uv: Vec<DVec2> =
            local.par_iter().map(|point| ground.parameters(point.truncate())).collect();
        let mut fitting = FitOptions::new(options.net, options.degree, (false, false))?;
        let (degree, rows) = (options.degree.0, options.net.0);
        fitting.knots_u = KnotVector::clamped_creased(degree, rows, ground.bends())?;
        fitting.fairness = options.fairness.unwrap_or(fitting.fairness);
        super::check(&local, &uv, weights, &fitting)?;
        let trend = Trend::of(&local, weights);
        local.par_iter_mut().for_each(|point| point.z -= trend.height(point.truncate()));
        let few = points.len() < FEW || on_conic(&uv);
        let order = if few { ORDER_OF_FEW } else { ORDER };
        let order = order.min(options.degree.0.max(options.degree.1));
        let axes = [*along, *across, *up];
        Ok(Self { axes, ground, local, trend, uv, weights, options: fitting, order })
    }

    fn fitted(
        self,
        fairness: f64,
        reach: Option<f64>,
        listen: &mut Listen<'_>,
    ) -> Result<HeightFit> {
        let (heights, reach) = self.held(fairness, reach, listen)?;
        let Self { axes: [along, across, up], ground, local, trend, uv, .. } = self;
        listen()?;
        let residuals = residuals(&heights, &local, &uv);
        let (rows, cols) = (heights.knots_u().greville(), heights.knots_v().greville());
        let net = heights.control_points().iter().enumerate().map(|(i, point)| {
            let place = ground.place(DVec2::new(rows[i / cols.len()], cols[i % cols.len()]));
            place.x * along + place.y * across + (point.z + trend.height(place)) * up
        });
        let (knots_u, knots_v) = (heights.knots_u().clone(), heights.knots_v().clone());
        let surface = NurbsSurface::new(net.collect(), None, knots_u, knots_v)?;
        Ok(HeightFit { surface, uv, residuals, fairness, reach, expected: f64::INFINITY })
    }

    /// The surface over the trend, held where there are no points, and the reach that this takes, at most
    /// the one that is known.
    fn held(
        &self,
        fairness: f64,
        known: Option<f64>,
        listen: &mut Listen<'_>,
    ) -> Result<(NurbsSurface, Option<f64>)> {
        let Self { local, uv, weights, options, order, .. } = self;
        let mut equations = Equations::of(local, uv, *weights, options, *order, listen)?;
        if let Some(reach) = known {
            equations.tighten(reach);
        }
        let (low, high) = range(local.iter().map(|point| point.z));
        let beyond = BEYOND * (high - low);
        let (mut heights, mut reach) = (equations.solve(fairness, listen)?, known);
        for shorter in
            REACHES.into_iter().filter(|shorter| known.is_none_or(|known| *shorter < known))
        {
            let (lowest, highest) = range(self::heights(&heights));
            if fairness == 0.0 || low - beyond <= lowest && highest <= high + beyond {
                break;
            }
            equations.tighten(shorter);
            (heights, reach) = (equations.solve(fairness, listen)?, Some(shorter));
        }
        Ok((heights, reach))
    }

    pub(super) fn weight(&self, i: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights[i])
    }
}

/// Whether a quadratic vanishes on all places: one of its terms is a sum of those before it there.
fn on_conic(uv: &[DVec2]) -> bool {
    const TERMS: usize = 6;
    let mut moments = Dense::new(TERMS);
    for place in uv.iter().step_by((uv.len() / TELLING).max(1)) {
        let DVec2 { x, y } = 2.0 * *place - 1.0;
        let terms = [1.0, x, y, x * x, x * y, y * y];
        for (i, a) in terms.iter().enumerate() {
            terms.iter().enumerate().for_each(|(j, b)| moments.values[i * TERMS + j] += a * b);
        }
    }
    let Some(lower) = moments.cholesky() else { return true };
    (0..TERMS * TERMS)
        .step_by(TERMS + 1)
        .any(|at| lower.values[at].powi(2) < CONIC * moments.values[at])
}

fn range(heights: impl Iterator<Item = f64>) -> (f64, f64) {
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)))
}

/// Heights of a surface, evenly over its domain.
fn heights(surface: &NurbsSurface) -> impl Iterator<Item = f64> {
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let [rows, cols] = [u, v].map(|knots| PLACES * (knots.control_points() - knots.degree()));
    let place = |i: usize| {
        DVec2::new((i / (cols + 1)) as f64 / rows as f64, (i % (cols + 1)) as f64 / cols as f64)
    };
    Patches::of(surface).each((rows + 1) * (cols + 1), place, |_, place| place.point.z).into_iter()
}

/// Heights of points over a surface.
fn residuals(surface: &NurbsSurface, local: &[DVec3], uv: &[DVec2]) -> Vec<f64> {
    Patches::of(surface).each(uv.len(), |i| uv[i], |i, place| local[i].z - place.point.z)
}

/// How steeply a surface rises at parameters: the cosine of the angle between its normal and a
/// direction.
pub(crate) fn cosines(surface: &NurbsSurface, uv: &[DVec2], up: DVec3) -> Vec<f64> {
    Patches::of(surface).each(uv.len(), |i| uv[i], |_, place| place.normal().dot(up))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn unit(i: u32) -> (f64, f64) {
        let i = f64::from(i);
        ((i * 0.754_877_666_246_692_7).fract(), (i * 0.569_840_290_998_053_2).fract())
    }

    /// Noise of deviation 1, from eight numbers that look random.
    fn noise(i: u32) -> f64 {
        let uniform = (1..9).map(|k| (f64::from(i) * 0.618_033 * f64::from(k * k)).fract() - 0.5);
        uniform.sum::<f64>() * (12.0_f64 / 8.0).sqrt()
    }

    fn wave(x: f64, y: f64) -> f64 {
        (3.0 * x).sin() * (2.0 * y).cos()
    }

    fn options(side: usize) -> HeightOptions {
        HeightOptions { net: (side, side), degree: (3, 3), fairness: None }
    }

    #[test]
    fn heights_over_a_circle_or_two_lines_are_held_beside_it() {
        let circle = |i: u32| DVec2::from_angle(0.01 * f64::from(i));
        let lines = |i: u32| DVec2::new(f64::from(i % 300), f64::from(i % 2));
        for place in [circle, lines] {
            let points: Vec<DVec3> =
                (0..600).map(place).map(|p| p.extend(0.3 * p.x + wave(p.x, 0.0))).collect();
            let fit = fit_heights(&points, None, DVec3::Z, &options(8), &mut Silent).unwrap();
            let (low, high) = range(heights(&fit.surface));
            let (least, most) = range(points.iter().map(|point| point.z));
            let beyond = 0.6 * (most - least);
            assert!(low > least - beyond && high < most + beyond, "{low} {high} {least} {most}");
        }
    }

    #[test]
    fn exact_heights_get_next_to_no_fairness_and_noisy_ones_much() {
        let exact: Vec<DVec3> =
            (0..2000).map(unit).map(|(x, y)| DVec3::new(x, y, wave(x, y))).collect();
        let noisy: Vec<DVec3> =
            (0..).zip(&exact).take(200).map(|(i, p)| *p + DVec3::Z * 0.02 * noise(i)).collect();
        let free = fit_heights(&exact, None, DVec3::Z, &options(12), &mut Silent).unwrap();
        let best = HeightOptions { fairness: Some(0.0), ..options(12) };
        let best = fit_heights(&exact, None, DVec3::Z, &best, &mut Silent).unwrap();
        let sum = |fit: &HeightFit| fit.residuals.iter().map(|height| height * height).sum::<f64>();
        assert!(sum(&free) < 1.1 * sum(&best), "{} {}", sum(&free), sum(&best));
        let found = fit_heights(&noisy, None, DVec3::Z, &options(12), &mut Silent).unwrap();
        assert!(found.fairness >= 100.0 * free.fairness, "{}", found.fairness);
        let (low, high) = (found.surface.point(0.0, 0.0), found.surface.point(1.0, 1.0));
        let error = |p: &DVec3| {
            let at = (*p - low) / (high - low);
            found.surface.point(at.x.clamp(0.0, 1.0), at.y.clamp(0.0, 1.0)).z - p.z
        };
        let rms = |points: &[DVec3]| {
            (points.iter().map(|p| error(p).powi(2)).sum::<f64>() / points.len() as f64).sqrt()
        };
        // A net of 144 through 200 noisy points would err by more than the noise.
        assert!(rms(&exact) < 0.015, "{}", rms(&exact));
    }

    #[test]
    fn holes_are_spanned_smoothly() {
        let points: Vec<DVec3> = (0..3000)
            .map(unit)
            .filter(|(x, y)| (x - 0.5).hypot(y - 0.5) > 0.2)
            .map(|(x, y)| DVec3::new(x, y, 0.3 * wave(x, y)))
            .collect();
        let found = fit_heights(&points, None, DVec3::Z, &options(20), &mut Silent).unwrap();
        assert!((found.surface.point(0.5, 0.5).z - 0.3 * wave(0.5, 0.5)).abs() < 0.02);
    }

    #[test]
    fn corners_without_points_stay_within_half_the_range_beyond() {
        // A trench that deepens ever faster towards where the points end.
        let points: Vec<DVec3> = (0..3000)
            .map(unit)
            .filter(|(x, y)| x + y < 0.7 || *x > 0.98 && *y > 0.98)
            .map(|(x, y)| DVec3::new(x, y, 2.0 * x - 100.0 * (x + y).powi(8)))
            .filter(|point| point.z > -20.0)
            .collect();
        let corner = |x: f64| DVec3::new(x, x, 2.0 * x);
        let points: Vec<DVec3> = points.into_iter().chain([corner(0.99), corner(1.0)]).collect();
        let options = HeightOptions { fairness: Some(1e-4), ..options(16) };
        let found = fit_heights(&points, None, DVec3::Z, &options, &mut Silent).unwrap();
        assert!(found.reach.is_some());
        let trend = Trend::of(&points, None);
        let over = |point: DVec3| point.z - trend.height(point.truncate());
        let (low, high) = range(points.iter().map(|&point| over(point)));
        let places = (0..2500).map(|i| (f64::from(i % 50) / 49.0, f64::from(i / 50) / 49.0));
        let (lowest, highest) = range(places.map(|(u, v)| over(found.surface.point(u, v))));
        let beyond = 0.55 * (high - low);
        assert!(low - beyond < lowest && highest < high + beyond, "{lowest} {highest}");
    }

    #[test]
    fn another_direction_gives_the_turned_surface() {
        let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.4, 1.0, -0.3);
        let points: Vec<DVec3> = (0..1500)
            .map(unit)
            .map(|(x, y)| turn * DVec3::new(3.0 * x, y, 0.2 * wave(x, y)))
            .collect();
        let found = fit_heights(&points, None, turn * DVec3::Z, &options(10), &mut Silent).unwrap();
        assert!(found.residuals.iter().all(|height| height.abs() < 1e-3));
        let feet = points.iter().zip(&found.uv);
        let gap = |(p, at): (&DVec3, &DVec2)| found.surface.point(at.x, at.y).distance(*p);
        assert!(feet.map(gap).fold(0.0, f64::max) < 1e-3);
    }

    #[test]
    fn a_line_is_no_field() {
        let line: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i), 2.0, 1.0)).collect();
        let error = fit_heights(&line, None, DVec3::Z, &options(4), &mut Silent).unwrap_err();
        assert!(error.to_string().contains("extended across"));
    }
}
