//! Points dealt into folds, each of which is left out in turn: at random, and by blocks in space.

use glam::DVec3;

/// Folds of each kind.
pub const FOLDS: usize = 5;

/// Points in a block on average, and how many blocks there are at least and at most.
const POINTS_PER_BLOCK: usize = 12;
const BLOCKS: (usize, usize) = (15, 60);

/// The fold of each point. A fold of blocks leaves gaps as wide as those between tracks, sweeps and
/// clumps of points; a random one does not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folds {
    /// At random.
    pub random: Vec<u8>,
    /// By blocks in space.
    pub blocks: Vec<u8>,
}

impl Folds {
    /// Of points whose order is that of no direction.
    #[must_use]
    pub fn of(points: &[DVec3]) -> Self {
        let count = (points.len() / POINTS_PER_BLOCK).clamp(BLOCKS.0, BLOCKS.1).min(points.len());
        let fold_of_block = dealt(count);
        let blocks = blocks(points, count).into_iter().map(|block| fold_of_block[block]);
        Self { random: dealt(points.len()), blocks: blocks.collect() }
    }
}

/// As many fold numbers as items, each equally often, in an order that looks random (Weyl's
/// sequence of the golden ratio).
fn dealt(count: usize) -> Vec<u8> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| (a as f64 * golden).fract().total_cmp(&(b as f64 * golden).fract()));
    let mut folds = vec![0; count];
    for (rank, place) in order.into_iter().enumerate() {
        // Neighbours of the sequence fall into different folds.
        folds[place] = u8::try_from(rank * FOLDS / count).unwrap_or(0);
    }
    folds
}

/// The block of each point: its nearest of seeds, each as far as can be from those before.
fn blocks(points: &[DVec3], count: usize) -> Vec<usize> {
    let mut nearest = vec![(f64::INFINITY, 0); points.len()];
    let mut seed = 0;
    for block in 0..count {
        let mut farthest = (f64::NEG_INFINITY, 0);
        for (i, (point, known)) in points.iter().zip(&mut nearest).enumerate() {
            let square = point.distance_squared(points[seed]);
            if square < known.0 {
                *known = (square, block);
            }
            if known.0 > farthest.0 {
                farthest = (known.0, i);
            }
        }
        seed = farthest.1;
    }
    nearest.into_iter().map(|(_, block)| block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_are_equally_large_and_blocks_hang_together() {
        let points: Vec<DVec3> =
            (0..900_u32).map(|i| DVec3::new(f64::from(i / 30), f64::from(i % 30), 0.0)).collect();
        let folds = Folds::of(&points);
        for fold in 0..5 {
            assert_eq!(folds.random.iter().filter(|f| **f == fold).count(), 180);
        }
        let alike = (0..899).filter(|&i| i % 30 != 29 && folds.blocks[i] == folds.blocks[i + 1]);
        let share = alike.count() as f64 / 870.0;
        assert!(share > 0.7, "{share}");
        let random = (0..899).filter(|&i| folds.random[i] == folds.random[i + 1]).count();
        assert!(random < 300, "{random}");
    }
}
