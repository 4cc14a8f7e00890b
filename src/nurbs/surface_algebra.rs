//! What can be done to a surface without moving it: knots, degree, directions, domains.

use std::borrow::Cow;

use glam::DAffine3;

use super::control_net::{same_place, same_row};
use super::curve_family::Strip;
use super::direction::Direction;
use super::surface::NurbsSurface;
use super::work_blocks::listening;
use crate::error::{Error, Result};
use crate::progress::{Listen, Observer};

impl NurbsSurface {
    /// The same surface with more knots, each strictly inside the domain (The NURBS Book, A5.4).
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
    /// [`Error::Parameter`] if a knot lies outside the open domain; [`Error::Knots`] if one would
    /// stand more often than the degree; [`Error::Interrupted`] if the observer stops it.
    pub fn insert_knots(
        &self,
        direction: Direction,
        knots: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        self.along(direction, &mut listening(observer), |strip, listen| {
            strip.refined(knots, listen)
        })
    }

    /// The surface with as few of these inner knots (`None`: of all) as `tolerance` allows. No
    /// point moves further than `tolerance`, in the points' unit: the distance of the control
    /// points over the original knots bounds it (The NURBS Book, A5.8).
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
        self.along(direction, &mut listening(observer), |strip, listen| {
            strip.simplified(knots, tolerance, listen)
        })
    }

    /// The same surface with higher degrees, by `u` and `v`, clamped in each direction that is
    /// raised (H. Prautzsch, *Degree elevation of B-spline curves*, 1984).
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
    /// [`Error::Parameter`] if a degree would pass [`MAX_DEGREE`](super::MAX_DEGREE),
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn elevate_degree(&self, u: usize, v: usize, observer: &mut dyn Observer) -> Result<Self> {
        self.in_turn([u, v], &mut listening(observer), Strip::elevated)
    }

    /// A surface of lower degrees, by `u` and `v`, no point of which lies further from where it
    /// was than `tolerance`, in the points' unit; its boundary corners stay.
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
    /// [`Error::Parameter`] if a degree would be 0, a weight would not stay positive, or the
    /// tolerance cannot be held: the message says what can; [`Error::Interrupted`] if the observer stops it.
    pub fn reduce_degree(
        &self,
        u: usize,
        v: usize,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        // Both steps may move a point: each gets its share.
        let share = if u > 0 && v > 0 { tolerance / 2.0 } else { tolerance };
        self.in_turn([u, v], &mut listening(observer), |strip, times, listen| {
            strip.reduced(times, share, listen)
        })
    }

    /// What `f` makes of the surface in the directions whose degree changes, by u and by v.
    fn in_turn(
        &self,
        [u, v]: [usize; 2],
        listen: &mut Listen<'_>,
        f: impl Fn(&Strip, usize, &mut Listen<'_>) -> Result<Strip>,
    ) -> Result<Self> {
        let mut surface = Cow::Borrowed(self);
        for (direction, times) in [(Direction::U, u), (Direction::V, v)] {
            if times > 0 {
                let changed =
                    surface.along(direction, listen, |strip, listen| f(strip, times, listen))?;
                surface = Cow::Owned(changed);
            }
        }
        Ok(surface.into_owned())
    }

    /// The same surface with clamped knots in both directions.
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
        let mut listen = listening(observer);
        self.along(Direction::U, &mut listen, Strip::clamped)?.along(
            Direction::V,
            &mut listen,
            Strip::clamped,
        )
    }

    /// The same surface with every inner knot as often as its degree.
    pub(super) fn in_bezier_form(&self, listen: &mut Listen<'_>) -> Result<Self> {
        self.along(Direction::U, listen, Strip::bezier)?.along(Direction::V, listen, Strip::bezier)
    }

    /// The same surface run through backwards in a direction: on the same domain, the point at
    /// `start + t` is where the one at `end - t` was. Its normals turn over.
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
        self.along(direction, &mut listening(observer), Strip::reversed)
    }

    /// The same surface with u and v exchanged. Its normals turn over.
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
        let mut listen = listening(observer);
        let Strip { knots, points, .. } = self.strip(Direction::V, &mut listen)?;
        let knots = [knots, self.knots_u().clone()];
        Self::from_homogeneous(points, self.weights().is_some(), knots, &mut listen)
    }

    /// The surface moved by an affine map.
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
    /// [`Error::Net`] if a point leaves the range of numbers.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        self.map_control_points(|point| map.transform_point3(point))
    }

    /// The same surface with other ranges of its parameters.
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

    /// Whether the surface ends where it begins, in u and in v: a tube, a torus.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert_eq!(sphere.closed(), (true, false));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn closed(&self) -> (bool, bool) {
        let tolerance = same_place(self.net_box(), self.weights());
        let closed = |direction| {
            let (start, end) = self.knots(direction).domain();
            same_row(&self.row(direction, start), &self.row(direction, end), tolerance)
        };
        (closed(Direction::U), closed(Direction::V))
    }
}

pub(super) fn check_tolerance(tolerance: f64) -> Result<()> {
    if tolerance >= 0.0 && tolerance.is_finite() {
        return Ok(());
    }
    Err(Error::parameter("tolerance", "a finite distance, at least 0", tolerance))
}
