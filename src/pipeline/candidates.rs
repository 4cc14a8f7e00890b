//! The hypotheses among which the surface is chosen.

use glam::DVec3;

use super::options::ReconstructOptions;
use super::relay;
use crate::chart::Kind;
use crate::cloud;
use crate::error::Result;
use crate::progress::Observer;
use crate::topology::detect;

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

/// Ranks the hypotheses about points, the best first, without the fit of the final surface.
///
/// # Errors
///
/// As [`reconstruct`](super::reconstruct).
pub fn candidates(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Vec<Candidate>> {
    options.check(points.len())?;
    let found = relay::in_pool(points.len(), observer, |observer| {
        cloud::checked_bounds(points, observer)?;
        detect(points, observer)
    })?;
    let kind = options.kind.unwrap_or(found.kind);
    Ok(vec![Candidate {
        chart: "detected",
        kind,
        direction: found.height.map(|height| height.up).filter(|_| kind == Kind::Height),
        score: None,
        terms: Vec::new(),
        rank: Some(1),
        outcome: "chosen".to_string(),
    }])
}
