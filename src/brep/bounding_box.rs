//! Tight axis-aligned bounding boxes of faces and shells.

use glam::DVec3;

use super::border_curve::{BorderCurve, extents};
use super::crease::creases;
use super::face::Face;
use super::loop_tree::LoopTree;
use super::shell::Shell;
use crate::error::Result;
use crate::nurbs::{Direction, SurfacePart};
use crate::progress::Observer;

impl Face {
    /// Returns the smallest and largest coordinates of the face.
    ///
    /// The box touches the face on all six sides, up to 1e-9 of the surface's size.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, nurbs::{NurbsCurve, NurbsSurface}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y)?;
    /// let (center, x, y) = (DVec3::new(0.5, 0.5, 0.0), 0.25 * DVec3::X, 0.25 * DVec3::Y);
    /// let circle = NurbsCurve::arc(center, x, y, std::f64::consts::TAU)?;
    /// let disc = Face::trimmed(plane, vec![vec![circle]])?;
    /// let (low, high) = disc.bounding_box(&mut Silent)?;
    /// assert!(low.distance(DVec3::new(1.0, 1.0, 0.0)) < 1e-8);
    /// assert!(high.distance(DVec3::new(3.0, 3.0, 0.0)) < 1e-8);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn bounding_box(&self, observer: &mut dyn Observer) -> Result<(DVec3, DVec3)> {
        let surface = self.surface();
        if !self.is_trimmed() {
            return surface.bounding_box(observer);
        }
        let region = LoopTree::new(self.loops())?;
        let border = extents(&BorderCurve::of(self)?)?;
        let creases = [Direction::U, Direction::V].map(|direction| creases(surface, direction));
        surface.bounding_box_of(Some(&SurfacePart { region: &region, border, creases }), observer)
    }
}

impl Shell {
    /// Returns the smallest and largest coordinates of the faces; see [`Face::bounding_box`].
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell, progress::Silent};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::X, 1.0)?)?;
    /// let (low, high) = Shell::new(vec![sphere], None)?.bounding_box(&mut Silent)?;
    /// assert!(low.distance(DVec3::new(0.0, -1.0, -1.0)) < 1e-8);
    /// assert!(high.distance(DVec3::new(2.0, 1.0, 1.0)) < 1e-8);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Face::bounding_box`].
    pub fn bounding_box(&self, observer: &mut dyn Observer) -> Result<(DVec3, DVec3)> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for face in self.faces() {
            let corners = face.bounding_box(observer)?;
            (low, high) = (low.min(corners.0), high.max(corners.1));
        }
        Ok((low, high))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::loops::Loop;
    use super::super::test_faces::{circle, pierced, polygon, rectangle, twenty_circles, waves};
    use super::*;
    use crate::nurbs::NurbsSurface;
    use crate::progress::Silent;

    fn corners(face: &Face) -> (DVec3, DVec3) {
        face.bounding_box(&mut Silent).unwrap()
    }

    #[test]
    fn boxes_match_closed_forms() {
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
        let z = |v: f64| sphere.point(0.0, v).z;
        let zone = |low: f64, high: f64| {
            Face::trimmed(sphere.clone(), vec![rectangle((0.0, low), (1.0, high))]).unwrap()
        };
        // The equator is inside one zone and outside the other.
        let (low, high) = corners(&zone(0.3, 0.8));
        assert!(low.distance(DVec3::new(-1.0, -1.0, z(0.3))) < 1e-8, "{low}");
        assert!(high.distance(DVec3::new(1.0, 1.0, z(0.8))) < 1e-8, "{high}");
        let radius = (1.0 - z(0.7).powi(2)).sqrt();
        let (low, high) = corners(&zone(0.7, 1.0));
        assert!(low.distance(DVec3::new(-radius, -radius, z(0.7))) < 1e-8, "{low}");
        assert!(high.distance(DVec3::new(radius, radius, 1.0)) < 1e-8, "{high}");
        // A hole around the point that is farthest in x.
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let band = rectangle((0.1, 0.0), (0.9, 1.0));
        let (low, high) = corners(&Face::trimmed(torus.clone(), vec![band]).unwrap());
        let edge = (0..=4).map(|k| torus.point(0.1, f64::from(k) / 4.0).x).fold(0.0, f64::max);
        assert!(low.distance(DVec3::new(-4.0, -4.0, -1.0)) < 1e-8, "{low}");
        assert!(high.distance(DVec3::new(edge, 4.0, 1.0)) < 1e-8, "{high}");
    }

    #[test]
    fn the_tip_of_a_pyramid_counts() {
        let net = (0..9).map(|k| {
            let z = if k == 4 { 1.0 } else { 0.0 };
            DVec3::new(f64::from(k / 3), f64::from(k % 3), z)
        });
        let pyramid = NurbsSurface::clamped(net.collect(), (3, 3), 1).unwrap();
        let face = Face::trimmed(pyramid.clone(), vec![circle((0.5, 0.5), 0.3)]).unwrap();
        assert_eq!(corners(&face).1.z, 1.0);
        let beside = Face::trimmed(pyramid, vec![circle((0.55, 0.5), 0.03)]).unwrap();
        assert!((corners(&beside).1.z - 0.96).abs() < 1e-8);
    }

    #[test]
    fn boxes_contain_samples_and_touch_them() {
        let l = [(0.1, 0.1), (0.1, 0.9), (0.5, 0.9), (0.5, 0.5), (0.9, 0.5), (0.9, 0.1)];
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        for face in [
            pierced(waves(), twenty_circles()),
            Face::trimmed(waves(), vec![circle((0.45, 0.55), 0.4)]).unwrap(),
            Face::trimmed(torus.clone(), vec![polygon(&l)]).unwrap(),
            Face::trimmed(torus, vec![circle((0.52, 0.47), 0.3)]).unwrap(),
        ] {
            let (low, high) = corners(&face);
            let place = |k: u32| DVec2::new(f64::from(k / 401), f64::from(k % 401)) / 400.0;
            let mut uv: Vec<DVec2> = (0..401 * 401).map(place).collect();
            let inside = face.contains(&uv, &mut Silent).unwrap();
            let mut keep = inside.iter();
            uv.retain(|_| *keep.next().unwrap());
            for curve in face.loops().iter().flat_map(Loop::curves) {
                let (start, end) = curve.knots().domain();
                let at = |k: u32| start + (end - start) * f64::from(k) / 2000.0;
                uv.extend((0..=2000).map(|k| curve.point(at(k)).truncate()));
            }
            let points = || uv.iter().map(|uv| face.surface().point(uv.x, uv.y));
            let least = points().fold(DVec3::INFINITY, DVec3::min);
            let most = points().fold(DVec3::NEG_INFINITY, DVec3::max);
            let size = face.surface().size();
            assert!((least - low).min_element() >= -2e-9 * size, "{least} {low}");
            assert!((high - most).min_element() >= -2e-9 * size, "{most} {high}");
            assert!((least - low).max(high - most).max_element() < 1e-4 * size);
        }
    }
}
