//! Height field: z = f(x, y) as a surface.
//!
//! The parameters are the places in the plane, so a single least-squares solution suffices. Control
//! points lie at the Greville abscissae, so the plane's coordinates are linear in the parameters.
//! The surface's heights are a tensor-product spline of x and y.

use glam::DVec3;

use super::adaptive_refinement::{EXACT_ERROR, diameter};
use super::base_domain::BasePlane;
use super::fit_result::{EndedBy, HeightFit};
use super::height_cv::Choice;
use super::height_field::HeightField;
use super::options::{Growth, HeightOptions};
use super::settings::HeightSettings;
use super::warm_start::WarmStart;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Stage};
use crate::worker_pool;

const SETTINGS: HeightSettings = HeightSettings::STANDARD;

/// The least-squares surface z = f(x, y), or the same along another direction of length 1. Each
/// squared residual is multiplied by its weight, 1 without weights.
///
/// The surface covers the rectangle around the points' places in the plane. A side with more than
/// two points on it is kept, as in grids. Otherwise the points are scattered, and the surface
/// extends beyond the side by two mean gaps between n points: 2 / n of the rectangle, at most 0.02
/// of it.
///
/// Where there are no points, the fairness decides: the surface spans holes like a thin plate.
/// There, heights over the regression plane stay within their range and half of it beyond on either
/// side. Where a plate would exceed this, slopes are penalized as well, over ever shorter lengths
/// down to a 64th of the side.
///
/// O(points · degree⁴), a few times as much where the fairness is chosen by cross-validation (by
/// 20,000 points at most).
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
/// [`Error::Parameter`] if the direction does not have length 1 or the points have no extent across
/// it, and those of [`fit`](super::fit).
pub fn fit_heights(
    points: &[DVec3],
    weights: Option<&[f64]>,
    up: DVec3,
    options: &HeightOptions,
    observer: &mut dyn Observer,
) -> Result<HeightFit> {
    worker_pool::run_observed(points.len(), observer, |observer| {
        let base = BasePlane::over(points, up);
        fit_heights_over(points, weights, &base, options, None, observer)
    })
}

/// Like [`fit_heights`], over a given plane. The search for the fairness starts near that of
/// another net, and slopes are penalized as there.
pub(crate) fn fit_heights_over(
    points: &[DVec3],
    weights: Option<&[f64]>,
    base: &BasePlane,
    options: &HeightOptions,
    near: Option<WarmStart>,
    observer: &mut dyn Observer,
) -> Result<HeightFit> {
    let mut check_interrupt = progress::interrupt_check(observer, Stage::Fitting, points.len());
    let heights = HeightField::of(points, weights, base, options)?;
    let equations = heights.equations(&mut check_interrupt)?;
    let found = heights.choose(&equations, options.fairness, near, &mut check_interrupt)?;
    let reach = near.and_then(|near| near.reach);
    let Choice { equations, fairness, anisotropy, expected, expected_in_gaps } = found;
    let fit = heights.fitted(equations, fairness, reach, &mut check_interrupt)?;
    Ok(HeightFit { anisotropy, expected, expected_in_gaps, ..fit })
}

/// Like [`fit_heights_over`], with a net that grows. It stops when the tolerance holds, or without
/// one when cross-validation expects no smaller error.
///
/// # Errors
///
/// Those of [`fit_heights`].
pub(crate) fn grow_heights(
    points: &[DVec3],
    weights: Option<&[f64]>,
    base: &BasePlane,
    options: &HeightOptions,
    growth: Growth,
    observer: &mut dyn Observer,
) -> Result<(HeightFit, EndedBy)> {
    let used_point = |i: usize| weights.is_none_or(|weights| weights[i] > 0.0);
    let used = (0..points.len()).filter(|&i| used_point(i)).count();
    // Cross-validation ends the growth, so a net may have more control points than points.
    let max_supported = SETTINGS.max_control_points_per_point * used;
    let mut options = *options;
    let mut fit = fit_heights_over(points, weights, base, &options, None, observer)?;
    loop {
        let within = |tolerance: f64| {
            let mut residuals = fit.residuals.iter().enumerate();
            residuals.all(|(i, residual)| residual.abs() <= tolerance || !used_point(i))
        };
        match growth.tolerance {
            Some(tolerance) if within(tolerance) => return Ok((fit, EndedBy::Tolerance)),
            None if fit.expected.sqrt() <= EXACT_ERROR * diameter(points) => {
                return Ok((fit, EndedBy::Exact));
            }
            _ => {}
        }
        let longer = |side: usize| (3 * side).div_ceil(2);
        options.net = (longer(options.net.0), longer(options.net.1));
        if options.net.0 * options.net.1 > growth.most.min(max_supported) {
            let points_limit = max_supported < growth.most;
            return Ok((
                fit,
                if points_limit { EndedBy::Points } else { EndedBy::MaxControlPoints },
            ));
        }
        let near = Some(WarmStart::from(&fit));
        let finer = match fit_heights_over(points, weights, base, &options, near, observer) {
            Ok(finer) => finer,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            // Between distant lines no point determines a control point.
            Err(_) => return Ok((fit, EndedBy::Points)),
        };
        let gains = finer.expected_in_gaps < SETTINGS.significant_ratio() * fit.expected_in_gaps;
        if !gains && growth.tolerance.is_none() {
            return Ok((fit, EndedBy::Noise));
        }
        fit = finer;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::height_field::heights;
    use super::super::plane_trend::PlaneTrend;
    use super::*;
    use crate::numeric::min_max;
    use crate::progress::Silent;

    fn unit(i: u32) -> (f64, f64) {
        let i = f64::from(i);
        ((i * 0.754_877_666_246_692_7).fract(), (i * 0.569_840_290_998_053_2).fract())
    }

    /// Noise of standard deviation 1, from eight numbers that look random.
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
    fn heights_over_a_circle_or_two_lines_do_not_overshoot() {
        let circle = |i: u32| DVec2::from_angle(0.01 * f64::from(i));
        let lines = |i: u32| DVec2::new(f64::from(i % 300), f64::from(i % 2));
        for place in [circle, lines] {
            let points: Vec<DVec3> =
                (0..600).map(place).map(|p| p.extend(0.3 * p.x + wave(p.x, 0.0))).collect();
            let fit = fit_heights(&points, None, DVec3::Z, &options(8), &mut Silent).unwrap();
            let (low, high) = min_max(heights(&fit.surface));
            let (least, most) = min_max(points.iter().map(|point| point.z));
            let beyond = 0.6 * (most - least);
            assert!(low > least - beyond && high < most + beyond, "{low} {high} {least} {most}");
        }
    }

    #[test]
    fn exact_heights_get_little_fairness_and_noisy_heights_get_much() {
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
        // A net of 144 through 200 noisy points would have a larger error than the noise.
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
    fn empty_corners_exceed_the_range_by_at_most_half() {
        // A trench that becomes ever steeper towards the boundary of the points.
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
        let trend = PlaneTrend::of(&points, None);
        let over = |point: DVec3| point.z - trend.height(point.truncate());
        let (low, high) = min_max(points.iter().map(|&point| over(point)));
        let places = (0..2500).map(|i| (f64::from(i % 50) / 49.0, f64::from(i / 50) / 49.0));
        let (lowest, highest) = min_max(places.map(|(u, v)| over(found.surface.point(u, v))));
        let beyond = 0.55 * (high - low);
        assert!(low - beyond < lowest && highest < high + beyond, "{lowest} {highest}");
    }

    #[test]
    fn a_rotated_direction_gives_the_rotated_surface() {
        let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.4, 1.0, -0.3);
        let points: Vec<DVec3> = (0..1500)
            .map(unit)
            .map(|(x, y)| turn * DVec3::new(3.0 * x, y, 0.2 * wave(x, y)))
            .collect();
        let found = fit_heights(&points, None, turn * DVec3::Z, &options(10), &mut Silent).unwrap();
        assert!(found.residuals.iter().all(|height| height.abs() < 1e-3));
        let projections = points.iter().zip(&found.uv);
        let gap = |(p, at): (&DVec3, &DVec2)| found.surface.point(at.x, at.y).distance(*p);
        assert!(projections.map(gap).fold(0.0, f64::max) < 1e-3);
    }

    #[test]
    fn collinear_points_are_refused() {
        let line: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i), 2.0, 1.0)).collect();
        let error = fit_heights(&line, None, DVec3::Z, &options(4), &mut Silent).unwrap_err();
        assert!(error.to_string().contains("extended across"));
    }

    #[test]
    fn heights_between_sweeps_stay_close() {
        for seed in 0..5 {
            let point = |i: u32| {
                let (x, y) = unit(i + 1000 * seed);
                let x = 100.0 + 200.0 * f64::from(i / 100) + 10.0 * (x - 0.5);
                let y = 20.0 * y - 10.0;
                DVec3::new(x, y, x / 20.0 * (y / 3.0).sin())
            };
            let points: Vec<DVec3> = (0..500).map(point).collect();
            for net in [(4, 4), (8, 8)] {
                let options = HeightOptions { net, degree: (3, 3), fairness: None };
                let (base, growth) =
                    (BasePlane::over(&points, DVec3::Z), Growth { tolerance: None, most: 2000 });
                let found =
                    grow_heights(&points, None, &base, &options, growth, &mut Silent).unwrap();
                let (surface, size) = (&found.0.surface, DVec2::new(800.0, 18.0));
                let (low, high) = (surface.point(0.0, 0.0), surface.point(1.0, 1.0));
                let off = |i: u32| {
                    let (x, y) = unit(i);
                    let at = DVec2::new(100.0, -9.0) + DVec2::new(x, y) * size;
                    let uv = (at - low.truncate()) / (high - low).truncate();
                    (surface.point(uv.x, uv.y).z - at.x / 20.0 * (at.y / 3.0).sin()).abs()
                };
                let worst = (0..1000).map(off).fold(0.0, f64::max);
                assert!(worst < 2.0, "{seed} {net:?} {worst} {:?}", found.1);
            }
        }
    }
}
