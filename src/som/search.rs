//! Parallel nearest-node queries and sums over many points, for fixed node positions.

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;

use super::batch_sums::{BatchSums, PartSums};
use super::frame::Frame;
use super::nearest_lists::{Lookup, NearestLists};
use super::octree::Octree;
use crate::cloud::Bounds;
use crate::error::Result;
use crate::progress::InterruptCheck;
use crate::worker_pool::{self, for_each_task};

/// Points summed between two reports, about ten milliseconds.
const POINTS_PER_REPORT: usize = 1 << 18;

/// Points per task, least and most. Fewer would not repay the start of a task; more would not fit
/// into a core's cache while they are sorted.
const POINTS_PER_TASK: [usize; 2] = [1 << 11, 1 << 16];

/// Target number of tasks for few points, so that all threads get some.
const TARGET_TASKS: usize = 32;

/// Points queried between two reports. Points far from the lattice compare many nodes, so there are
/// fewer than for sums.
const QUERIES_PER_REPORT: usize = 1 << 16;

/// Points per query task, least and most.
const QUERIES_PER_TASK: [usize; 2] = [1 << 8, 1 << 14];

/// Time after which tasks stop so that a report can be made. Where many nodes are equally near, as
/// at the center of a ring, a query compares all of them.
const REPORT_INTERVAL: Duration = Duration::from_millis(30);

/// Points processed between two checks of the clock.
const POINTS_PER_CLOCK_CHECK: usize = 128;

/// Points per task within the limits, as a power of two, so that whole tasks fill a report.
fn per_task(points: usize, [min, max]: [usize; 2]) -> usize {
    points.div_ceil(TARGET_TASKS).next_power_of_two().clamp(min, max)
}

/// Some points and their ranks.
type Piece<'a> = (&'a [DVec3], &'a [u32]);

/// Points, and each one's rank in the Morton order of its task.
pub(super) struct OrderedPoints<'a> {
    frame: Frame,
    points: &'a [DVec3],
    boxes: Octree,
    ranks: Vec<u32>,
    /// Points to a task.
    per_task: usize,
    /// Largest absolute coordinate, in the frame.
    farthest: f64,
}

impl<'a> OrderedPoints<'a> {
    /// Orders points within `bounds` for queries among `nodes` nodes.
    pub(super) fn new(
        frame: Frame,
        points: &'a [DVec3],
        bounds: &Bounds,
        nodes: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let local = local(&frame, bounds);
        let boxes = Octree::new(&local, points.len(), nodes);
        let mut ranks = vec![0; points.len()];
        let per_task = per_task(points.len(), POINTS_PER_TASK);
        let slabs = points.chunks(POINTS_PER_REPORT).zip(ranks.chunks_mut(POINTS_PER_REPORT));
        for (points, ranks) in slabs {
            check_interrupt()?;
            let tasks = ranks.chunks_mut(per_task).zip(points.chunks(per_task));
            for_each_task(tasks, 1, |(): &mut (), (ranks, points)| {
                boxes.morton_ranks(points.iter().map(|&point| frame.apply(point)), ranks);
            });
        }
        let farthest = frame.farthest(bounds);
        Ok(Self { frame, points, boxes, ranks, per_task, farthest })
    }

    /// Adds each point to the sums of its nearest node.
    pub(super) fn accumulate(
        &self,
        nodes: &[DVec3],
        reach: f64,
        sums: &mut BatchSums,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<()> {
        let reach_squared = reach * reach;
        let tree = NearestLists::new(nodes, self.boxes, 1, check_interrupt)?;
        let per_task = self.per_task;
        let scratch = || (tree.lookup(), vec![DVec3::ZERO; per_task.min(self.points.len())]);
        // `begun` is the index of the current piece and of the next point in it.
        let task = |(lookup, sorted): &mut (Lookup<'_>, Vec<DVec3>),
                    pieces: &[Piece<'_>],
                    begun: &mut (usize, usize),
                    end: Instant| {
            let mut part = PartSums::new(&self.frame, nodes.len());
            while let Some((points, ranks)) = pieces.get(begun.0) {
                // The points are read sequentially; only this scratch copy is written out of order.
                for (&point, &rank) in points.iter().zip(*ranks) {
                    sorted[rank as usize] = self.frame.apply(point);
                }
                for some in sorted[begun.1..points.len()].chunks(POINTS_PER_CLOCK_CHECK) {
                    for &point in some {
                        let (winner, squared) = lookup.nearest(point);
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
        // Each part has sums for all nodes, so a part should have many more points than there are
        // nodes.
        let max_per_part = PartSums::capacity(&self.frame, self.farthest) / per_task;
        let per_part = (4 * nodes.len() / per_task).clamp(1, max_per_part);
        let per_report = (POINTS_PER_REPORT / per_task).max(2 * per_part);
        for pieces in pieces.chunks(per_report) {
            let mut begun = vec![(0, 0); pieces.len().div_ceil(per_part)];
            let mut unfinished = true;
            while unfinished {
                check_interrupt()?;
                let end = Instant::now() + REPORT_INTERVAL;
                let tasks = pieces.par_chunks(per_part).zip(&mut begun);
                let parts = tasks.map_init(scratch, |scratch, (pieces, begun)| {
                    task(scratch, pieces, begun, end)
                });
                for part in worker_pool::install(|| parts.collect::<Vec<PartSums>>()) {
                    sums.absorb(&part);
                }
                let mut tasks = pieces.chunks(per_part).zip(&begun);
                unfinished = tasks.any(|(pieces, begun)| begun.0 < pieces.len());
            }
        }
        Ok(())
    }
}

/// Computes `query(lookup, point)` for each point within `bounds`, in parallel. `take` receives the
/// results in pieces, in order; `report` receives the number of finished points.
pub(super) fn query<T: Send + Clone + Default>(
    nodes: &[DVec3],
    frame: &Frame,
    (points, bounds): (&[DVec3], &Bounds),
    k_nearest: usize,
    report: &mut dyn FnMut(usize) -> Result<()>,
    query: impl Fn(&mut Lookup<'_>, DVec3) -> T + Sync,
    mut take: impl FnMut(&[T]),
) -> Result<()> {
    let boxes = Octree::new(&local(frame, bounds), points.len(), nodes.len());
    let tree = NearestLists::new(nodes, boxes, k_nearest, &mut || report(0))?;
    let mut answers = vec![T::default(); points.len().min(QUERIES_PER_REPORT)];
    let per_task = per_task(points.len(), QUERIES_PER_TASK);
    for (number, points) in points.chunks(QUERIES_PER_REPORT).enumerate() {
        let answers = &mut answers[..points.len()];
        let mut begun = vec![0; points.len().div_ceil(per_task)];
        let mut done = 0;
        while done < points.len() {
            report(number * QUERIES_PER_REPORT + done)?;
            let end = Instant::now() + REPORT_INTERVAL;
            let tasks = answers.chunks_mut(per_task).zip(points.chunks(per_task)).zip(&mut begun);
            for_each_task(tasks, 1, |(): &mut (), ((answers, points), begun)| {
                let mut lookup = tree.lookup();
                let order = boxes.morton_order(points.iter().map(|&point| frame.apply(point)));
                for index in order.skip(*begun) {
                    answers[index] = query(&mut lookup, frame.apply(points[index]));
                    *begun += 1;
                    if begun.is_multiple_of(POINTS_PER_CLOCK_CHECK) && Instant::now() >= end {
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
