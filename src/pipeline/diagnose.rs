//! What a user should know of points, surface and tolerance.

use glam::DVec3;

use super::fitted::Fitted;
use super::measure::Measured;
use super::options::ReconstructOptions;
use super::ranked::Ranked;
use crate::chart::Kind;
use crate::cloud::KdTree;
use crate::diagnostic::{Cause, Diagnostic};
use crate::fit::EndedBy;

/// When something is said. Sources: calibrated on the scoreboard's clouds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DiagnoseSettings {
    /// Share of border points times the root of their number under which a cloud is closed.
    closed: f64,
    /// Share of the points in a component from which on it is one.
    component: f64,
    /// Share of the points from which on those left out are reported.
    left_out: f64,
    /// Distance of the points from the surface, in their noise and in their diagonal, from which on
    /// it does not follow them.
    astray: (f64, f64),
}

impl Default for DiagnoseSettings {
    fn default() -> Self {
        Self { closed: 0.12, component: 0.1, left_out: 0.01, astray: (3.0, 0.02) }
    }
}

/// What there is to say, beside the defects that the surface itself has.
pub(super) fn diagnose(
    given: &[DVec3],
    ranked: &Ranked<'_>,
    options: &ReconstructOptions<'_>,
    kind: Kind,
    fitted: &Fitted,
    measured: &Measured,
) -> Vec<Diagnostic> {
    let settings = DiagnoseSettings::default();
    let mut found = Vec::new();
    if let Some(no_data) = &ranked.cloud.no_data {
        found.push(Diagnostic::NoData { value: no_data.value, count: no_data.count });
    }
    if ranked.axis_scale != DVec3::ONE && options.axis_scale.is_none() {
        found.push(Diagnostic::MixedUnits { scale: ranked.axis_scale.to_array() });
    }
    found.extend(components(ranked, options, &settings));
    found.extend(left_out(given, measured, ranked, &settings));
    let seen = ranked.seen;
    let border = seen.border_share() * (seen.points().len() as f64).sqrt();
    if kind != Kind::Torus && border < settings.closed {
        found.push(Diagnostic::ClosedBody);
    }
    found.extend(astray(ranked, options, fitted));
    found.extend(missed(options, fitted, measured));
    found
}

fn components(
    ranked: &Ranked<'_>,
    options: &ReconstructOptions<'_>,
    settings: &DiagnoseSettings,
) -> Option<Diagnostic> {
    let sizes = &ranked.cloud.components.sizes;
    let all: usize = sizes.iter().sum();
    let second = *sizes.get(1)?;
    let several = options.component.is_none() && second as f64 > settings.component * all as f64;
    several.then(|| Diagnostic::Components { sizes: sizes.clone(), fitted: None })
}

/// Points that were left out, if they are many or lie together.
fn left_out(
    given: &[DVec3],
    measured: &Measured,
    ranked: &Ranked<'_>,
    settings: &DiagnoseSettings,
) -> Option<Diagnostic> {
    let out = measured.outliers(ranked.cloud);
    let (count, points) = (out.len(), given.len());
    if count == 0 {
        return None;
    }
    let tree = KdTree::new(given);
    let beside = |index: &u32| {
        let mut near = Vec::new();
        tree.nearest_to(*index, 1, &mut near);
        near.first().is_some_and(|near| out.binary_search(&near.index).is_ok())
    };
    let many = count as f64 > settings.left_out * points as f64;
    // A pair may lie together by chance; half of several do not.
    let together = count > 2 && 2 * out.iter().filter(|index| beside(index)).count() > count;
    (many || together).then_some(Diagnostic::LeftOut { count, points, together })
}

/// Whether the surface follows the points: not between two layers, and not of another kind.
pub(super) fn astray(
    ranked: &Ranked<'_>,
    options: &ReconstructOptions<'_>,
    fitted: &Fitted,
) -> Option<Diagnostic> {
    let (frame, seen) = (&ranked.cloud.frame, ranked.seen);
    let (noise, share) = DiagnoseSettings::default().astray;
    let diagonal = ranked.diagonal;
    let rms = fitted.rms();
    if !seen.planes().tell || rms <= (noise * seen.noise()).max(share * diagonal) {
        return None;
    }
    let [rms, noise, diagonal] =
        [rms, seen.noise(), diagonal].map(|length| frame.length_to_given(length));
    Some(match options.kind {
        Some(asked) => Diagnostic::KindDoubtful { asked, rms, diagonal },
        None => Diagnostic::TwoLayers { held_out: rms, noise },
    })
}

/// A tolerance that was missed, and why.
fn missed(
    options: &ReconstructOptions<'_>,
    fitted: &Fitted,
    measured: &Measured,
) -> Option<Diagnostic> {
    let tolerance = options.tolerance?;
    let counted = measured.counted();
    let missed = counted.iter().filter(|deviation| **deviation > tolerance).count();
    let cause = match fitted.ended_by {
        EndedBy::MaxControlPoints => Cause::MaxControlPoints,
        EndedBy::Grid => Cause::Grid,
        EndedBy::Noise => Cause::Noise,
        EndedBy::Points => Cause::Points,
        EndedBy::Defects | EndedBy::Tolerance | EndedBy::Exact => Cause::Defects,
    };
    let points = counted.len();
    (missed > 0).then_some(Diagnostic::ToleranceMissed { tolerance, missed, points, cause })
}
