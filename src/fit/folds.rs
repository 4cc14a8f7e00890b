//! Points dealt into folds, each of which is left out in turn.

use glam::DVec3;

use super::blocks::{blocks, in_turn};

/// The fold of each point. A fold of blocks leaves gaps as wide as those between tracks, sweeps and
/// clumps of points; one of points taken in turn does not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folds {
    /// Points taken in turn.
    pub in_turn: Vec<usize>,
    /// Blocks in space.
    pub blocks: Vec<usize>,
}

impl Folds {
    /// Of points whose order is that of no direction.
    #[must_use]
    pub fn of(points: &[DVec3]) -> Self {
        Self { in_turn: in_turn(points.len()), blocks: blocks(points) }
    }
}
