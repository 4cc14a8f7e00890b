//! Areas of faces and shells, and volumes of closed shells.

use glam::DVec3;

use super::face::Face;
use super::face_strips::strips;
use super::shell::Shell;
use super::strip::{Integrand, Strip, rules};
use crate::error::{Error, Result};
use crate::nurbs::gauss::check_accuracy;
use crate::nurbs::integral;
use crate::progress::Observer;

impl Face {
    /// Returns the area, in the square of the points' unit, with relative error at most `accuracy`
    /// (for instance 1e-9).
    ///
    /// By Green's theorem the area is a sum of integrals over strips along the loops, exact up to
    /// rounding: no polygon replaces a curve. Strips whose estimates disagree are quartered.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, nurbs::{NurbsCurve, NurbsSurface}, progress::Silent};
    /// use std::f64::consts::{PI, TAU};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y)?;
    /// let center = DVec3::new(0.5, 0.5, 0.0);
    /// let circle = NurbsCurve::arc(center, 0.25 * DVec3::X, 0.25 * DVec3::Y, TAU)?;
    /// let disc = Face::trimmed(plane, vec![vec![circle]])?;
    /// assert!((disc.area(1e-12, &mut Silent)? / (PI / 4.0) - 1.0).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the accuracy is not between 1e-14 and 1, [`Error::Interrupted`] if
    /// the observer stops it.
    pub fn area(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        if !self.is_trimmed() {
            return self.surface().area(accuracy, observer);
        }
        check_accuracy(accuracy)?;
        let (low, high) = self.surface().net_box();
        let strips = strips(self, Integrand::Area, low.midpoint(high), observer)?;
        integral(&strips, Strip::clone, &rules(), accuracy, observer)
    }
}

impl Shell {
    /// Returns the sum of the areas of the faces, with relative error at most `accuracy`; see
    /// [`Face::area`].
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell, progress::Silent};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// let area = Shell::new(vec![sphere], None)?.area(1e-10, &mut Silent)?;
    /// assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-10);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Face::area`].
    pub fn area(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        self.faces().iter().map(|face| face.area(accuracy, observer)).sum()
    }

    /// Returns the volume of a closed shell, in the cube of the points' unit, with relative error
    /// at most `accuracy` (for instance 1e-9). It is negative if the faces' normals point inward.
    ///
    /// The volume is the flux of the field S / 3 through the faces, from a point near the middle of
    /// the shell. It is integrated like [`Face::area`]; no mesh is made.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell, progress::Silent};
    /// let torus = Face::whole(NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0)?)?;
    /// let volume = Shell::new(vec![torus], None)?.volume(1e-12, &mut Silent)?;
    /// let exact = 6.0 * std::f64::consts::PI.powi(2);
    /// assert!((volume / exact - 1.0).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Shell`] if the shell is not closed; else as [`Face::area`].
    pub fn volume(&self, accuracy: f64, observer: &mut dyn Observer) -> Result<f64> {
        check_accuracy(accuracy)?;
        if !self.is_closed() {
            let must = "be closed to have a volume";
            let (border, edges) = (self.border().count(), self.edges().len());
            let got = format!("{border} of its {edges} edges belong to one face only");
            return Err(Error::Shell { must, got });
        }
        let middle = self.middle();
        let mut all = vec![];
        for face in self.faces() {
            all.extend(strips(face, Integrand::Volume, middle, observer)?);
        }
        integral(&all, Strip::clone, &rules(), accuracy, observer)
    }

    /// The middle of the box around the edges' control points.
    fn middle(&self) -> DVec3 {
        let points = || self.edges().iter().flat_map(|edge| edge.curve.control_points()).copied();
        let low = points().reduce(DVec3::min).unwrap_or_default();
        low.midpoint(points().reduce(DVec3::max).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::DAffine3;

    use super::super::test_faces::{
        circle, pierced, plane, polygon, random, rectangle, twenty_circles, waves,
    };
    use super::*;
    use crate::nurbs::{NurbsCurve, NurbsSurface};
    use crate::progress::Silent;

    fn area(face: &Face) -> f64 {
        face.area(1e-12, &mut Silent).unwrap()
    }

    fn volume(faces: Vec<Face>) -> f64 {
        Shell::new(faces, None).unwrap().volume(1e-12, &mut Silent).unwrap()
    }

    fn assert_near(value: f64, exact: f64, accuracy: f64) {
        assert!((value / exact - 1.0).abs() <= accuracy, "{value} instead of {exact}");
    }

    /// A disc of radius 1 in a plane.
    fn cap(z: f64) -> Face {
        let origin = DVec3::new(-2.0, -2.0, z);
        let plane = NurbsSurface::plane(origin, 4.0 * DVec3::X, 4.0 * DVec3::Y).unwrap();
        Face::trimmed(plane, vec![circle((0.5, 0.5), 0.25)]).unwrap()
    }

    /// The six faces of a box, normals outward.
    fn box_faces(corner: DVec3) -> Vec<Face> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * corner);
        let faces = (0..3).flat_map(|k| {
            let (a, b, c) = (axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]);
            let face = |origin| Face::whole(NurbsSurface::plane(origin, a, b).unwrap()).unwrap();
            [face(DVec3::ZERO).reversed(), face(c)]
        });
        faces.collect()
    }

    /// The parts of a torus inside and outside a circle that crosses its knots.
    fn torus_halves() -> Vec<Face> {
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let around = || circle((0.52, 0.47), 0.3);
        let inside = Face::trimmed(torus.clone(), vec![around()]).unwrap();
        vec![inside, pierced(torus, vec![around()])]
    }

    #[test]
    fn areas_of_plane_faces_are_exact() {
        let holes = vec![circle((0.3, 0.3), 0.1), circle((0.7, 0.4), 0.2)];
        let disc = [vec![circle((0.5, 0.5), 0.45)], holes].concat();
        let disc = Face::trimmed(plane(2.0), disc).unwrap();
        assert_near(area(&disc), 4.0 * PI * (0.45 * 0.45 - 0.01 - 0.04), 1e-12);
        let l = [(0.1, 0.1), (0.1, 0.9), (0.5, 0.9), (0.5, 0.5), (0.9, 0.5), (0.9, 0.1)];
        assert_near(area(&Face::trimmed(plane(1.0), vec![polygon(&l)]).unwrap()), 0.48, 1e-14);
        let holes: f64 = (0..20).map(|k| PI * (0.06 + 0.03 * random(k)).powi(2)).sum();
        assert_near(area(&pierced(plane(1.0), twenty_circles())), 1.0 - holes, 1e-12);
        // A tiny face in a large plane, far from the origin.
        let far = NurbsSurface::plane(1e6 * DVec3::ONE, DVec3::X, DVec3::Y).unwrap();
        let tiny = Face::trimmed(far, vec![circle((0.7, 0.7), 1e-3)]).unwrap();
        assert_near(area(&tiny), PI * 1e-6, 1e-9);
    }

    #[test]
    fn areas_of_zones_of_a_sphere_are_exact() {
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0).unwrap();
        let z = |v: f64| sphere.point(0.0, v).z;
        let zone = |low, high| TAU * 2.0 * (z(high) - z(low)) / 4.0;
        let outer = rectangle((0.25, 0.1), (0.5, 0.9));
        let face = Face::trimmed(sphere.clone(), vec![outer.clone()]).unwrap();
        assert_near(area(&face), zone(0.1, 0.9), 1e-11);
        // The pole is a corner of the zone.
        let top = Face::trimmed(sphere.clone(), vec![rectangle((0.0, 0.6), (0.5, 1.0))]).unwrap();
        assert_near(area(&top), 2.0 * zone(0.6, 1.0), 1e-11);
        let round = || circle((0.4, 0.5), 0.08);
        let disc = Face::trimmed(sphere.clone(), vec![round()]).unwrap();
        let rest = Face::trimmed(sphere.clone(), vec![outer, round()]).unwrap();
        assert_near(area(&disc) + area(&rest), zone(0.1, 0.9), 1e-11);
    }

    #[test]
    fn parts_of_a_surface_add_up() {
        let [inside, outside] = &torus_halves()[..] else { panic!() };
        assert_near(area(inside) + area(outside), 12.0 * PI * PI, 1e-11);
        let all = pierced(waves(), vec![]);
        assert_near(area(&all), area(&Face::whole(waves()).unwrap()), 1e-11);
        let parts = twenty_circles().into_iter().map(|c| Face::trimmed(waves(), vec![c]).unwrap());
        let parts: f64 = parts.map(|face| area(&face)).sum();
        assert_near(parts + area(&pierced(waves(), twenty_circles())), area(&all), 1e-11);
    }

    #[test]
    fn volumes_match_closed_forms() {
        let whole = |surface: NurbsSurface| Face::whole(surface).unwrap();
        let sphere = || whole(NurbsSurface::sphere(DVec3::ONE, 2.0).unwrap());
        assert_near(volume(vec![sphere()]), 32.0 / 3.0 * PI, 1e-12);
        assert_near(volume(vec![sphere().reversed()]), -32.0 / 3.0 * PI, 1e-12);
        let tube = NurbsSurface::cylinder(DVec3::ZERO, 2.0 * DVec3::Z, 1.0).unwrap();
        let can = || vec![whole(tube.clone()), cap(0.0).reversed(), cap(2.0)];
        assert_near(volume(can()), TAU, 1e-12);
        let shell = Shell::new(can(), None).unwrap();
        assert_near(shell.area(1e-12, &mut Silent).unwrap(), 6.0 * PI, 1e-12);
        let cone = NurbsSurface::cone(DVec3::ZERO, 3.0 * DVec3::Z, 1.0, 0.0).unwrap();
        assert_near(volume(vec![whole(cone), cap(0.0).reversed()]), PI, 1e-12);
        assert_near(volume(box_faces(DVec3::new(1.0, 2.0, 3.0))), 6.0, 1e-14);
        // A torus in two trimmed faces.
        assert_near(volume(torus_halves()), 6.0 * PI * PI, 1e-11);
        let mirrored = shell.transformed(&DAffine3::from_scale(-DVec3::ONE)).unwrap();
        assert_near(mirrored.volume(1e-12, &mut Silent).unwrap(), TAU, 1e-12);
    }

    #[test]
    fn volumes_far_from_the_origin_are_accurate() {
        let far = DAffine3::from_translation(1e6 * DVec3::new(1.0, -2.0, 0.5));
        let moved = box_faces(DVec3::ONE).into_iter().map(|face| face.transformed(&far).unwrap());
        assert_near(volume(moved.collect()), 1.0, 1e-9);
        let torus = torus_halves().iter().map(|face| face.transformed(&far).unwrap()).collect();
        assert_near(volume(torus), 6.0 * PI * PI, 1e-8);
    }

    #[test]
    fn a_hole_is_subtracted() {
        // A box with a cylindrical hole from bottom to top.
        let mut faces = box_faces(DVec3::new(4.0, 4.0, 2.0));
        let tube = NurbsSurface::cylinder(DVec3::new(2.0, 2.0, 0.0), 2.0 * DVec3::Z, 1.0).unwrap();
        for face in &mut faces[..2] {
            let holes =
                pierced(NurbsSurface::clone(face.surface()), vec![circle((0.5, 0.5), 0.25)]);
            *face = if face.is_reversed() { holes.reversed() } else { holes };
        }
        faces.push(Face::whole(tube).unwrap().reversed());
        assert_near(volume(faces), 32.0 - TAU, 1e-12);
    }

    #[test]
    fn open_shells_have_no_volume() {
        let shell = Shell::new(box_faces(DVec3::ONE)[1..].to_vec(), None).unwrap();
        let error = shell.volume(1e-9, &mut Silent).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("must be closed") && message.contains("4 of its 12"), "{message}");
        assert!(matches!(shell.volume(2.0, &mut Silent), Err(Error::Parameter { .. })));
    }

    #[test]
    fn gaps_of_loops_are_closed() {
        let shift = |curve: &NurbsCurve| {
            curve.transformed(&DAffine3::from_translation(DVec3::new(0.0, 5e-7, 0.0))).unwrap()
        };
        let mut open = polygon(&[(0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8)]);
        open[1] = shift(&open[1]);
        let face = Face::trimmed(plane(1.0), vec![open]).unwrap();
        assert_near(area(&face), 0.36, 1e-6);
        let gap = glam::DVec2::new(0.1, 0.2 + 2e-7);
        assert_eq!(face.contains(&[gap], &mut Silent).unwrap(), [false]);
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let face = pierced(waves(), twenty_circles());
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| area(&face).to_bits())
        };
        assert_eq!(on(1), on(3));
    }
}
