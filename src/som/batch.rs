//! Batch training: Kohonen's batch map, an epoch at a time.

use glam::DVec3;

use super::search::Ordered;
use super::smoothing::smooth;
use super::sums::BatchSums;
use super::{SelfOrganizingMap, StoppedBy};
use crate::cloud::Bounds;
use crate::error::Result;
use crate::progress::Observer;

/// Runs epochs until a criterion ends them.
pub(super) fn train(
    map: &mut SelfOrganizingMap,
    points: &[DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<()> {
    let ordered = order(map, points, bounds, observer)?;
    while map.stopped_by == StoppedBy::Unfinished {
        let sums = accumulate(map, &ordered, observer)?;
        if sums.reached == points.len() as u64 {
            map.note(&sums);
            map.stopped_by = StoppedBy::Reached;
            break;
        }
        let shown = end_epoch(map, &sums, observer)?;
        if map.settled() {
            map.stopped_by = StoppedBy::Settled;
        }
        map.stop_at_last_step();
        shown?;
    }
    map.report(observer)
}

/// Brings points within `bounds` in an order that all epochs use.
pub(super) fn order<'a>(
    map: &SelfOrganizingMap,
    points: &'a [DVec3],
    bounds: &Bounds,
    observer: &mut dyn Observer,
) -> Result<Ordered<'a>> {
    Ordered::new(map.frame, points, bounds, map.nodes.len(), &mut || map.report(observer))
}

/// The sums over points, for the lattice as it is.
pub(super) fn accumulate(
    map: &SelfOrganizingMap,
    points: &Ordered<'_>,
    observer: &mut dyn Observer,
) -> Result<BatchSums> {
    let mut sums = BatchSums::new(map.frame, map.nodes.len(), map.steps);
    points.accumulate(&map.nodes, map.plan.reach, &mut sums, &mut || map.report(observer))?;
    Ok(sums)
}

/// Moves the lattice to where the sums want it. An interruption before leaves it as it is; the
/// inner result is the observer's answer after.
pub(super) fn end_epoch(
    map: &mut SelfOrganizingMap,
    sums: &BatchSums,
    observer: &mut dyn Observer,
) -> Result<Result<()>> {
    let (plan, radius) = (&map.plan, map.radius());
    let mut listen = || map.report(observer);
    let channels = sums.channels();
    let places =
        smooth(&map.lattice, &channels, plan.neighborhood, plan.kernel, radius, &mut listen)?;
    let mut farthest: f64 = 0.0;
    for (node, place) in map.nodes.iter_mut().zip(places) {
        // A node that nothing weighs on stays.
        let place = place.unwrap_or(*node);
        farthest = farthest.max(node.distance_squared(place));
        *node = place;
    }
    map.note(sums);
    map.change = Some(farthest.sqrt());
    map.steps += 1;
    Ok(map.show(&map.nodes, observer))
}
