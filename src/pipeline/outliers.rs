//! Weights by which a surface lets outliers go.

use glam::DVec3;

use crate::cloud::{KdTree, Neighbor};
use crate::error::Result;
use crate::fit::{EXACT_ERROR, biweight, cutoff_distance, diameter};
use crate::numeric::median;
use crate::progress::Observer;

/// Points around each whose distances from the surface say what is usual there: where a surface
/// cannot follow a feature, all of them are far from it, and none is an outlier.
const AROUND: usize = 16;

/// Share of the way to the farthest of those that a point may be off the surface without having
/// changed its shape.
const SLIGHT: f64 = 0.1;

/// Weights by Tukey's biweight (see [`biweights`](crate::fit::biweights)), where the usual distance
/// is the median around a point, or of all points if that is more. Only points beyond the reach of
/// all points' median, and beyond `least`, can lose weight.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub(super) fn outlier_weights(
    points: &[DVec3],
    distances: &[f64],
    least: f64,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<f64>>> {
    let usual = median(distances.iter().copied()).max(EXACT_ERROR * diameter(points));
    let near = cutoff_distance(usual).max(least);
    if distances.iter().all(|distance| *distance <= near) {
        return Ok(None);
    }
    let tree = KdTree::over(points, observer)?;
    let weights = tree.map(observer, |index, found: &mut Vec<Neighbor>| {
        let distance = distances[index as usize];
        if distance <= near {
            return 1.0;
        }
        tree.nearest_to(index, AROUND, found);
        if distance <= SLIGHT * found.last().map_or(0.0, Neighbor::distance) {
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
    fn what_is_far_among_near_ones_goes_and_what_is_far_together_stays() {
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
