//! Degrees above 9: quadrics of raised degree against closed forms, and random nets.

use std::f64::consts::PI;

use neurbs::mesh::{DistanceSearch, TessellateOptions};
use neurbs::nurbs::{
    ClosestPointSearch, Direction, GridOptions, KnotVector, MAX_DEGREE, NurbsSurface, Outside,
};
use neurbs::progress::Silent;
use neurbs::{DVec2, DVec3};

/// A number in [0, 1) for each index.
fn random(k: usize) -> f64 {
    (k as f64 * 0.618_033_989 + (k as f64).sin() * 1e4).rem_euclid(1.0)
}

/// A wavy rational surface of these degrees with inner knots, one of them repeated.
fn wavy(p: usize, q: usize) -> NurbsSurface {
    let (rows, cols) = (p + 4, q + 3);
    let net = (0..rows * cols).map(|k| {
        let (x, y) = ((k / cols) as f64 / rows as f64, (k % cols) as f64 / cols as f64);
        DVec3::new(x, y, 0.2 * random(k))
    });
    let weights = (0..rows * cols).map(|k| 0.5 + random(7 * k + 1)).collect();
    let knots = |degree: usize, inner: &[f64]| {
        let ends = [0.0, 1.0].map(|end| vec![end; degree + 1]);
        KnotVector::new(degree, [&ends[0], inner, &ends[1]].concat()).unwrap()
    };
    let (knots_u, knots_v) = (knots(p, &[0.3, 0.6, 0.6]), knots(q, &[0.25, 0.5]));
    NurbsSurface::new(net.collect(), Some(weights), knots_u, knots_v).unwrap()
}

/// Parameters that fill the unit square, with its corners.
fn parameters() -> Vec<DVec2> {
    let inside = (0..200).map(|i| DVec2::new(random(i), random(3 * i + 1)));
    let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
    inside.chain(corners).collect()
}

const DEGREES: [(usize, usize); 5] = [(10, 10), (25, 3), (2, 17), (13, 25), (25, 25)];

#[test]
fn grids_and_scattered_parameters_give_the_same_bits() {
    for (p, q) in DEGREES {
        let surface = wavy(p, q);
        let t: Vec<f64> = (0..=20).map(|i| f64::from(i) / 20.0).collect();
        let uv: Vec<DVec2> = t.iter().flat_map(|u| t.iter().map(|v| DVec2::new(*u, *v))).collect();
        let (mut grid, mut points) = (vec![DVec3::ZERO; uv.len()], vec![DVec3::ZERO; uv.len()]);
        surface.evaluate_grid(&t, &t, &mut grid, None, Outside::Refuse, &mut Silent).unwrap();
        surface.evaluate(&uv, &mut points, Outside::Refuse, &mut Silent).unwrap();
        assert_eq!(grid, points, "{p} {q}");
        for (point, at) in points.iter().zip(&uv) {
            assert!(point.distance(surface.point(at.x, at.y)) < 1e-14, "{p} {q} {at}");
        }
    }
}

#[test]
fn algebra_keeps_the_points() {
    for (p, q) in DEGREES {
        let surface = wavy(p, q);
        let o = &mut Silent;
        let refined = surface.insert_knots(Direction::U, &[0.1, 0.3, 0.77], o).unwrap();
        let (raise_u, raise_v) = ((MAX_DEGREE - p).min(4), (MAX_DEGREE - q).min(3));
        let raised = surface.elevate_degree(raise_u, raise_v, o).unwrap();
        let (below, above) = surface.split(Direction::V, 0.4, o).unwrap();
        let patches = surface.bezier_patches(o).unwrap();
        assert_eq!((patches.len(), patches[0].len()), (3, 3));
        let inside = |surface: &NurbsSurface, at: DVec2| {
            let ((u0, u1), (v0, v1)) = (surface.knots_u().domain(), surface.knots_v().domain());
            (u0..=u1).contains(&at.x) && (v0..=v1).contains(&at.y)
        };
        for at in parameters() {
            let point = surface.point(at.x, at.y);
            let part = if at.y <= 0.4 { &below } else { &above };
            let patch = patches.iter().flatten().find(|patch| inside(patch, at)).unwrap();
            for same in [&refined, &raised, part, patch] {
                let error = same.point(at.x, at.y).distance(point);
                assert!(error < 1e-13, "{p} {q} {at} {error:e}");
            }
        }
    }
}

/// A sphere whose degrees are raised to 25.
fn sphere() -> NurbsSurface {
    let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    sphere.elevate_degree(MAX_DEGREE - 2, MAX_DEGREE - 2, &mut Silent).unwrap()
}

#[test]
fn measures_of_a_sphere_are_exact() {
    let sphere = sphere();
    for at in parameters() {
        assert!((sphere.point(at.x, at.y).length() - 1.0).abs() < 1e-13, "{at}");
        let normal = sphere.normal(at.x, at.y);
        assert!(normal.distance(sphere.point(at.x, at.y)) < 1e-11, "{at} {normal}");
    }
    assert!((sphere.curvature(0.3, 0.4).gaussian - 1.0).abs() < 1e-10);
    assert!((sphere.area(1e-9, &mut Silent).unwrap() / (4.0 * PI) - 1.0).abs() < 1e-9);
    let (low, high) = sphere.bounding_box(&mut Silent).unwrap();
    assert!(low.distance(-DVec3::ONE) < 1e-8 && high.distance(DVec3::ONE) < 1e-8);
    let search = ClosestPointSearch::new(&sphere).unwrap();
    for k in 0..100 {
        let point = DVec3::new(random(k), random(2 * k + 1), random(3 * k + 1)) * 4.0 - 2.0;
        let found = search.closest_point(point);
        assert!(found.converged && (found.distance - (point.length() - 1.0).abs()).abs() < 1e-12);
    }
}

#[test]
fn reduction_returns_to_the_sphere() {
    let reduced = sphere().reduce_degree(23, 23, 1e-9, &mut Silent).unwrap();
    assert_eq!((reduced.knots_u().degree(), reduced.knots_v().degree()), (2, 2));
    for at in parameters() {
        assert!((reduced.point(at.x, at.y).length() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn meshes_stay_within_the_certified_bound() {
    for (surface, tolerance) in
        [(wavy(10, 10), 1e-3), (wavy(25, 3), 1e-3), (wavy(13, 25), 1e-3), (sphere(), 1e-2)]
    {
        let options = TessellateOptions { tolerance: Some(tolerance), ..Default::default() };
        let mesh = surface.tessellate(&options, &mut Silent).unwrap();
        let bound = mesh.max_deviation.unwrap();
        assert!(bound <= tolerance);
        let search = DistanceSearch::new(mesh.view());
        for k in 0..81 * 81 {
            let (u, v) = (f64::from(k / 81) / 80.0, f64::from(k % 81) / 80.0);
            let distance = search.distance(surface.point(u, v));
            assert!(distance <= bound + 1e-14, "{u} {v} {distance} {bound}");
        }
    }
}

#[test]
fn interpolation_passes_through_the_points() {
    let side = 30;
    let grid: Vec<DVec3> = (0..side * side)
        .map(|k| {
            let (x, y) = ((k / side) as f64 / 29.0, (k % side) as f64 / 29.0);
            DVec3::new(x, y, 0.1 * (5.0 * x).sin() * (4.0 * y).cos())
        })
        .collect();
    for degree in [(10, 3), (16, 12), (25, 25)] {
        let options = GridOptions { degree, ..GridOptions::default() };
        let o = &mut Silent;
        let surface = NurbsSurface::interpolate(&grid, (side, side), &options, o).unwrap();
        let (u, v) = NurbsSurface::grid_parameters(&grid, (side, side), &options, o).unwrap();
        for (k, point) in grid.iter().enumerate() {
            let error = surface.point(u[k / side], v[k % side]).distance(*point);
            assert!(error < 1e-11, "{degree:?} {k} {error:e}");
        }
    }
}
