//! Properties of fitted surfaces: accuracy, invariance, growth and interruption.

use glam::{DMat3, DQuat, DVec2};
use neurbs::chart::Kind;
use neurbs::cloud::Bounds;
use neurbs::fit::EndedBy;
use neurbs::nurbs::ClosestPointSearch;
use neurbs::pipeline::Aspect;
use neurbs::progress::{Progress, Silent};
use neurbs::{
    DVec3, Diagnostic, Error, NurbsSurface, ReconstructOptions, Reconstruction, Result, reconstruct,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Numbers that look random, from 0 to 1: an additive recurrence spreads them evenly.
fn scattered(count: usize) -> impl Iterator<Item = DVec2> {
    let (a, b) = (0.754_877_666_246_693, 0.569_840_290_998_053);
    (0..count).map(move |i| DVec2::new((0.5 + a * i as f64).fract(), (0.5 + b * i as f64).fract()))
}

/// A sheet rolled to two thirds of a cylinder, with a bump.
fn rolled(count: usize) -> Vec<DVec3> {
    let place = |at: DVec2| {
        let (angle, z) = (at.x * TAU * 2.0 / 3.0, 2.0 * at.y);
        let r = 1.0 + 0.2 * (-((angle - 2.0).powi(2) + (z - 1.1).powi(2)) / 0.3).exp();
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    };
    scattered(count).map(place).collect()
}

/// A height field over a square.
fn waves(count: usize) -> Vec<DVec3> {
    let height = |at: DVec2| (3.0 * at.x).sin() * (2.0 * at.y).cos();
    scattered(count).map(|at| at.extend(0.5 * height(at))).collect()
}

/// The points with deterministic noise of this standard deviation.
fn noisy(points: &[DVec3], size: f64) -> Vec<DVec3> {
    let wave = |i: usize, k: f64| (k * (i * i % 9973) as f64).sin() * 2.0_f64.sqrt() * size;
    let noise = |i: usize| DVec3::new(wave(i, 1.7), wave(i, 2.9), wave(i, 0.83));
    points.iter().enumerate().map(|(i, point)| *point + noise(i)).collect()
}

fn with_grid(points: &[DVec3], side: usize, kind: Kind) -> Reconstruction {
    let options = ReconstructOptions {
        grid: Some((side, side)),
        kind: Some(kind),
        ..ReconstructOptions::default()
    };
    reconstruct(points, &options, &mut Silent).unwrap()
}

/// Largest distance of points from a surface.
fn farthest(points: &[DVec3], surface: &NurbsSurface) -> f64 {
    let search = ClosestPointSearch::new(surface).unwrap();
    points.iter().map(|&point| search.closest_point(point).distance).fold(0.0, f64::max)
}

#[test]
fn a_rolled_sheet_is_fitted_and_its_deviations_are_distances() {
    let points = rolled(1500);
    let result = with_grid(&points, 12, Kind::Sheet);
    let size = Bounds::of(&points).diagonal();
    assert!(result.report.deviations.rms < 2e-4 * size, "{:?}", result.report.deviations);
    let search = ClosestPointSearch::new(&result.surface).unwrap();
    for ((point, distance), uv) in points.iter().zip(&result.deviations).zip(&result.uv) {
        let there = result.surface.point(uv.x, uv.y);
        assert!((there.distance(*point) - distance).abs() < 1e-11 * size);
        assert!(search.closest_point(*point).distance <= distance + 1e-11 * size);
    }
    // The budget follows the shape: about twice as long as wide.
    let (rows, cols) = result.surface.shape();
    assert!(rows > cols && (130..=144).contains(&(rows * cols)), "{rows} × {cols}");
}

#[test]
fn tubes_and_tori_close_smoothly() {
    let torus = |at: DVec2| {
        let (a, b) = (TAU * at.x, TAU * at.y);
        let r = 1.0 + 0.4 * b.cos();
        DVec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin())
    };
    let points: Vec<DVec3> = scattered(2000).map(torus).collect();
    let result = with_grid(&points, 12, Kind::Torus);
    assert_eq!(result.surface.closed(), (true, true));
    assert!(result.report.deviations.max < 5e-4 * result.report.diagonal);

    let tube = |at: DVec2| {
        let (a, z) = (TAU * at.x, 3.0 * at.y);
        let r = 1.0 + 0.2 * (2.0 * a).cos() * z.sin();
        DVec3::new(r * a.cos(), r * a.sin(), z)
    };
    let points: Vec<DVec3> = scattered(2000).map(tube).collect();
    let result = with_grid(&points, 12, Kind::Tube);
    assert_eq!(result.surface.closed(), (true, false));
    assert!(result.report.deviations.max < 2e-3 * result.report.diagonal);
}

#[test]
fn rigid_motion_and_scale_apply_to_the_fit() {
    let points = rolled(800);
    let expected = with_grid(&points, 9, Kind::Sheet);
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 0.7));
    let (scale, offset) = (250.0, DVec3::new(1e4, -3e4, 5e3));
    let moved: Vec<DVec3> = points.iter().map(|&p| scale * (turn * p) + offset).collect();
    let got = with_grid(&moved, 9, Kind::Sheet);
    let size = expected.report.diagonal;
    let back: Vec<DVec3> = got
        .surface
        .control_points()
        .iter()
        .map(|p| turn.transpose() * (*p - offset) / scale)
        .collect();
    // The directions of u and v may differ, but the surface must be the same.
    let surface =
        NurbsSurface::new(back, None, got.surface.knots_u().clone(), got.surface.knots_v().clone())
            .unwrap();
    for at in scattered(200) {
        let search = ClosestPointSearch::new(&surface).unwrap();
        let distance = search.closest_point(expected.surface.point(at.x, at.y)).distance;
        assert!(distance < 1e-6 * size, "{distance}");
    }
}

#[test]
fn the_order_of_the_points_changes_nothing() {
    let points = rolled(700);
    let mut turned = points.clone();
    turned.reverse();
    turned.rotate_left(123);
    let (expected, got) = (with_grid(&points, 9, Kind::Sheet), with_grid(&turned, 9, Kind::Sheet));
    let size = expected.report.diagonal;
    let pairs = got.surface.control_points().iter().zip(expected.surface.control_points());
    for (got, expected) in pairs {
        assert!(got.distance(*expected) < 1e-9 * size, "{got} {expected}");
    }
}

#[test]
fn heights_of_the_same_net_are_recovered() {
    for (seed, net) in [(1, (4, 4)), (2, (5, 9)), (3, (8, 6)), (4, (12, 12)), (5, (16, 7))] {
        let flat = NurbsSurface::clamped(vec![DVec3::ZERO; net.0 * net.1], net, 3).unwrap();
        let (x, y) = (flat.knots_u().greville(), flat.knots_v().greville());
        let height = |i: usize| 0.3 * (f64::from(seed) * 12.9 + 78.2 * i as f64).sin();
        let places = x.iter().flat_map(|x| y.iter().map(move |y| (3.0 * x, 2.0 * y)));
        let control_points = places.zip(0..).map(|((x, y), i)| DVec3::new(x, y, height(i)));
        let truth = NurbsSurface::clamped(control_points.collect(), net, 3).unwrap();
        let border = (0..=40).map(|i| f64::from(i) / 40.0);
        let border = border.flat_map(|t| [(t, 0.0), (t, 1.0), (0.0, t), (1.0, t)]);
        let uv = border.map(DVec2::from).chain(scattered(2000));
        let points: Vec<DVec3> = uv.map(|at| truth.point(at.x, at.y)).collect();
        let options = ReconstructOptions {
            grid: Some(net),
            aspect: Aspect::Fixed,
            kind: Some(Kind::Height),
            ..ReconstructOptions::default()
        };
        let found = reconstruct(&points, &options, &mut Silent).unwrap();
        let others: Vec<DVec3> =
            scattered(3000).skip(2000).map(|at| truth.point(at.x, at.y)).collect();
        let far = farthest(&others, &found.surface);
        assert!(far < 1e-6 * found.report.diagonal, "{net:?} {far}");
    }
}

#[test]
fn a_tolerance_makes_the_net_grow_until_it_holds() {
    let points = waves(3000);
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let options =
            ReconstructOptions { tolerance: Some(tolerance), ..ReconstructOptions::default() };
        let result = reconstruct(&points, &options, &mut Silent).unwrap();
        assert!(result.report.converged);
        assert_eq!(result.report.ended_by, EndedBy::Tolerance);
        assert_eq!(result.report.within, Some(1.0));
        assert!(farthest(&points, &result.surface) <= tolerance);
    }
}

#[test]
fn noise_is_not_fitted() {
    let clean = waves(3000);
    let points = noisy(&clean, 0.01);
    let free = reconstruct(&points, &ReconstructOptions::default(), &mut Silent).unwrap();
    let (rows, cols) = free.report.grid;
    assert!(rows * cols < 400, "{rows} × {cols}");
    let search = ClosestPointSearch::new(&free.surface).unwrap();
    let squares: f64 = clean.iter().map(|&p| search.closest_point(p).distance.powi(2)).sum();
    let rms = (squares / clean.len() as f64).sqrt();
    assert!(rms < 0.004, "{rms}");
    // A tolerance below the noise is missed, and the report says so.
    let options = ReconstructOptions { tolerance: Some(0.004), ..ReconstructOptions::default() };
    let strict = reconstruct(&points, &options, &mut Silent).unwrap();
    assert!(matches!(strict.report.ended_by, EndedBy::Noise | EndedBy::Points));
    assert!(strict.report.within.unwrap() < 1.0);
    let codes: Vec<&str> = strict.report.diagnostics.iter().map(Diagnostic::code).collect();
    assert!(codes.contains(&"tolerance-missed") && !strict.report.converged, "{codes:?}");
}

#[test]
fn few_points_get_small_nets() {
    for count in [4, 6, 9, 16, 25, 100] {
        let points = waves(count);
        let result = reconstruct(&points, &ReconstructOptions::default(), &mut Silent).unwrap();
        let (rows, cols) = result.report.grid;
        assert!((rows, cols) == (4, 4) || rows * cols <= 2 * count, "{rows} × {cols}");
        let data = Bounds::of(&points);
        for point in result.surface.control_points() {
            assert!(point.distance(data.center()) < 3.0 * data.diagonal(), "{count}: {point}");
        }
    }
}

#[test]
fn many_points_get_no_more_control_points_than_a_third() {
    // Without the limit the net would grow on, since neighbors share their noise.
    let bent = |i: u32| {
        let (x, y) = (f64::from(i / 60) / 20.0, f64::from(i % 60) / 20.0);
        let wave = |f: f64| (f * x + 1.7 * f * f).sin() * (1.3 * f * y + f).cos() / f;
        let radius = 1.0 + 0.05 * (4..60).step_by(3).map(|f| wave(f64::from(f))).sum::<f64>();
        DVec3::new(radius * x.sin(), y, radius * x.cos())
    };
    let points: Vec<DVec3> = (0..3600).map(bent).collect();
    let found = reconstruct(&points, &ReconstructOptions::default(), &mut Silent).unwrap();
    let (rows, cols) = found.report.grid;
    assert!(3 * rows * cols <= points.len(), "{rows} × {cols}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let points = rolled(1200);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| with_grid(&points, 10, Kind::Sheet).surface)
    };
    let expected = run(1);
    assert_eq!(run(2), expected);
    assert_eq!(run(7), expected);
}

#[test]
fn all_degrees_are_fitted() {
    let points = waves(500);
    for degree in 1..=5 {
        let options =
            ReconstructOptions { grid: Some((8, 8)), degree, ..ReconstructOptions::default() };
        let result = reconstruct(&points, &options, &mut Silent).unwrap();
        assert_eq!(result.report.degree, (degree, degree));
        assert!(result.report.deviations.rms < 0.02, "{degree}: {:?}", result.report.deviations);
    }
}

#[test]
fn the_observer_can_stop_every_stage() {
    let points = rolled(500);
    // Each stage reports at least once, however little time it takes.
    let mut stages = vec![];
    let mut note = |progress: &Progress| {
        if !stages.contains(&progress.stage) {
            stages.push(progress.stage);
        }
        ControlFlow::Continue(())
    };
    let options = ReconstructOptions { grid: Some((8, 8)), ..ReconstructOptions::default() };
    reconstruct(&points, &options, &mut note).unwrap();
    assert!(stages.len() > 4, "{stages:?}");
    for stage in stages {
        let mut stopping = |progress: &Progress| {
            if progress.stage == stage { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let stopped: Result<_> = reconstruct(&points, &options, &mut stopping);
        assert!(matches!(stopped, Err(Error::Interrupted)));
    }
}
