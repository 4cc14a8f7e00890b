//! Knot insertion and removal, degree changes, splitting and joining of curves.

use glam::DAffine3;

use super::bezier_patch::BezierPatch;
use super::compatible::unify_degrees;
use super::curve::NurbsCurve;
use super::curve_family::CurveFamily;
use super::patch_distance::check_distance;
use super::split_join::joined;
use super::surface_algebra::check_tolerance;
use super::work_blocks::interrupt_check;
use crate::error::Result;
use crate::progress::{InterruptCheck, Observer};

impl NurbsCurve {
    /// Inserts knots without changing the curve; see
    /// [`NurbsSurface::insert_knots`](super::NurbsSurface::insert_knots).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let curve = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// let refined = curve.insert_knots(&[0.25, 0.5], &mut Silent)?;
    /// assert_eq!(refined.control_points().len(), 5);
    /// assert!(refined.point(0.3).distance(curve.point(0.3)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] or [`Error::Knots`], as
    /// [`NurbsSurface::insert_knots`](super::NurbsSurface::insert_knots).
    ///
    /// [`Error::Parameter`]: crate::Error::Parameter
    /// [`Error::Knots`]: crate::Error::Knots
    pub fn insert_knots(&self, knots: &[f64], observer: &mut dyn Observer) -> Result<Self> {
        self.map_family(observer, |family, check_interrupt| family.refined(knots, check_interrupt))
    }

    /// Removes as many of these inner knots (`None`: of all) as `tolerance` allows; see
    /// [`NurbsSurface::remove_knots`](super::NurbsSurface::remove_knots).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let curve = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// let refined = curve.insert_knots(&[0.25, 0.5], &mut Silent)?;
    /// let back = refined.remove_knots(None, 1e-12, &mut Silent)?;
    /// assert_eq!(back.control_points().len(), 3);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the tolerance is negative or not finite.
    pub fn remove_knots(
        &self,
        knots: Option<&[f64]>,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        self.map_family(observer, |family, check_interrupt| {
            family.with_knots_removed(knots, tolerance, check_interrupt)
        })
    }

    /// Raises the degree by `times` without changing the curve; the result is clamped.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let line = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE], 1)?;
    /// let cubic = line.elevate_degree(2, &mut Silent)?;
    /// assert_eq!((cubic.knots().degree(), cubic.control_points().len()), (3, 4));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the degree would exceed
    /// [`MAX_DEGREE`](super::MAX_DEGREE).
    pub fn elevate_degree(&self, times: usize, observer: &mut dyn Observer) -> Result<Self> {
        self.map_family(observer, |family, check_interrupt| family.elevated(times, check_interrupt))
    }

    /// Lowers the degree by `times`; the result is clamped. No point moves by more than
    /// `tolerance`, and the ends stay.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let line = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE], 1)?;
    /// let cubic = line.elevate_degree(2, &mut Silent)?;
    /// assert_eq!(cubic.reduce_degree(2, 1e-12, &mut Silent)?.knots().degree(), 1);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the degree would be 0, a weight would not
    /// stay positive, or the error exceeds `tolerance`: the message names the smallest possible
    /// tolerance.
    pub fn reduce_degree(
        &self,
        times: usize,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        self.map_family(observer, |family, check_interrupt| {
            let reduced = family.reduced(times, check_interrupt)?;
            let back = reduced.elevated(times, check_interrupt)?;
            let original = BezierPatch::of_curves(family, check_interrupt)?;
            let changed = BezierPatch::of_curves(&back, check_interrupt)?;
            check_distance(original.into_iter().zip(changed), tolerance, check_interrupt)?;
            Ok(reduced)
        })
    }

    /// Clamps the knots: the curve begins and ends at its outermost control points.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// assert_eq!(arch.clamp(&mut Silent)?, arch);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn clamp(&self, observer: &mut dyn Observer) -> Result<Self> {
        self.map_family(observer, CurveFamily::clamped)
    }

    /// Splits the curve at a parameter; both parts keep their parameters.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// let (before, after) = arch.split(0.5, &mut Silent)?;
    /// assert_eq!(before.point(0.5), after.point(0.5));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the parameter is not strictly inside the
    /// domain, [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn split(&self, at: f64, observer: &mut dyn Observer) -> Result<(Self, Self)> {
        let mut check_interrupt = interrupt_check(observer);
        let (before, after) = self.family().split(at, &mut check_interrupt)?;
        let mut part = |family: CurveFamily| {
            let rational = self.weights().is_some();
            Self::from_homogeneous(family.points, rational, family.knots, &mut check_interrupt)
        };
        Ok((part(before)?, part(after)?))
    }

    /// Returns the part between two parameters, clamped, with unchanged parameters.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// assert_eq!(arch.sub_curve(0.25, 0.75, &mut Silent)?.knots().domain(), (0.25, 0.75));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the range is empty or not inside the
    /// domain, [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn sub_curve(&self, from: f64, to: f64, observer: &mut dyn Observer) -> Result<Self> {
        self.map_family(observer, |family, check_interrupt| {
            family.restricted((from, to), check_interrupt)
        })
    }

    /// Maps the parameter linearly to another domain.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// assert_eq!(arch.with_domain(0.0, 2.0)?.point(1.0), arch.point(0.5));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Knots`](crate::Error::Knots) if the range is empty or not finite.
    pub fn with_domain(&self, from: f64, to: f64) -> Result<Self> {
        let knots = self.knots().with_domain((from, to))?;
        Self::new(self.control_points().to_vec(), self.weights().map(<[f64]>::to_vec), knots)
    }

    /// Reverses the direction of the curve, on the same domain.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// assert_eq!(arch.reversed(&mut Silent)?.point(0.25), arch.point(0.75));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn reversed(&self, observer: &mut dyn Observer) -> Result<Self> {
        self.map_family(observer, CurveFamily::reversed)
    }

    /// Joins this curve and `next`, which begins where this one ends; see
    /// [`NurbsSurface::joined`](super::NurbsSurface::joined).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// let (before, after) = arch.split(0.5, &mut Silent)?;
    /// let whole = before.joined(&after, 0.0, &mut Silent)?;
    /// assert!(whole.point(0.7).distance(arch.point(0.7)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the distance between the ends exceeds
    /// `tolerance`, in the points' unit; [`Error::Interrupted`](crate::Error::Interrupted) if the
    /// observer stops it.
    pub fn joined(&self, next: &Self, tolerance: f64, observer: &mut dyn Observer) -> Result<Self> {
        check_tolerance(tolerance)?;
        let check_interrupt = &mut interrupt_check(observer);
        let mut families =
            [self.family().copied(check_interrupt)?, next.family().copied(check_interrupt)?];
        unify_degrees(&mut families, check_interrupt)?;
        let joined = joined(&families[0], &families[1], tolerance, check_interrupt)?;
        let rational = self.weights().is_some() || next.weights().is_some();
        Self::from_homogeneous(joined.points, rational, joined.knots, check_interrupt)
    }

    /// Applies an affine map.
    ///
    /// ```
    /// use neurbs::{DAffine3, DVec3, nurbs::NurbsCurve};
    /// let arch = NurbsCurve::clamped(vec![DVec3::ZERO, DVec3::ONE, DVec3::X], 2)?;
    /// let moved = arch.transformed(&DAffine3::from_translation(DVec3::Z))?;
    /// assert_eq!(moved.point(0.0), DVec3::Z);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`](crate::Error::Net) if a coordinate overflows.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        let points = self.control_points().iter().map(|p| map.transform_point3(*p)).collect();
        Self::new(points, self.weights().map(<[f64]>::to_vec), self.knots().clone())
    }

    /// Applies `f` to the control points, as a family of one curve.
    fn map_family(
        &self,
        observer: &mut dyn Observer,
        f: impl FnOnce(&CurveFamily, &mut InterruptCheck<'_>) -> Result<CurveFamily>,
    ) -> Result<Self> {
        let check_interrupt = &mut interrupt_check(observer);
        let family = f(self.family(), check_interrupt)?;
        Self::from_homogeneous(
            family.points,
            self.weights().is_some(),
            family.knots,
            check_interrupt,
        )
    }
}
