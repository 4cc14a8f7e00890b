//! The whole job, on real terrain and on invalid input.

use std::ops::ControlFlow;

use neurbs::chart::Kind;
use neurbs::cloud::Bounds;
use neurbs::progress::{Progress, Silent};
use neurbs::som::StoppedBy;
use neurbs::{
    DVec3, Diagnostic, Error, PaperOptions, ReconstructOptions, Reconstruction, candidates,
    reconstruct, reconstruct_paper,
};

fn terrain() -> Vec<DVec3> {
    let lines = include_str!("../examples/jacksboro.xyz").lines();
    let rows = lines.filter(|line| !line.starts_with('#'));
    let point = |line: &str| {
        let mut numbers = line.split_whitespace().map(|number| number.parse().unwrap());
        DVec3::from_array(std::array::from_fn(|_| numbers.next().unwrap()))
    };
    rows.map(point).collect()
}

fn quick(points: &[DVec3]) -> Reconstruction {
    let options =
        PaperOptions { grid: Some((9, 8)), max_steps: Some(20_000), ..PaperOptions::default() };
    reconstruct_paper(points, &options, &mut Silent).unwrap()
}

#[test]
fn the_paper_method_covers_the_terrain_without_folds() {
    let points = terrain();
    let result = reconstruct_paper(&points, &PaperOptions::default(), &mut Silent).unwrap();
    let (report, data) = (&result.report, Bounds::of(&points));
    assert_eq!(report.training.stopped_by, StoppedBy::Settled);
    assert_eq!(result.surface.shape(), (28, 29));
    // The lattice covers the points: each has a node within about half a cell.
    assert!(report.training.quantization_error < 0.01 * report.diagonal);
    // The surface stays in the data's box and fills it up to about half a cell at the border.
    let triangles = result.tessellate(&mut Silent).unwrap();
    let mesh = Bounds::of(&triangles.vertices);
    assert!(mesh.min.cmpge(data.min).all() && mesh.max.cmple(data.max).all());
    let filled = (mesh.max - mesh.min) / (data.max - data.min);
    assert!(filled.x > 0.93 && filled.y > 0.93, "{filled}");
    // It has no folds: all normals point to the same side of the plane.
    let up = triangles.normals.iter().filter(|n| n.z > 0.0).count();
    assert!(up == 0 || up == triangles.normals.len(), "{up} of {}", triangles.normals.len());
}

#[test]
fn the_lattice_reaches_each_of_few_points() {
    let points = &terrain()[..13];
    let result = reconstruct_paper(points, &PaperOptions::default(), &mut Silent).unwrap();
    assert_eq!(result.report.training.stopped_by, StoppedBy::Reached);
    let reach = 1e-3 * result.report.diagonal;
    for point in points {
        let distances = result.som.codebook().into_iter().map(|node| node.distance(*point));
        assert!(distances.fold(f64::INFINITY, f64::min) <= reach);
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let points = terrain();
    let expected = quick(&points);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let got = pool.install(|| quick(&points));
        assert_eq!(got.surface, expected.surface);
        let mesh = |result: &Reconstruction| result.tessellate(&mut Silent).unwrap();
        assert_eq!(pool.install(|| mesh(&got)), mesh(&expected));
    }
    let other = PaperOptions { seed: 1, max_steps: Some(1000), ..PaperOptions::default() };
    let same = PaperOptions { seed: 0, ..other };
    let run = |options| reconstruct_paper(&points, options, &mut Silent).unwrap().surface;
    assert_ne!(run(&other), run(&same));
}

#[test]
fn the_surface_moves_and_scales_with_the_points() {
    // Multiples of 1/8 are moved without rounding, so the normalized points are the same bits.
    let points: Vec<DVec3> = terrain().iter().map(|p| (8.0 * *p).round() / 8.0).collect();
    let (scale, offset) = (1024.0, DVec3::new(5e9, -7.8e9, 1e6));
    let moved: Vec<DVec3> = points.iter().map(|&p| scale * p + offset).collect();
    let (expected, got) = (quick(&points), quick(&moved));
    assert_eq!(got.report.training.steps, expected.report.training.steps);
    let size = expected.report.diagonal;
    let pairs = got.surface.control_points().iter().zip(expected.surface.control_points());
    for (got, expected) in pairs {
        let back = (*got - offset) / scale;
        assert!(back.distance(*expected) < 1e-13 * size);
    }
}

#[test]
fn small_points_far_from_the_origin_keep_their_digits() {
    let corner = DVec3::new(5e6, 5e6, 100.0);
    let points: Vec<DVec3> = terrain().iter().map(|p| corner + *p * 1e-6).collect();
    let result = quick(&points);
    let mesh = result.tessellate(&mut Silent).unwrap();
    let (got, data) = (Bounds::of(&mesh.vertices), Bounds::of(&points));
    assert!(got.min.cmpge(data.min).all() && got.max.cmple(data.max).all());
    assert!((got.max - got.min).z > 0.3 * (data.max - data.min).z);
}

#[test]
fn the_observer_receives_progress_and_can_stop() {
    let points = terrain();
    let mut stages = Vec::new();
    let mut steps = Vec::new();
    let mut watch = |progress: &Progress| {
        stages.push(progress.stage.name());
        steps.push(progress.step);
        assert!(progress.step <= progress.total);
        ControlFlow::Continue(())
    };
    let options = PaperOptions { max_steps: Some(10_000), ..PaperOptions::default() };
    reconstruct_paper(&points, &options, &mut watch).unwrap().tessellate(&mut watch).unwrap();
    stages.dedup();
    assert_eq!(stages, ["checking", "training", "measuring", "tessellation"]);
    assert!(steps.len() > 4);

    let mut calls = 0;
    let mut stop = |_: &Progress| {
        calls += 1;
        if calls < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let stopped = reconstruct_paper(&points, &options, &mut stop);
    assert!(matches!(stopped, Err(Error::Interrupted)));
    assert_eq!(calls, 3);
}

#[test]
fn a_single_break_of_the_observer_stops_the_job() {
    // A leaf, for which several first fits are made.
    let leaf = |i: u32| {
        let (u, v) = (f64::from(i) / 300.0, (f64::from(i) * 0.618_033_988_75).fract() - 0.5);
        let width = 0.9 * (std::f64::consts::PI * u).sin().powf(0.7);
        DVec3::new(2.0 * u, width * v, 0.25 * (3.0 * u).sin() + 0.3 * v * v)
    };
    let points: Vec<DVec3> = (0..300).map(leaf).collect();
    let options = ReconstructOptions::default();
    let run = |stop: usize| {
        let mut calls = 0;
        let mut observer = |_: &Progress| {
            calls += 1;
            if calls == stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let done = reconstruct(&points, &options, &mut observer).map(|_| ());
        (done, calls)
    };
    // Inside a pool, the job calls its observer on its own thread.
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| {
        let (done, calls) = run(0);
        assert!(done.is_ok() && calls > 40, "{calls}");
        for stop in (1..=calls).step_by(calls / 40) {
            let (done, _) = run(stop);
            assert!(matches!(done, Err(Error::Interrupted)), "{stop} of {calls}");
        }
    });
}

#[test]
fn a_kind_that_no_chart_proposes_is_an_error() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5)];
    for kind in [Kind::Tube, Kind::Torus] {
        let options = ReconstructOptions { kind: Some(kind), ..ReconstructOptions::default() };
        let error = reconstruct(&points, &options, &mut Silent).unwrap_err();
        assert!(matches!(error, Error::Parameter { name: "points", .. }), "{error}");
    }
}

#[test]
fn paper_options_out_of_range_are_refused_by_name() {
    let points = terrain();
    let message = |options: PaperOptions| {
        reconstruct_paper(&points, &options, &mut Silent).unwrap_err().to_string()
    };
    let options = PaperOptions::default();
    let cases = [
        (PaperOptions { grid: Some((1, 5)), ..options }, "grid", "(1, 5)"),
        (PaperOptions { grid: Some((usize::MAX, 5)), ..options }, "grid", "at most 16777216"),
        (PaperOptions { degree: 0, ..options }, "degree", "got 0"),
        (PaperOptions { degree: 26, ..options }, "degree", "got 26"),
        (PaperOptions { max_steps: Some(0), ..options }, "max_steps", "got 0"),
        (PaperOptions { reach: Some(0.0), ..options }, "reach", "positive"),
        (PaperOptions { reach: Some(f64::NAN), ..options }, "reach", "got NaN"),
        (PaperOptions { min_change: Some(-1.0), ..options }, "min_change", "got -1"),
    ];
    for (options, name, detail) in cases {
        let message = message(options);
        assert!(message.starts_with(name) && message.contains(detail), "{message}");
    }
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    let points = terrain();
    let options = ReconstructOptions::default();
    let cases = [
        (ReconstructOptions { kind: Some(Kind::Body), ..options }, "kind", "not supported yet"),
        (
            ReconstructOptions { axis_scale: Some(DVec3::new(1.0, 0.0, 1.0)), ..options },
            "axis_scale",
            "positive",
        ),
        (ReconstructOptions { tolerance: Some(0.0), ..options }, "tolerance", "positive"),
        (ReconstructOptions { fairness: Some(-1.0), ..options }, "fairness", "got -1"),
        (ReconstructOptions { grid: Some((1, 5)), ..options }, "grid", "(1, 5)"),
        (ReconstructOptions { degree: 0, ..options }, "degree", "got 0"),
        (ReconstructOptions { max_control_points: 3, ..options }, "max_control_points", "got 3"),
        (ReconstructOptions { weights: Some(&[1.0]), ..options }, "weights", "got 1"),
    ];
    for (options, name, detail) in cases {
        let message = reconstruct(&points, &options, &mut Silent).unwrap_err().to_string();
        assert!(message.starts_with(name) && message.contains(detail), "{message}");
        assert!(candidates(&points, &options, &mut Silent).is_err());
    }
}

#[test]
fn the_times_of_the_stages_add_up_to_the_whole() {
    let points = terrain();
    let started = std::time::Instant::now();
    let options = ReconstructOptions { grid: Some((12, 12)), ..ReconstructOptions::default() };
    let report = reconstruct(&points, &options, &mut Silent).unwrap().report;
    let elapsed = started.elapsed().as_secs_f64();
    let known: f64 = report.seconds.iter().map(|(_, seconds)| seconds).sum();
    assert!(known <= elapsed && known > 0.95 * elapsed, "{known} of {elapsed}");
}

#[test]
fn valid_and_converged_agree_with_the_diagnostics() {
    let points = &terrain()[..400];
    for tolerance in [None, Some(1e-9)] {
        let options = ReconstructOptions {
            tolerance,
            max_control_points: 16,
            ..ReconstructOptions::default()
        };
        let report = reconstruct(points, &options, &mut Silent).unwrap().report;
        assert_eq!(report.valid, !report.diagnostics.iter().any(Diagnostic::is_defect));
        let missed = report.diagnostics.iter().any(|found| found.code() == "tolerance-missed");
        assert_eq!(report.converged, !missed);
        assert_eq!(missed, tolerance.is_some());
    }
}
