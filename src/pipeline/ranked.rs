//! Points made ready, observed, and the ranking of what they may lie on.

use glam::{DMat3, DVec3};

use super::clock::Clock;
use super::options::{ReconstructOptions, Start};
use super::select::{Model, Ranking, SelectSettings, ends_search, rank};
use super::whole::{Part, before};
use crate::chart::{CHARTS, Kind};
use crate::cloud::{Bounds, KdTree, PrepareOptions, PreparedCloud, items_at, random_sample};
use crate::error::Result;
use crate::numeric::quantile;
use crate::observe::{Observations, ObserveSettings};
use crate::progress::Observer;
use crate::validate::DefectSettings;

/// Ratio of the points' extents along x, y and z from which on axes may have different units.
const UNEVEN: f64 = 30.0;

/// Share of the points at either end of an axis that its extent leaves out.
const TAIL: f64 = 0.01;

/// What is known of points before a surface is refined.
pub(super) struct Ranked<'a> {
    pub(super) cloud: &'a PreparedCloud,
    /// Places of the points that were observed, among the cloud's points.
    pub(super) chosen: Vec<u32>,
    /// A tree over many of the cloud's points.
    pub(super) tree: KdTree<'a>,
    /// The observed points.
    pub(super) sample: &'a [DVec3],
    pub(super) seen: &'a Observations<'a>,
    /// The diagonal of their box in the given frame, as a local length.
    pub(super) diagonal: f64,
    pub(super) ranking: Ranking,
    /// What coordinates were divided by.
    pub(super) axis_scale: DVec3,
    pub(super) settings: SelectSettings,
    pub(super) clock: Clock,
}

impl Ranked<'_> {
    /// A direction of the local frame in the given one, of length 1, without rounding errors beside
    /// an axis.
    pub(super) fn given_direction(&self, local: DVec3) -> DVec3 {
        let given = self.cloud.frame.direction_to_given(local).normalize();
        let exact = given.to_array().map(|x| if x.abs() <= f64::EPSILON { 0.0 } else { x });
        DVec3::from_array(exact)
    }
}

/// Prepares, observes and ranks points, and hands on what is known.
///
/// Heights that end the search at once are looked for first. Where extents differ so much that axes
/// may have different units, heights along an axis in scaled units are tried next.
pub(super) fn ranked<T>(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
    then: impl FnOnce(Ranked<'_>, &mut dyn Observer) -> Result<T>,
) -> Result<T> {
    let given = options.axis_scale.unwrap_or(DVec3::ONE);
    let heights = options.kind.is_none_or(|kind| kind == Kind::Height);
    let scale = extents(points).filter(|_| options.axis_scale.is_none() && heights);
    if let Some(scale) = scale
        && !heights_end_search(points, given, DMat3::IDENTITY, options, observer)?
    {
        let turned = [DMat3::IDENTITY, cycled(2), cycled(1)];
        for axes in turned {
            if heights_end_search(points, scale, axes, options, observer)? {
                return stages(points, scale, axes, Some(Kind::Height), options, observer, then);
            }
        }
    }
    stages(points, given, DMat3::IDENTITY, options.kind, options, observer, then)
}

/// The extents of points along x, y and z, if they differ so much that their units may differ.
fn extents(points: &[DVec3]) -> Option<DVec3> {
    let some = sampled(points);
    let extent = |axis: usize| {
        let along = || some.iter().map(|point| point[axis]);
        quantile(along(), 1.0 - TAIL) - quantile(along(), TAIL)
    };
    let extents = DVec3::new(extent(0), extent(1), extent(2));
    let uneven = extents.max_element() > UNEVEN * extents.min_element();
    (uneven && extents.min_element() > 0.0).then_some(extents)
}

/// As many points as are observed.
fn sampled(points: &[DVec3]) -> Vec<DVec3> {
    items_at(points, &random_sample(points, ObserveSettings::default().sample))
}

/// The axes x, y and z moved on by so many.
fn cycled(by: usize) -> DMat3 {
    DMat3::from_cols(DVec3::AXES[by % 3], DVec3::AXES[(by + 1) % 3], DVec3::AXES[(by + 2) % 3])
}

/// Whether heights end the search, with this scale and these axes as x, y and z.
fn heights_end_search(
    points: &[DVec3],
    scale: DVec3,
    axes: DMat3,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<bool> {
    let some = sampled(points);
    let part = ReconstructOptions { weights: None, component: None, ..*options };
    let mut observer = before(observer);
    stages(&some, scale, axes, Some(Kind::Height), &part, &mut observer, |found, _| {
        let (steep, settings) = (found.settings.drop.steep, &found.settings);
        let ends = |model: &Model| ends_search(model, found.seen, steep, settings);
        Ok(found.ranking.models.first().is_some_and(ends))
    })
}

/// The stages up to the ranking, with this scale and these axes as x, y and z.
fn stages<T>(
    points: &[DVec3],
    axis_scale: DVec3,
    axes: DMat3,
    kind: Option<Kind>,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
    then: impl FnOnce(Ranked<'_>, &mut dyn Observer) -> Result<T>,
) -> Result<T> {
    let mut clock = Clock::start();
    let ReconstructOptions { weights, clean, component, .. } = *options;
    let prepare = PrepareOptions { weights, clean, component, axis_scale };
    let (settings, select) = (ObserveSettings::default(), SelectSettings::default());
    let mut part = Part::Prepare.observed(points.len(), settings.sample, observer);
    let cloud = PreparedCloud::of(points, &prepare, &mut part)?;
    let mut part = Part::Select.observed(points.len(), settings.sample, observer);
    clock.lap("prepare");
    let chosen = random_sample(&cloud.points, settings.sample);
    let sample = items_at(&cloud.points, &chosen);
    let many =
        items_at(&cloud.points, &random_sample(&cloud.points, DefectSettings::default().points));
    let seen = Observations::of(&sample, settings);
    clock.lap("observe");
    let local = |axis: DVec3| cloud.frame.direction_to_local(axis).normalize();
    let given = DMat3::from_cols(local(axes.x_axis), local(axes.y_axis), local(axes.z_axis));
    let ranking = match options.init {
        Start::Given { .. } => Ranking::default(),
        start => {
            let allowed: Vec<_> =
                CHARTS.into_iter().filter(|chart| start.allows(chart.name())).collect();
            let found = rank(&seen, given, kind, &allowed, &select, &mut part)?;
            if found.models.is_empty() && allowed.len() < CHARTS.len() {
                rank(&seen, given, kind, &CHARTS, &select, &mut part)?
            } else {
                found
            }
        }
    };
    clock.lap("select");
    let (cloud, frame) = (&cloud, cloud.frame);
    let given_sample: Vec<DVec3> =
        sample.iter().map(|point| frame.to_given(*point) / axis_scale).collect();
    then(
        Ranked {
            cloud,
            chosen,
            tree: KdTree::new(&many),
            sample: &sample,
            seen: &seen,
            diagonal: frame.length_to_local(Bounds::of(&given_sample).diagonal()),
            ranking,
            axis_scale,
            settings: select,
            clock,
        },
        observer,
    )
}
