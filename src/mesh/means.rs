//! Linear maps with few terms: what turns control points into others.

use std::collections::BTreeMap;
use std::ops::{Add, Mul};

/// Terms that are added without a look whether there are more.
const TOGETHER: usize = 4;

/// Weighted means of elements of a slice.
#[derive(Debug, Default)]
pub(super) struct Means {
    /// Indices and weights, mean after mean, each filled up with weights of zero: fewer ends of
    /// loops to be foreseen.
    terms: Vec<[(u32, f64); TOGETHER]>,
    /// The end of each mean's terms.
    ends: Vec<usize>,
}

impl Means {
    /// Appends a mean; weights of the same element add up.
    pub(super) fn push(&mut self, terms: impl IntoIterator<Item = (usize, f64)>) {
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for (index, weight) in terms {
            *sums.entry(index).or_default() += weight;
        }
        let terms: Vec<_> = sums
            .into_iter()
            .filter_map(|(i, weight)| Some((u32::try_from(i).ok()?, weight)))
            .collect();
        for terms in terms.chunks(TOGETHER) {
            let mut together = [(0, 0.0); TOGETHER];
            together[..terms.len()].copy_from_slice(terms);
            self.terms.push(together);
        }
        self.ends.push(self.terms.len());
    }

    /// Appends the means to `out`.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    pub(super) fn of<T>(&self, elements: &[T], out: &mut Vec<T>)
    where
        T: Copy + Default + Add<Output = T>,
        f64: Mul<T, Output = T>,
    {
        let (start, mut from) = (out.len(), 0);
        out.resize(start + self.ends.len(), T::default());
        for (mean, &end) in out[start..].iter_mut().zip(&self.ends) {
            let mut sum = T::default();
            for [a, b, c, d] in &self.terms[from..end] {
                let first = a.1 * elements[a.0 as usize] + b.1 * elements[b.0 as usize];
                sum = sum + (first + (c.1 * elements[c.0 as usize] + d.1 * elements[d.0 as usize]));
            }
            (*mean, from) = (sum, end);
        }
    }
}
