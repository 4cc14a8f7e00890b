//! The score of a hypothesis: a sum of weighted error terms, of which the lowest is best.

use std::cmp::Ordering;

use super::settings::ScoreSettings;
use crate::chart::Kind;
use crate::validate::Terms;

/// The score of a hypothesis; the lowest is best.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// The terms by name, each with its weight.
    pub terms: [(&'static str, f64); 9],
}

impl Score {
    /// The score of a surface with these error terms.
    ///
    /// The errors are those of held-out points, first by random folds and then by blocks. Errors
    /// below `floor` are noise. `unfilled` is the share of a height field's rectangle without
    /// points.
    #[must_use]
    pub fn of(
        kind: Kind,
        unfilled: f64,
        [random, blocks]: [f64; 2],
        floor: f64,
        terms: &Terms,
        points: usize,
        settings: &ScoreSettings,
    ) -> Self {
        // Grows as the logarithm of the error over the floor, and is flat below the floor.
        let over = |error: f64| 0.25 * (0.5 * ((error / floor).powi(2) + 1.0)).ln();
        let grows = |share: f64, scale: f64| (share / scale).ln_1p();
        let closed = kind.closed().0;
        let root = (points as f64).sqrt();
        Self {
            terms: [
                ("held_out", settings.held_out_weight * (over(random) + over(blocks))),
                ("torn", settings.torn_weight * grows(root * terms.torn, settings.torn_scale)),
                (
                    "uncovered",
                    if closed { grows(terms.uncovered, settings.uncovered_scale) } else { 0.0 },
                ),
                ("misaligned", grows(terms.misaligned, settings.misaligned_scale)),
                ("folded", grows(terms.folded, settings.folded_scale)),
                ("unfilled", grows(unfilled, settings.unfilled_scale)),
                ("pinched", settings.pinched_weight * terms.pinched),
                ("closed", if closed { settings.closed_cost } else { 0.0 }),
                ("free", if kind == Kind::Height { 0.0 } else { settings.free_cost / root }),
            ],
        }
    }

    /// The sum of the terms.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.terms.iter().map(|(_, value)| value).sum()
    }

    /// Orders scores, the lower one first.
    #[must_use]
    pub fn compare(&self, other: &Self) -> Ordering {
        self.total().total_cmp(&other.total())
    }
}
