//! What fits return.

use glam::DVec2;

use crate::nurbs::NurbsSurface;

/// A surface near points.
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
    /// Mean square of the error that cross-validation expects at a point that was left out, in the
    /// points' unit squared; `None` if it was not asked.
    pub expected: Option<f64>,
    /// Solutions made after the coarse net.
    pub iterations: usize,
    /// What ended the growth of the net.
    pub ended_by: EndedBy,
}

/// A surface of heights.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightFit {
    /// The surface, over a rectangle of the plane: see [`fit_heights`](super::fit_heights).
    pub surface: NurbsSurface,
    /// The points' parameters.
    pub uv: Vec<DVec2>,
    /// Heights of the points above the surface, in the points' unit.
    pub residuals: Vec<f64>,
    /// The weight of the fairness that was used.
    pub fairness: f64,
    /// Gaps over which slopes end, as a share of the ground's side, where bends alone would have let the
    /// surface go too far.
    pub reach: Option<f64>,
    /// Mean square of the error at points that were left out at random, in the points' unit squared;
    /// infinite if it was not asked.
    pub expected: f64,
    /// The same for blocks of points that were left out; zero if the points do not lie in clumps.
    pub expected_of_blocks: f64,
}

/// What ended the growth of a net.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndedBy {
    /// All points lie within the tolerance.
    Tolerance,
    /// Cross-validation expects a larger net to follow noise, or to stray between samples.
    Noise,
    /// The error is so small that a larger net makes no visible difference.
    Exact,
    /// The size of the net was given.
    Grid,
    /// The points cannot hold more control points.
    Points,
    /// As many control points as were allowed.
    MaxControlPoints,
    /// A larger net has defects.
    Defects,
}

impl EndedBy {
    /// The name, as Python and reports spell it.
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
