//! What many points find on a lattice that does not move: winners, distances, sums.

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::Candidates;
use super::frame::Frame;
use super::sums::BatchSums;
use crate::error::Result;
use crate::point_cloud::Bounds;

/// Points between two reports, some ten milliseconds.
const POINTS_PER_REPORT: usize = 1 << 18;

/// Points to a task of a thread: enough to have many in each part of the space, few enough to stay
/// in the core's own cache.
const POINTS_PER_TASK: usize = 1 << 15;

/// The square of each point's distance to its nearest node.
pub(super) fn distances_squared(nodes: &[DVec3], frame: &Frame, points: &[DVec3]) -> Vec<f64> {
    let mut distances = vec![0.0; points.len()];
    // No report, no interruption.
    let _ = fill(nodes, frame, points, &mut distances, &mut |_| Ok(()), |tree, point| {
        tree.nearest(point).1
    });
    distances
}

/// Writes into `out` what `ask` answers for each point, in order; `report` is told from time to
/// time how many are done.
pub(super) fn fill<T: Send>(
    nodes: &[DVec3],
    frame: &Frame,
    points: &[DVec3],
    out: &mut [T],
    report: &mut dyn FnMut(usize) -> Result<()>,
    ask: impl Fn(&Candidates<'_>, DVec3) -> T + Sync,
) -> Result<()> {
    let tree = Candidates::new(nodes, &local_bounds(frame, points), points.len(), 1);
    fill_from(&tree, frame, points, out, report, ask)
}

/// As [`fill`], from a tree of the caller's.
pub(super) fn fill_from<T: Send>(
    tree: &Candidates<'_>,
    frame: &Frame,
    points: &[DVec3],
    out: &mut [T],
    report: &mut dyn FnMut(usize) -> Result<()>,
    ask: impl Fn(&Candidates<'_>, DVec3) -> T + Sync,
) -> Result<()> {
    let slabs = points.chunks(POINTS_PER_REPORT).zip(out.chunks_mut(POINTS_PER_REPORT));
    for (number, (points, out)) in slabs.enumerate() {
        report(number * POINTS_PER_REPORT)?;
        let tasks = points.par_chunks(POINTS_PER_TASK).zip(out.par_chunks_mut(POINTS_PER_TASK));
        tasks.for_each(|(points, out)| {
            for index in tree.order(points, frame) {
                let index = index as usize;
                out[index] = ask(tree, frame.apply(points[index]));
            }
        });
    }
    Ok(())
}

/// Adds points to the sums of their winners.
pub(super) fn accumulate(
    nodes: &[DVec3],
    points: &[DVec3],
    bounds: &Bounds,
    reach: f64,
    sums: &mut BatchSums,
    report: &mut dyn FnMut() -> Result<()>,
) -> Result<()> {
    let (frame, step) = (sums.frame, sums.step);
    let (grains, reach_squared) = (frame.grains_per_unit(), reach * reach);
    let local = local_box(&frame, bounds);
    let tree = Candidates::new(nodes, &local, points.len(), 1);
    let empty = || BatchSums::new(frame, nodes.len(), step);
    let add = |mut part: BatchSums, points: &[DVec3]| {
        for index in tree.order(points, &frame) {
            let point = frame.apply(points[index as usize]);
            let (winner, squared) = tree.nearest(point);
            part.add(winner, point, squared.sqrt(), grains);
            part.reached += u64::from(squared <= reach_squared);
        }
        part
    };
    // Each part has sums for all nodes: there should be many more points to a part than nodes.
    let per_report = POINTS_PER_REPORT.max(8 * nodes.len());
    let per_part = POINTS_PER_TASK.max(4 * nodes.len());
    for points in points.chunks(per_report) {
        report()?;
        let parts: Vec<BatchSums> =
            points.par_chunks(per_part).map(|points| add(empty(), points)).collect();
        for part in parts {
            sums.merge(&part)?;
        }
    }
    Ok(())
}

/// The box around points, in the frame's coordinates.
pub(super) fn local_bounds(frame: &Frame, points: &[DVec3]) -> Bounds {
    local_box(frame, &Bounds::of(points))
}

fn local_box(frame: &Frame, bounds: &Bounds) -> Bounds {
    Bounds { min: frame.apply(bounds.min), max: frame.apply(bounds.max) }
}
