//! Which point is presented next (the paper's section 4.3).

use rand::RngExt;
use rand_pcg::Pcg64;

/// The original presentation: at random, with replacement.
pub(super) fn random(points: usize, rng: &mut Pcg64) -> usize {
    rng.random_range(0..points)
}
