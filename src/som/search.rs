//! What many points find on a lattice that does not move: winners, distances, sums.

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;

use super::boxes::Boxes;
use super::candidates::{Candidates, Walk};
use super::frame::Frame;
use super::sums::{BatchSums, PartSums};
use crate::cloud::Bounds;
use crate::error::Result;
use crate::progress::Listen;

/// Points between two reports, some ten milliseconds.
const POINTS_PER_REPORT: usize = 1 << 18;

/// Points to a task of a thread, at least: enough to be worth waking another one; and at most: enough to have many in
/// each part of the space, few enough to be sorted in the core's own cache.
const POINTS_PER_TASK: [usize; 2] = [1 << 11, 1 << 16];

/// Tasks that few points are divided into, so that all threads have some.
const TASKS: usize = 32;

/// The same where points are asked for more than sums: they may lie far from the lattice, where
/// each looks at many nodes.
const ASKED_PER_REPORT: usize = 1 << 16;
const ASKED_PER_TASK: [usize; 2] = [1 << 8, 1 << 14];

/// Time after which tasks give back what they have not done yet, for a report to be made: where
/// many nodes are equally near, as to the middle of a ring, each point looks at all of them.
const SLICE: Duration = Duration::from_millis(30);

/// Points between two looks at the clock.
const POINTS_PER_LOOK: usize = 128;

/// Points to a task, of so many, and within limits: a power of two, so that tasks fill a report.
fn per_task(points: usize, [least, most]: [usize; 2]) -> usize {
    points.div_ceil(TASKS).next_power_of_two().clamp(least, most)
}

/// Some points and their ranks.
type Piece<'a> = (&'a [DVec3], &'a [u32]);

/// Points and each one's rank in the order in which its task looks at them.
pub(super) struct Ordered<'a> {
    frame: Frame,
    points: &'a [DVec3],
    boxes: Boxes,
    ranks: Vec<u32>,
    /// Points to a task.
    per_task: usize,
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
        let per_task = per_task(points.len(), POINTS_PER_TASK);
        let slabs = points.chunks(POINTS_PER_REPORT).zip(ranks.chunks_mut(POINTS_PER_REPORT));
        for (points, ranks) in slabs {
            listen()?;
            let tasks = ranks.par_chunks_mut(per_task);
            tasks.zip(points.par_chunks(per_task)).for_each(|(ranks, points)| {
                boxes.rank(points.iter().map(|&point| frame.apply(point)), ranks);
            });
        }
        let farthest = frame.farthest(bounds);
        Ok(Self { frame, points, boxes, ranks, per_task, farthest })
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
        let per_task = self.per_task;
        let scratch = || (tree.walk(), vec![DVec3::ZERO; per_task.min(self.points.len())]);
        // `begun` is the number of the piece to go on with, and of the point in it.
        let task = |(walk, sorted): &mut (Walk<'_>, Vec<DVec3>),
                    pieces: &[Piece<'_>],
                    begun: &mut (usize, usize),
                    end: Instant| {
            let mut part = PartSums::new(&self.frame, nodes.len());
            while let Some((points, ranks)) = pieces.get(begun.0) {
                // Memory is read from one end to the other, and only this copy here and there.
                for (&point, &rank) in points.iter().zip(*ranks) {
                    sorted[rank as usize] = self.frame.apply(point);
                }
                for some in sorted[begun.1..points.len()].chunks(POINTS_PER_LOOK) {
                    for &point in some {
                        let (winner, squared) = walk.nearest(point);
                        part.add(winner, point, squared.sqrt(), squared <= reach_squared);
                    }
                    begun.1 += some.len();
                    if begun.1 < points.len() && Instant::now() >= end {
                        return part;
                    }
                }
                *begun = (begun.0 + 1, 0);
            }
            part
        };
        let pieces: Vec<Piece<'_>> =
            self.points.chunks(per_task).zip(self.ranks.chunks(per_task)).collect();
        // Each part has sums for all nodes: there should be many more points to a part than nodes.
        let most = PartSums::capacity(&self.frame, self.farthest) / per_task;
        let per_part = (4 * nodes.len() / per_task).clamp(1, most);
        let per_report = (POINTS_PER_REPORT / per_task).max(2 * per_part);
        for pieces in pieces.chunks(per_report) {
            let mut begun = vec![(0, 0); pieces.len().div_ceil(per_part)];
            let mut unfinished = true;
            while unfinished {
                listen()?;
                let end = Instant::now() + SLICE;
                let tasks = pieces.par_chunks(per_part).zip(&mut begun);
                let parts = tasks.map_init(scratch, |scratch, (pieces, begun)| {
                    task(scratch, pieces, begun, end)
                });
                for part in parts.collect::<Vec<PartSums>>() {
                    sums.absorb(&part);
                }
                let mut tasks = pieces.chunks(per_part).zip(&begun);
                unfinished = tasks.any(|(pieces, begun)| begun.0 < pieces.len());
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
    let per_task = per_task(points.len(), ASKED_PER_TASK);
    for (number, points) in points.chunks(ASKED_PER_REPORT).enumerate() {
        let answers = &mut answers[..points.len()];
        let mut begun = vec![0; points.len().div_ceil(per_task)];
        let mut done = 0;
        while done < points.len() {
            report(number * ASKED_PER_REPORT + done)?;
            let end = Instant::now() + SLICE;
            let tasks = answers.par_chunks_mut(per_task);
            let tasks = tasks.zip(points.par_chunks(per_task)).zip(&mut begun);
            tasks.for_each(|((answers, points), begun)| {
                let mut walk = tree.walk();
                let order = boxes.order(points.iter().map(|&point| frame.apply(point)));
                for index in order.skip(*begun) {
                    answers[index] = ask(&mut walk, frame.apply(points[index]));
                    *begun += 1;
                    if begun.is_multiple_of(POINTS_PER_LOOK) && Instant::now() >= end {
                        break;
                    }
                }
            });
            done = begun.iter().sum();
        }
        take(answers);
    }
    Ok(())
}

/// Bounds in the frame's coordinates.
fn local(frame: &Frame, bounds: &Bounds) -> Bounds {
    Bounds { min: frame.apply(bounds.min), max: frame.apply(bounds.max) }
}
