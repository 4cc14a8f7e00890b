//! Gaussian weights along one side of the lattice.

/// Number of `f64` in the widest vector registers.
pub(super) const LANES: usize = 8;

/// Fills in `exp(-(d / radius)² / 2)` for d = 0, 1, … Each weight follows from the previous one by
/// multiplication, so that a single exponential is needed.
pub(super) fn gaussian_weights(radius: f64, weights: &mut [f64]) {
    let ratio = (-0.5 / (radius * radius)).exp();
    let (mut weight, mut factor, square) = (1.0, ratio, ratio * ratio);
    for value in weights {
        *value = weight;
        weight *= factor;
        factor *= square;
    }
}

/// Weights by the signed distance along a side of the lattice. On a closed side the distance is the
/// shorter way around.
pub(super) struct SideWeights {
    count: usize,
    closed: bool,
    /// For distances from `1 - count` up, padded with zeros to whole registers.
    values: Vec<f64>,
}

impl SideWeights {
    /// All-zero weights for a side of `count` nodes.
    pub(super) fn new(count: usize, closed: bool) -> Self {
        Self { count, closed, values: vec![0.0; 2 * count - 1 + LANES] }
    }

    /// Sets the weights for distances from 0 up.
    pub(super) fn set(&mut self, weights: &[f64]) {
        let (before, after) = self.values.split_at_mut(self.count - 1);
        let reach = if self.closed { self.count / 2 + 1 } else { self.count };
        let (near, far) = after[..self.count].split_at_mut(reach);
        near.copy_from_slice(&weights[..reach]);
        far.iter_mut().rev().zip(&weights[1..]).for_each(|(value, weight)| *value = *weight);
        before.iter_mut().rev().zip(&after[1..]).for_each(|(value, weight)| *value = *weight);
    }

    /// The weights by index difference `other - node`, from `1 - count` up.
    pub(super) fn values(&self) -> &[f64] {
        &self.values[..2 * self.count - 1]
    }

    /// The weights of all nodes around `node`, padded to whole registers.
    pub(super) fn around(&self, node: usize) -> &[f64] {
        &self.values[self.count - 1 - node..][..self.count.next_multiple_of(LANES)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_follow_the_shorter_distance() {
        let mut weights = [0.0; 9];
        gaussian_weights(1.5, &mut weights);
        for (closed, count) in [(false, 9), (true, 9), (true, 8)] {
            let mut side_weights = SideWeights::new(count, closed);
            side_weights.set(&weights[..count]);
            for node in 0..count {
                for (other, weight) in side_weights.around(node)[..count].iter().enumerate() {
                    let apart = node.abs_diff(other);
                    let apart = if closed { apart.min(count - apart) } else { apart };
                    let expected = (-0.5 * (apart as f64 / 1.5).powi(2)).exp();
                    assert!((weight - expected).abs() < 1e-15, "{closed} {node} {other}");
                }
            }
        }
    }
}
