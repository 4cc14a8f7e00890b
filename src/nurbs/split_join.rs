//! Splitting of surfaces and curve families, and joining of two of them.

use super::bezier_patch::BezierPatch;
use super::compatible::{unify, unify_degrees};
use super::control_net::distance_bound;
use super::curve::NurbsCurve;
use super::curve_family::CurveFamily;
use super::direction::Direction;
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use super::surface_algebra::check_tolerance;
use super::work_blocks::interrupt_check;
use crate::error::{Error, Result};
use crate::progress::{InterruptCheck, Observer};

impl NurbsSurface {
    /// Splits the surface at a parameter; both parts keep their parameters.
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
    /// [`Error::Parameter`] if the parameter is not strictly inside the domain,
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn split(
        &self,
        direction: Direction,
        at: f64,
        observer: &mut dyn Observer,
    ) -> Result<(Self, Self)> {
        let mut check_interrupt = interrupt_check(observer);
        let (before, after) =
            self.family(direction, &mut check_interrupt)?.split(at, &mut check_interrupt)?;
        let mut part = |family| self.with_family(direction, family, &mut check_interrupt);
        Ok((part(before)?, part(after)?))
    }

    /// Returns the part over a rectangle of the domain, with unchanged parameters.
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
    /// [`Error::Parameter`] if a range is empty or not inside the domain, [`Error::Interrupted`] if
    /// the observer stops it.
    pub fn sub_surface(
        &self,
        u: (f64, f64),
        v: (f64, f64),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let mut check_interrupt = interrupt_check(observer);
        self.map_family(Direction::U, &mut check_interrupt, |family, check_interrupt| {
            family.restricted(u, check_interrupt)
        })?
        .map_family(Direction::V, &mut check_interrupt, |family, check_interrupt| {
            family.restricted(v, check_interrupt)
        })
    }

    /// Returns the Bézier patches of the surface, one for each pair of spans, row by row. The
    /// patches keep their parameters: a point has the same u and v on its patch.
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
        let (rational, mut check_interrupt) = (self.weights().is_some(), interrupt_check(observer));
        let (patches, (_, cols)) = BezierPatch::of(self, &mut check_interrupt)?;
        let mut row = |row: &[BezierPatch]| {
            check_interrupt()?;
            row.iter().map(|patch| patch.surface(rational)).collect()
        };
        patches.chunks(cols).map(&mut row).collect()
    }

    /// Returns the isocurve at a parameter in `direction`; it runs in the other direction.
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
    /// [`Error::Parameter`] if the parameter is outside the domain.
    pub fn isocurve(&self, direction: Direction, at: f64) -> Result<NurbsCurve> {
        let (start, end) = self.knots(direction).domain();
        if !(start..=end).contains(&at) {
            let must = format!("inside the domain [{start}, {end}]");
            return Err(Error::parameter("parameter", must, at));
        }
        let (points, rational) = (self.isocurve_net(direction, at), self.weights().is_some());
        let knots = self.knots(direction.other()).clone();
        NurbsCurve::from_homogeneous(points, rational, knots, &mut || Ok(()))
    }

    /// Joins this surface and `next`, which begins where this one ends in `direction`.
    ///
    /// Degrees and knots are made compatible first. The parameters of `next` in `direction` are
    /// shifted to follow the domain of this surface.
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
    /// - [`Error::Parameter`] if the distance between the edges, bounded by their control points,
    ///   exceeds `tolerance`, in the points' unit, or the domains in the other direction differ.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn joined(
        &self,
        direction: Direction,
        next: &Self,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        let mut check_interrupt = interrupt_check(observer);
        let [along, next_along] = compatible(direction, self, next, false, &mut check_interrupt)?;
        let across = direction.other();
        let [first, second] = compatible(across, &along, &next_along, true, &mut check_interrupt)?;
        let family = first.family(direction, &mut check_interrupt)?;
        let next_family = second.family(direction, &mut check_interrupt)?;
        let joined = joined(&family, &next_family, tolerance, &mut check_interrupt)?;
        let rational = self.weights().is_some() || next.weights().is_some();
        first.replace_family(direction, joined, rational, &mut check_interrupt)
    }
}

impl CurveFamily {
    /// Splits the curves at a parameter inside the domain; both parts are clamped.
    pub(super) fn split(
        &self,
        at: f64,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<(Self, Self)> {
        self.check_inside("split", at)?;
        let degree = self.knots.degree();
        let missing = degree.saturating_sub(self.knots.multiplicity(at));
        let family = self.clamped(check_interrupt)?.refined(&vec![at; missing], check_interrupt)?;
        let t = family.knots.as_slice();
        let (first, end) =
            (t.partition_point(|&knot| knot < at), t.partition_point(|&knot| knot <= at));
        let before: Vec<f64> = t[..end].iter().copied().chain([at]).collect();
        let after: Vec<f64> = [at].into_iter().chain(t[first..].iter().copied()).collect();
        let mut part = |knots: Vec<f64>, rows| -> Result<Self> {
            let (knots, points) =
                (KnotVector::new(degree, knots)?, family.rows_from(rows, check_interrupt)?);
            Ok(Self { knots, points, width: self.width })
        };
        let cut = first - 1;
        Ok((part(before, 0..cut + 1)?, part(after, cut..family.rows())?))
    }

    /// Returns the part between two parameters of the domain, clamped.
    pub(super) fn restricted(
        &self,
        (from, to): (f64, f64),
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (start, end) = self.knots.domain();
        if !(start <= from && from < to && to <= end) {
            let must = format!("an increasing pair inside the domain [{start}, {end}]");
            return Err(Error::parameter("range", must, format!("({from}, {to})")));
        }
        let tail = if from > start {
            self.split(from, check_interrupt)?.1
        } else {
            self.clamped(check_interrupt)?
        };
        if to < end { Ok(tail.split(to, check_interrupt)?.0) } else { Ok(tail) }
    }

    /// Joins this family and `next`, which has the same degree and begins where this one ends. The
    /// knots of `next` are shifted to follow those of this family.
    pub(super) fn joined(
        &self,
        next: &Self,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (first, next) = (self.clamped(check_interrupt)?, next.clamped(check_interrupt)?);
        let degree = first.knots.degree();
        let ((_, end), (start, _)) = (first.knots.domain(), next.knots.domain());
        let shift = end - start;
        let t = first.knots.as_slice();
        let tail = next.knots.as_slice()[degree + 1..].iter().map(|knot| knot + shift);
        let knots = t[..t.len() - 1].iter().copied().chain(tail).collect();
        let mut points = first.points;
        points.extend(next.rows_from(1..next.rows(), check_interrupt)?);
        Ok(Self { knots: KnotVector::new(degree, knots)?, points, width: self.width })
    }
}

/// Joins two families of the same degree whose ends coincide within a tolerance.
pub(super) fn joined(
    first: &CurveFamily,
    next: &CurveFamily,
    tolerance: f64,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<CurveFamily> {
    let (first, mut next) = (first.clamped(check_interrupt)?, next.clamped(check_interrupt)?);
    // A common factor of all weights does not change the curves.
    let factor = first.row(first.rows() - 1)[0].w / next.row(0)[0].w;
    next.points.iter_mut().for_each(|point| *point *= factor);
    let gap = distance_bound(first.row(first.rows() - 1), next.row(0));
    // `gap > tolerance` would let NaN pass.
    let held = gap <= tolerance;
    if !held {
        let must = format!("at least {gap:e}, the distance between the edges");
        return Err(Error::parameter("tolerance", must, tolerance));
    }
    first.joined(&next, check_interrupt)
}

/// Elevates two surfaces to the higher of their degrees in a direction; if `knots`, also unites
/// their knots.
fn compatible(
    direction: Direction,
    a: &NurbsSurface,
    b: &NurbsSurface,
    knots: bool,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<[NurbsSurface; 2]> {
    let mut families =
        [a.family(direction, check_interrupt)?, b.family(direction, check_interrupt)?];
    if knots {
        unify(&mut families, check_interrupt)?;
    } else {
        unify_degrees(&mut families, check_interrupt)?;
    }
    let [first, second] = families;
    Ok([
        a.with_family(direction, first, check_interrupt)?,
        b.with_family(direction, second, check_interrupt)?,
    ])
}
