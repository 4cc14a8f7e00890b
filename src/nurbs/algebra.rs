//! What can be done to a surface without moving it: knots, degree, parts, directions.

use glam::{DAffine3, DVec4};

use super::bezier::Patch;
use super::curve::NurbsCurve;
use super::knot_vector::KnotVector;
use super::net::same_place;
use super::remove::deviation;
use super::strip::Strip;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};

/// A direction of a surface's parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along the rows of the net, its axis 0.
    U,
    /// Along the columns of the net, its axis 1.
    V,
}

impl Direction {
    fn other(self) -> Self {
        match self {
            Self::U => Self::V,
            Self::V => Self::U,
        }
    }
}

impl NurbsSurface {
    /// The knots in a direction.
    #[must_use]
    pub fn knots(&self, direction: Direction) -> &KnotVector {
        match direction {
            Direction::U => self.knots_u(),
            Direction::V => self.knots_v(),
        }
    }

    /// The same surface with more knots, each strictly inside the domain (The NURBS Book, A5.4).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{Direction, NurbsSurface}};
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
    /// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
    /// let refined = surface.insert_knots(Direction::U, &[0.25, 0.5])?;
    /// assert_eq!(refined.shape(), (4, 2));
    /// assert!(refined.point(0.3, 0.7).distance(surface.point(0.3, 0.7)) < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a knot lies outside the open domain; [`Error::Knots`] if one would
    /// stand more often than the degree.
    pub fn insert_knots(&self, direction: Direction, knots: &[f64]) -> Result<Self> {
        self.along(direction, |strip| strip.refined(knots))
    }

    /// The surface with as few of these inner knots (`None`: of all) as `tolerance` allows. No
    /// point moves further than `tolerance`, in the points' unit: the distance of the control
    /// points over the original knots bounds it (The NURBS Book, A5.8).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the tolerance is negative or not finite.
    pub fn remove_knots(
        &self,
        direction: Direction,
        knots: Option<&[f64]>,
        tolerance: f64,
    ) -> Result<Self> {
        check_tolerance(tolerance)?;
        self.along(direction, |strip| strip.simplified(knots, tolerance))
    }

    /// The same surface with higher degrees, by `u` and `v`, clamped in each direction that is
    /// raised (H. Prautzsch, *Degree elevation of B-spline curves*, 1984).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a degree would pass [`MAX_DEGREE`](super::MAX_DEGREE).
    pub fn elevate_degree(&self, u: usize, v: usize) -> Result<Self> {
        let raise = |times| {
            move |strip: &Strip| if times == 0 { Ok(strip.clone()) } else { strip.elevated(times) }
        };
        self.along(Direction::U, raise(u))?.along(Direction::V, raise(v))
    }

    /// A surface of lower degrees, by `u` and `v`, no point of which lies further from where it
    /// was than `tolerance`, in the points' unit; its boundary corners stay.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a degree would be 0, or the tolerance cannot be held: the message
    /// says what can.
    pub fn reduce_degree(&self, u: usize, v: usize, tolerance: f64) -> Result<Self> {
        check_tolerance(tolerance)?;
        // Both steps may move a point: each gets its share.
        let share = if u > 0 && v > 0 { tolerance / 2.0 } else { tolerance };
        let lower = |times: usize| {
            move |strip: &Strip| {
                if times == 0 { Ok(strip.clone()) } else { strip.reduced(times, share) }
            }
        };
        self.along(Direction::U, lower(u))?.along(Direction::V, lower(v))
    }

    /// The parts before and after a parameter, which keep their parameters.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if it does not lie strictly inside the domain.
    pub fn split(&self, direction: Direction, at: f64) -> Result<(Self, Self)> {
        let (before, after) = self.strip(direction).split(at)?;
        Ok((self.rebuilt(direction, &before)?, self.rebuilt(direction, &after)?))
    }

    /// The part over a rectangle of the domain, which keeps its parameters.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a range is empty or leaves the domain.
    pub fn sub_surface(&self, u: (f64, f64), v: (f64, f64)) -> Result<Self> {
        self.along(Direction::U, |strip| strip.between(u.0, u.1))?
            .along(Direction::V, |strip| strip.between(v.0, v.1))
    }

    /// The same surface with clamped knots in both directions.
    ///
    /// # Errors
    ///
    /// None; a surface can always be clamped.
    pub fn clamp(&self) -> Result<Self> {
        self.along(Direction::U, Strip::clamped)?.along(Direction::V, Strip::clamped)
    }

    /// The surface as Bézier patches, one for each pair of spans, row by row; each keeps its
    /// parameters, so that a point has the same u and v on its patch.
    ///
    /// # Errors
    ///
    /// None; every surface has Bézier patches.
    pub fn bezier_patches(&self) -> Result<Vec<Vec<Self>>> {
        let (patches, (_, cols)) = Patch::of(self)?;
        let rational = self.weights().is_some();
        patches
            .chunks(cols)
            .map(|row| row.iter().map(|patch| patch.surface(rational)).collect())
            .collect()
    }

    /// The same surface with every inner knot as often as its degree.
    pub(super) fn in_bezier_form(&self) -> Result<Self> {
        self.along(Direction::U, Strip::bezier)?.along(Direction::V, Strip::bezier)
    }

    /// The curve of points with this parameter in this direction; it runs in the other one.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the parameter lies outside the domain.
    pub fn isocurve(&self, direction: Direction, at: f64) -> Result<NurbsCurve> {
        let points = self.strip(direction).at(at)?;
        let knots = self.knots(direction.other()).clone();
        NurbsCurve::from_homogeneous(&points, self.weights().is_some(), knots)
    }

    /// The same surface run through backwards in a direction: on the same domain, the point at
    /// `start + t` is where the one at `end - t` was. Its normals turn over.
    ///
    /// # Errors
    ///
    /// None; every surface can be reversed.
    pub fn reversed(&self, direction: Direction) -> Result<Self> {
        self.along(direction, |strip| Ok(strip.reversed()))
    }

    /// The same surface with u and v exchanged. Its normals turn over.
    ///
    /// # Errors
    ///
    /// None; every surface can be transposed.
    pub fn transposed(&self) -> Result<Self> {
        let Strip { knots, points, .. } = self.strip(Direction::V);
        Self::from_homogeneous(&points, self.weights().is_some(), knots, self.knots_u().clone())
    }

    /// The surface moved by an affine map.
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if a point leaves the range of numbers.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        self.map_control_points(|point| map.transform_point3(point))
    }

    /// The same surface with other ranges of its parameters.
    ///
    /// # Errors
    ///
    /// [`Error::Knots`] if a range is empty or not finite.
    pub fn with_domain(&self, u: (f64, f64), v: (f64, f64)) -> Result<Self> {
        self.along(Direction::U, |strip| strip.with_domain(u))?
            .along(Direction::V, |strip| strip.with_domain(v))
    }

    /// This surface and `next`, which begins where this one ends in a direction, as one. Degrees
    /// and knots are made equal first; the parameters of `next` in this direction are moved behind
    /// the domain of this one.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the edges, point by point over their knots, lie further apart than
    /// `tolerance`, in the points' unit, or the other direction's domains differ.
    pub fn joined(&self, direction: Direction, next: &Self, tolerance: f64) -> Result<Self> {
        check_tolerance(tolerance)?;
        let [along, next_along] = compatible(direction, self, next, false)?;
        let [first, second] = compatible(direction.other(), &along, &next_along, true)?;
        let joined = joined(&first.strip(direction), &second.strip(direction), tolerance)?;
        let rational = self.weights().is_some() || next.weights().is_some();
        first.rebuilt_as(direction, &joined, rational)
    }

    /// Whether the surface ends where it begins, in u and in v: a tube, a torus.
    #[must_use]
    pub fn closed(&self) -> (bool, bool) {
        let tolerance = same_place(self.control_points());
        let closed = |direction| self.strip(direction).is_closed(tolerance);
        (closed(Direction::U), closed(Direction::V))
    }

    /// The net as a strip of curves that run in a direction.
    pub(super) fn strip(&self, direction: Direction) -> Strip {
        let (rows, cols) = self.shape();
        let net = self.homogeneous();
        match direction {
            Direction::U => {
                Strip { knots: self.knots_u().clone(), points: net.to_vec(), width: cols }
            }
            Direction::V => {
                Strip { knots: self.knots_v().clone(), points: transpose(net, cols), width: rows }
            }
        }
    }

    fn along(&self, direction: Direction, f: impl Fn(&Strip) -> Result<Strip>) -> Result<Self> {
        self.rebuilt(direction, &f(&self.strip(direction))?)
    }

    fn rebuilt(&self, direction: Direction, strip: &Strip) -> Result<Self> {
        self.rebuilt_as(direction, strip, self.weights().is_some())
    }

    /// The surface with this strip in place of its own in that direction.
    fn rebuilt_as(&self, direction: Direction, strip: &Strip, rational: bool) -> Result<Self> {
        let knots = strip.knots.clone();
        match direction {
            Direction::U => {
                Self::from_homogeneous(&strip.points, rational, knots, self.knots_v().clone())
            }
            Direction::V => {
                let net = transpose(&strip.points, strip.width);
                Self::from_homogeneous(&net, rational, self.knots_u().clone(), knots)
            }
        }
    }
}

/// The columns of a net of this many columns, one after the other.
pub(super) fn transpose(net: &[DVec4], cols: usize) -> Vec<DVec4> {
    (0..cols).flat_map(|j| net.iter().skip(j).step_by(cols).copied()).collect()
}

/// A strip and one of the same degree that begins where it ends, within a tolerance.
pub(super) fn joined(first: &Strip, next: &Strip, tolerance: f64) -> Result<Strip> {
    let (first, mut next) = (first.clamped()?, next.clamped()?);
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
    first.joined(&next)
}

pub(super) fn check_tolerance(tolerance: f64) -> Result<()> {
    if tolerance >= 0.0 && tolerance.is_finite() {
        return Ok(());
    }
    Err(Error::parameter("tolerance", "a finite distance, at least 0", tolerance))
}

/// Two surfaces with the higher of their degrees in a direction, and with the same knots there if
/// that is asked for.
fn compatible(
    direction: Direction,
    a: &NurbsSurface,
    b: &NurbsSurface,
    knots: bool,
) -> Result<[NurbsSurface; 2]> {
    let mut strips = [a.strip(direction), b.strip(direction)];
    if knots {
        super::strip::unify(&mut strips)?;
    } else {
        super::strip::unify_degrees(&mut strips)?;
    }
    Ok([a.rebuilt(direction, &strips[0])?, b.rebuilt(direction, &strips[1])?])
}
