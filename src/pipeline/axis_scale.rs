//! Mixed units: the choice of the axes, and of the divisors of the coordinates for the fit.

use glam::{DMat3, DVec3};

use super::options::ReconstructOptions;
use super::overall_progress::before_phases;
use super::ranked_cloud::{Axes, with_ranked_cloud};
use super::ranking::{Model, ends_search};
use super::settings::AxisScaleSettings;
use crate::chart::Kind;
use crate::cloud::{items_at, random_sample};
use crate::error::Result;
use crate::numeric::quantile;
use crate::observe::ObserveSettings;
use crate::progress::Observer;

const SETTINGS: AxisScaleSettings = AxisScaleSettings::STANDARD;

/// Chooses the axes for the ranking: those given, or scaled ones for a height field.
///
/// Where the extents differ too much for one unit, height fields along z, y and x in scaled units
/// are tried. The first that ends the search is taken. A height field in the given units goes
/// first.
pub(super) fn choose_axes(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Axes> {
    let scale = options.axis_scale.unwrap_or(DVec3::ONE);
    let given = Axes { scale, xyz: DMat3::IDENTITY, kind: options.kind };
    if options.axis_scale.is_some() || !options.kind.is_none_or(|kind| kind == Kind::Height) {
        return Ok(given);
    }
    let Some(extents) = uneven_extents(points) else { return Ok(given) };
    let heights = Axes { kind: Some(Kind::Height), ..given };
    if height_field_fits(points, heights, options, observer)? {
        return Ok(given);
    }
    for xyz in [DMat3::IDENTITY, cycled_axes(2), cycled_axes(1)] {
        let scaled = Axes { scale: extents, xyz, ..heights };
        if height_field_fits(points, scaled, options, observer)? {
            return Ok(scaled);
        }
    }
    Ok(given)
}

/// The extents of points along x, y and z, if they differ too much for one unit.
fn uneven_extents(points: &[DVec3]) -> Option<DVec3> {
    let sample = sampled(points);
    let extent = |axis: usize| {
        let along = || sample.iter().map(|point| point[axis]);
        quantile(along(), 1.0 - SETTINGS.tail_share) - quantile(along(), SETTINGS.tail_share)
    };
    let extents = DVec3::new(extent(0), extent(1), extent(2));
    let uneven = extents.max_element() > SETTINGS.max_extent_ratio * extents.min_element();
    (uneven && extents.min_element() > 0.0).then_some(extents)
}

/// As many points as are observed.
fn sampled(points: &[DVec3]) -> Vec<DVec3> {
    items_at(points, &random_sample(points, ObserveSettings::STANDARD.max_sample))
}

/// The axes x, y and z, shifted cyclically.
fn cycled_axes(by: usize) -> DMat3 {
    DMat3::from_cols(DVec3::AXES[by % 3], DVec3::AXES[(by + 1) % 3], DVec3::AXES[(by + 2) % 3])
}

/// Whether a height field in these axes fits a sample so well that it ends the search.
fn height_field_fits(
    points: &[DVec3],
    axes: Axes,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<bool> {
    let sample = sampled(points);
    let options = ReconstructOptions { weights: None, component: None, ..*options };
    let mut observer = before_phases(observer);
    with_ranked_cloud(&sample, axes, &options, &mut observer, |found, _| {
        let (min_cosine, settings) =
            (found.settings.search.end_search_scaled_min_cosine, &found.settings);
        let ends = |model: &Model| ends_search(model, found.observations, min_cosine, settings);
        Ok(found.ranking.models.first().is_some_and(ends))
    })
}
