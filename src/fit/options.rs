//! Options of fits: nets, degrees, fairness and growth.

use super::sizes::MAX_CONTROL_POINTS;
use crate::error::{Error, Result};
use crate::numeric::Short;
use crate::nurbs::KnotVector;

/// Knots and fairness of a least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitOptions {
    /// Knots in u. All parameters must lie in the domain.
    pub knots_u: KnotVector,
    /// Knots in v.
    pub knots_v: KnotVector,
    /// Directions in which the surface closes smoothly. Their knots must be periodic.
    pub closed: (bool, bool),
    /// Weight of the thin-plate energy. With 1 its matrix has the same trace as that of the points;
    /// with 0 it has no effect. Small values, such as 1e-6, only determine control points that no
    /// points determine.
    pub fairness: f64,
}

impl FitOptions {
    /// Evenly spaced knots on `[0, 1]²` for a net of this shape, and a fairness of 1e-6. In closed
    /// directions the shape excludes repeated control points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side of the net does not have more control points than its degree,
    /// or the net has more than 2^20 of them.
    pub fn new(net: (usize, usize), degree: (usize, usize), closed: (bool, bool)) -> Result<Self> {
        if net.0.saturating_mul(net.1) > MAX_CONTROL_POINTS {
            let must = format!("of at most {MAX_CONTROL_POINTS} control points");
            return Err(Error::parameter("net", must, format!("{} × {}", net.0, net.1)));
        }
        let knots_u = uniform(degree.0, net.0, closed.0)?;
        let knots_v = uniform(degree.1, net.1, closed.1)?;
        Ok(Self { knots_u, knots_v, closed, fairness: 1e-6 })
    }
}

/// Evenly spaced knots on `[0, 1]`, clamped or periodic.
pub(super) fn uniform(degree: usize, count: usize, closed: bool) -> Result<KnotVector> {
    if closed {
        KnotVector::periodic_uniform(degree, count)
    } else {
        KnotVector::clamped_uniform(degree, count)
    }
}

/// Net, degree and fairness of a height field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightOptions {
    /// Rows and columns of the control net, along the plane's first and second axis.
    pub net: (usize, usize),
    /// Degrees in u and v; lower where the net has too few rows or columns.
    pub degree: (usize, usize),
    /// See [`FitOptions::fairness`]. `None`: the value from 1e-12 to 100 that best predicts points
    /// that were left out.
    pub fairness: Option<f64>,
}

impl HeightOptions {
    /// The options with the degrees that the net allows.
    pub(super) fn with_possible_degree(self) -> Self {
        let possible = |degree: usize, count: usize| degree.min(count.saturating_sub(1).max(1));
        let degree = (possible(self.degree.0, self.net.0), possible(self.degree.1, self.net.1));
        Self { degree, ..self }
    }
}

/// Net, degree, fairness and growth of an approximation.
#[derive(Clone, Debug, PartialEq)]
pub struct ApproximateOptions {
    /// Rows and columns of the control net; in closed directions without repeated ones.
    pub net: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// Directions in which the surface closes smoothly.
    pub closed: (bool, bool),
    /// Weight of the fairness, the energy of third derivatives. With 1 its matrix has the same
    /// trace as that of the points. `None`: cross-validation chooses the weight, and marginal
    /// likelihood its anisotropy.
    pub fairness: Option<f64>,
    /// Mean distance of the surface's border from the outermost points at open sides, in mean
    /// spacings of the points.
    pub border: f64,
    /// Solutions with each net, at most.
    pub iterations: usize,
    /// Limits of the net's growth. `None`: the net keeps its size.
    pub growth: Option<Growth>,
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
        }
    }
}

/// Limits of a net's growth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// The net grows until all points are within this distance, in their unit. `None`: until
    /// cross-validation expects no improvement from more control points.
    pub tolerance: Option<f64>,
    /// Control points, at most.
    pub most: usize,
}

/// Largest weight of the fairness: beyond it, rounding hides the points.
const MAX_FAIRNESS: f64 = 1e12;

/// Largest ratio of two weights that are not 0: beyond it, rounding hides the lighter points.
const MAX_WEIGHT_RATIO: f64 = 1e12;

/// Checks the weight of the fairness.
pub(crate) fn check_fairness(fairness: f64) -> Result<()> {
    if (0.0..=MAX_FAIRNESS).contains(&fairness) {
        return Ok(());
    }
    Err(Error::parameter("fairness", format!("from 0 to {MAX_FAIRNESS:e}"), Short(fairness)))
}

/// Checks the weights of points: one for each, finite, not negative, not all 0.
pub(crate) fn check_weights(weights: &[f64], points: usize) -> Result<()> {
    if weights.len() != points {
        let must = format!("as many as the points, {points}");
        return Err(Error::parameter("weights", must, weights.len()));
    }
    if let Some(i) = weights.iter().position(|weight| !(*weight >= 0.0 && weight.is_finite())) {
        let got = format!("{} at index {i}", Short(weights[i]));
        return Err(Error::parameter("weights", "finite and at least 0", got));
    }
    let positive = || weights.iter().copied().filter(|weight| *weight > 0.0);
    let (least, most) = (positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max));
    if most == 0.0 {
        return Err(Error::parameter("weights", "positive for some point", "all 0"));
    }
    if most / least > MAX_WEIGHT_RATIO {
        let must = format!("0 or within a factor of {MAX_WEIGHT_RATIO:e} of each other");
        return Err(Error::parameter(
            "weights",
            must,
            format!("{} to {}", Short(least), Short(most)),
        ));
    }
    Ok(())
}
