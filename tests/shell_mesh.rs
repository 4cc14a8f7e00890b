//! Meshes of faces and shells: closed, oriented, within the tolerance.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use neurbs::mesh::{DistanceSearch, ShellMesh, TessellateOptions};
use neurbs::nurbs::{ClosestPointSearch, NurbsCurve};
use neurbs::progress::Silent;
use neurbs::{DAffine3, DVec2, DVec3, Face, NurbsSurface, Shell, TriangleMesh};

fn options(tolerance: f64) -> TessellateOptions {
    TessellateOptions { tolerance: Some(tolerance), ..TessellateOptions::default() }
}

fn plane(origin: DVec3, along_u: DVec3, along_v: DVec3) -> NurbsSurface {
    NurbsSurface::plane(origin, along_u, along_v).unwrap()
}

fn circle(center: DVec2, radius: DVec2) -> Vec<NurbsCurve> {
    let center = center.extend(0.0);
    vec![NurbsCurve::arc(center, radius.x * DVec3::X, radius.y * DVec3::Y, TAU).unwrap()]
}

fn polygon(corners: &[(f64, f64)]) -> Vec<NurbsCurve> {
    let at = |k: usize| DVec2::from(corners[k % corners.len()]).extend(0.0);
    (0..corners.len()).map(|k| NurbsCurve::line(at(k), at(k + 1)).unwrap()).collect()
}

/// A wavy surface over the unit square.
fn wavy() -> NurbsSurface {
    let height = |i: u32, j: u32| 0.1 * (f64::from(i) * 1.3).sin() * (f64::from(j) * 0.9).cos();
    let point = |i: u32, j: u32| DVec3::new(f64::from(i), f64::from(j), 7.0 * height(i, j)) / 7.0;
    let net = (0..8).flat_map(|i| (0..8).map(move |j| point(i, j))).collect();
    NurbsSurface::clamped(net, (8, 8), 3).unwrap()
}

/// Checks that sides belong to two triangles at most, in opposite directions; returns the number of
/// sides of one triangle.
fn check_sides(mesh: &TriangleMesh) -> usize {
    let mut sides: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        assert!(a != b && b != c && c != a);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *sides.entry((a, b)).or_default() += 1;
        }
    }
    assert!(sides.values().all(|count| *count == 1), "a side is used twice in one direction");
    sides.keys().filter(|(a, b)| !sides.contains_key(&(*b, *a))).count()
}

/// The largest distance of the triangles, sampled, from the surfaces of their faces.
fn from_surfaces(shell: &Shell, found: &ShellMesh) -> f64 {
    let search = |face: &Face| ClosestPointSearch::new(face.surface()).unwrap();
    let searches: Vec<ClosestPointSearch> = shell.faces().iter().map(search).collect();
    let mut most = 0.0_f64;
    for (triangle, &face) in found.mesh.triangles.iter().zip(&found.faces) {
        let [a, b, c] = triangle.map(|k| found.mesh.vertices[k as usize]);
        let distance = |x: f64, y: f64| {
            searches[face as usize].closest_point(a + x * (b - a) + y * (c - a)).distance
        };
        for (x, y) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5), (1.0 / 3.0, 1.0 / 3.0)] {
            most = most.max(distance(x, y));
        }
    }
    most
}

/// The largest distance from the triangles of points of a surface with parameters that pass.
fn from_mesh(surface: &NurbsSurface, mesh: &TriangleMesh, inside: impl Fn(DVec2) -> bool) -> f64 {
    let search = DistanceSearch::new(mesh.view());
    let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
    let mut most = 0.0_f64;
    for (i, j) in (0..=200).flat_map(|i| (0..=200).map(move |j| (i, j))) {
        let share = |(from, to): (f64, f64), k: i32| from + f64::from(k) / 200.0 * (to - from);
        let at = DVec2::new(share(u, i), share(v, j));
        if inside(at) {
            most = most.max(search.distance(surface.point(at.x, at.y)));
        }
    }
    most
}

/// Checks a mesh of a shell: sides, border, Euler characteristic, certified and sampled distance.
fn check(shell: &Shell, tolerance: f64, euler: i64) -> ShellMesh {
    let found = shell.tessellate(&options(tolerance), &mut Silent).unwrap();
    let mesh = &found.mesh;
    assert_eq!(found.faces.len(), mesh.triangles.len());
    let border = check_sides(mesh);
    assert_eq!(border == 0, shell.is_closed());
    assert_eq!(mesh.view().euler_characteristic(), euler);
    let certified = mesh.max_deviation.unwrap();
    assert!(certified <= tolerance, "{certified} {tolerance}");
    let sampled = from_surfaces(shell, &found);
    assert!(sampled <= certified + 1e-12, "{sampled} {certified}");
    for (triangle, &face) in mesh.triangles.iter().zip(&found.faces) {
        let [a, b, c] = triangle.map(|k| mesh.vertices[k as usize]);
        assert!((b - a).cross(c - a).length() > 0.0, "a triangle of face {face} has no area");
    }
    found
}

/// The faces of the box from the origin to a corner, normals outward.
fn box_faces(corner: DVec3) -> Vec<Face> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * corner);
    let mut faces = vec![];
    for k in 0..3 {
        let (a, b, c) = (axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]);
        let face = |origin| Face::whole(plane(origin, a, b)).unwrap();
        faces.extend([face(DVec3::ZERO).reversed(), face(c)]);
    }
    faces
}

fn tube_with_caps() -> Shell {
    let tube = NurbsSurface::cylinder(DVec3::ZERO, 2.0 * DVec3::Z, 1.0).unwrap();
    let cap = |z: f64| {
        let surface = plane(DVec3::new(-2.0, -2.0, z), 4.0 * DVec3::X, 4.0 * DVec3::Y);
        let turned = |angle: f64| 0.25 * DVec3::new(angle.cos(), angle.sin(), 0.0);
        let center = DVec3::new(0.5, 0.5, 0.0);
        let circle = NurbsCurve::arc(center, turned(1.0), turned(1.0 + PI / 2.0), TAU).unwrap();
        Face::trimmed(surface, vec![vec![circle]]).unwrap()
    };
    let faces = vec![Face::whole(tube).unwrap(), cap(0.0).reversed(), cap(2.0)];
    Shell::new(faces, None).unwrap()
}

/// A sphere cut into rows and columns of faces.
fn cut_sphere(rows: u32, cols: u32) -> Shell {
    let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    let (u, v) = (sphere.knots_u().domain(), sphere.knots_v().domain());
    let at = |(from, to): (f64, f64), k: u32, n: u32| {
        if k == n { to } else { from + f64::from(k) / f64::from(n) * (to - from) }
    };
    let mut faces = vec![];
    for (i, j) in (0..rows).flat_map(|i| (0..cols).map(move |j| (i, j))) {
        let part = sphere.sub_surface(
            (at(u, i, rows), at(u, i + 1, rows)),
            (at(v, j, cols), at(v, j + 1, cols)),
            &mut Silent,
        );
        faces.push(Face::whole(part.unwrap()).unwrap());
    }
    Shell::new(faces, None).unwrap()
}

#[test]
fn a_box_has_two_triangles_for_each_side() {
    let shell = Shell::new(box_faces(DVec3::new(1.0, 2.0, 3.0)), None).unwrap();
    let found = check(&shell, 1e-3, 2);
    assert_eq!(found.mesh.triangles.len(), 12);
    assert!((found.mesh.view().volume().unwrap() - 6.0).abs() < 1e-12);
    assert!(found.mesh.max_deviation.unwrap() < 1e-14);
}

#[test]
fn a_tube_and_its_caps_are_closed() {
    let shell = tube_with_caps();
    for tolerance in [0.3, 1e-2, 1e-3, 1e-5] {
        let found = check(&shell, tolerance, 2);
        let volume = found.mesh.view().volume().unwrap();
        assert!((volume / TAU - 1.0).abs() < 3.0 * tolerance, "{volume}");
    }
}

#[test]
fn a_sphere_of_a_hundred_faces_is_closed() {
    let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    let shell = cut_sphere(10, 10);
    assert!(shell.is_closed());
    for tolerance in [0.1, 3e-3, 1e-4] {
        let found = check(&shell, tolerance, 2);
        let mesh = &found.mesh;
        let volume = mesh.view().volume().unwrap();
        assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 3.0 * tolerance, "{volume}");
        let certified = mesh.max_deviation.unwrap();
        assert!(from_mesh(&sphere, mesh, |_| true) <= certified);
        let alone = |face: &Face| {
            face.tessellate(&options(tolerance), &mut Silent).unwrap().triangles.len()
        };
        let separate: usize = shell.faces().iter().map(alone).sum();
        // A few more: edges of a face are divided for its neighbors, too.
        let most = 1.1 * separate as f64;
        assert!(mesh.triangles.len() as f64 <= most, "{} {separate}", mesh.triangles.len());
    }
}

#[test]
fn a_sphere_of_few_faces_is_closed() {
    for (rows, cols) in [(2, 1), (3, 1), (4, 1), (1, 2), (2, 3)] {
        for tolerance in [0.5, 0.1, 1e-3] {
            check(&cut_sphere(rows, cols), tolerance, 2);
        }
    }
}

#[test]
fn edges_of_whole_faces_are_divided_where_others_end() {
    let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
    let part = |u, v| Face::whole(sphere.sub_surface(u, v, &mut Silent).unwrap()).unwrap();
    let third = |k: u32| f64::from(k) / 3.0;
    let mut faces = vec![part((0.0, 0.4), (0.0, 1.0))];
    faces.extend((0..3).map(|k| part((0.4, 1.0), (third(k), third(k + 1)))));
    let shell = Shell::new(faces, None).unwrap();
    for tolerance in [0.1, 1e-2, 1e-3, 1e-4] {
        let found = check(&shell, tolerance, 2);
        let alone = |face: &Face| face.tessellate(&options(tolerance), &mut Silent).unwrap();
        let separate: usize = shell.faces().iter().map(|face| alone(face).triangles.len()).sum();
        let most = 1.2 * separate as f64 + 20.0;
        assert!(found.mesh.triangles.len() as f64 <= most, "{}", found.mesh.triangles.len());
    }
}

#[test]
fn whole_faces_may_have_different_parameters_on_their_edge() {
    let tube = NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
    let turn = DAffine3::from_translation(DVec3::Z) * DAffine3::from_rotation_z(1.0);
    let turned = tube.transformed(&turn).unwrap();
    let faces = [tube, turned].map(|surface| Face::whole(surface).unwrap());
    let shell = Shell::new(faces.to_vec(), None).unwrap();
    assert_eq!(shell.border().count(), 2);
    for tolerance in [0.3, 1e-2, 1e-4] {
        check(&shell, tolerance, 0);
    }
}

#[test]
fn a_closed_surface_is_welded_inside_a_shell() {
    let faces =
        [0.0, 5.0].map(|x| Face::whole(NurbsSurface::sphere(x * DVec3::X, 1.0).unwrap()).unwrap());
    let shell = Shell::new(faces.to_vec(), None).unwrap();
    for tolerance in [0.5, 0.1, 1e-2, 1e-3] {
        check(&shell, tolerance, 4);
    }
    let torus = Face::whole(NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap()).unwrap();
    let shell = Shell::new(vec![faces[1].clone(), torus], None).unwrap();
    check(&shell, 1e-2, 2);
}

#[test]
fn holes_lower_the_euler_characteristic() {
    let disc = |holes: &[(f64, f64, f64)]| {
        let mut loops = vec![circle(DVec2::splat(0.5), DVec2::splat(0.45))];
        let hole = |&(x, y, r): &(f64, f64, f64)| circle(DVec2::new(x, y), DVec2::splat(r));
        loops.extend(holes.iter().map(hole));
        Shell::new(vec![Face::trimmed(wavy(), loops).unwrap()], None).unwrap()
    };
    let holes = [(0.35, 0.5, 0.1), (0.7, 0.55, 0.12)];
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5] {
        let found = check(&disc(&holes), tolerance, -1);
        let inside = |at: DVec2| {
            let outside = |&(x, y, r): &(f64, f64, f64)| at.distance(DVec2::new(x, y)) >= r;
            at.distance(DVec2::splat(0.5)) <= 0.45 && holes.iter().all(outside)
        };
        let away = from_mesh(&wavy(), &found.mesh, inside);
        assert!(away <= tolerance, "{away}");
        let whole = wavy().tessellate(&options(tolerance), &mut Silent).unwrap();
        assert!(found.mesh.triangles.len() <= whole.triangles.len());
    }
    check(&disc(&[(0.4, 0.4, 1e-4)]), 1e-3, 0);
    check(&disc(&[(0.4, 0.4, 0.1), (0.4, 0.6001, 0.1)]), 1e-3, -1);
    check(&disc(&[(0.5, 0.5, 0.4499)]), 1e-2, 0);
}

#[test]
fn plates_have_the_area_of_their_loops() {
    let surface = || plane(DVec3::ZERO, 10.0 * DVec3::X, 5.0 * DVec3::Y);
    let l = [(0.1, 0.1), (0.9, 0.1), (0.9, 0.3), (0.4, 0.35), (0.35, 0.9), (0.1, 0.85)];
    let twice: f64 =
        (0..l.len()).map(|k| DVec2::from(l[k]).perp_dot(DVec2::from(l[(k + 1) % l.len()]))).sum();
    let shell = Shell::new(vec![Face::trimmed(surface(), vec![polygon(&l)]).unwrap()], None);
    let found = check(&shell.unwrap(), 1e-3, 1);
    assert!((found.mesh.view().area() - 25.0 * twice).abs() < 1e-6);
    assert_eq!(found.mesh.triangles.len(), 4);
    let mut loops = vec![polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])];
    for k in 0..20 {
        let center =
            DVec2::new(f64::from(k % 5) + 0.5, f64::from(k / 5) + 0.5) / DVec2::new(5.0, 4.0);
        loops.push(circle(center, DVec2::new(0.04, 0.08)));
    }
    let shell = Shell::new(vec![Face::trimmed(surface(), loops).unwrap()], None).unwrap();
    for tolerance in [1e-2, 1e-4] {
        let found = check(&shell, tolerance, -19);
        let area = 50.0 - 20.0 * PI * 0.16;
        assert!((found.mesh.view().area() / area - 1.0).abs() < tolerance);
    }
}

#[test]
fn limits_of_edges_and_angles_hold() {
    let shell = tube_with_caps();
    let limits = TessellateOptions { max_edge: Some(0.25), max_angle: Some(0.2), ..options(0.1) };
    let found = shell.tessellate(&limits, &mut Silent).unwrap();
    check_sides(&found.mesh);
    for &[a, b, c] in &found.mesh.triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            let [a, b] = [a, b].map(|k| found.mesh.vertices[k as usize]);
            assert!(a.distance(b) <= 0.25 + 1e-12, "{}", a.distance(b));
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let shells = [cut_sphere(4, 5), cut_sphere(10, 10), tube_with_caps()];
    for shell in shells {
        neurbs::set_num_threads(1);
        let one = shell.tessellate(&options(1e-3), &mut Silent).unwrap();
        neurbs::set_num_threads(2);
        let two = shell.tessellate(&options(1e-3), &mut Silent).unwrap();
        assert_eq!(one, two);
    }
}

#[test]
fn one_whole_face_keeps_the_mesh_of_its_surface() {
    let face = Face::whole(wavy()).unwrap();
    let shell = Shell::new(vec![face.clone()], None).unwrap();
    let mesh = wavy().tessellate(&options(1e-3), &mut Silent).unwrap();
    assert_eq!(shell.tessellate(&options(1e-3), &mut Silent).unwrap().mesh, mesh);
    let turned = face.reversed().tessellate(&options(1e-3), &mut Silent).unwrap();
    assert_eq!(turned.normals[7], -mesh.normals[7]);
    assert_eq!(turned.triangles.len(), mesh.triangles.len());
}
