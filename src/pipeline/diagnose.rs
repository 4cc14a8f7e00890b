//! Findings about the points, the fit and the tolerance, beside those of [`crate::validate`].
//!
//! A closed body and a doubtful kind are defects, too.

use glam::DVec3;

use super::options::ReconstructOptions;
use super::point_deviations::{PointDeviations, count_missed};
use super::ranked_cloud::RankedCloud;
use super::settings::DiagnoseSettings;
use super::surface_fit::SurfaceFit;
use crate::chart::Kind;
use crate::cloud::KdTree;
use crate::diagnostic::{Cause, Diagnostic};
use crate::fit::EndedBy;

const SETTINGS: DiagnoseSettings = DiagnoseSettings::STANDARD;

/// All findings about the points, the fit and the tolerance.
pub(super) fn diagnose(
    given: &[DVec3],
    ranked: &RankedCloud<'_>,
    options: &ReconstructOptions<'_>,
    kind: Kind,
    fit: &SurfaceFit,
    measured: &PointDeviations,
) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    if let Some(no_data) = &ranked.cloud.no_data {
        found.push(Diagnostic::NoData { value: no_data.value, count: no_data.count });
    }
    if ranked.axis_scale != DVec3::ONE && options.axis_scale.is_none() {
        found.push(Diagnostic::MixedUnits { scale: ranked.axis_scale.to_array() });
    }
    found.extend(components(ranked, options));
    found.extend(left_out(given, measured, ranked));
    let observations = ranked.observations;
    let border = observations.border_share() * (observations.points().len() as f64).sqrt();
    if kind != Kind::Torus && border < SETTINGS.max_closed_border {
        found.push(Diagnostic::ClosedBody);
    }
    found.extend(strays_from_points(ranked, options, fit));
    found.extend(tolerance_missed(options, fit, measured));
    found
}

/// Several components that were fitted by one surface.
fn components(ranked: &RankedCloud<'_>, options: &ReconstructOptions<'_>) -> Option<Diagnostic> {
    let sizes = &ranked.cloud.components.sizes;
    let all: usize = sizes.iter().sum();
    let second = *sizes.get(1)?;
    let several =
        options.component.is_none() && second as f64 > SETTINGS.min_component_share * all as f64;
    several.then(|| Diagnostic::Components { sizes: sizes.clone() })
}

/// Points that were left out as outliers, if they are many or lie together.
fn left_out(
    given: &[DVec3],
    measured: &PointDeviations,
    ranked: &RankedCloud<'_>,
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
    let many = count as f64 > SETTINGS.max_left_out_share * points as f64;
    // They lie together if the nearest neighbor of more than half of them is left out, too.
    let together =
        count >= SETTINGS.min_group && 2 * out.iter().filter(|index| beside(index)).count() > count;
    (many || together).then_some(Diagnostic::LeftOut { count, points, together })
}

/// A surface too far from the points: between two layers, or of a kind that does not fit them.
pub(super) fn strays_from_points(
    ranked: &RankedCloud<'_>,
    options: &ReconstructOptions<'_>,
    fit: &SurfaceFit,
) -> Option<Diagnostic> {
    let (frame, observations) = (&ranked.cloud.frame, ranked.observations);
    let diagonal = ranked.diagonal;
    let rms = fit.rms();
    let limit = (SETTINGS.max_noise_ratio * observations.noise())
        .max(SETTINGS.max_diagonal_share * diagonal);
    if !observations.planes().reliable || rms <= limit {
        return None;
    }
    let [rms, noise, diagonal] =
        [rms, observations.noise(), diagonal].map(|length| frame.length_to_given(length));
    Some(match options.kind {
        Some(requested) => Diagnostic::KindDoubtful { requested, rms, diagonal },
        None => Diagnostic::TwoLayers { rms, noise },
    })
}

/// A missed tolerance with its cause.
fn tolerance_missed(
    options: &ReconstructOptions<'_>,
    fit: &SurfaceFit,
    measured: &PointDeviations,
) -> Option<Diagnostic> {
    let tolerance = options.tolerance?;
    let deviations = measured.inlier_deviations();
    let missed = count_missed(&deviations, tolerance);
    let cause = match fit.ended_by {
        EndedBy::MaxControlPoints => Cause::MaxControlPoints,
        EndedBy::Grid => Cause::Grid,
        EndedBy::Noise => Cause::Noise,
        EndedBy::Points => Cause::Points,
        EndedBy::Defects | EndedBy::Tolerance | EndedBy::Exact => Cause::Defects,
    };
    let points = deviations.len();
    (missed > 0).then_some(Diagnostic::ToleranceMissed { tolerance, missed, points, cause })
}
