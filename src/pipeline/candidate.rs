//! A hypothesis in the report.

use glam::DVec3;

use crate::chart::Kind;

/// A hypothesis about the surface, its score, and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The chart that put the points on a parameter domain.
    pub chart: &'static str,
    /// The kind of surface.
    pub kind: Kind,
    /// The direction of the heights, of a height field.
    pub direction: Option<DVec3>,
    /// The score, the lowest of which wins; `None` if it was not computed.
    pub score: Option<f64>,
    /// The weighted terms whose sum is the score.
    pub terms: Vec<(&'static str, f64)>,
    /// Place in the ranking, the first being 1; `None` without a score.
    pub rank: Option<usize>,
    /// `"chosen"`, or why it lost.
    pub outcome: String,
}
