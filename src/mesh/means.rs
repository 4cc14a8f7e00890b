//! Linear maps with few terms: what turns control points into others.

use std::collections::BTreeMap;
use std::ops::{Add, Mul};

/// Weighted means of elements of a slice.
#[derive(Debug, Default)]
pub(super) struct Means {
    /// Indices and weights, mean after mean.
    terms: Vec<(u32, f64)>,
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
        let terms =
            sums.into_iter().filter_map(|(i, weight)| Some((u32::try_from(i).ok()?, weight)));
        self.terms.extend(terms);
        self.ends.push(self.terms.len());
    }

    /// Appends the means to `out`.
    pub(super) fn of<T>(&self, elements: &[T], out: &mut Vec<T>)
    where
        T: Copy + Default + Add<Output = T>,
        f64: Mul<T, Output = T>,
    {
        let mut from = 0;
        out.extend(self.ends.iter().map(|&end| {
            let terms = &self.terms[from..end];
            from = end;
            terms.iter().fold(T::default(), |sum, &(i, weight)| sum + weight * elements[i as usize])
        }));
    }
}
