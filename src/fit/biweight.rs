//! Robust weights: Tukey's biweight, which removes outliers.

use super::settings::BiweightSettings;

const SETTINGS: BiweightSettings = BiweightSettings::STANDARD;

/// Standard deviations of normal noise for each median absolute deviation.
pub(crate) const MAD_TO_DEVIATION: f64 = 1.4826;

/// Tukey's biweight for distances from a surface, signed or not. It is near 1 for small distances
/// and falls to 0 at 4.7 standard deviations. The median of the absolute distances estimates the
/// standard deviation (J. Tukey 1974; P. Huber, *Robust Statistics*, 1981).
///
/// All weights are 1 if most distances are 0.
///
/// ```
/// use neurbs::fit::biweights;
/// let distances = [0.1, -0.1, 0.2, 0.0, 7.0];
/// let weights = biweights(&distances);
/// assert!(weights[0] > 0.9 && weights[4] == 0.0);
/// ```
#[must_use]
pub fn biweights(distances: &[f64]) -> Vec<f64> {
    let mut sizes: Vec<f64> = distances.iter().map(|distance| distance.abs()).collect();
    let middle = sizes.len() / 2;
    if sizes.is_empty() {
        return Vec::new();
    }
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    distances.iter().map(|distance| biweight(*distance, median)).collect()
}

/// Weights by Tukey's biweight for distances of points in parts. `usual` is the median of all
/// distances, and `around` has the usual distance around each point. A point within the reach of
/// the median of all keeps its weight, and so does one of a group that is as far away.
///
/// ```
/// use neurbs::fit::robust_weights;
/// assert_eq!(robust_weights(&[0.1, 9.0, 9.0], &[0.1, 0.1, 8.0], 0.1)[..2], [1.0, 0.0]);
/// assert!(robust_weights(&[9.0], &[8.0], 0.1)[0] > 0.9);
/// ```
///
/// # Panics
///
/// If the numbers of distances differ.
#[must_use]
pub fn robust_weights(distances: &[f64], around: &[f64], usual: f64) -> Vec<f64> {
    assert_eq!(distances.len(), around.len(), "one usual distance for each point");
    let near = cutoff_distance(usual);
    let weight = |(&distance, &around): (&f64, &f64)| {
        if distance <= near { 1.0 } else { biweight(distance, around.max(usual)) }
    };
    distances.iter().zip(around).map(weight).collect()
}

/// The weight of one distance, for a median of absolute distances.
pub(crate) fn biweight(distance: f64, median: f64) -> f64 {
    let cutoff = cutoff_distance(median);
    let share = if cutoff > 0.0 { distance / cutoff } else { 0.0 };
    if share.abs() < 1.0 { (1.0 - share * share).powi(2) } else { 0.0 }
}

/// The distance from which on the weight is 0, for a median of absolute distances.
pub(crate) fn cutoff_distance(median: f64) -> f64 {
    SETTINGS.cutoff * MAD_TO_DEVIATION * median
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_noise_keeps_most_of_its_weight() {
        // Quantiles of the normal distribution at 5 %, 15 %, ...
        let noise = [1.645, 1.036, 0.674, 0.385, 0.126, -0.126, -0.385, -0.674, -1.036, -1.645];
        let weights = biweights(&noise);
        assert!(weights.iter().all(|weight| *weight > 0.74));
        // At one standard deviation (1 - 1 / 4.7²)².
        let expected = (1.0 - (1.036_f64 / (4.7 * 1.4826 * 0.674)).powi(2)).powi(2);
        assert!((weights[1] - expected).abs() < 1e-12);
    }

    #[test]
    fn exact_points_have_full_weight() {
        assert_eq!(biweights(&[0.0, 0.0, 0.0]), [1.0; 3]);
        assert!(biweights(&[]).is_empty());
    }
}
