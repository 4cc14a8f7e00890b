//! Trimming of tubes and tori, with holes on seams and ragged rims.

use std::collections::HashMap;
use std::sync::Arc;

use neurbs::mesh::TessellateOptions;
use neurbs::progress::Silent;
use neurbs::trim::{Trim, TrimOptions, trim};
use neurbs::{DVec2, DVec3, NurbsSurface, Shell};

use super::samplings::Random;

/// A part of a closed surface.
struct Part<F> {
    surface: Arc<NurbsSurface>,
    keeps: F,
}

impl<F: Fn(DVec3) -> bool> Part<F> {
    /// Random points, evenly over the area, as parameters.
    fn points(&self, count: usize, seed: u64) -> Vec<DVec2> {
        let mut random = Random::new(seed);
        let largest = self.cells(50).map(|(_, area)| area).fold(0.0, f64::max) * 2500.0;
        let mut points = vec![];
        while points.len() < count {
            let at = random.point();
            let kept = random.number() * largest < self.stretch(at);
            if kept && (self.keeps)(self.point(at)) {
                points.push(at);
            }
        }
        points
    }

    fn point(&self, at: DVec2) -> DVec3 {
        self.surface.point(at.x, at.y)
    }

    /// Area over that in (u, v).
    fn stretch(&self, at: DVec2) -> f64 {
        let step = 1e-5;
        let low = (at - step).max(DVec2::ZERO);
        let high = (at + step).min(DVec2::ONE);
        let along = |from: DVec2, to: DVec2| {
            (self.point(to) - self.point(from)) / (to - from).element_sum()
        };
        let by_u = along(DVec2::new(low.x, at.y), DVec2::new(high.x, at.y));
        let by_v = along(DVec2::new(at.x, low.y), DVec2::new(at.x, high.y));
        by_u.cross(by_v).length()
    }

    /// Middles of a lattice of cells, with their areas.
    fn cells(&self, count: u32) -> impl Iterator<Item = (DVec2, f64)> {
        let at = move |k: u32| (f64::from(k) + 0.5) / f64::from(count);
        let middles = (0..count * count).map(move |k| DVec2::new(at(k / count), at(k % count)));
        middles.map(move |at| (at, self.stretch(at) / f64::from(count * count)))
    }

    fn area(&self) -> f64 {
        let kept = self.cells(400).filter(|(at, _)| (self.keeps)(self.point(*at)));
        kept.map(|(_, area)| area).sum()
    }

    /// Trims it with some seeds. Holes, area and topology are right.
    fn check(&self, name: &str, holes: usize, euler: i64) {
        for seed in 0..3 {
            let made = self.trimmed(4000, seed);
            let name = format!("{name}, seed {seed}");
            assert_eq!((made.faces.len(), made.regions), (1, 1), "{name}");
            let found = made.loops.iter().filter(|of| of.is_hole).count();
            assert_eq!(found, holes, "{name}: {:?}", made.loops);
            assert!(made.loops.iter().all(|of| !of.form.is_polygon()), "{name}: {:?}", made.loops);
            let area = made.faces[0].area(1e-6, &mut Silent).unwrap();
            assert!((area / self.area() - 1.0).abs() < 0.015, "{name}: {}", area / self.area());
            check_mesh(&name, &made, euler);
        }
    }

    fn trimmed(&self, count: usize, seed: u64) -> Trim {
        let points = self.points(count, seed);
        trim(&self.surface, &points, &TrimOptions::default(), &mut Silent).unwrap()
    }
}

/// Sides of the mesh belong to two triangles at most, and its topology is right.
fn check_mesh(name: &str, made: &Trim, euler: i64) {
    let shell = Shell::new(made.faces.clone(), None).unwrap();
    assert_eq!(shell.euler_characteristic(), euler, "{name}");
    let mesh = shell.tessellate(&TessellateOptions::default(), &mut Silent).unwrap().mesh;
    assert_eq!(mesh.view().euler_characteristic(), euler, "{name}");
    let mut sides: HashMap<(u32, u32), u32> = HashMap::new();
    for [a, b, c] in mesh.triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *sides.entry((a, b)).or_default() += 1;
        }
    }
    assert!(sides.values().all(|count| *count == 1), "{name}");
}

/// A cylinder of radius 1 from height -0.5 to 3.5, with its seam at (1, 0).
fn tube<F: Fn(DVec3) -> bool>(keeps: F) -> Part<F> {
    let surface = NurbsSurface::cylinder(DVec3::new(0.0, 0.0, -0.5), 4.0 * DVec3::Z, 1.0);
    Part { surface: Arc::new(surface.unwrap()), keeps }
}

fn torus<F: Fn(DVec3) -> bool>(keeps: F) -> Part<F> {
    Part { surface: Arc::new(NurbsSurface::torus(DVec3::ZERO, 2.0, 0.8).unwrap()), keeps }
}

fn angle(at: DVec3) -> f64 {
    at.y.atan2(at.x)
}

/// The point of the tube at an angle and a height.
fn on_tube(angle: f64, height: f64) -> DVec3 {
    DVec3::new(angle.cos(), angle.sin(), height)
}

/// Whether a point is farther than 0.45 from all of some points.
fn away(at: DVec3, holes: &[DVec3]) -> bool {
    holes.iter().all(|hole| at.distance(*hole) > 0.45)
}

fn level(at: DVec3) -> bool {
    (0.0..3.0).contains(&at.z)
}

#[test]
fn tubes_with_level_and_ragged_rims() {
    tube(level).check("level", 0, 0);
    let ragged = |at: DVec3| {
        at.z > 0.2 * (3.0 * angle(at)).sin() && at.z < 2.7 + 0.25 * (5.0 * angle(at)).cos()
    };
    tube(ragged).check("ragged", 0, 0);
    tube(|at| at.z > 0.0 && at.z < 1.5 + 0.9 * angle(at).cos()).check("slanted", 0, 0);
    let holes = [on_tube(0.0, 1.4), on_tube(3.0, 1.4)];
    tube(|at| ragged(at) && away(at, &holes)).check("ragged with holes", 2, -2);
}

#[test]
fn tubes_with_holes_beside_and_on_the_seam() {
    // From the opposite side to the middle of the seam.
    for turn in [3.0, 1.0, 0.47, 0.45, 0.3, 0.0, -0.44] {
        let holes = [on_tube(turn, 1.5)];
        tube(|at| level(at) && away(at, &holes)).check(&format!("at {turn}"), 1, -1);
    }
    let holes = [on_tube(0.1, 0.7), on_tube(-0.2, 2.1), on_tube(2.0, 1.5)];
    tube(|at| level(at) && away(at, &holes)).check("three", 3, -3);
}

#[test]
fn bays_at_the_seam_and_open_tubes() {
    let bay = [on_tube(0.1, 3.0)];
    tube(|at| level(at) && away(at, &bay)).check("bay", 0, 0);
    tube(|at| level(at) && angle(at).abs() < 2.0).check("across the seam", 0, 1);
}

#[test]
fn tori_with_holes_beside_and_on_seams() {
    let at = |u: f64, v: f64| {
        let far = 2.0 + 0.8 * v.cos();
        DVec3::new(far * u.cos(), far * u.sin(), 0.8 * v.sin())
    };
    torus(|_| true).check("whole", 0, 0);
    for (u, v) in [(2.0, 1.0), (0.1, 1.0), (2.0, 0.1), (0.05, -0.1), (0.0, 0.0)] {
        let holes = [at(u, v)];
        torus(|at| away(at, &holes)).check(&format!("at {u} {v}"), 1, -1);
    }
    let holes = [at(0.0, 0.0), at(0.1, 2.0), at(2.0, 0.2), at(3.0, 3.0)];
    torus(|at| away(at, &holes)).check("four", 4, -4);
    // A sleeve that winds around with the hole of the torus or through it.
    torus(|at| angle(at).abs() < 2.0).check("sleeve across a seam", 0, 0);
    torus(|at| at.z > -0.3).check("without its bottom", 0, 0);
}
