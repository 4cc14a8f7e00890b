//! Correlation of neighboring residuals: it separates noise from a surface that cannot follow its
//! points.

use glam::DVec2;

use super::settings::RefinementSettings;
use crate::numeric::min_max;

const SETTINGS: RefinementSettings = RefinementSettings::STANDARD;

/// Whether signed distances are noise. Then neighbors are uncorrelated; those of a surface that
/// cannot follow its points are alike.
pub(super) fn are_noise(uv: &[DVec2], distances: &[f64]) -> bool {
    correlation(uv, distances) < SETTINGS.noise_deviations / (uv.len() as f64).sqrt()
}

/// The correlation of signed distances between neighbors in the parameters. Neighbors are
/// successive points in strips about as wide as their spacing.
fn correlation(uv: &[DVec2], distances: &[f64]) -> f64 {
    let strips = (uv.len() as f64).sqrt();
    let (low, high) = min_max(uv.iter().map(|uv| uv.x));
    let width = (high - low).max(f64::MIN_POSITIVE);
    let strip = |uv: DVec2| (strips * (uv.x - low) / width).floor();
    let mut order: Vec<usize> = (0..uv.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (uv[a], uv[b]);
        strip(a).total_cmp(&strip(b)).then(a.y.total_cmp(&b.y))
    });
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for pair in order.windows(2).filter(|pair| strip(uv[pair[0]]) == strip(uv[pair[1]])) {
        let [a, b] = [pair[0], pair[1]].map(|i| distances[i] - mean);
        covariance += a * b;
        variance += 0.5 * (a * a + b * b);
    }
    if variance > 0.0 { covariance / variance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_uncorrelated_and_waves_are_correlated() {
        // Evenly over the unit square.
        let spread = |i: usize| {
            let at = |share: f64| (0.5 + share * i as f64).fract();
            DVec2::new(at(0.754_877_666_246_693), at(0.569_840_290_998_053))
        };
        let uv: Vec<DVec2> = (0..3000).map(spread).collect();
        let noise: Vec<f64> = (0..uv.len()).map(|i| (1.7 * (i * i % 9973) as f64).sin()).collect();
        assert!(correlation(&uv, &noise).abs() < 0.06, "{}", correlation(&uv, &noise));
        let wave: Vec<f64> =
            uv.iter().map(|uv| (40.0 * uv.x).sin() * (30.0 * uv.y).cos()).collect();
        assert!(correlation(&uv, &wave) > 0.5, "{}", correlation(&uv, &wave));
        assert_eq!(correlation(&uv, &vec![1.0; uv.len()]), 0.0);
    }
}
