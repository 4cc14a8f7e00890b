//! Outliers that only the surface shows.

use glam::DVec3;

use crate::error::Result;
use crate::fit::{biweight, reach};
use crate::point_cloud::KdTree;
use crate::progress::Observer;

/// Points near one another, in a tree's order, whose distances from the surface say what is usual
/// there: where a surface cannot follow a feature, all of them are far from it, and none is an
/// outlier.
const TOGETHER: usize = 16;

/// Weights by Tukey's biweight (see [`biweights`](crate::fit::biweights)), where what is usual is
/// the median of the distances around a point, or of all if that is more; `None` if no point is an
/// outlier.
pub(super) fn weights(
    points: &[DVec3],
    distances: &[f64],
    observer: &mut dyn Observer,
) -> Result<Option<Vec<f64>>> {
    let usual = median(&mut distances.to_vec());
    let reach = reach(usual);
    if distances.iter().all(|distance| *distance <= reach) {
        return Ok(None);
    }
    let tree = KdTree::over(points, observer)?;
    let order = tree.order();
    let mut weights = vec![1.0; points.len()];
    for first in (0..order.len()).step_by(TOGETHER) {
        // The last are taken together with those before them.
        let from = first.min(order.len().saturating_sub(TOGETHER));
        let together = &order[from..order.len().min(from + TOGETHER)];
        let distance = |&index: &u32| distances[index as usize];
        let there = median(&mut together.iter().map(distance).collect::<Vec<f64>>()).max(usual);
        for index in &together[first - from..] {
            weights[*index as usize] = biweight(distance(index), there);
        }
    }
    Ok(weights.contains(&0.0).then_some(weights))
}

/// The upper median; 0 of nothing.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
