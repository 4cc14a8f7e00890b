//! The surface near points whose parameters are known roughly: least squares, coarse to fine, with
//! fairness and parameter correction by tangent distance.
//!
//! Tangent distance (W. Wang, H. Pottmann, Y. Liu, *Fitting B-spline curves to point clouds by
//! curvature-based squared distance minimization*, 2006) counts how far a point is from the tangent
//! plane at its foot, and hardly where in the plane it is: the net may slide along the surface
//! towards the parameters that suit it, which plain distances hinder.

use glam::{DVec2, DVec3};

use super::fitting::{Fitting, Pace};
use super::growth::{EndedBy, Growth};
use super::relaxation::Flat;
use super::rim::Rim;
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsSurface};
use crate::progress::Observer;

/// How to approximate.
#[derive(Clone, Debug, PartialEq)]
pub struct ApproximateOptions {
    /// Rows and columns of the control net; in closed directions the different ones.
    pub net: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// Directions in which the surface closes smoothly.
    pub closed: (bool, bool),
    /// Weight of the fairness, the energy of third derivatives: 1 gives it as large a say as all
    /// points together. `None`: by generalized cross-validation; how much more derivatives along one
    /// direction count is found, too, by marginal likelihood.
    pub fairness: Option<f64>,
    /// About how far the surface goes on beyond the points at open borders, in mean spacings of the
    /// points: less where the border is sure, more where it is in doubt.
    pub border: f64,
    /// Solutions with the whole net at most.
    pub iterations: usize,
    /// Whether and how far the net grows.
    pub growth: Option<Growth>,
    /// Parameters along u, increasing, at which the surface has creases, if its net has room for
    /// them: isocurves along u may have corners there.
    pub creases: Vec<f64>,
}

/// A surface near points.
#[derive(Clone, Debug, PartialEq)]
pub struct Approximation {
    /// The surface.
    pub surface: NurbsSurface,
    /// Where on it each point has its foot.
    pub uv: Vec<DVec2>,
    /// Each point's distance from its foot, in the points' unit.
    pub distances: Vec<f64>,
    /// The weight of the fairness that was used.
    pub fairness: f64,
    /// Mean square of the error that cross-validation expects at a point that was left out, in the
    /// points' unit squared; `None` if it was not asked.
    pub expected: Option<f64>,
    /// Solutions made after the coarse net.
    pub iterations: usize,
    /// What ended the growth of the net.
    pub ended_by: EndedBy,
}

/// Solutions with the whole net for each with a coarse one: that only has to take shape.
const COARSE_SHARE: usize = 3;

/// Control points of the coarsest net at most, but there is always one.
const COARSEST: usize = 300;

/// Shares of the fairness that are left after each solution, with coarse nets and with the whole.
const LEFT_OF_FAIRNESS: (f64, f64) = (0.5, 0.25);

/// Of solutions with all points and the whole net, on the domain that ends where they do.
const LAST: Pace = Pace { limit: 3, left_of_fairness: LEFT_OF_FAIRNESS.1 };

/// Turns in which the domain follows a notch of the outline.
const TURNS_FOR_NOTCHES: usize = 2;

/// The surface near `points`, from rough parameters in [0, 1]² (a closed direction has the period
/// 1). Each squared distance counts with its weight (1 without weights).
///
/// Half the net is fitted first, then the whole, both to as many points as they need, taken at equal
/// steps; at last the whole net to all points. O(points · degree⁴) and one band solution of three
/// times the unknowns for each iteration. The number of threads does not change a bit.
///
/// ```
/// use neurbs::{DVec2, DVec3, fit::{ApproximateOptions, approximate}, progress::Silent};
/// let points: Vec<DVec3> = (0..400)
///     .map(|i| {
///         let (x, y) = (f64::from(i * 7 % 400) / 399.0, f64::from(i) / 399.0);
///         DVec3::new(x, y, 0.3 * (2.0 * x).sin() * y)
///     })
///     .collect();
/// let uv: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
/// let options = ApproximateOptions { net: (6, 6), ..ApproximateOptions::default() };
/// let found = approximate(&points, &uv, None, &options, &mut Silent)?;
/// assert!(found.distances.iter().all(|distance| *distance < 1e-3));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`](crate::Error::Parameter) if the net is too small for the degree, or nothing holds it;
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn approximate(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &ApproximateOptions,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    let spaces: Vec<SplineSpace> =
        levels(options).into_iter().map(|net| uniform(net, options)).collect::<Result<_>>()?;
    let (coarsest, whole) = (&spaces[0], &spaces[spaces.len() - 1]);
    let mut fitting = Fitting::new(points, uv, weights, options, observer);
    fitting.look_at_enough_for(coarsest);
    let mut surface = fitting.first(coarsest)?;
    for space in &spaces {
        fitting.look_at_enough_for(space);
        let pace = if space == whole {
            Pace { limit: options.iterations, left_of_fairness: LEFT_OF_FAIRNESS.1 }
        } else {
            let limit = options.iterations.div_ceil(COARSE_SHARE);
            Pace { limit, left_of_fairness: LEFT_OF_FAIRNESS.0 }
        };
        surface = fitting.descend(space, surface, pace)?;
    }
    if fitting.look_at_all(&surface) || options.closed != (true, true) {
        for _ in 0..TURNS_FOR_NOTCHES {
            let (bent, notched) = fitting.conform(surface, options.border)?;
            surface = fitting.descend(whole, bent, LAST)?;
            if !notched {
                break;
            }
        }
    }
    fitting.grown(surface, options.growth)
}

/// The surface that a fit becomes with other weights, which change little, on the domain that it has;
/// it grows on, if it may.
///
/// # Errors
///
/// Those of [`approximate`].
pub(crate) fn continued(
    points: &[DVec3],
    weights: Option<&[f64]>,
    from: &Flat<'_>,
    fairness: Option<f64>,
    growth: Option<Growth>,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    let mut fitting = from.fitting(points, weights, fairness, observer);
    fitting.bent = from.closed != (true, true);
    fitting.rim = (from.closed == (false, false)).then(|| Rim::of(from.surface));
    let knots = [from.surface.knots_u().clone(), from.surface.knots_v().clone()];
    let space = SplineSpace::new(knots, from.closed.into())?;
    let surface = fitting.descend(&space, from.surface.clone(), LAST)?;
    fitting.grown(surface, growth)
}

impl Default for ApproximateOptions {
    fn default() -> Self {
        Self {
            net: (12, 12),
            degree: (3, 3),
            closed: (false, false),
            fairness: None,
            border: 0.5,
            iterations: 8,
            growth: None,
            creases: Vec::new(),
        }
    }
}

/// Nets from coarse to whole: each has half the rows and columns of the next, as far as the degree
/// allows.
fn levels(options: &ApproximateOptions) -> Vec<(usize, usize)> {
    let half = |count: usize, degree: usize, closed| {
        let least = degree + if closed { 2 } else { 1 };
        (count / 2).max(least).min(count)
    };
    let ((p, q), (closed_u, closed_v)) = (options.degree, options.closed);
    let mut nets = vec![options.net];
    while let Some(&(rows, cols)) = nets.last() {
        let coarser = (half(rows, p, closed_u), half(cols, q, closed_v));
        let coarse_enough = nets.len() > 1 && rows * cols <= COARSEST;
        if coarser == (rows, cols) || coarse_enough {
            break;
        }
        nets.push(coarser);
    }
    nets.reverse();
    nets
}

/// Evenly spaced knots for a net, repeated at creases.
fn uniform(net: (usize, usize), options: &ApproximateOptions) -> Result<SplineSpace> {
    let knots = |degree, count, closed, creases| {
        if closed {
            KnotVector::periodic_uniform(degree, count)
        } else {
            KnotVector::clamped_creased(degree, count, creases)
        }
    };
    let u = knots(options.degree.0, net.0, options.closed.0, options.creases.as_slice())?;
    let v = knots(options.degree.1, net.1, options.closed.1, &[])?;
    SplineSpace::new([u, v], options.closed.into())
}
