//! Parts of a surface, and one of two.

use super::bezier_patch::Patch;
use super::compatible::{unify, unify_degrees};
use super::control_net::deviation;
use super::curve::NurbsCurve;
use super::curve_family::Strip;
use super::direction::Direction;
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use super::surface_algebra::check_tolerance;
use super::work_blocks::listening;
use crate::error::{Error, Result};
use crate::progress::{Listen, Observer};

impl NurbsSurface {
    /// The parts before and after a parameter, which keep their parameters.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let (before, after) = sphere.split(Direction::U, 0.25, &mut Silent)?;
    /// assert_eq!(before.knots_u().domain(), (0.0, 0.25));
    /// assert!(after.point(0.7, 0.3).distance(sphere.point(0.7, 0.3)) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if it does not lie strictly inside the domain, [`Error::Interrupted`]
    /// if the observer stops it.
    pub fn split(
        &self,
        direction: Direction,
        at: f64,
        observer: &mut dyn Observer,
    ) -> Result<(Self, Self)> {
        let mut listen = listening(observer);
        let (before, after) = self.strip(direction, &mut listen)?.split(at, &mut listen)?;
        let mut part = |strip| self.rebuilt(direction, strip, &mut listen);
        Ok((part(before)?, part(after)?))
    }

    /// The part over a rectangle of the domain, which keeps its parameters.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let part = sphere.sub_surface((0.1, 0.6), (0.2, 0.5), &mut Silent)?;
    /// assert!(part.point(0.3, 0.4).distance(sphere.point(0.3, 0.4)) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a range is empty or leaves the domain, [`Error::Interrupted`] if the
    /// observer stops it.
    pub fn sub_surface(
        &self,
        u: (f64, f64),
        v: (f64, f64),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let mut listen = listening(observer);
        self.along(Direction::U, &mut listen, |strip, listen| strip.between(u, listen))?.along(
            Direction::V,
            &mut listen,
            |strip, listen| strip.between(v, listen),
        )
    }

    /// The surface as Bézier patches, one for each pair of spans, row by row; each keeps its
    /// parameters, so that a point has the same u and v on its patch.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let patches = sphere.bezier_patches(&mut Silent)?;
    /// assert_eq!((patches.len(), patches[0].len()), (4, 2));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn bezier_patches(&self, observer: &mut dyn Observer) -> Result<Vec<Vec<Self>>> {
        let (rational, mut listen) = (self.weights().is_some(), listening(observer));
        let (patches, (_, cols)) = Patch::of(self, &mut listen)?;
        let mut row = |row: &[Patch]| {
            listen()?;
            row.iter().map(|patch| patch.surface(rational)).collect()
        };
        patches.chunks(cols).map(&mut row).collect()
    }

    /// The curve of points with this parameter in this direction; it runs in the other one.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let equator = sphere.isocurve(Direction::V, 0.5)?;
    /// assert!(equator.closed() && equator.point(0.3).z.abs() < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the parameter lies outside the domain.
    pub fn isocurve(&self, direction: Direction, at: f64) -> Result<NurbsCurve> {
        let (start, end) = self.knots(direction).domain();
        if !(start..=end).contains(&at) {
            let must = format!("inside the domain [{start}, {end}]");
            return Err(Error::parameter("parameter", must, at));
        }
        let (points, rational) = (self.row(direction, at), self.weights().is_some());
        let knots = self.knots(direction.other()).clone();
        NurbsCurve::from_homogeneous(points, rational, knots, &mut || Ok(()))
    }

    /// This surface and `next`, which begins where this one ends in a direction, as one. Degrees
    /// and knots are made equal first; the parameters of `next` in this direction are moved behind
    /// the domain of this one.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let (before, after) = sphere.split(Direction::V, 0.5, &mut Silent)?;
    /// let whole = before.joined(Direction::V, &after, 0.0, &mut Silent)?;
    /// assert!(whole.point(0.3, 0.6).distance(sphere.point(0.3, 0.6)) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the edges, point by point over their knots, lie further apart than
    /// `tolerance`, in the points' unit, or the other direction's domains differ;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn joined(
        &self,
        direction: Direction,
        next: &Self,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        let mut listen = listening(observer);
        let [along, next_along] = compatible(direction, self, next, false, &mut listen)?;
        let across = direction.other();
        let [first, second] = compatible(across, &along, &next_along, true, &mut listen)?;
        let strip = first.strip(direction, &mut listen)?;
        let next_strip = second.strip(direction, &mut listen)?;
        let joined = joined(&strip, &next_strip, tolerance, &mut listen)?;
        let rational = self.weights().is_some() || next.weights().is_some();
        first.rebuilt_as(direction, joined, rational, &mut listen)
    }
}

impl Strip {
    /// The parts before and after a parameter inside the domain, clamped.
    pub(super) fn split(&self, at: f64, listen: &mut Listen<'_>) -> Result<(Self, Self)> {
        self.check_inside("split", at)?;
        let degree = self.knots.degree();
        let missing = degree.saturating_sub(self.knots.multiplicity(at));
        let strip = self.clamped(listen)?.refined(&vec![at; missing], listen)?;
        let t = strip.knots.as_slice();
        let (first, end) =
            (t.partition_point(|&knot| knot < at), t.partition_point(|&knot| knot <= at));
        let before: Vec<f64> = t[..end].iter().copied().chain([at]).collect();
        let after: Vec<f64> = [at].into_iter().chain(t[first..].iter().copied()).collect();
        let mut part = |knots: Vec<f64>, rows| -> Result<Self> {
            let (knots, points) = (KnotVector::new(degree, knots)?, strip.rows_from(rows, listen)?);
            Ok(Self { knots, points, width: self.width })
        };
        let cut = first - 1;
        Ok((part(before, 0..cut + 1)?, part(after, cut..strip.rows())?))
    }

    /// The part between two parameters of the domain, clamped.
    pub(super) fn between(&self, (from, to): (f64, f64), listen: &mut Listen<'_>) -> Result<Self> {
        let (start, end) = self.knots.domain();
        if !(start <= from && from < to && to <= end) {
            let must = format!("an increasing pair inside the domain [{start}, {end}]");
            return Err(Error::parameter("range", must, format!("({from}, {to})")));
        }
        let tail = if from > start { self.split(from, listen)?.1 } else { self.clamped(listen)? };
        if to < end { Ok(tail.split(to, listen)?.0) } else { Ok(tail) }
    }

    /// This and the strip that follows it, which begins where this one ends and has the same
    /// degree; the knots of the second are moved behind those of the first.
    pub(super) fn joined(&self, next: &Self, listen: &mut Listen<'_>) -> Result<Self> {
        let (first, next) = (self.clamped(listen)?, next.clamped(listen)?);
        let degree = first.knots.degree();
        let ((_, end), (start, _)) = (first.knots.domain(), next.knots.domain());
        let shift = end - start;
        let t = first.knots.as_slice();
        let tail = next.knots.as_slice()[degree + 1..].iter().map(|knot| knot + shift);
        let knots = t[..t.len() - 1].iter().copied().chain(tail).collect();
        let mut points = first.points;
        points.extend(next.rows_from(1..next.rows(), listen)?);
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }
}

/// A strip and one of the same degree that begins where it ends, within a tolerance.
pub(super) fn joined(
    first: &Strip,
    next: &Strip,
    tolerance: f64,
    listen: &mut Listen<'_>,
) -> Result<Strip> {
    let (first, mut next) = (first.clamped(listen)?, next.clamped(listen)?);
    // Weights count only up to a factor.
    let factor = first.row(first.rows() - 1)[0].w / next.row(0)[0].w;
    next.points.iter_mut().for_each(|point| *point *= factor);
    let gap = deviation(first.row(first.rows() - 1), next.row(0));
    // `gap > tolerance` would let NaN pass.
    let held = gap <= tolerance;
    if !held {
        let must = format!("at least {gap:e}, which is how far the edges are apart");
        return Err(Error::parameter("tolerance", must, tolerance));
    }
    first.joined(&next, listen)
}

/// Two surfaces with the higher of their degrees in a direction, and with the same knots there if
/// that is asked for.
fn compatible(
    direction: Direction,
    a: &NurbsSurface,
    b: &NurbsSurface,
    knots: bool,
    listen: &mut Listen<'_>,
) -> Result<[NurbsSurface; 2]> {
    let mut strips = [a.strip(direction, listen)?, b.strip(direction, listen)?];
    if knots {
        unify(&mut strips, listen)?;
    } else {
        unify_degrees(&mut strips, listen)?;
    }
    let [first, second] = strips;
    Ok([a.rebuilt(direction, first, listen)?, b.rebuilt(direction, second, listen)?])
}
