//! What is wrong with a surface, whatever its distance from the points.

use glam::DVec2;

use super::job::{BORDER, Fit, Job};
use super::own_frame::Frame;
use crate::error::Result;
use crate::fit::EndedBy;
use crate::inspection::{FoldOver, Overshoot, folds, runaways};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Where a surface folds over or runs away, though its points do not.
pub(super) struct Flaws {
    fold: Option<FoldOver>,
    overshoot: Option<Overshoot>,
    /// Where on the surface.
    pub(super) places: Vec<DVec2>,
}

impl Flaws {
    /// Of a surface on which the job's points have their feet there, and which may lie outside of their hull by such
    /// a share of their longest chord.
    pub(super) fn of(
        surface: &NurbsSurface,
        uv: &[DVec2],
        job: &Job<'_>,
        outside: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let counts = |i: &usize| job.weight(*i) > 0.0;
        let counted: Vec<usize> = (0..job.points.len()).filter(counts).collect();
        let points: Vec<_> = counted.iter().map(|&i| job.points[i]).collect();
        let uv: Vec<_> = counted.iter().map(|&i| uv[i]).collect();
        let closed = job.shape.closed().closed();
        // Heights are a function, which cannot fold over however steep it is.
        let folds = match job.shape.base {
            Some(_) => Vec::new(),
            None => folds(surface, &points, observer)?,
        };
        // How far they go was looked at when they were fitted; in another unit nothing else tells.
        let runaways = if job.shape.straight {
            Vec::new()
        } else {
            // Heights end with the rectangle that they stand on.
            let heights = job.shape.base.is_some();
            let wanted = if heights { f64::INFINITY } else { (job.border() - BORDER).max(0.0) };
            runaways(surface, &points, &uv, closed, (outside, wanted), observer)?
        };
        let runaway_places = runaways.iter().map(|(_, flaw)| flaw.uv);
        Ok(Self {
            fold: FoldOver::of(&folds),
            overshoot: Overshoot::of(&runaways),
            places: folds.iter().map(|flaw| flaw.uv).chain(runaway_places).collect(),
        })
    }

    /// At how many places.
    pub(super) fn count(&self) -> usize {
        self.places.len()
    }

    /// Whether there are any that no tolerance, kept, excuses.
    pub(super) fn spoil(&self, fit: &Fit) -> bool {
        self.count() > 0 && fit.ended_by != EndedBy::Tolerance
    }

    /// In words, in the points' own frame.
    pub(super) fn warnings(&self, frame: &Frame) -> impl Iterator<Item = String> {
        let fold = self.fold.map(|fold| FoldOver { place: frame.undo(fold.place), ..fold });
        let overshoot = self.overshoot.map(|found| Overshoot {
            distance: frame.length(found.distance),
            place: frame.undo(found.place),
            ..found
        });
        fold.map(|fold| fold.to_string())
            .into_iter()
            .chain(overshoot.map(|overshoot| overshoot.to_string()))
    }
}
