//! Knot insertion and removal, degree changes, reversal, transformations and domains of surfaces.

use std::borrow::Cow;

use glam::DAffine3;

use super::bezier_patch::BezierPatch;
use super::control_net::{coincidence_tolerance, rows_coincide};
use super::curve_family::CurveFamily;
use super::direction::Direction;
use super::patch_distance::check_distance;
use super::surface::NurbsSurface;
use super::work_blocks::interrupt_check;
use crate::error::{Error, Result};
use crate::progress::{InterruptCheck, Observer};

impl NurbsSurface {
    /// Inserts knots of the domain without changing the surface (The NURBS Book, A5.4). Knots at
    /// the ends of the domain are possible where it is not clamped.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}, progress::Silent};
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
    /// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
    /// let refined = surface.insert_knots(Direction::U, &[0.25, 0.5], &mut Silent)?;
    /// assert_eq!(refined.shape(), (4, 2));
    /// assert!(refined.point(0.3, 0.7).distance(surface.point(0.3, 0.7)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if a knot is not in the domain.
    /// - [`Error::Knots`] if the multiplicity of one would exceed the degree.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn insert_knots(
        &self,
        direction: Direction,
        knots: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        self.map_family(direction, &mut interrupt_check(observer), |family, check_interrupt| {
            family.refined(knots, check_interrupt)
        })
    }

    /// Removes as many of these inner knots (`None`: of all) as `tolerance` allows.
    ///
    /// No point moves by more than `tolerance`, in the points' unit. The distance of the control
    /// points over the original knots bounds the movement (The NURBS Book, A5.8).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let refined = sphere.insert_knots(Direction::V, &[0.2, 0.7], &mut Silent)?;
    /// let back = refined.remove_knots(Direction::V, None, 1e-12, &mut Silent)?;
    /// assert_eq!(back.shape(), sphere.shape());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the tolerance is negative or not finite, [`Error::Interrupted`] if
    /// the observer stops it.
    pub fn remove_knots(
        &self,
        direction: Direction,
        knots: Option<&[f64]>,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        self.map_family(direction, &mut interrupt_check(observer), |family, check_interrupt| {
            family.with_knots_removed(knots, tolerance, check_interrupt)
        })
    }

    /// Raises the degrees by `u` and `v` without changing the surface (H. Prautzsch, *Degree
    /// elevation of B-spline curves*, 1984). The result is clamped in each direction that changes.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// assert_eq!(plane.elevate_degree(2, 1, &mut Silent)?.shape(), (4, 3));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a degree would exceed [`MAX_DEGREE`](super::MAX_DEGREE),
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn elevate_degree(&self, u: usize, v: usize, observer: &mut dyn Observer) -> Result<Self> {
        self.in_changed_directions([u, v], &mut interrupt_check(observer), CurveFamily::elevated)
    }

    /// Lowers the degrees by `u` and `v`. No point moves by more than `tolerance`, in the points'
    /// unit, and the corners stay.
    ///
    /// A surface of the lower degree is found again to about 1e-15 of its size for degrees up to 9,
    /// and to 1e-8 for degrees up to 25.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// let raised = plane.elevate_degree(2, 1, &mut Silent)?;
    /// assert_eq!(raised.reduce_degree(2, 1, 1e-12, &mut Silent)?.shape(), (2, 2));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if a degree would be 0, a weight would not stay positive, or the
    ///   error exceeds `tolerance`: the message names the smallest possible tolerance.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn reduce_degree(
        &self,
        u: usize,
        v: usize,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        let check_interrupt = &mut interrupt_check(observer);
        let reduced = self.in_changed_directions([u, v], check_interrupt, CurveFamily::reduced)?;
        let back = reduced.in_changed_directions([u, v], check_interrupt, CurveFamily::elevated)?;
        let (original, _) = BezierPatch::of(self, check_interrupt)?;
        let (changed, _) = BezierPatch::of(&back, check_interrupt)?;
        check_distance(original.into_iter().zip(changed), tolerance, check_interrupt)?;
        Ok(reduced)
    }

    /// Applies `f` first in u and then in v, in each direction whose degree changes.
    fn in_changed_directions(
        &self,
        [u, v]: [usize; 2],
        check_interrupt: &mut InterruptCheck<'_>,
        f: impl Fn(&CurveFamily, usize, &mut InterruptCheck<'_>) -> Result<CurveFamily>,
    ) -> Result<Self> {
        let mut surface = Cow::Borrowed(self);
        for (direction, times) in [(Direction::U, u), (Direction::V, v)] {
            if times > 0 {
                let changed =
                    surface.map_family(direction, check_interrupt, |family, check_interrupt| {
                        f(family, times, check_interrupt)
                    })?;
                surface = Cow::Owned(changed);
            }
        }
        Ok(surface.into_owned())
    }

    /// Clamps the knots in both directions.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0)?;
    /// assert!(torus.clamp(&mut Silent)?.knots_u().is_clamped());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn clamp(&self, observer: &mut dyn Observer) -> Result<Self> {
        let mut check_interrupt = interrupt_check(observer);
        self.map_family(Direction::U, &mut check_interrupt, CurveFamily::clamped)?.map_family(
            Direction::V,
            &mut check_interrupt,
            CurveFamily::clamped,
        )
    }

    /// Inserts every inner knot up to multiplicity `degree`, in both directions.
    pub(super) fn bezier_form(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        self.map_family(Direction::U, check_interrupt, CurveFamily::bezier_form)?.map_family(
            Direction::V,
            check_interrupt,
            CurveFamily::bezier_form,
        )
    }

    /// Reverses a direction on the same domain: the point at `start + t` is the former
    /// one at `end - t`. The normals change sign.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let turned = sphere.reversed(Direction::U, &mut Silent)?;
    /// assert!(turned.point(0.2, 0.5).distance(sphere.point(0.8, 0.5)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn reversed(&self, direction: Direction, observer: &mut dyn Observer) -> Result<Self> {
        self.map_family(direction, &mut interrupt_check(observer), CurveFamily::reversed)
    }

    /// Exchanges u and v. The normals change sign.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let turned = sphere.transposed(&mut Silent)?;
    /// assert!(turned.point(0.2, 0.7).distance(sphere.point(0.7, 0.2)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn transposed(&self, observer: &mut dyn Observer) -> Result<Self> {
        let mut check_interrupt = interrupt_check(observer);
        let CurveFamily { knots, points, .. } = self.family(Direction::V, &mut check_interrupt)?;
        let knots = [knots, self.knots_u().clone()];
        Self::from_homogeneous(points, self.weights().is_some(), knots, &mut check_interrupt)
    }

    /// Applies an affine map.
    ///
    /// ```
    /// use neurbs::{DAffine3, DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let moved = sphere.transformed(&DAffine3::from_translation(DVec3::Z))?;
    /// assert!(moved.point(0.2, 0.5).distance(sphere.point(0.2, 0.5) + DVec3::Z) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if a coordinate overflows.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        self.map_control_points(|point| map.transform_point3(point))
    }

    /// Maps the parameters linearly to another domain.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let degrees = sphere.with_domain((0.0, 360.0), (-90.0, 90.0))?;
    /// assert!(degrees.point(90.0, 0.0).distance(sphere.point(0.25, 0.5)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Knots`] if a range is empty or not finite.
    pub fn with_domain(&self, u: (f64, f64), v: (f64, f64)) -> Result<Self> {
        let (knots_u, knots_v) = (self.knots_u().with_domain(u)?, self.knots_v().with_domain(v)?);
        Self::new(
            self.control_points().to_vec(),
            self.weights().map(<[f64]>::to_vec),
            knots_u,
            knots_v,
        )
    }

    /// Whether the surface ends where it begins, in u and in v: true for both on a torus.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert_eq!(sphere.closed(), (true, false));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn closed(&self) -> (bool, bool) {
        let tolerance = coincidence_tolerance(self.net_box(), self.weights());
        let closed = |direction| {
            let (start, end) = self.knots(direction).domain();
            rows_coincide(
                &self.isocurve_net(direction, start),
                &self.isocurve_net(direction, end),
                tolerance,
            )
        };
        (closed(Direction::U), closed(Direction::V))
    }
}

/// Checks that a tolerance is finite and not negative.
pub(super) fn check_tolerance(tolerance: f64) -> Result<()> {
    if tolerance >= 0.0 && tolerance.is_finite() {
        return Ok(());
    }
    Err(Error::parameter("tolerance", "a finite distance, at least 0", tolerance))
}
