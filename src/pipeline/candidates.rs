//! The ranked candidates without the final fit, and the reason why each lost.

use std::fmt;

use glam::DVec3;

use super::axis_scale::choose_axes;
use super::options::ReconstructOptions;
use super::ranked_cloud::{RankedCloud, with_ranked_cloud};
use super::ranking::Model;
use crate::chart::Kind;
use crate::diagnostic::Diagnostic;
use crate::error::{Error, Result};
use crate::numeric::Short;
use crate::progress::Observer;
use crate::worker_pool;

/// A hypothesis about the surface as the report shows it: its score and its outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The chart that put the points on a parameter domain.
    pub chart: &'static str,
    /// The kind of surface.
    pub kind: Kind,
    /// The direction of the heights; `None` unless it is a height field.
    pub direction: Option<DVec3>,
    /// The score, of which the lowest is best; `None` if it was not computed.
    pub score: Option<f64>,
    /// The weighted terms whose sum is the score.
    pub terms: Vec<(&'static str, f64)>,
    /// Place in the ranking, the first being 1; `None` without a score.
    pub rank: Option<usize>,
    /// `"chosen"`, or the reason why it lost.
    pub outcome: String,
}

/// Why a candidate was chosen or lost. Its text is the outcome in the report.
pub(super) enum Outcome<'a> {
    /// It is the result.
    Chosen,
    /// It is the result, although a finer net has defects or is farther from the points.
    ChosenNotGrown,
    /// It is the result, although it has defects.
    ChosenWithDefects,
    /// Its score is higher by `by`, mostly because of one term.
    HigherScore { by: f64, term: &'static str, term_by: f64 },
    /// Its quick error is this many times that of the best.
    Dropped { error_ratio: f64 },
    /// Its fit failed.
    NotFitted(&'a Error),
    /// Its refined surface has no defects, but is farther from the points than another one.
    Farther,
    /// Its refined surface could not grow without defects.
    NotGrown,
    /// Its refined surface has this defect.
    Defect(&'a Diagnostic),
}

impl fmt::Display for Outcome<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Chosen => f.write_str("chosen"),
            Self::ChosenNotGrown => {
                f.write_str("chosen with a small net: a finer one has defects or is farther away")
            }
            Self::ChosenWithDefects => {
                f.write_str("chosen with defects: no other candidate is better")
            }
            Self::HigherScore { by, term, term_by } => {
                write!(f, "score higher by {by:.2}, mainly from {term} ({term_by:.2})")
            }
            Self::Dropped { error_ratio } => {
                let ratio = Short(*error_ratio);
                write!(f, "dropped: quick fit {ratio} times as far from the points as the best")
            }
            Self::NotFitted(error) => write!(f, "not fitted: {error}"),
            Self::Farther => f.write_str("refined, but farther from the points than another"),
            Self::NotGrown => {
                f.write_str("refined, but a finer net has defects or is farther from the points")
            }
            Self::Defect(defect) => write!(f, "refined, with the defect {}", defect.code()),
        }
    }
}

/// Ranks the candidates for points, the best first, without the fit of the final surface.
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
        let axes = choose_axes(points, options, observer)?;
        with_ranked_cloud(points, axes, options, observer, |ranked, _| Ok(ranked.candidates()))
    })
}

impl RankedCloud<'_> {
    /// All hypotheses as candidates. The first of the ranking is the chosen one.
    pub(super) fn candidates(&self) -> Vec<Candidate> {
        let models = &self.ranking.models;
        let scored = models.iter().enumerate().map(|(place, model)| {
            let outcome = if place == 0 {
                Outcome::Chosen
            } else {
                let by = model.score.total() - models[0].score.total();
                let (term, term_by) = worst_term(model, &models[0]);
                Outcome::HigherScore { by, term, term_by }
            };
            Candidate {
                chart: model.hypothesis.chart,
                kind: model.hypothesis.kind,
                direction: model.hypothesis.heights.map(|axes| self.given_direction(axes[2])),
                score: Some(model.score.total()),
                terms: model.score.terms.to_vec(),
                rank: Some(place + 1),
                outcome: outcome.to_string(),
            }
        });
        let dropped = self.ranking.dropped.iter().map(|dropped| Candidate {
            chart: dropped.chart,
            kind: dropped.kind,
            direction: None,
            score: None,
            terms: Vec::new(),
            rank: None,
            outcome: Outcome::Dropped { error_ratio: dropped.error_ratio }.to_string(),
        });
        scored.chain(dropped).collect()
    }
}

/// The term by which a model is most above another, and the difference.
fn worst_term(model: &Model, best: &Model) -> (&'static str, f64) {
    let terms = model.score.terms.iter().zip(&best.score.terms);
    let differences = terms.map(|((name, own), (_, other))| (*name, own - other));
    differences.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(("", 0.0))
}
