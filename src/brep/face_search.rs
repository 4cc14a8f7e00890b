//! Projection of points onto faces: the globally closest point.
//!
//! The closest point of a face is on a curve around it, or it is a place inside where the distance
//! from the surface is locally smallest. The curves are searched first: their distance ends the
//! search of pieces of the surface that the curves cut.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::border_curve::BorderCurve;
use super::face::Face;
use super::loop_tree::LoopTree;
use super::shell::Shell;
use crate::error::{Error, Result};
use crate::nurbs::{
    ClosestPointSearch, CurveSearch, NurbsCurve, NurbsSurface, ParameterRegion, map_in_blocks,
};
use crate::progress::Observer;

/// The projection of a point onto faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacePoint {
    /// The index of the face.
    pub face: usize,
    /// The parameters of the projection.
    pub uv: DVec2,
    /// The projection.
    pub point: DVec3,
    /// The distance from the point, in the points' unit.
    pub distance: f64,
}

/// Faces prepared for closest-point searches.
///
/// ```
/// use neurbs::{DVec3, Face, FaceSearch, NurbsSurface, progress::Silent};
/// let plane = |x: f64| NurbsSurface::plane(x * DVec3::X, DVec3::X, DVec3::Y);
/// let faces = [Face::whole(plane(0.0)?)?, Face::whole(plane(2.0)?)?];
/// let search = FaceSearch::new(&faces, &mut Silent)?;
/// let projection = search.closest_point(DVec3::new(2.5, 0.5, 3.0));
/// assert_eq!((projection.face, projection.distance), (1, 3.0));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Debug)]
pub struct FaceSearch {
    faces: Vec<OneFace>,
}

impl FaceSearch {
    /// Prepares faces.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, Face, FaceSearch, NurbsSurface, progress::Progress};
    /// use std::ops::ControlFlow;
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// let mut stop = |_: &Progress| ControlFlow::Break(());
    /// assert!(matches!(FaceSearch::new(&[sphere], &mut stop), Err(Error::Interrupted)));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn new(faces: &[Face], observer: &mut dyn Observer) -> Result<Self> {
        let faces = faces.iter().map(|face| OneFace::new(face, observer)).collect::<Result<_>>()?;
        Ok(Self { faces })
    }

    /// Returns the closest point of the faces; if several are equally close, any of them.
    ///
    /// Without faces, or for a point that is not finite, the result is NaN.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, FaceSearch, NurbsSurface, progress::Silent};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// let search = FaceSearch::new(&[sphere], &mut Silent)?;
    /// assert!((search.closest_point(3.0 * DVec3::Y).distance - 2.0).abs() < 1e-14);
    /// assert!(search.closest_point(DVec3::NAN).distance.is_nan());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn closest_point(&self, point: DVec3) -> FacePoint {
        let bounds: Vec<f64> = self.faces.iter().map(|face| face.corners.distance(point)).collect();
        let mut best =
            FacePoint { face: 0, uv: DVec2::NAN, point: DVec3::NAN, distance: f64::INFINITY };
        let nearest = (0..bounds.len()).min_by(|a, b| bounds[*a].total_cmp(&bounds[*b]));
        let Some(nearest) = nearest.filter(|_| point.is_finite()) else {
            return FacePoint { distance: f64::NAN, ..best };
        };
        self.faces[nearest].improve(nearest, point, &mut best);
        let mut others: Vec<usize> = (0..bounds.len())
            .filter(|face| *face != nearest && bounds[*face] < best.distance)
            .collect();
        others.sort_by(|a, b| bounds[*a].total_cmp(&bounds[*b]));
        for face in others {
            if bounds[face] >= best.distance {
                break;
            }
            self.faces[face].improve(face, point, &mut best);
        }
        best
    }

    /// Finds the closest points of many points, in parallel, in the order of the points.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, FaceSearch, NurbsSurface, progress::Silent};
    /// let sphere = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// let search = FaceSearch::new(&[sphere], &mut Silent)?;
    /// let found = search.closest_points(&[3.0 * DVec3::X, 4.0 * DVec3::Z], &mut Silent)?;
    /// assert!((found[1].distance - 3.0).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`] if a point is not finite, [`Error::Interrupted`] if the observer stops
    /// it.
    pub fn closest_points(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<Vec<FacePoint>> {
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::NotFinite { index, point: points[index] });
        }
        map_in_blocks(points, observer, |point| self.closest_point(*point))
    }
}

impl Face {
    /// Finds the closest points of the face to many points, in parallel. A point whose projection
    /// lies outside the loops goes to the nearest place of the border or inside.
    ///
    /// [`FaceSearch`] prepares faces once for several calls.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, nurbs::{NurbsCurve, NurbsSurface}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y)?;
    /// let (center, x, y) = (DVec3::new(0.5, 0.5, 0.0), 0.25 * DVec3::X, 0.25 * DVec3::Y);
    /// let circle = NurbsCurve::arc(center, x, y, std::f64::consts::TAU)?;
    /// let disc = Face::trimmed(plane, vec![vec![circle]])?;
    /// let found = disc.closest_points(&[DVec3::new(2.0, 4.0, 0.0)], &mut Silent)?;
    /// assert!(found[0].point.distance(DVec3::new(2.0, 3.0, 0.0)) < 1e-8);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`FaceSearch::closest_points`].
    pub fn closest_points(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<Vec<FacePoint>> {
        FaceSearch::new(std::slice::from_ref(self), observer)?.closest_points(points, observer)
    }
}

impl Shell {
    /// Finds the closest points of the faces to many points, in parallel; see
    /// [`Face::closest_points`].
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface, Shell, progress::Silent};
    /// let plane = |x: f64| NurbsSurface::plane(x * DVec3::X, DVec3::X, DVec3::Y);
    /// let faces = vec![Face::whole(plane(0.0)?)?, Face::whole(plane(1.0)?)?];
    /// let shell = Shell::new(faces, None)?;
    /// let found = shell.closest_points(&[DVec3::new(1.5, 0.5, 2.0)], &mut Silent)?;
    /// assert_eq!((found[0].face, found[0].distance), (1, 2.0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`FaceSearch::closest_points`].
    pub fn closest_points(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<Vec<FacePoint>> {
        FaceSearch::new(self.faces(), observer)?.closest_points(points, observer)
    }
}

/// A face prepared for searches.
#[derive(Debug)]
struct OneFace {
    surface: Arc<NurbsSurface>,
    search: ClosestPointSearch,
    /// The curves around the face; none if it is a whole surface.
    border: Vec<Curve>,
    corners: Corners,
}

/// A curve around a face.
#[derive(Debug)]
struct Curve {
    uv: NurbsCurve,
    search: CurveSearch,
    corners: Corners,
}

/// The smallest and largest corner of a bounding box.
#[derive(Clone, Copy, Debug)]
struct Corners(DVec3, DVec3);

impl Corners {
    /// A lower bound of the distance of a point from the contents.
    fn distance(self, point: DVec3) -> f64 {
        (self.0 - point).max(point - self.1).max(DVec3::ZERO).length()
    }
}

impl OneFace {
    fn new(face: &Face, observer: &mut dyn Observer) -> Result<Self> {
        let surface = Arc::clone(face.surface());
        let (mut region, mut border) = (None, vec![]);
        if face.is_trimmed() {
            region = Some(Arc::new(LoopTree::new(face.loops())?) as Arc<dyn ParameterRegion>);
            border = BorderCurve::of(face)?.into_iter().map(Curve::new).collect::<Result<_>>()?;
        }
        let search = ClosestPointSearch::within(&surface, region, observer)?;
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = search.corners().unwrap_or(empty);
        let mut corners = Corners(low, high);
        for Curve { corners: Corners(low, high), .. } in &border {
            corners = Corners(corners.0.min(*low), corners.1.max(*high));
        }
        Ok(Self { surface, search, border, corners })
    }

    /// Replaces the best point so far if the face has a closer one.
    fn improve(&self, face: usize, point: DVec3, best: &mut FacePoint) {
        for curve in &self.border {
            if curve.corners.distance(point) >= best.distance {
                continue;
            }
            let uv = self.surface_parameters(curve, point);
            let place = self.surface.point(uv.x, uv.y);
            let distance = place.distance(point);
            if distance < best.distance {
                *best = FacePoint { face, uv, point: place, distance };
            }
        }
        if let Some(found) = self.search.closer_point(point, best.distance) {
            let (uv, distance) = (found.uv, found.distance);
            *best = FacePoint { face, uv, point: found.point, distance };
        }
    }

    /// The place in (u, v) of the closest point of a curve, inside the surface's rectangle.
    fn surface_parameters(&self, curve: &Curve, point: DVec3) -> DVec2 {
        let ((u0, u1), (v0, v1)) =
            (self.surface.knots_u().domain(), self.surface.knots_v().domain());
        let uv = curve.uv.point(curve.search.closest_point(point).u).truncate();
        uv.clamp(DVec2::new(u0, v0), DVec2::new(u1, v1))
    }
}

impl Curve {
    fn new(BorderCurve { uv, in_space }: BorderCurve) -> Result<Self> {
        let points = || in_space.control_points().iter().copied();
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let corners = Corners(low, points().fold(DVec3::NEG_INFINITY, DVec3::max));
        Ok(Self { uv, search: CurveSearch::new(&in_space)?, corners })
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::super::loops::Loop;
    use super::super::test_faces::{
        circle, pierced, plane, polygon, random_point, steep, twenty_circles, waves,
    };
    use super::*;
    use crate::progress::Silent;

    /// A grid of points of a face and points of its border.
    fn samples(face: &Face) -> Vec<DVec3> {
        let place = |k: u32| DVec2::new(f64::from(k / 161), f64::from(k % 161)) / 160.0;
        let uv: Vec<DVec2> = (0..161 * 161).map(place).collect();
        let inside = face.contains(&uv, &mut Silent).unwrap();
        let mut kept: Vec<DVec2> =
            uv.into_iter().zip(inside).filter_map(|(uv, inside)| inside.then_some(uv)).collect();
        for curve in face.loops().iter().flat_map(Loop::curves) {
            let (start, end) = curve.knots().domain();
            let at = |k: u32| start + (end - start) * f64::from(k) / 200.0;
            kept.extend((0..=200).map(|k| curve.point(at(k)).truncate()));
        }
        kept.iter().map(|uv| face.surface().point(uv.x, uv.y)).collect()
    }

    /// Checks that no sample is closer than the projections, which are on the face.
    fn check(face: &Face, points: &[DVec3]) {
        let samples = samples(face);
        let found = face.closest_points(points, &mut Silent).unwrap();
        let uv: Vec<DVec2> = found.iter().map(|found| found.uv).collect();
        assert!(face.contains(&uv, &mut Silent).unwrap().iter().all(|inside| *inside));
        let size = face.surface().size();
        for (point, found) in points.iter().zip(&found) {
            let nearest = samples.iter().map(|s| s.distance(*point)).fold(f64::INFINITY, f64::min);
            assert!(found.distance <= nearest + 2e-9 * size, "{point}: {found:?}, {nearest}");
            let place = face.surface().point(found.uv.x, found.uv.y);
            assert!(place.distance(found.point) < 1e-12 * size);
            assert!((place.distance(*point) - found.distance).abs() < 1e-12 * size);
        }
    }

    /// Points near the surface, around it and far away.
    fn points_around(face: &Face) -> Vec<DVec3> {
        let (low, high) = face.surface().net_box();
        let (middle, half) = (low.midpoint(high), (high - low).max(DVec3::splat(0.1)) / 2.0);
        let near = (0..250).map(|k| {
            let uv = 0.5 * random_point(k).truncate() + 0.5;
            face.surface().point(uv.x, uv.y) + 0.02 * half * random_point(k + 1000)
        });
        let around = (0..150).map(|k| middle + 1.2 * half * random_point(k + 5000));
        let far = (0..100).map(|k| middle + 50.0 * half * random_point(k + 9000));
        near.chain(around).chain(far).collect()
    }

    #[test]
    fn no_sample_of_a_face_is_closer() {
        let l = [(0.1, 0.1), (0.1, 0.9), (0.5, 0.9), (0.5, 0.5), (0.9, 0.5), (0.9, 0.1)];
        let l = || polygon(&l);
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let sphere = NurbsSurface::sphere(DVec3::ONE, 2.0).unwrap();
        let holes = || vec![circle((0.3, 0.5), 0.2), circle((0.75, 0.4), 0.2)];
        for face in [
            pierced(plane(1.0), twenty_circles()),
            Face::trimmed(plane(1.0), vec![l()]).unwrap(),
            Face::trimmed(waves(), vec![l()]).unwrap(),
            pierced(waves(), twenty_circles()),
            Face::trimmed(torus.clone(), vec![circle((0.52, 0.47), 0.3)]).unwrap(),
            Face::trimmed(torus.clone(), vec![l()]).unwrap(),
            pierced(torus, holes()),
            pierced(sphere.clone(), holes()),
            Face::trimmed(sphere, vec![circle((0.5, 0.5), 0.45)]).unwrap(),
        ] {
            check(&face, &points_around(&face));
        }
    }

    #[test]
    fn points_over_a_hole_go_to_its_border_or_to_another_minimum_inside() {
        let face = pierced(plane(4.0), vec![circle((0.5, 0.5), 0.25)]);
        let found = face.closest_points(&[DVec3::new(2.3, 2.0, 1.0)], &mut Silent).unwrap();
        assert!(found[0].point.distance(DVec3::new(3.0, 2.0, 0.0)) < 1e-8);
        // A hole in the near side of a sphere around the point: the far side is next.
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).unwrap();
        let wide = pierced(sphere, vec![circle((0.5, 0.5), 0.3)]);
        let found = wide.closest_points(&[DVec3::new(-0.02, 0.0, 0.0)], &mut Silent).unwrap();
        assert!(found[0].distance < 1.02);
        check(&wide, &[DVec3::new(-0.02, 0.0, 0.0), DVec3::new(-0.1, 0.03, 0.01)]);
    }

    #[test]
    fn minima_inside_are_found_on_pieces_whose_nearest_point_is_outside() {
        let l =
            || polygon(&[(0.1, 0.1), (0.1, 0.9), (0.5, 0.9), (0.5, 0.5), (0.9, 0.5), (0.9, 0.1)]);
        let cases: [(u32, &[u32]); 8] = [
            (700, &[1159]),
            (1400, &[306, 1138]),
            (1800, &[933, 1383]),
            (2700, &[1351]),
            (2800, &[1119, 1281]),
            (3500, &[1096]),
            (3600, &[618, 749]),
            (3700, &[0, 1, 2, 3, 4, 5]),
        ];
        for (seed, places) in cases {
            let face = Face::trimmed(steep(seed), vec![l()]).unwrap();
            let point = |k: &u32| {
                let uv = 0.5 * random_point(*k).truncate() + 0.5;
                face.surface().point(uv.x, uv.y) + 0.3 * random_point(k + 2000)
            };
            check(&face, &places.iter().map(point).collect::<Vec<DVec3>>());
        }
    }

    #[test]
    fn shells_are_searched_far_from_the_origin_and_reversed() {
        let far = DAffine3::from_translation(1e6 * DVec3::new(1.0, -2.0, 0.5));
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let around = || circle((0.52, 0.47), 0.3);
        let faces = [
            Face::trimmed(torus.clone(), vec![around()]).unwrap().reversed(),
            pierced(torus.clone(), vec![around()]).reversed(),
        ];
        let whole = ClosestPointSearch::new(&torus).unwrap();
        let points: Vec<DVec3> = (0..300).map(|k| 5.0 * random_point(k)).collect();
        let moved: Vec<DVec3> = points.iter().map(|p| far.transform_point3(*p)).collect();
        let shell = Shell::new(faces.to_vec(), None).unwrap();
        let there = shell.transformed(&far).unwrap();
        let here = shell.closest_points(&points, &mut Silent).unwrap();
        let there = there.closest_points(&moved, &mut Silent).unwrap();
        for ((point, here), there) in points.iter().zip(here).zip(there) {
            let expected = whole.closest_point(*point);
            assert!((here.distance - expected.distance).abs() < 1e-12);
            assert!((there.distance - expected.distance).abs() < 1e-8);
            assert!(faces[here.face].contains(&[here.uv], &mut Silent).unwrap()[0]);
        }
        let nan = shell.closest_points(&[DVec3::NAN], &mut Silent);
        assert!(matches!(nan, Err(Error::NotFinite { index: 0, .. })));
    }
}
