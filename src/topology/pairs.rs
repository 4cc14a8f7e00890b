//! Which vertices of a graph are joined.

/// For each vertex those that it is joined with, a bit each.
pub(super) struct Pairs {
    /// How many words a vertex has.
    words: usize,
    bits: Vec<u64>,
}

impl Pairs {
    /// None among so many vertices.
    pub(super) fn none(vertices: usize) -> Self {
        let words = vertices.div_ceil(u64::BITS as usize);
        Self { words, bits: vec![0; words * vertices] }
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        for (own, other) in [(a, b), (b, a)] {
            self.bits[own as usize * self.words + (other / u64::BITS) as usize] |=
                1 << (other % u64::BITS);
        }
    }

    /// What a vertex is joined with.
    pub(super) fn of(&self, vertex: u32) -> &[u64] {
        &self.bits[vertex as usize * self.words..][..self.words]
    }
}

/// The vertices whose bits are set, ascending.
pub(super) fn set(words: impl Iterator<Item = u64>) -> impl Iterator<Item = u32> {
    (0..).step_by(u64::BITS as usize).zip(words).flat_map(|(first, mut word)| {
        std::iter::from_fn(move || {
            let bit = (word != 0).then(|| word.trailing_zeros())?;
            word &= word - 1;
            Some(first + bit)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_joined_both_ways() {
        let mut pairs = Pairs::none(130);
        for to in [0, 63, 64, 128] {
            pairs.join(129, to);
        }
        let of = |vertex| set(pairs.of(vertex).iter().copied()).collect::<Vec<u32>>();
        assert_eq!(of(129), [0, 63, 64, 128]);
        assert!([0, 63, 64, 128].into_iter().all(|vertex| of(vertex) == [129]));
        assert!(of(1).is_empty());
    }
}
