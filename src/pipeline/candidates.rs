//! The hypotheses among which the surface is chosen.

use glam::DVec3;

use super::candidate::Candidate;
use super::options::ReconstructOptions;
use super::ranked::{Ranked, ranked};
use super::select::Model;
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

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
    worker_pool::run_observed(points.len(), observer, |observer| {
        ranked(points, options, observer, |ranked, _| Ok(ranked.candidates()))
    })
}

impl Ranked<'_> {
    /// All hypotheses, the first of the ranking chosen.
    pub(super) fn candidates(&self) -> Vec<Candidate> {
        let models = &self.ranking.models;
        let best = models.first().map_or(0.0, |model| model.score.total());
        let scored = models.iter().enumerate().map(|(place, model)| {
            let outcome = if place == 0 {
                "chosen".to_string()
            } else {
                let (term, by) = worse_term(model, &models[0]);
                format!("score {:.2} higher, most by {term} ({by:.2})", model.score.total() - best)
            };
            Candidate {
                chart: model.hypothesis.chart,
                kind: model.hypothesis.kind,
                direction: model.hypothesis.heights.map(|axes| self.given_direction(axes[2])),
                score: Some(model.score.total()),
                terms: model.score.terms.to_vec(),
                rank: Some(place + 1),
                outcome,
            }
        });
        let dropped = self.ranking.dropped.iter().map(|&(chart, kind, error)| Candidate {
            chart,
            kind,
            direction: None,
            score: None,
            terms: Vec::new(),
            rank: None,
            outcome: format!(
                "dropped: quick fit {error:.1} times as far from the points as the best"
            ),
        });
        scored.chain(dropped).collect()
    }
}

/// The term by which a model is most worse than another.
fn worse_term(model: &Model, best: &Model) -> (&'static str, f64) {
    let terms = model.score.terms.iter().zip(&best.score.terms);
    let differences = terms.map(|((name, own), (_, other))| (*name, own - other));
    differences.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(("", 0.0))
}
