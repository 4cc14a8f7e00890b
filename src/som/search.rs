//! What many points find on a lattice that does not move: winners, distances, sums.

use glam::DVec3;
use rayon::prelude::*;

use super::boxes::Boxes;
use super::candidates::{Candidates, Walk};
use super::frame::Frame;
use super::sums::{BatchSums, PartSums};
use crate::error::Result;
use crate::point_cloud::Bounds;
use crate::progress::Listen;

/// Points between two reports, some ten milliseconds.
const POINTS_PER_REPORT: usize = 1 << 18;

/// Points to a task of a thread: enough to have many in each part of the space, few enough to be
/// sorted in the core's own cache.
const POINTS_PER_TASK: usize = 1 << 16;

/// The same where points are asked for more than sums: they may lie far from the lattice, where
/// each looks at many nodes.
const ASKED_PER_REPORT: usize = 1 << 16;
const ASKED_PER_TASK: usize = 1 << 14;

/// Points and each one's rank in the order in which its task looks at them.
pub(super) struct Ordered<'a> {
    frame: Frame,
    points: &'a [DVec3],
    boxes: Boxes,
    ranks: Vec<u32>,
    /// Farthest coordinate from the frame's centre.
    farthest: f64,
}

impl<'a> Ordered<'a> {
    /// Orders points within `bounds` for being looked up among `nodes` nodes.
    pub(super) fn new(
        frame: Frame,
        points: &'a [DVec3],
        bounds: &Bounds,
        nodes: usize,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let local = local(&frame, bounds);
        let boxes = Boxes::new(&local, points.len(), nodes);
        let mut ranks = vec![0; points.len()];
        let slabs = points.chunks(POINTS_PER_REPORT).zip(ranks.chunks_mut(POINTS_PER_REPORT));
        for (points, ranks) in slabs {
            listen()?;
            let tasks = ranks.par_chunks_mut(POINTS_PER_TASK);
            tasks.zip(points.par_chunks(POINTS_PER_TASK)).for_each(|(ranks, points)| {
                boxes.rank(points.iter().map(|&point| frame.apply(point)), ranks);
            });
        }
        let farthest = local.min.abs().max(local.max.abs()).max_element();
        Ok(Self { frame, points, boxes, ranks, farthest })
    }

    /// Adds the points to the sums of their winners.
    pub(super) fn accumulate(
        &self,
        nodes: &[DVec3],
        reach: f64,
        sums: &mut BatchSums,
        listen: &mut Listen<'_>,
    ) -> Result<()> {
        let reach_squared = reach * reach;
        let tree = Candidates::new(nodes, self.boxes, 1, listen)?;
        let scratch = || (tree.walk(), vec![DVec3::ZERO; POINTS_PER_TASK.min(self.points.len())]);
        let task = |(walk, sorted): &mut (Walk<'_>, Vec<DVec3>), pieces: &[(&[DVec3], &[u32])]| {
            let mut part = PartSums::new(&self.frame, nodes.len());
            for (points, ranks) in pieces {
                // Memory is read from one end to the other, and only this copy here and there.
                for (&point, &rank) in points.iter().zip(*ranks) {
                    sorted[rank as usize] = self.frame.apply(point);
                }
                for &point in &sorted[..points.len()] {
                    let (winner, squared) = walk.nearest(point);
                    part.add(winner, point, squared.sqrt(), squared <= reach_squared);
                }
            }
            part
        };
        let pieces: Vec<(&[DVec3], &[u32])> =
            self.points.chunks(POINTS_PER_TASK).zip(self.ranks.chunks(POINTS_PER_TASK)).collect();
        // Each part has sums for all nodes: there should be many more points to a part than nodes.
        let most = PartSums::capacity(&self.frame, self.farthest) / POINTS_PER_TASK;
        let per_part = (4 * nodes.len() / POINTS_PER_TASK).clamp(1, most);
        let per_report = (POINTS_PER_REPORT / POINTS_PER_TASK).max(2 * per_part);
        for pieces in pieces.chunks(per_report) {
            listen()?;
            let tasks = pieces.par_chunks(per_part).map_init(scratch, task);
            for part in tasks.collect::<Vec<PartSums>>() {
                sums.absorb(&part);
            }
        }
        Ok(())
    }
}

/// Asks something of the nearest node or two of points within bounds, and hands on the answers
/// piece by piece, in order; `report` is told how many are done.
pub(super) fn ask<T: Send + Clone + Default>(
    nodes: &[DVec3],
    frame: &Frame,
    (points, bounds): (&[DVec3], &Bounds),
    wanted: usize,
    report: &mut dyn FnMut(usize) -> Result<()>,
    ask: impl Fn(&mut Walk<'_>, DVec3) -> T + Sync,
    mut take: impl FnMut(&[T]),
) -> Result<()> {
    let boxes = Boxes::new(&local(frame, bounds), points.len(), nodes.len());
    let tree = Candidates::new(nodes, boxes, wanted, &mut || report(0))?;
    let mut answers = vec![T::default(); points.len().min(ASKED_PER_REPORT)];
    for (number, points) in points.chunks(ASKED_PER_REPORT).enumerate() {
        report(number * ASKED_PER_REPORT)?;
        let answers = &mut answers[..points.len()];
        let tasks = answers.par_chunks_mut(ASKED_PER_TASK);
        tasks.zip(points.par_chunks(ASKED_PER_TASK)).for_each(|(answers, points)| {
            let mut walk = tree.walk();
            for index in boxes.order(points.iter().map(|&point| frame.apply(point))) {
                answers[index] = ask(&mut walk, frame.apply(points[index]));
            }
        });
        take(answers);
    }
    Ok(())
}

/// Bounds in the frame's coordinates.
fn local(frame: &Frame, bounds: &Bounds) -> Bounds {
    Bounds { min: frame.apply(bounds.min), max: frame.apply(bounds.max) }
}
