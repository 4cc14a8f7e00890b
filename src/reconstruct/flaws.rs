//! What is wrong with a surface, whatever its distance from the points.

use super::job::{Fit, Job};
use crate::error::Result;
use crate::inspection::{FoldOver, Overshoot, fold_over, overshoot};
use crate::point_cloud::Normalization;
use crate::progress::Observer;

/// Where a surface folds over or runs away, though its points do not.
pub(super) struct Flaws {
    fold: Option<FoldOver>,
    overshoot: Option<Overshoot>,
}

impl Flaws {
    pub(super) fn of(fit: &Fit, job: &Job<'_>, observer: &mut dyn Observer) -> Result<Self> {
        let counts = |i: &usize| job.weight(*i) > 0.0;
        let counted: Vec<usize> = (0..job.points.len()).filter(counts).collect();
        let points: Vec<_> = counted.iter().map(|&i| job.points[i]).collect();
        let uv: Vec<_> = counted.iter().map(|&i| fit.uv[i]).collect();
        let closed = job.shape.closed().closed();
        Ok(Self {
            fold: fold_over(&fit.surface, &points, observer)?,
            overshoot: overshoot(&fit.surface, &points, &uv, closed, observer)?,
        })
    }

    /// At how many places.
    pub(super) fn count(&self) -> usize {
        self.fold.map_or(0, |fold| fold.count) + self.overshoot.map_or(0, |found| found.count)
    }

    /// In words, in the points' own frame.
    pub(super) fn warnings(&self, frame: &Normalization) -> impl Iterator<Item = String> {
        let fold = self.fold.map(|fold| FoldOver { place: frame.undo(fold.place), ..fold });
        let overshoot = self.overshoot.map(|found| Overshoot {
            distance: found.distance / frame.scale,
            place: frame.undo(found.place),
            ..found
        });
        fold.map(|fold| fold.to_string())
            .into_iter()
            .chain(overshoot.map(|overshoot| overshoot.to_string()))
    }
}
