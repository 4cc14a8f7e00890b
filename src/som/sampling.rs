//! Subsamples of a cloud, and node lists built in steps that can be interrupted.

use glam::DVec3;

use crate::error::Result;
use crate::numeric::mix;
use crate::progress::InterruptCheck;

/// Nodes placed between two reports, a few milliseconds.
const NODES_PER_REPORT: usize = 1 << 16;

/// Most points that the initial positions are computed from. Extent and axes of a cloud show in far
/// fewer.
pub(super) const START_POINTS: usize = 1 << 16;

/// Indices of the points that the initial positions of so many points are computed from, ascending:
/// all, or one of each run of neighbors in their order. It is chosen by a hash, as a regular choice
/// would pick single columns of ordered grids.
pub(super) fn start_indices(count: u64) -> Vec<u64> {
    let run = count.div_ceil(START_POINTS as u64).max(1);
    let starts = (0..count.div_ceil(run)).map(|k| k * run);
    starts.map(|start| start + mix(start) % run.min(count - start)).collect()
}

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
