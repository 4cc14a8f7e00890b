//! The order in which online training presents points (section 4.3 of the paper).

use super::options::Presentation;
use super::random::Random;

/// The order of presentation and its current position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PresentationOrder {
    pub(super) kind: Presentation,
    pub(super) points: usize,
    /// Shuffled: this epoch's order. Skip-reached: the points still presented. Random: empty.
    pub(super) pool: Vec<u32>,
    /// Index in `pool` of the last presented point.
    pub(super) place: usize,
}

impl PresentationOrder {
    pub(super) fn new(kind: Presentation, points: usize) -> Self {
        let pool = if kind == Presentation::Random {
            Vec::new()
        } else {
            (0..u32::try_from(points).unwrap_or(u32::MAX)).collect()
        };
        Self { kind, points, pool, place: usize::MAX }
    }

    /// The index of the next point, or `None` if none is left.
    pub(super) fn next(&mut self, random: &mut Random) -> Option<usize> {
        match self.kind {
            Presentation::Random => Some(random.index(self.points)),
            Presentation::SkipReached => {
                if self.pool.is_empty() {
                    return None;
                }
                self.place = random.index(self.pool.len());
                Some(self.pool[self.place] as usize)
            }
            Presentation::Shuffled => {
                self.place = self.place.wrapping_add(1);
                if self.place.is_multiple_of(self.points) {
                    random.shuffle(&mut self.pool);
                    self.place = 0;
                }
                Some(self.pool[self.place] as usize)
            }
        }
    }

    /// Whether an order read from bytes is consistent.
    pub(super) fn is_valid(&self) -> bool {
        let complete = match self.kind {
            Presentation::Random => self.pool.is_empty(),
            Presentation::SkipReached => self.pool.len() <= self.points,
            Presentation::Shuffled => {
                let begun = self.place < self.points || self.place == usize::MAX;
                self.pool.len() == self.points && begun
            }
        };
        complete && self.pool.iter().all(|&index| (index as usize) < self.points)
    }

    /// Removes the last presented point from the pool if reached points are skipped.
    pub(super) fn remove_presented(&mut self) {
        if self.kind == Presentation::SkipReached {
            self.pool.swap_remove(self.place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shuffled_presents_each_point_once_per_epoch() {
        let mut random = Random::new(1);
        let mut order = PresentationOrder::new(Presentation::Shuffled, 10);
        let mut epochs: Vec<Vec<usize>> = Vec::new();
        for _ in 0..3 {
            epochs.push((0..10).filter_map(|_| order.next(&mut random)).collect());
        }
        assert_ne!(epochs[0], epochs[1]);
        for mut epoch in epochs {
            epoch.sort_unstable();
            assert_eq!(epoch, (0..10).collect::<Vec<_>>());
        }
    }

    #[test]
    fn removed_points_are_not_presented_again() {
        let mut random = Random::new(1);
        let mut order = PresentationOrder::new(Presentation::SkipReached, 5);
        let mut seen = Vec::new();
        while let Some(index) = order.next(&mut random) {
            seen.push(index);
            order.remove_presented();
        }
        seen.sort_unstable();
        assert_eq!(seen, [0, 1, 2, 3, 4]);
    }
}
