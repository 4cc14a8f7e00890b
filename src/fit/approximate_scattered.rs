//! Approximation: a surface near points with rough parameters, by least squares from coarse to
//! fine.
//!
//! The distances are tangent distances (W. Wang, H. Pottmann, Y. Liu, *Fitting B-spline curves to
//! point clouds by curvature-based squared distance minimization*, 2006): those to the tangent
//! plane at a point's projection count in full, those within the plane little. So the net can slide
//! along the surface to better parameters, which plain distances prevent.

use glam::{DVec2, DVec3};

use super::adaptive_refinement::{Accept, RefinementResult};
use super::alternating_fit::AlternatingFit;
use super::fit_result::Approximation;
use super::options::{ApproximateOptions, Growth, uniform};
use super::settings::{AlternatingFitSettings, FairnessSettings};
use super::spline_space::SplineSpace;
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::worker_pool;

const FAIRNESS: FairnessSettings = FairnessSettings::STANDARD;
const SETTINGS: AlternatingFitSettings = AlternatingFitSettings::STANDARD;

/// The surface near `points`, from rough parameters in [0, 1]². Closed directions have the period
/// 1. Each squared distance is multiplied by its weight, 1 without weights.
///
/// A net with half the rows and columns is fitted first, then the whole net, both to as many points
/// as they need, at equal steps. Finally the whole net is fitted to all points. Each iteration
/// takes O(points · degree⁴) and one band solution of three times the unknowns. The result is the
/// same to the last bit with any number of threads.
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
/// [`Error::Parameter`](crate::Error::Parameter) if the net is too small for the degree, or the
/// points do not determine it; [`Error::Interrupted`](crate::Error::Interrupted) if the observer
/// stops it.
pub fn approximate(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &ApproximateOptions,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    worker_pool::run_observed(points.len(), observer, |observer| {
        approximated(points, uv, weights, options, observer)
    })
}

fn approximated(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &ApproximateOptions,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    let spaces: Vec<SplineSpace> =
        levels(options).into_iter().map(|net| space(net, options)).collect::<Result<_>>()?;
    let (coarsest, whole) = (&spaces[0], &spaces[spaces.len() - 1]);
    let mut fitting = AlternatingFit::new(points, uv, weights, options, observer);
    fitting.subsample_for(coarsest);
    let mut surface = fitting.first(coarsest)?;
    fitting.limit = options.iterations.div_ceil(2);
    for space in &spaces {
        fitting.subsample_for(space);
        if space == whole {
            (fitting.limit, fitting.fairness_decay) = (options.iterations, FAIRNESS.final_decay);
        }
        surface = fitting.minimize(space, surface)?;
    }
    fitting.limit = options.iterations.div_ceil(2);
    if fitting.use_all_points(&surface) || options.closed != (true, true) {
        surface = fitting.fit_on_square(&surface, options.border)?;
        surface = fitting.minimize(whole, surface)?;
    }
    fitting.limit = options.iterations;
    Ok(fitting.refined_fit(surface, options.growth, &|_, _| Ok(true))?.finest)
}

/// A surface from which a fit continues.
#[derive(Clone, Copy)]
pub(crate) struct FittedSurface<'a> {
    pub(crate) surface: &'a NurbsSurface,
    /// The parameters of each point's projection.
    pub(crate) uv: &'a [DVec2],
    pub(crate) closed: (bool, bool),
    /// The weight of the fairness at the start of the fit.
    pub(crate) fairness: f64,
}

/// The surface fitted again with slightly different weights, on the same domain. It grows if it
/// may. `fairness` is as in [`ApproximateOptions`].
///
/// # Errors
///
/// Those of [`approximate`].
pub(crate) fn continued(
    points: &[DVec3],
    weights: Option<&[f64]>,
    from: &FittedSurface<'_>,
    fairness: Option<f64>,
    growth: Option<Growth>,
    accept: Accept<'_>,
    observer: &mut dyn Observer,
) -> Result<RefinementResult> {
    let &FittedSurface { surface, uv, closed, fairness: first } = from;
    let options = ApproximateOptions { closed, fairness, ..ApproximateOptions::default() };
    let mut fitting = AlternatingFit::new(points, uv, weights, &options, observer);
    fitting.fairness_weight = first;
    let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
    let space = SplineSpace::new(knots, closed.into())?;
    let surface = fitting.minimize(&space, surface.clone())?;
    fitting.refined_fit(surface, growth, accept)
}

/// Nets from coarse to whole. Each has half the rows and columns of the next, as far as the degree
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
        let coarse_enough = nets.len() > 1 && rows * cols <= SETTINGS.max_coarse_control_points;
        if coarser == (rows, cols) || coarse_enough {
            break;
        }
        nets.push(coarser);
    }
    nets.reverse();
    nets
}

/// Evenly spaced knots for a net.
fn space(net: (usize, usize), options: &ApproximateOptions) -> Result<SplineSpace> {
    let u = uniform(options.degree.0, net.0, options.closed.0)?;
    let v = uniform(options.degree.1, net.1, options.closed.1)?;
    SplineSpace::new([u, v], options.closed.into())
}
