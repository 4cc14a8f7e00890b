//! Trimming of random points on shapes whose outlines are known.

mod closed;
mod measures;
mod samplings;
mod shapes;

use std::sync::Arc;

use neurbs::nurbs::NurbsSurface;
use neurbs::progress::Silent;
use neurbs::trim::{Trim, TrimOptions, trim};
use neurbs::{DVec2, DVec3, Error};

use measures::Measures;
use samplings::{Random, Sampling, grown_box, sheet};
use shapes::{Shape, all, inside};

fn trimmed(surface: &Arc<NurbsSurface>, uv: &[DVec2]) -> Trim {
    trim(surface, uv, &TrimOptions::default(), &mut Silent).unwrap()
}

/// The measures of all shapes with some seeds. `noise` moves points sideways.
fn table(sampling: Sampling, count: usize, seeds: u64, noise: f64) -> Vec<(String, Measures)> {
    let cases =
        all().into_iter().flat_map(|shape| (0..seeds).map(move |seed| (shape.clone(), seed)));
    let case = |(shape, seed): (Shape, u64)| {
        let mut random = Random::new(seed);
        let mut points = sampling.points(&shape, count, &mut random);
        for at in &mut points {
            *at += noise * random.normal();
        }
        let surface = sheet(grown_box(&points, 0.4 * shape.spacing(points.len())));
        let made = trimmed(&surface, &points);
        (format!("{} {sampling:?} {seed}", shape.name), Measures::of(&made, &shape, points.len()))
    };
    cases.map(case).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Holes are right in all, and the median error is at most the limit.
fn check(sampling: Sampling, noise: f64, limit: f64) {
    let rows = table(sampling, 3000, 3, noise);
    for (name, measures) in &rows {
        assert_eq!(measures.holes, measures.true_holes, "{name}");
        assert_eq!(measures.faces, 1, "{name}");
    }
    let errors: Vec<f64> = rows.iter().map(|(_, measures)| measures.error).collect();
    assert!(median(errors.clone()) <= limit, "{sampling:?}: {errors:.2?}");
}

#[test]
fn random_points_show_the_outline() {
    check(Sampling::Random, 0.0, 0.25);
}

#[test]
fn noise_along_the_surface_hides_no_outline() {
    check(Sampling::Random, 0.005, 0.25);
}

#[test]
fn areas_are_right_on_average() {
    // Smooth outlines away from the sides of the surface, where nothing else decides.
    for (shape, sampling) in [0, 2, 6]
        .into_iter()
        .flat_map(|k| [(k, Sampling::Random), (k, Sampling::Grid)])
        .map(|(k, sampling)| (all().swap_remove(k), sampling))
    {
        let ratio = |seed| {
            let points = sampling.points(&shape, 2000, &mut Random::new(seed));
            let surface = sheet(grown_box(&points, 0.1));
            measures::area(&measures::rings(&trimmed(&surface, &points)))
                / measures::area(&shape.rings)
        };
        let mean = (0..5).map(ratio).sum::<f64>() / 5.0;
        assert!((mean - 1.0).abs() < 0.0075, "{} {sampling:?}: {mean}", shape.name);
    }
}

#[test]
fn few_points_show_holes() {
    let (count, plane) = (300, sheet((DVec2::ZERO, DVec2::ONE)));
    let radius = 3.0 / f64::from(count).sqrt();
    for seed in 0..30 {
        let mut random = Random::new(seed);
        let middle = 0.3 + 0.4 * random.point();
        let around = std::iter::repeat_with(|| random.point());
        let around = around.filter(|at| at.distance(middle) > radius).take(300);
        let made = trimmed(&plane, &around.collect::<Vec<DVec2>>());
        assert!(!inside(&measures::rings(&made), middle), "seed {seed}");
    }
}

#[test]
fn ragged_outlines_become_curves() {
    // Teeth that are too narrow for arcs.
    let plane = sheet((DVec2::ZERO, DVec2::ONE));
    for seed in 0..5 {
        let mut random = Random::new(seed);
        let radii: Vec<f64> = (0..24).map(|_| 0.3 + 0.15 * random.number()).collect();
        let around = std::iter::repeat_with(|| random.point()).filter(|at| {
            let away = *at - 0.5;
            let turn = (away.to_angle() / std::f64::consts::TAU).rem_euclid(1.0);
            let tooth = (0..24).take_while(|k| f64::from(*k) < 24.0 * turn).count();
            away.length() < radii[tooth.max(1) - 1]
        });
        let made = trimmed(&plane, &around.take(1000).collect::<Vec<DVec2>>());
        assert!(made.loops.iter().all(|of| !of.form.is_polygon()), "{:?}", made.loops);
        assert!(made.outside < 0.01, "{}", made.outside);
    }
}

#[test]
fn grids_show_the_outline() {
    check(Sampling::Grid, 0.0, 0.2);
}

#[test]
fn falling_densities_show_the_outline() {
    check(Sampling::Falling, 0.0, 0.3);
}

#[test]
fn scan_lines_show_the_outline() {
    check(Sampling::Lines, 0.0, 0.4);
}

#[test]
fn corners_are_found_and_curves_have_none() {
    let rows = table(Sampling::Random, 3000, 3, 0.0);
    let sum = |of: fn(&Measures) -> usize| rows.iter().map(|(_, m)| of(m)).sum::<usize>();
    let (found, all, wrong) =
        (sum(|m| m.corners), sum(|m| m.true_corners), sum(|m| m.false_corners));
    assert_eq!(all, 84);
    let shown: Vec<_> = rows.iter().map(|(name, m)| (name, m.corners, m.true_corners)).collect();
    assert!(found >= 76 && wrong <= 10, "{found} of {all}, {wrong} false ones: {shown:?}");
}

#[test]
fn random_squares_have_no_hole_and_discs_cut_out_are_found() {
    let count: usize = 1000;
    let radius = 3.0 / (count as f64).sqrt();
    let plane = sheet((DVec2::ZERO, DVec2::ONE));
    let (mut wrong, mut second) = (0, 0);
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let square: Vec<DVec2> = (0..count).map(|_| random.point()).collect();
        let holes = |made: &Trim| made.loops.iter().filter(|of| of.is_hole).count();
        wrong += usize::from(holes(&trimmed(&plane, &square)) > 0);
        let middle = 0.2 + 0.6 * random.point();
        let around = std::iter::repeat_with(|| random.point());
        let around = around.filter(|at| at.distance(middle) > radius).take(count);
        let made = trimmed(&plane, &around.collect::<Vec<DVec2>>());
        assert!(!inside(&measures::rings(&made), middle), "seed {seed}");
        second += usize::from(holes(&made) > 1);
    }
    assert!(wrong <= 1 && second <= 1, "{wrong} and {second}");
}

#[test]
fn full_rectangles_are_pointless_to_trim() {
    let mut random = Random::new(3);
    let points: Vec<DVec2> = (0..2000).map(|_| random.point()).collect();
    let made = trimmed(&sheet((DVec2::ZERO, DVec2::ONE)), &points);
    assert!(made.pointless && made.doubt.is_none());
    let half: Vec<DVec2> = points.into_iter().filter(|at| at.x < 0.5).collect();
    assert!(!trimmed(&sheet((DVec2::ZERO, DVec2::ONE)), &half).pointless);
}

#[test]
fn holes_can_stay_closed_and_borders_move() {
    let shape = &all()[0];
    let points = Sampling::Random.points(shape, 1500, &mut Random::new(1));
    let surface = sheet(grown_box(&points, 0.1));
    let area = |options: &TrimOptions| {
        let made = trim(&surface, &points, options, &mut Silent).unwrap();
        (made.faces[0].inner().len(), measures::area(&measures::rings(&made)))
    };
    let (holes, through) = area(&TrimOptions { border: Some(0.0), ..TrimOptions::default() });
    let (_, usual) = area(&TrimOptions::default());
    let (_, wide) = area(&TrimOptions { border: Some(2.0), ..TrimOptions::default() });
    let (closed, _) = area(&TrimOptions { holes: false, ..TrimOptions::default() });
    assert_eq!((holes, closed), (2, 0));
    assert!(through < usual && usual < wide, "{through} {usual} {wide}");
    let wrong = TrimOptions { border: Some(-1.0), ..TrimOptions::default() };
    let error = trim(&surface, &points, &wrong, &mut Silent).unwrap_err();
    assert!(matches!(error, Error::Parameter { name: "border", .. }));
}

#[test]
fn separate_regions_are_faces_of_their_own() {
    let mut random = Random::new(4);
    let points: Vec<DVec2> =
        (0..3000).map(|_| random.point()).filter(|at| (at.x - 0.4).abs() > 0.1).collect();
    let made = trimmed(&sheet((DVec2::ZERO, DVec2::ONE)), &points);
    assert_eq!((made.regions, made.faces.len()), (2, 2));
    assert!(Arc::ptr_eq(made.faces[0].surface(), made.faces[1].surface()));
}

#[test]
fn few_points_leave_the_surface_whole() {
    let plane = Arc::new(NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap());
    let made = trimmed(&plane, &[DVec2::splat(0.5); 100]);
    assert!(made.doubt.is_some() && !made.faces[0].is_trimmed());
    let line: Vec<DVec2> = (0..200).map(|k| DVec2::splat(f64::from(k) / 200.0)).collect();
    let made = trimmed(&plane, &line);
    assert!(made.doubt.is_some() && !made.faces[0].is_trimmed());
    let outside = trim(&plane, &[DVec2::splat(1.5)], &TrimOptions::default(), &mut Silent);
    assert!(matches!(outside, Err(Error::Parameter { .. })));
}

#[test]
fn threads_do_not_change_a_bit() {
    let shape = &all()[5];
    let points = Sampling::Random.points(shape, 2000, &mut Random::new(2));
    let surface = sheet(grown_box(&points, 0.01));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trimmed(&surface, &points))
    };
    assert_eq!(with(1), with(3));
}
