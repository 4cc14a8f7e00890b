//! Exact recovery: the net of a surface, from points on it.
//!
//! Control points and parameters are found together. The problem has many local minima, since the
//! positions of the knots on the surface are unknown, as in free-knot spline fitting. So the search
//! starts from several parametrizations.

mod lm_iterate;
mod multistart;
mod settings;
mod varpro;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::lm_iterate::Trial;
use self::multistart::{StartParameters, search};
use self::settings::RecoverySettings;
use self::varpro::Problem;
use super::adaptive_refinement::{EXACT_ERROR, diameter};
use super::approximate_scattered::approximate;
use super::options::ApproximateOptions;
use super::spline_space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, NurbsSurface};
use crate::progress::{self, Observer, Progress, Stage};

const SETTINGS: RecoverySettings = RecoverySettings::STANDARD;

/// The surface with a net of this shape through points of a surface like this, from rough
/// parameters in [0, 1]². Closed directions have the period 1, and the shape excludes repeated
/// control points.
///
/// `None` if no surface is found whose rms distance is at most 1e-5 of the points' diameter. Then
/// the points may be noisy or lie on no surface with this net, or the search ended in a local
/// minimum.
///
/// # Errors
///
/// [`Error::Parameter`](crate::Error::Parameter) if the net is too small for the degree;
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn recover_net(
    points: &[DVec3],
    uv: &[DVec2],
    shape: (usize, usize),
    degree: usize,
    closed: (bool, bool),
    observer: &mut dyn Observer,
) -> Result<Option<NurbsSurface>> {
    let options = ApproximateOptions {
        net: shape,
        degree: (degree, degree),
        closed,
        border: 0.0,
        ..ApproximateOptions::default()
    };
    let near = approximate(points, uv, None, &options, observer)?;
    let knots = [near.surface.knots_u().clone(), near.surface.knots_v().clone()];
    let space = SplineSpace::new(knots, closed.into())?;
    // With fewer points than unknown numbers, many surfaces pass through all points.
    let unknown_numbers = 3 * space.unknowns();
    if points.len() < unknown_numbers {
        return Ok(None);
    }
    let size = diameter(points);
    let step = (points.len() / (SETTINGS.points_per_control_point * space.unknowns())).max(1);
    let subset: Vec<DVec3> = points.iter().step_by(step).copied().collect();
    let subset = Problem { points: &subset, space: &space, beyond: SETTINGS.extension, size };
    let uv: Vec<DVec2> = near.uv.iter().step_by(step).copied().collect();
    let starts = StartParameters { space: &space, uv: &uv };
    let mut found = search(&subset, &starts.even(), observer)?;
    if found.as_ref().is_none_or(|found| found.error > EXACT_ERROR * size) {
        let other = search(&subset, &starts.graded(), observer)?;
        found = other.into_iter().chain(found).min_by(|a, b| a.error.total_cmp(&b.error));
    }
    let Some(found) = found.filter(|found| found.error <= EXACT_ERROR * size) else {
        return Ok(None);
    };
    // The domain must end at the outermost points. Projections that stay in the domain move its
    // ends there.
    let open = Problem { points, ..subset };
    let all = Problem { beyond: 0.0, ..open };
    let search = ClosestPointSearch::new(&found.surface)?;
    let nearest = points.par_iter().map(|point| search.closest_point(*point).uv);
    let uv: Vec<DVec2> = nearest.collect();
    let trial = Trial::from_surface(&open, found.surface.clone(), &uv);
    let mut trial =
        Trial::from_parameters(&all, &open.scaled_to_domain(&trial.projections))?.unwrap_or(trial);
    for step in 0..SETTINGS.final_steps {
        if all.is_converged(trial.error) {
            break;
        }
        let (step, total) = (step as u64, SETTINGS.final_steps as u64);
        progress::report(observer, &Progress::of_stage(Stage::Fitting, step, total, points.len()))?;
        trial.advance(&all)?;
    }
    Ok((trial.error <= EXACT_ERROR * size).then_some(trial.surface))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::options::uniform;
    use super::*;
    use crate::progress::Silent;

    fn scattered(count: u32) -> Vec<DVec2> {
        let place = |i: u32| {
            let at = f64::from(i) + 0.5;
            DVec2::new((at * 0.754_877_666_247).fract(), (at * 0.569_840_290_998).fract())
        };
        (0..count).map(place).collect()
    }

    fn bumps(at: DVec2) -> DVec3 {
        let wave = |k: f64| (37.0 * k * at.x).sin() * (53.0 * k * at.y + k).cos();
        DVec3::new(wave(1.0), wave(1.7), wave(2.3))
    }

    /// Whether the surface of a net is recovered from points on it.
    fn is_recovered(
        shape: (usize, usize),
        closed: (bool, bool),
        place: impl Fn(DVec2) -> DVec3,
    ) -> bool {
        let knots = |count, closed| uniform(3, count, closed).unwrap();
        let knots = [knots(shape.0, closed.0), knots(shape.1, closed.1)];
        let space = SplineSpace::new(knots, closed.into()).unwrap();
        let [rows, cols] = space.shape();
        let mut net = vec![DVec3::ZERO; rows * cols];
        for (i, j) in (0..rows).flat_map(|i| (0..cols).map(move |j| (i, j))) {
            let share = |i: usize, count: usize, closed: bool| {
                i as f64 / (count - usize::from(!closed)) as f64
            };
            let at = DVec2::new(share(i, rows, closed.0), share(j, cols, closed.1));
            net[space.place(i, j)] = place(at);
        }
        let truth = space.surface(&net).unwrap();
        let uv = scattered(1500);
        let points: Vec<DVec3> = uv.iter().map(|at| truth.point(at.x, at.y)).collect();
        // Rough parameters.
        let rough = |at: &DVec2| {
            let wave = 0.02 * DVec2::new((TAU * at.x).sin(), (TAU * at.y).sin());
            *at + wave
        };
        let uv: Vec<DVec2> = uv.iter().map(rough).collect();
        let found = recover_net(&points, &uv, shape, 3, closed, &mut Silent).unwrap();
        let Some(found) = found else { return false };
        let search = ClosestPointSearch::new(&found).unwrap();
        let size = diameter(&points);
        let far = |point: &DVec3| search.closest_point(*point).distance;
        points.iter().map(far).fold(0.0, f64::max) < 1e-6 * size
    }

    #[test]
    fn nets_of_sheets_are_recovered() {
        let arch = |at: DVec2| {
            let (sin, cos) = (3.0 * at.x).sin_cos();
            DVec3::new(cos, 1.4 * at.y, sin) + 0.04 * bumps(at)
        };
        let waves = |at: DVec2| {
            let z = 0.2 * (5.0 * at.x).sin() * (5.0 * at.y).cos();
            DVec3::new(1.4 * at.x.powf(1.5), at.y.powf(0.8), z)
        };
        for shape in [(4, 4), (6, 6), (8, 7)] {
            assert!(is_recovered(shape, (false, false), arch), "{shape:?}");
            assert!(is_recovered(shape, (false, false), waves), "{shape:?}");
        }
    }

    #[test]
    fn nets_of_tubes_and_tori_are_recovered() {
        let tube = |at: DVec2| {
            let (sin, cos) = (TAU * at.x).sin_cos();
            DVec3::new(cos, sin, 3.0 * at.y) + 0.08 * bumps(at)
        };
        let torus = |at: DVec2| {
            let ((sin, cos), (up, out)) = ((TAU * at.x).sin_cos(), (TAU * at.y).sin_cos());
            let radius = 2.0 + 0.7 * out;
            DVec3::new(radius * cos, radius * sin, 0.7 * up) + 0.05 * bumps(at)
        };
        assert!(is_recovered((8, 5), (true, false), tube));
        assert!(is_recovered((8, 7), (true, true), torus));
    }

    #[test]
    fn points_of_other_surfaces_have_no_such_net() {
        let uv = scattered(600);
        let points: Vec<DVec3> = uv.iter().map(|at| at.extend((9.0 * at.x).sin())).collect();
        let found = recover_net(&points, &uv, (5, 4), 3, (false, false), &mut Silent).unwrap();
        assert!(found.is_none());
    }
}
