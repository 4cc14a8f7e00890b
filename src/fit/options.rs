//! What is fitted, and how far a net grows.

use super::sizes::MAX_CONTROL_POINTS;
use crate::error::{Error, Result};
use crate::nurbs::KnotVector;

/// Knots and fairness of a least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitOptions {
    /// Knots in u; the domain must hold all parameters.
    pub knots_u: KnotVector,
    /// Knots in v.
    pub knots_v: KnotVector,
    /// Directions in which the surface closes smoothly: their knots must be periodic.
    pub closed: (bool, bool),
    /// Weight of the thin-plate energy: 1 gives it as large a say (trace of the matrix) as all
    /// points together, 0 none at all. Small values, 1e-6 say, only fill what points leave open.
    pub fairness: f64,
}

impl FitOptions {
    /// Evenly spaced knots on `[0, 1]²` for a net of this shape, and a fairness of 1e-6; in closed
    /// directions the shape counts the different control points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side of the net has not more control points than its degree, or
    /// the net has more than 2^20 of them.
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

/// How heights are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightOptions {
    /// Rows and columns of the control net: along the plane's first and second axis.
    pub net: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// See [`FitOptions::fairness`]; `None`: the value from 1e-12 to 100 that best predicts
    /// points which are left out.
    pub fairness: Option<f64>,
}

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
    /// points together. `None`: by cross-validation; how much more derivatives along one direction
    /// count is found, too, by marginal likelihood.
    pub fairness: Option<f64>,
    /// About how far the surface goes on beyond the points at open borders, in mean spacings of the
    /// points: less where the border is sure, more where it is in doubt.
    pub border: f64,
    /// Solutions with each net at most.
    pub iterations: usize,
    /// Whether and how far the net grows.
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

/// How far a net grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Until all points are within this distance, in their unit; `None`: until cross-validation
    /// expects nothing from more control points.
    pub tolerance: Option<f64>,
    /// Control points at most.
    pub most: usize,
}
