//! Results of fits.

use glam::DVec2;

use crate::nurbs::NurbsSurface;

/// A surface fitted to points.
#[derive(Clone, Debug, PartialEq)]
pub struct Approximation {
    /// The surface.
    pub surface: NurbsSurface,
    /// The parameters of each point's projection.
    pub uv: Vec<DVec2>,
    /// Each point's distance from its projection, in the points' unit.
    pub distances: Vec<f64>,
    /// The weight of the fairness that was used.
    pub fairness: f64,
    /// Mean squared error that cross-validation expects at a point that was left out, in the
    /// points' unit squared. `None` without cross-validation.
    pub expected: Option<f64>,
    /// Solutions after the first one.
    pub iterations: usize,
    /// The reason why the net stopped growing.
    pub ended_by: EndedBy,
}

/// A height field fitted to points.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightFit {
    /// The surface over a rectangle of the plane; see [`fit_heights`](super::fit_heights).
    pub surface: NurbsSurface,
    /// The points' parameters.
    pub uv: Vec<DVec2>,
    /// Heights of the points above the surface, in the points' unit.
    pub residuals: Vec<f64>,
    /// The weight of the fairness that was used.
    pub fairness: f64,
    /// Factor of the energy's derivatives along u; those along v are divided by it.
    pub anisotropy: f64,
    /// Length above which gaps are spanned like a membrane, in sides of the base rectangle. `None`
    /// if a thin plate does not overshoot.
    pub reach: Option<f64>,
    /// Mean squared error at points that were left out in turn, in the points' unit squared.
    /// Infinite without cross-validation.
    pub expected: f64,
    /// The same where points left gaps as wide as those between the others.
    pub expected_in_gaps: f64,
}

/// The reason why a net stopped growing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndedBy {
    /// All points lie within the tolerance.
    Tolerance,
    /// Cross-validation expects a larger net to follow noise, or to deviate between samples.
    Noise,
    /// The error is so small that a larger net makes no visible difference.
    Exact,
    /// The size of the net was given.
    Grid,
    /// The points do not determine more control points.
    Points,
    /// The limit on the number of control points is reached.
    MaxControlPoints,
    /// A larger net has defects.
    Defects,
}

impl EndedBy {
    /// The name in Python and in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tolerance => "tolerance",
            Self::Noise => "noise",
            Self::Exact => "exact",
            Self::Grid => "grid",
            Self::Points => "points",
            Self::MaxControlPoints => "max_control_points",
            Self::Defects => "defects",
        }
    }
}
