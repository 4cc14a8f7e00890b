//! The tube that points lie on whose loops were not seen.

use super::Start;
use super::candidate::{Candidate, NEARER, Placed, Wanted};
use super::report::Clock;
use super::shape::Shape;
use crate::error::Result;
use crate::progress::Observer;
use crate::topology::{Kind, Pipe, around_axis};

/// How near a tube is around what has a point, which a sheet may cover without a hole.
const CLEARLY_NEARER: f64 = 0.5;

/// How near one around a round pipe is, and that as a share of what the points scatter around it, unless the sheet
/// is so near as it only gets to points that do not scatter.
const AS_NEAR: f64 = 1.2;
const TOO_NEAR: f64 = 0.3;

impl<'a> Wanted<'a> {
    /// The tube instead of a sheet that was found out, if it goes around a long pipe and is nearer to the points, or
    /// as near as they scatter: loops around few of them hide among accidental ones.
    pub(super) fn or_tube(
        &self,
        sheet: Candidate<'a>,
        clock: &mut Clock,
        observer: &mut dyn Observer,
    ) -> Result<Candidate<'a>> {
        let &Self { placed: Placed { frame, sample, .. }, seen, options, .. } = self;
        let free = options.kind.is_none() && options.init == Start::Auto;
        if !free || sheet.job.shape.kind != Kind::Sheet {
            return Ok(sheet);
        }
        let pipe = match seen {
            Some(seen) => seen.pipe(&frame.counted(&seen.points)),
            None => around_axis(sample, observer)?,
        };
        clock.lap("topology");
        let Some(Pipe { chart, round, scatter, open }) = pipe else { return Ok(sheet) };
        let chart = frame.undo_chart(chart);
        let tube = self.candidate(Shape::new(Kind::Tube, None), Some(&chart), clock, observer);
        if !(round && open) {
            return sheet.or_nearer(tube, if open { NEARER } else { CLEARLY_NEARER }, 0.0);
        }
        let scatter = AS_NEAR * frame.length(scatter);
        let noise = if sheet.error() > TOO_NEAR * scatter { scatter } else { 0.0 };
        sheet.or_nearer(tube, AS_NEAR, noise.max(self.near_enough()))
    }
}
