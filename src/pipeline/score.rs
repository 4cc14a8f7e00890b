//! One number by which hypotheses are compared.

use std::cmp::Ordering;

use crate::chart::Kind;
use crate::validate::Terms;

/// Weights and scales of the terms. Sources: the study that the scoreboard repeats; with all weights
/// 1 nearly as many clouds come out right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScoreSettings {
    /// Weight of the error of points left out.
    pub held_out: f64,
    /// Weight of torn links, and the share times the root of the number of points that counts ln 2.
    pub torn: (f64, f64),
    /// The share of the area that counts ln 2: uncovered, misaligned, and the share of neighbouring
    /// cells that turn over.
    pub uncovered: f64,
    /// See `uncovered`.
    pub misaligned: f64,
    /// See `uncovered`.
    pub folded: f64,
    /// Share of the rectangle under heights that the points leave empty which counts ln 2: sheets
    /// end where the points end.
    pub unfilled: f64,
    /// Weight of pinched ends.
    pub pinched: f64,
    /// What a closed direction costs.
    pub closed: f64,
    /// What parameters that follow the surface cost, times the root of the number of points: by
    /// so much another hypothesis may be better than heights by chance.
    pub free: f64,
}

impl Default for ScoreSettings {
    fn default() -> Self {
        Self {
            held_out: 3.0,
            torn: (3.0, 0.3),
            uncovered: 0.02,
            misaligned: 0.05,
            folded: 0.01,
            unfilled: 0.2,
            pinched: 1.5,
            closed: 1.5,
            free: 4.0,
        }
    }
}

/// The score of a hypothesis: the lowest wins.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// The terms by name, each with its weight.
    pub terms: [(&'static str, f64); 9],
}

impl Score {
    /// Of a surface of this kind with these errors of points left out, by random folds and by
    /// blocks, where errors below `floor` are noise; of heights, with so much of their rectangle unfilled.
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
        let over = |error: f64| 0.25 * (0.5 * ((error / floor).powi(2) + 1.0)).ln();
        let grows = |share: f64, scale: f64| (share / scale).ln_1p();
        let closed = kind.closed().0;
        let root = (points as f64).sqrt();
        Self {
            terms: [
                ("held_out", settings.held_out * (over(random) + over(blocks))),
                ("torn", settings.torn.0 * grows(root * terms.torn, settings.torn.1)),
                (
                    "uncovered",
                    if closed { grows(terms.uncovered, settings.uncovered) } else { 0.0 },
                ),
                ("misaligned", grows(terms.misaligned, settings.misaligned)),
                ("folded", grows(terms.folded, settings.folded)),
                ("unfilled", grows(unfilled, settings.unfilled)),
                ("pinched", settings.pinched * terms.pinched),
                ("closed", if closed { settings.closed } else { 0.0 }),
                ("free", if kind == Kind::Height { 0.0 } else { settings.free / root }),
            ],
        }
    }

    /// The sum of the terms.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.terms.iter().map(|(_, value)| value).sum()
    }

    /// The lower score first.
    #[must_use]
    pub fn compare(&self, other: &Self) -> Ordering {
        self.total().total_cmp(&other.total())
    }
}
