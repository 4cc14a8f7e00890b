//! Which places of (u, v) are on a face.

use glam::DVec2;

use super::face::Face;
use super::loop_tree::LoopTree;
use super::settings::BrepSettings;
use crate::error::{Error, Result};
use crate::nurbs::map_in_blocks;
use crate::progress::Observer;

impl Face {
    /// Returns whether each place (u, v) is on the face, in parallel. The border counts, up to the
    /// gap that loops may have: 1e-6 of the sides of the surface's rectangle.
    ///
    /// Beside that margin the result is exact: no polygon replaces a curve.
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, Face, nurbs::{NurbsCurve, NurbsSurface}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// let center = DVec3::new(0.5, 0.5, 0.0);
    /// let (x, y) = (0.25 * DVec3::X, 0.25 * DVec3::Y);
    /// let circle = NurbsCurve::arc(center, x, y, std::f64::consts::TAU)?;
    /// let disc = Face::trimmed(plane, vec![vec![circle]])?;
    /// let uv = [DVec2::new(0.5, 0.5), DVec2::new(0.75, 0.5), DVec2::new(0.7, 0.7)];
    /// assert_eq!(disc.contains(&uv, &mut Silent)?, [true, true, false]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`] if a place is not finite, [`Error::Interrupted`] if the observer stops
    /// it.
    pub fn contains(&self, uv: &[DVec2], observer: &mut dyn Observer) -> Result<Vec<bool>> {
        if let Some(index) = uv.iter().position(|place| !place.is_finite()) {
            return Err(Error::NotFinite { index, point: uv[index].extend(0.0) });
        }
        let tree = LoopTree::new(self.loops())?;
        let ((u0, u1), (v0, v1)) =
            (self.surface().knots_u().domain(), self.surface().knots_v().domain());
        let gap = BrepSettings::STANDARD.loop_gap * DVec2::new(u1 - u0, v1 - v0);
        map_in_blocks(uv, observer, |&place| {
            tree.winding_number(place) != Some(0) || tree.meets(place - gap, place + gap)
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::loops::Loop;
    use super::super::test_faces::{
        circle, pierced, plane, polygon, random, random_point, twenty_circles,
    };
    use super::*;
    use crate::nurbs::NurbsSurface;
    use crate::progress::Silent;

    /// Whether a fine polygon contains a point; `None` within 1e-4 of the polygon.
    fn polygon_contains(face: &Face, point: DVec2) -> Option<bool> {
        let mut inside = false;
        for curve in face.loops().iter().flat_map(Loop::curves) {
            let (start, end) = curve.knots().domain();
            let place =
                |k: u32| curve.point(start + (end - start) * f64::from(k) / 500.0).truncate();
            for k in 0..500 {
                let (a, b) = (place(k), place(k + 1));
                if a.distance(point) < 1e-4 + a.distance(b) {
                    let along = b - a;
                    let share = (point - a).dot(along) / along.length_squared();
                    if (a + share.clamp(0.0, 1.0) * along).distance(point) < 1e-4 {
                        return None;
                    }
                }
                let above = |p: DVec2| p.y > point.y;
                if above(a) != above(b) && (a.y > b.y) == ((b - a).perp_dot(point - a) < 0.0) {
                    inside = !inside;
                }
            }
        }
        Some(inside)
    }

    fn faces() -> [Face; 4] {
        let l = [(0.1, 0.1), (0.1, 0.9), (0.5, 0.9), (0.5, 0.5), (0.9, 0.5), (0.9, 0.1)];
        let star: Vec<(f64, f64)> = (0..14)
            .map(|k| {
                let radius = if k % 2 == 0 { 0.45 } else { 0.1 };
                let at = DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 14.0);
                (0.5 + radius * at.x, 0.5 + radius * at.y)
            })
            .collect();
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        [
            pierced(plane(1.0), twenty_circles()),
            Face::trimmed(plane(1.0), vec![polygon(&l), circle((0.3, 0.3), 0.15)]).unwrap(),
            Face::trimmed(plane(1.0), vec![polygon(&star)]).unwrap(),
            Face::whole(torus).unwrap(),
        ]
    }

    #[test]
    fn places_agree_with_a_fine_polygon() {
        for face in faces() {
            let place = |k: u32| 0.5 + 0.6 * random_point(k).truncate();
            let uv: Vec<DVec2> = (0..2500).map(place).collect();
            let found = face.contains(&uv, &mut Silent).unwrap();
            for (uv, found) in uv.iter().zip(found) {
                if let Some(expected) = polygon_contains(&face, *uv) {
                    assert_eq!(found, expected, "{uv}");
                }
            }
        }
    }

    #[test]
    fn the_border_counts() {
        for face in faces() {
            for curve in face.loops().iter().flat_map(Loop::curves) {
                let (start, end) = curve.knots().domain();
                let place = |k: u32| curve.point(start + (end - start) * random(k)).truncate();
                let near = |k: u32| place(k) + 9e-7 * random_point(k).truncate();
                let uv: Vec<DVec2> = (0..100).flat_map(|k| [place(k), near(k)]).collect();
                assert!(face.contains(&uv, &mut Silent).unwrap().iter().all(|inside| *inside));
            }
        }
        let disc = Face::trimmed(plane(1.0), vec![circle((0.5, 0.5), 0.25)]).unwrap();
        let right = |by: f64| DVec2::new(0.75 + by, 0.5);
        let found = disc.contains(&[right(0.0), right(5e-7), right(2e-6)], &mut Silent);
        assert_eq!(found.unwrap(), [true, true, false]);
        let nan = disc.contains(&[DVec2::NAN], &mut Silent);
        assert!(matches!(nan, Err(Error::NotFinite { index: 0, .. })));
    }
}
