//! Robust weights: points that the fitted surface shows to be outliers lose their weight.

use glam::DVec3;

use super::settings::SurfaceOutlierSettings;
use crate::cloud::{KdTree, Neighbor};
use crate::error::Result;
use crate::fit::{EXACT_ERROR, biweight, cutoff_distance, diameter};
use crate::numeric::median;
use crate::progress::Observer;

const SETTINGS: SurfaceOutlierSettings = SurfaceOutlierSettings::STANDARD;

/// Weights by Tukey's biweight, see [`biweights`](crate::fit::biweights); `None` if no point loses
/// weight.
///
/// The usual distance is the median around a point, or that of all points if it is larger. Only
/// points farther away than `min_distance` and the reach of the median of all can lose weight.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub(super) fn outlier_weights(
    points: &[DVec3],
    distances: &[f64],
    min_distance: f64,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<f64>>> {
    let usual = median(distances.iter().copied()).max(EXACT_ERROR * diameter(points));
    let near = cutoff_distance(usual).max(min_distance);
    if distances.iter().all(|distance| *distance <= near) {
        return Ok(None);
    }
    let tree = KdTree::over(points, observer)?;
    let weights = tree.map(observer, |index, found: &mut Vec<Neighbor>| {
        let distance = distances[index as usize];
        if distance <= near {
            return 1.0;
        }
        tree.nearest_to(index, SETTINGS.k_neighbors, found);
        let farthest = found.last().map_or(0.0, Neighbor::distance);
        if distance <= SETTINGS.max_slight_ratio * farthest {
            return 1.0;
        }
        let around = median(found.iter().map(|near| distances[near.index as usize]));
        biweight(distance, around.max(usual))
    })?;
    Ok(weights.iter().any(|weight| *weight < 1.0).then_some(weights))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn single_far_points_lose_their_weight_and_groups_keep_it() {
        let points: Vec<DVec3> =
            (0..900_u32).map(|i| DVec3::new(f64::from(i / 30), f64::from(i % 30), 0.0)).collect();
        let mut distances = vec![0.01; 900];
        distances[455] = 3.0;
        distances[..100].fill(2.0);
        let weights = outlier_weights(&points, &distances, 0.0, &mut Silent).unwrap().unwrap();
        assert_eq!(weights[455], 0.0);
        assert!(weights[45] > 0.5);
        assert!(outlier_weights(&points, &[0.01; 900], 0.0, &mut Silent).unwrap().is_none());
    }
}
