//! Subsamples of a cloud, and node lists built in steps that can be interrupted.

use glam::DVec3;

use crate::error::Result;
use crate::progress::InterruptCheck;

/// Nodes placed between two reports, a few milliseconds.
const NODES_PER_REPORT: usize = 1 << 16;

/// At most `count` of the points, evenly spaced in their order.
pub(super) fn subsample(points: &[DVec3], count: usize) -> Vec<DVec3> {
    points.iter().copied().step_by(points.len().div_ceil(count).max(1)).collect()
}

/// Collects `place(node)` for all nodes, in order.
pub(super) fn place_nodes(
    nodes: usize,
    check_interrupt: &mut InterruptCheck<'_>,
    mut place: impl FnMut(usize) -> DVec3,
) -> Result<Vec<DVec3>> {
    let mut places = Vec::with_capacity(nodes);
    for first in (0..nodes).step_by(NODES_PER_REPORT) {
        check_interrupt()?;
        places.extend((first..nodes.min(first + NODES_PER_REPORT)).map(&mut place));
    }
    Ok(places)
}
