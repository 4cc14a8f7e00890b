//! Lengths along chains.

/// Cumulative sums as shares of the last one, from 0 to 1.
pub(super) fn shares(steps: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    sums.extend(steps.map(|step| {
        sum += step;
        sum
    }));
    let total = if sum > 0.0 { sum } else { 1.0 };
    sums.into_iter().map(|sum| sum / total).collect()
}
