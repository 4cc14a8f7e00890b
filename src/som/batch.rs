//! Batch training: Kohonen's batch map, one epoch at a time.

use glam::DVec3;

use super::batch_sums::BatchSums;
use super::map::SelfOrganizingMap;
use super::search::OrderedPoints;
use super::smoothing::smooth;
use super::stop_criterion::StoppedBy;
use crate::cloud::Bounds;
use crate::error::Result;
use crate::progress::Observer;

/// Runs epochs until a stop criterion is met.
pub(super) fn train(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<()> {
    let ordered = order(map, points, bounds, observer)?;
    while map.stopped_by == StoppedBy::Unfinished {
        let sums = accumulate(map, &ordered, observer)?;
        train_epoch(map, &sums, observer)?;
    }
    map.report(observer)
}

/// Ends an epoch with the sums over all points, and the training if a stop criterion is met.
pub(super) fn train_epoch(
    map: &mut SelfOrganizingMap,
    sums: &BatchSums,
    observer: &mut dyn Observer,
) -> Result<()> {
    if sums.reached == sums.points() {
        map.record_epoch(sums);
        map.stopped_by = StoppedBy::Reached;
        return Ok(());
    }
    let shown = end_epoch(map, sums, observer)?;
    if map.settled() {
        map.stopped_by = StoppedBy::Settled;
    }
    map.stop_at_last_step();
    shown
}

/// Sorts points within `bounds` into an order that all epochs share.
pub(super) fn order<'a>(
    map: &SelfOrganizingMap,
    points: &'a [DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<OrderedPoints<'a>> {
    OrderedPoints::new(map.frame, points, bounds, map.nodes.len(), &mut || map.report(observer))
}

/// Sums the points of each node, for the current node positions.
pub(super) fn accumulate(
    map: &SelfOrganizingMap,
    points: &OrderedPoints<'_>,
    observer: &mut dyn Observer,
) -> Result<BatchSums> {
    let mut sums = BatchSums::new(map.frame, map.nodes.len(), map.steps);
    points.accumulate(&map.nodes, map.plan.reach, &mut sums, &mut || map.report(observer))?;
    Ok(sums)
}

/// Moves the nodes to the smoothed means of `sums`. If the observer interrupts before, the map
/// stays unchanged. The inner result is the observer's answer after the epoch.
pub(super) fn end_epoch(
    map: &mut SelfOrganizingMap,
    sums: &BatchSums,
    observer: &mut dyn Observer,
) -> Result<Result<()>> {
    let (plan, radius) = (&map.plan, map.radius());
    let mut check_interrupt = || map.report(observer);
    let channels = sums.channels();
    let places = smooth(
        &map.lattice,
        &channels,
        plan.neighborhood,
        plan.kernel,
        radius,
        &mut check_interrupt,
    )?;
    let mut farthest: f64 = 0.0;
    for (node, place) in map.nodes.iter_mut().zip(places) {
        // A node with no weighted points stays where it is.
        let place = place.unwrap_or(*node);
        farthest = farthest.max(node.distance_squared(place));
        *node = place;
    }
    map.record_epoch(sums);
    map.change = Some(farthest.sqrt());
    map.steps += 1;
    Ok(map.report_epoch(&map.nodes, observer))
}
