//! Adaptive meshes: within the tolerance, without gaps, the same for any number of threads.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use neurbs::mesh::{DistanceSearch, TessellateOptions, TriangleMesh};
use neurbs::nurbs::{ClosestPointSearch, KnotVector};
use neurbs::progress::{Progress, Silent};
use neurbs::{DVec3, Error, NurbsSurface};
use proptest::prelude::*;

fn relative(tolerance: f64) -> TessellateOptions {
    let tolerance = Some(tolerance);
    TessellateOptions { tolerance, relative: true, ..TessellateOptions::default() }
}

fn tessellate(surface: &NurbsSurface, options: &TessellateOptions) -> TriangleMesh {
    surface.tessellate(options, &mut Silent).unwrap()
}

/// The largest sampled distance between surface and mesh, in both directions.
fn deviation(surface: &NurbsSurface, mesh: &TriangleMesh) -> f64 {
    let to_mesh = DistanceSearch::new(mesh.view());
    let to_surface = ClosestPointSearch::new(surface).unwrap();
    let ((u0, u1), (v0, v1)) = (surface.knots_u().domain(), surface.knots_v().domain());
    let mut most = 0.0_f64;
    for (i, j) in (0..=60).flat_map(|i| (0..=60).map(move |j| (i, j))) {
        let (s, t) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
        most = most.max(to_mesh.distance(surface.point(u0 + s * (u1 - u0), v0 + t * (v1 - v0))));
    }
    let stride = mesh.triangles.len().div_ceil(1000);
    for triangle in mesh.triangles.iter().step_by(stride) {
        let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize]);
        for point in [(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (a + c) / 2.0] {
            most = most.max(to_surface.closest_point(point).distance);
        }
    }
    most
}

/// Checks that vertices are the surface points of their parameters, that all triangles have area,
/// that all vertices are used, and that boundary edges lie on the boundary of the surface.
fn assert_valid(surface: &NurbsSurface, mesh: &TriangleMesh) {
    let size = surface.size();
    for (vertex, at) in mesh.vertices.iter().zip(&mesh.uv) {
        assert!(vertex.distance(surface.point(at.x, at.y)) < 1e-12 * size);
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize]);
        assert!((b - a).cross(c - a).length() > 0.0, "{triangle:?}");
    }
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    assert!(used.iter().all(|used| *used));
    let ((u0, u1), (v0, v1)) = (surface.knots_u().domain(), surface.knots_v().domain());
    for (a, b) in mesh.view().boundary_edges() {
        let (a, b) = (mesh.uv[a as usize], mesh.uv[b as usize]);
        let on_boundary =
            (a.x == b.x && (a.x == u0 || a.x == u1)) || (a.y == b.y && (a.y == v0 || a.y == v1));
        assert!(on_boundary, "{a} {b}");
    }
}

fn surfaces() -> impl Strategy<Value = NurbsSurface> {
    let shape = (1..=4_usize, 1..=4_usize, 0..=5_usize, 0..=4_usize);
    (shape, any::<bool>(), any::<u32>()).prop_map(|((p, q, more_u, more_v), rational, seed)| {
        let (rows, cols) = (p + 1 + more_u, q + 1 + more_v);
        let mut state = u64::from(seed) + 1;
        let mut random = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let net = (0..rows * cols).map(|k| {
            let (x, y) = ((k / cols) as f64, (k % cols) as f64);
            DVec3::new(x + 0.4 * random(), y + 0.4 * random(), 1.5 * random())
        });
        let net: Vec<DVec3> = net.collect();
        let weights = rational.then(|| (0..rows * cols).map(|_| 0.3 + 3.0 * random()).collect());
        let u = KnotVector::clamped_uniform(p, rows).unwrap();
        NurbsSurface::new(net, weights, u, KnotVector::clamped_uniform(q, cols).unwrap()).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn random_surfaces_stay_within_the_certified_bound(surface in surfaces(), exponent in 1.3..3.3_f64) {
        let mesh = tessellate(&surface, &relative(10.0_f64.powf(-exponent)));
        let tolerance = 10.0_f64.powf(-exponent) * surface.size();
        let bound = mesh.max_deviation.unwrap();
        prop_assert!(bound <= tolerance);
        prop_assert!(deviation(&surface, &mesh) <= bound + 1e-12 * surface.size());
        prop_assert_eq!(mesh.view().euler_characteristic(), 1);
        assert_valid(&surface, &mesh);
    }
}

/// Surfaces with the Euler characteristic and the number of boundary loops of their meshes.
fn shapes() -> [(NurbsSurface, i64, usize); 5] {
    let net: Vec<DVec3> = (0..42)
        .map(|k| {
            let (angle, height) = (f64::from(k / 6) * PI / 3.5, f64::from(k % 6));
            DVec3::new(angle.cos(), angle.sin(), 0.4 * height) * (2.0 + 0.3 * height.sin())
        })
        .collect();
    let tube = NurbsSurface::periodic(&net, None, (7, 6), (3, 3), (true, false)).unwrap();
    let torus = NurbsSurface::torus(DVec3::splat(100.0), 3.0, 1.0).unwrap();
    let flat: Vec<DVec3> =
        (0..25).map(|k| DVec3::new(f64::from(k / 5), f64::from(k % 5), 0.0)).collect();
    [
        (NurbsSurface::clamped(flat, (5, 5), 3).unwrap(), 1, 1),
        (tube, 0, 2),
        (torus.clone(), 0, 0),
        (torus.elevate_degree(1, 0, &mut Silent).unwrap(), 0, 0),
        (NurbsSurface::sphere(DVec3::ONE, 2.0).unwrap(), 2, 0),
    ]
}

#[test]
fn meshes_have_the_topology_of_their_surface() {
    for tolerance in [0.1, 1e-2, 1e-3, 1e-4] {
        for (surface, characteristic, loops) in shapes() {
            let mesh = tessellate(&surface, &relative(tolerance));
            assert_eq!(mesh.view().euler_characteristic(), characteristic);
            assert_eq!(mesh.view().boundary_loops().len(), loops);
            let bound = mesh.max_deviation.unwrap();
            assert!(deviation(&surface, &mesh) <= bound + 1e-12 * surface.size());
            assert!(bound <= tolerance * surface.size());
            assert_valid(&surface, &mesh);
        }
    }
}

#[test]
fn triangles_are_counter_clockwise_about_the_normals() {
    for (surface, ..) in shapes() {
        let mesh = tessellate(&surface, &relative(1e-3));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.vertices[i as usize]);
            let normal: DVec3 = triangle.map(|i| mesh.normals[i as usize]).iter().sum();
            assert!(
                (b - a).cross(c - a).normalize().dot(normal) > 0.9 * 3.0_f64.min(normal.length())
            );
        }
    }
}

#[test]
fn seams_are_split_on_request() {
    let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
    let options = TessellateOptions { split_seams: true, ..relative(1e-3) };
    let (split, welded) = (tessellate(&torus, &options), tessellate(&torus, &relative(1e-3)));
    assert_eq!(split.view().euler_characteristic(), 1);
    assert_eq!(split.triangles.len(), welded.triangles.len());
    assert!((split.view().area() - welded.view().area()).abs() < 1e-12 * welded.view().area());
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (surface, ..) = &shapes()[1];
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tessellate(surface, &relative(1e-4)))
    };
    let one = run(1);
    assert!(one.triangles.len() > 1000);
    assert_eq!(one, run(2));
    assert_eq!(one, run(7));
}

#[test]
fn flat_surfaces_take_two_triangles_even_with_a_fine_net() {
    let net: Vec<DVec3> =
        (0..196).map(|k| DVec3::new(f64::from(k / 14), f64::from(k % 14), 3.0)).collect();
    let plane = NurbsSurface::clamped(net, (14, 14), 3).unwrap();
    assert_eq!(tessellate(&plane, &relative(1e-6)).triangles.len(), 2);
}

#[test]
fn creases_lie_on_edges() {
    let knots = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.3, 0.3, 1.0, 1.0, 1.0]).unwrap();
    let net = (0..5).flat_map(|i| (0..3).map(move |j| (f64::from(i), f64::from(j))));
    let roof = net.map(|(x, y)| DVec3::new(x, y, 2.0 - (x - 2.0).abs() + 0.1 * y * y)).collect();
    let across = KnotVector::clamped_uniform(2, 3).unwrap();
    let surface = NurbsSurface::new(roof, None, knots, across).unwrap();
    let mesh = tessellate(&surface, &relative(0.02));
    for triangle in &mesh.triangles {
        let u = triangle.map(|i| mesh.uv[i as usize].x);
        assert!(u.iter().all(|&u| u <= 0.3) || u.iter().all(|&u| u >= 0.3), "{u:?}");
    }
}

#[test]
fn limits_of_edges_angles_and_aspect_hold() {
    let (surface, ..) = &shapes()[1];
    let most = |mesh: &TriangleMesh, of: &dyn Fn(usize, usize) -> f64| {
        let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        edges.map(|(a, b)| of(a as usize, b as usize)).fold(0.0, f64::max)
    };
    let edge = tessellate(surface, &TessellateOptions { max_edge: Some(0.2), ..relative(0.01) });
    assert!(most(&edge, &|a, b| edge.vertices[a].distance(edge.vertices[b])) <= 0.2);
    let angle = tessellate(surface, &TessellateOptions { max_angle: Some(0.1), ..relative(0.01) });
    let turn = |a: usize, b: usize| angle.normals[a].angle_between(angle.normals[b]);
    assert!(most(&angle, &turn) <= 0.1 + 1e-7);
    let ribbon: Vec<DVec3> =
        (0..8).map(|k| DVec3::new(f64::from(k / 2) * 20.0, f64::from(k % 2), 0.0)).collect();
    let ribbon = NurbsSurface::clamped(ribbon, (4, 2), 3).unwrap();
    let aspect =
        tessellate(&ribbon, &TessellateOptions { max_aspect: Some(4.0), ..relative(0.01) });
    assert!(
        most(&aspect, &|a, b| aspect.vertices[a].distance(aspect.vertices[b])) <= 17.0_f64.sqrt()
    );
}

fn message(options: &TessellateOptions) -> String {
    let surface = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    surface.tessellate(options, &mut Silent).unwrap_err().to_string()
}

#[test]
fn limits_out_of_range_are_refused() {
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = message(&relative(tolerance));
        assert!(message.contains("tolerance must be positive and finite, got"), "{message}");
    }
    let aspect = TessellateOptions { max_aspect: Some(1.0), ..TessellateOptions::default() };
    assert!(message(&aspect).contains("max_aspect must be finite and at least 4, got 1"));
}

#[test]
fn too_many_triangles_are_refused_before_they_are_made() {
    // By its curvature, a sphere needs 4 π r² / (2.6 ε r) triangles.
    let message = message(&relative(1e-12));
    assert!(message.contains("at most 100000000 triangles"), "{message}");
    let count: f64 = message.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(count > 1e12 && count < 1e13, "{message}");
    // The limit of the options replaces the default.
    let options = TessellateOptions { max_triangles: 300, ..relative(1e-3) };
    let surface = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    assert!(surface.tessellate(&options, &mut Silent).is_err());
}

#[test]
fn the_observer_can_stop_the_tessellation() {
    let surface = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    let mut stop = |_: &Progress| ControlFlow::Break(());
    let stopped = surface.tessellate(&TessellateOptions::default(), &mut stop);
    assert!(matches!(stopped, Err(Error::Interrupted)));
}
