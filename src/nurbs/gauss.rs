//! Gauss-Legendre quadrature rules, and the accuracy that integrals accept.

use super::basis::MAX_ORDER;
use crate::error::{Error, Result};

/// Maximal number of nodes: twice the highest order of a spline.
const MAX_POINTS: usize = 2 * MAX_ORDER;

/// Returns the nodes in (0, 1) and weights (sum 1) of the rule with `count` nodes. It is exact for
/// polynomials of degree `2 count - 1`.
///
/// The nodes are roots of the Legendre polynomial. Newton's method starts from Tricomi's estimate
/// and converges quadratically from the first step (W. Press et al., *Numerical Recipes*, section
/// 4.6).
pub(crate) fn rule(count: usize) -> Vec<(f64, f64)> {
    debug_assert!((1..=MAX_POINTS).contains(&count));
    let n = count as f64;
    let root = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        // Five steps converge to the last bit for all counts up to `MAX_POINTS`.
        for _ in 0..5 {
            let (mut value, mut before) = (1.0, 0.0);
            for k in 0..count {
                let k = k as f64;
                let next = ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0);
                (value, before) = (next, value);
            }
            slope = n * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        ((1.0 - x) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(root).collect()
}

/// Checks the relative accuracy of a length, an area or a volume.
pub(crate) fn check_accuracy(accuracy: f64) -> Result<()> {
    if (1e-14..=1.0).contains(&accuracy) {
        return Ok(());
    }
    Err(Error::parameter("accuracy", "between 1e-14 and 1", accuracy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for count in 1..=MAX_POINTS {
            let rule = rule(count);
            for degree in 0..2 * count {
                let power = i32::try_from(degree).unwrap();
                let sum: f64 = rule.iter().map(|(x, weight)| weight * x.powi(power)).sum();
                assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-13, "{count} {degree}");
            }
        }
    }
}
