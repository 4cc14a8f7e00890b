//! Differences and intersections of sorted knots, with repetitions.

/// Returns the elements of the sorted sequence `all` without those of `without`, a subsequence of
/// it.
pub(super) fn difference(all: &[f64], without: &[f64]) -> Vec<f64> {
    let mut without = without.iter().peekable();
    all.iter().copied().filter(|value| without.next_if(|other| *other == value).is_none()).collect()
}

/// Returns the common elements of two sorted sequences, with repetitions.
pub(super) fn intersection(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut b = b.iter().peekable();
    let mut common = Vec::new();
    for value in a {
        while b.next_if(|other| *other < value).is_some() {}
        common.extend(b.next_if(|other| *other == value));
    }
    common
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_respect_multiplicity() {
        assert_eq!(difference(&[1.0, 1.0, 2.0, 3.0, 3.0], &[1.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
