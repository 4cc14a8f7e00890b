//! Random numbers of a training. Their count is saved, so that a loaded map continues the sequence.

use std::collections::BTreeSet;

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// PCG64 with a count of the numbers drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Random {
    generator: Pcg64,
    draws: u64,
}

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self { generator: Pcg64::seed_from_u64(seed), draws: 0 }
    }

    /// The generator after `draws` numbers.
    pub(super) fn after(seed: u64, draws: u64) -> Self {
        let mut random = Self::new(seed);
        random.generator.advance(u128::from(draws));
        random.draws = draws;
        random
    }

    pub(super) fn draws(&self) -> u64 {
        self.draws
    }

    fn number(&mut self) -> u64 {
        self.draws += 1;
        self.generator.next_u64()
    }

    /// An integer from 0 to `count - 1`, from one draw. The bias of `count` in 2⁶⁴ is negligible.
    pub(super) fn index(&mut self, count: usize) -> usize {
        let wide = u128::from(self.number()) * count as u128;
        #[expect(clippy::cast_possible_truncation, reason = "less than `count`")]
        let index = (wide >> 64) as usize;
        index
    }

    /// A number in [0, 1) with 53 random bits.
    pub(super) fn unit(&mut self) -> f64 {
        (self.number() >> 11) as f64 * (-53.0_f64).exp2()
    }

    /// `count` distinct integers from 0 to `total - 1`, ascending (Floyd's sampling).
    pub(super) fn sample(&mut self, count: usize, total: usize) -> Vec<usize> {
        let mut chosen = BTreeSet::new();
        for last in total - count..total {
            let index = self.index(last + 1);
            if !chosen.insert(index) {
                chosen.insert(last);
            }
        }
        chosen.into_iter().collect()
    }

    /// Shuffles `values` (Fisher-Yates).
    pub(super) fn shuffle<T>(&mut self, values: &mut [T]) {
        for last in (1..values.len()).rev() {
            values.swap(last, self.index(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_resumes_the_sequence() {
        let mut random = Random::new(7);
        for _ in 0..5 {
            random.index(10);
        }
        let mut later = Random::after(7, random.draws());
        assert_eq!(later.unit(), random.unit());
        assert_eq!(later, random);
    }

    #[test]
    fn samples_are_uniform_without_repetition() {
        let mut random = Random::new(2);
        let mut chosen = [0; 6];
        for _ in 0..10_000 {
            let sample = random.sample(3, 6);
            assert!(sample.windows(2).all(|pair| pair[0] < pair[1]) && sample.len() == 3);
            for &index in &sample {
                chosen[index] += 1;
            }
        }
        // 5,000 each, with a standard deviation of 50.
        assert!(chosen.iter().all(|&count| (4_750..5_250).contains(&count)), "{chosen:?}");
        assert_eq!(random.sample(4, 4), [0, 1, 2, 3]);
    }

    #[test]
    fn shuffles_are_uniform() {
        let mut random = Random::new(1);
        let mut first = [0; 5];
        for _ in 0..10_000 {
            let mut values = [0, 1, 2, 3, 4];
            random.shuffle(&mut values);
            first[values[0]] += 1;
            assert!((0.0..1.0).contains(&random.unit()));
        }
        // 2,000 each, with a standard deviation of 40.
        assert!(first.iter().all(|&count| (1_800..2_200).contains(&count)), "{first:?}");
    }
}
