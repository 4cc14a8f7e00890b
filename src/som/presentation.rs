//! Which point is presented next (the paper's section 4.3).

use super::options::Presentation;
use super::random::Random;

/// The order in which points are presented.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Order {
    pub(super) kind: Presentation,
    pub(super) points: usize,
    /// Shuffled: this epoch's order. Skip-reached: the points that are still presented. Random:
    /// empty, since it needs none.
    pub(super) pool: Vec<u32>,
    /// Place in `pool` of the last presented point.
    pub(super) place: usize,
}

impl Order {
    pub(super) fn new(kind: Presentation, points: usize) -> Self {
        let pool = if kind == Presentation::Random {
            Vec::new()
        } else {
            (0..u32::try_from(points).unwrap_or(u32::MAX)).collect()
        };
        Self { kind, points, pool, place: usize::MAX }
    }

    /// The next point's index, or `None` if none is left to present.
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

    /// Whether an order that was read from bytes can be followed.
    pub(super) fn is_sound(&self) -> bool {
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

    /// Takes the point that was presented last out of the game, if reached points are skipped.
    pub(super) fn retire(&mut self) {
        if self.kind == Presentation::SkipReached {
            self.pool.swap_remove(self.place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shuffled_presents_each_once_an_epoch() {
        let mut random = Random::new(1);
        let mut order = Order::new(Presentation::Shuffled, 10);
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
    fn retired_points_do_not_come_back() {
        let mut random = Random::new(1);
        let mut order = Order::new(Presentation::SkipReached, 5);
        let mut seen = Vec::new();
        while let Some(index) = order.next(&mut random) {
            seen.push(index);
            order.retire();
        }
        seen.sort_unstable();
        assert_eq!(seen, [0, 1, 2, 3, 4]);
    }
}
