//! What is wrong with a surface, whatever its distance from the points.

use glam::DVec2;

use super::job::{BORDER, Fit, Job};
use crate::error::Result;
use crate::fit::EndedBy;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::validate::{Flaw, Samples, folds, run_out, runaways};

/// Where a surface folds over or runs away, though its points do not.
pub(super) struct Flaws {
    folds: Vec<Flaw>,
    /// With their distances from the points.
    runaways: Vec<(f64, Flaw)>,
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
        if job.shape.straight {
            // How far heights go was looked at when they were fitted; in another unit nothing else tells.
            return Ok(Self { folds: Vec::new(), runaways: Vec::new() });
        }
        let points = job.counted();
        let uv: Vec<_> = (0..uv.len()).filter(|&i| job.weight(i) > 0.0).map(|i| uv[i]).collect();
        let closed = job.shape.closed().closed();
        let samples = Samples::of(surface, observer)?;
        let heights = job.shape.base.is_some();
        // Heights are a function, which cannot fold over however steep it is.
        let folds = if heights { Vec::new() } else { folds(&samples, &points) };
        // Heights end with the rectangle that they stand on.
        let wanted = if heights { f64::INFINITY } else { (job.border() - BORDER).max(0.0) };
        let runaways = runaways(&samples, &points, &uv, closed, (outside, wanted));
        Ok(Self { folds, runaways })
    }

    /// At how many places.
    pub(super) fn count(&self) -> usize {
        self.folds.len() + self.runaways.len()
    }

    /// Whether it folds over there, or runs out of the hull of the job's points.
    pub(super) fn are_wild(&self, job: &Job<'_>) -> bool {
        let places = self.runaways.iter().map(|(_, flaw)| flaw.place);
        // Heights end with the rectangle that they stand on.
        let bounded = job.shape.base.is_none();
        !self.folds.is_empty() || bounded && run_out(&job.counted(), places)
    }

    /// Where on the surface.
    pub(super) fn places(&self) -> Vec<DVec2> {
        let runaways = self.runaways.iter().map(|(_, flaw)| flaw);
        self.folds.iter().chain(runaways).map(|flaw| flaw.uv).collect()
    }

    /// Whether there are any that no tolerance, kept, excuses.
    pub(super) fn spoil(&self, fit: &Fit) -> bool {
        self.count() > 0 && fit.ended_by != EndedBy::Tolerance
    }
}
