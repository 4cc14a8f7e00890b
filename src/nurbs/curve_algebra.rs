//! What can be done to a curve without moving it, as to a surface.

use glam::DAffine3;

use super::compatible::unify_degrees;
use super::curve::NurbsCurve;
use super::curve_family::Strip;
use super::split_join::joined;
use super::surface_algebra::check_tolerance;
use super::work_blocks::listening;
use crate::error::Result;
use crate::progress::{Listen, Observer};

impl NurbsCurve {
    /// The same curve with more knots; see
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
    /// [`Error::Parameter`] or [`Error::Knots`], as there.
    ///
    /// [`Error::Parameter`]: crate::Error::Parameter
    /// [`Error::Knots`]: crate::Error::Knots
    pub fn insert_knots(&self, knots: &[f64], observer: &mut dyn Observer) -> Result<Self> {
        self.rebuilt(observer, |strip, listen| strip.refined(knots, listen))
    }

    /// With as few of these inner knots (`None`: of all) as `tolerance` allows; see
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
        self.rebuilt(observer, |strip, listen| strip.simplified(knots, tolerance, listen))
    }

    /// The same curve with a degree higher by `times`, clamped.
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
    /// [`Error::Parameter`](crate::Error::Parameter) if the degree would pass
    /// [`MAX_DEGREE`](super::MAX_DEGREE).
    pub fn elevate_degree(&self, times: usize, observer: &mut dyn Observer) -> Result<Self> {
        self.rebuilt(observer, |strip, listen| strip.elevated(times, listen))
    }

    /// A curve with a degree lower by `times`, clamped, no point of which lies further from where
    /// it was than `tolerance`; its ends stay.
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
    /// stay positive, or the tolerance cannot be held: the message says what can.
    pub fn reduce_degree(
        &self,
        times: usize,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        self.rebuilt(observer, |strip, listen| strip.reduced(times, tolerance, listen))
    }

    /// The same curve with clamped knots: it begins and ends at its outermost control points.
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
        self.rebuilt(observer, Strip::clamped)
    }

    /// The parts before and after a parameter, which keep their parameters.
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
    /// [`Error::Parameter`](crate::Error::Parameter) if it does not lie strictly inside the domain,
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn split(&self, at: f64, observer: &mut dyn Observer) -> Result<(Self, Self)> {
        let mut listen = listening(observer);
        let (before, after) = self.strip().split(at, &mut listen)?;
        let mut part = |strip: Strip| {
            let rational = self.weights().is_some();
            Self::from_homogeneous(strip.points, rational, strip.knots, &mut listen)
        };
        Ok((part(before)?, part(after)?))
    }

    /// The part between two parameters, which keeps its parameters, clamped.
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
    /// [`Error::Parameter`](crate::Error::Parameter) if the range is empty or leaves the domain,
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn sub_curve(&self, from: f64, to: f64, observer: &mut dyn Observer) -> Result<Self> {
        self.rebuilt(observer, |strip, listen| strip.between((from, to), listen))
    }

    /// The same curve with another range of its parameter.
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

    /// The same curve run through backwards, on the same domain.
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
        self.rebuilt(observer, Strip::reversed)
    }

    /// This curve and `next`, which begins where this one ends, as one; see
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
    /// [`Error::Parameter`](crate::Error::Parameter) if the ends lie further apart than
    /// `tolerance`, in the points' unit; [`Error::Interrupted`](crate::Error::Interrupted) if the
    /// observer stops it.
    pub fn joined(&self, next: &Self, tolerance: f64, observer: &mut dyn Observer) -> Result<Self> {
        check_tolerance(tolerance)?;
        let listen = &mut listening(observer);
        let mut strips = [self.strip().copied(listen)?, next.strip().copied(listen)?];
        unify_degrees(&mut strips, listen)?;
        let joined = joined(&strips[0], &strips[1], tolerance, listen)?;
        let rational = self.weights().is_some() || next.weights().is_some();
        Self::from_homogeneous(joined.points, rational, joined.knots, listen)
    }

    /// The curve moved by an affine map.
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
    /// [`Error::Net`](crate::Error::Net) if a point leaves the range of numbers.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        let points = self.control_points().iter().map(|p| map.transform_point3(*p)).collect();
        Self::new(points, self.weights().map(<[f64]>::to_vec), self.knots().clone())
    }

    /// The curve of what `f` makes of this one's strip.
    fn rebuilt(
        &self,
        observer: &mut dyn Observer,
        f: impl FnOnce(&Strip, &mut Listen<'_>) -> Result<Strip>,
    ) -> Result<Self> {
        let listen = &mut listening(observer);
        let strip = f(self.strip(), listen)?;
        Self::from_homogeneous(strip.points, self.weights().is_some(), strip.knots, listen)
    }
}
