//! Batch training: Kohonen's batch map, an epoch at a time.

use glam::DVec3;

use super::smoothing::smooth;
use super::sums::BatchSums;
use super::{SelfOrganizingMap, StoppedBy, search};
use crate::error::Result;
use crate::point_cloud::Bounds;
use crate::progress::Observer;

/// Runs epochs until a criterion ends them.
pub(super) fn train(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<()> {
    while map.stopped_by == StoppedBy::Unfinished {
        let sums = accumulate(map, points, bounds, observer)?;
        if sums.reached == points.len() as u64 {
            map.note(&sums);
            map.stopped_by = StoppedBy::Reached;
            break;
        }
        let shown = end_epoch(map, &sums, observer);
        if map.settled() {
            map.stopped_by = StoppedBy::Settled;
        }
        map.stop_at_last_step();
        shown?;
    }
    map.report(observer)
}

/// The sums over points within `bounds`, for the lattice as it is.
pub(super) fn accumulate(
    map: &SelfOrganizingMap,
    points: &[DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<BatchSums> {
    let mut sums = BatchSums::new(map.frame, map.nodes.len(), map.steps);
    let mut report = || map.report(observer);
    search::accumulate(&map.nodes, points, bounds, map.plan.reach, &mut sums, &mut report)?;
    Ok(sums)
}

/// Moves the lattice to where the sums want it.
pub(super) fn end_epoch(
    map: &mut SelfOrganizingMap,
    sums: &BatchSums,
    observer: &mut dyn Observer,
) -> Result<()> {
    map.note(sums);
    let plan = &map.plan;
    let radius = plan.radius_at(map.steps);
    let places = smooth(&map.lattice, &sums.channels(), plan.neighborhood, plan.kernel, radius);
    let mut farthest: f64 = 0.0;
    for (node, place) in map.nodes.iter_mut().zip(places) {
        // A node that nothing weighs on stays.
        let place = place.unwrap_or(*node);
        farthest = farthest.max(node.distance_squared(place));
        *node = place;
    }
    map.change = Some(farthest.sqrt());
    map.steps += 1;
    map.show(&map.nodes, observer)
}
