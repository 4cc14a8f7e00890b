//! The whole job: scattered points in, a surface out.

mod alternatives;
mod candidate;
mod candidates;
mod corners;
mod counted;
mod feet;
mod fitted;
mod flattening;
mod flaws;
mod heights;
mod job;
mod measured;
mod options;
mod outline;
mod own_frame;
mod paper;
mod reconstruction;
mod recover_net;
mod region;
mod relay;
mod relief;
mod report;
mod robust;
mod round;
mod shape;
mod start;
mod strip;
mod telling;
mod torus;
mod tube;
mod units;
mod unwound;

use std::time::Instant;

use glam::DVec3;

use crate::cloud;
use crate::error::Result;
use crate::progress::Observer;

pub use self::candidates::{Candidate, candidates};
pub use self::options::{Aspect, ReconstructOptions, Start};
pub use self::paper::{PaperOptions, reconstruct_paper};
pub use self::reconstruction::Reconstruction;
pub use self::recover_net::recover_net;
pub use self::report::{Deviations, PERCENTILES, Report, TrainingReport};

/// Turns scattered points into a NURBS surface; [`Reconstruction::tessellate`] turns that into
/// triangles.
///
/// A map that learns the points from an ordered start brings them in order. Their places on it are
/// parameters, with which least squares with fairness and parameter correction fit the surface.
///
/// # Errors
///
/// Those of [`cloud::check`]; [`crate::Error::Parameter`] for an option out of its range;
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn reconstruct(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    let started = Instant::now();
    options.check(points.len())?;
    let mut found = relay::in_pool(points.len(), observer, |observer| {
        let bounds = cloud::checked_bounds(points, observer)?;
        fitted::reconstruct(points, &bounds, options, observer)
    })?;
    found.report.account_for(started.elapsed());
    Ok(found)
}
