//! Points prepared, observed and ranked: the stages before a surface is refined.

use glam::{DMat3, DVec3};

use super::options::{ReconstructOptions, Start};
use super::overall_progress::Phase;
use super::ranking::{Ranking, rank};
use super::settings::RankingSettings;
use super::stage_times::StageTimes;
use crate::chart::{CHARTS, Kind};
use crate::cloud::{Bounds, KdTree, PrepareOptions, PreparedCloud, items_at, random_sample};
use crate::error::Result;
use crate::observe::{Observations, ObserveSettings};
use crate::progress::Observer;
use crate::validate::DefectSettings;

/// The axes in which a cloud is ranked.
#[derive(Clone, Copy)]
pub(super) struct Axes {
    /// Divisors of the given coordinates.
    pub(super) scale: DVec3,
    /// The given axes that stand for x, y and z.
    pub(super) xyz: DMat3,
    /// The only kind that is ranked; `None`: all.
    pub(super) kind: Option<Kind>,
}

/// A prepared cloud with its observations and the ranking of its hypotheses.
pub(super) struct RankedCloud<'a> {
    pub(super) cloud: &'a PreparedCloud,
    /// Indices of the sampled points among the cloud's points.
    pub(super) sample_indices: Vec<u32>,
    /// A tree over the larger sample by which folds are detected.
    pub(super) tree: KdTree<'a>,
    /// The sampled points.
    pub(super) sample: &'a [DVec3],
    /// Observations of the sample.
    pub(super) observations: &'a Observations<'a>,
    /// The diagonal of the sample's box in the given frame, as a local length.
    pub(super) diagonal: f64,
    pub(super) ranking: Ranking,
    /// Divisors of the given coordinates.
    pub(super) axis_scale: DVec3,
    pub(super) settings: RankingSettings,
    pub(super) times: StageTimes,
}

impl RankedCloud<'_> {
    /// A direction of the local frame as a unit vector of the given frame. Components that are
    /// rounding errors become 0.
    pub(super) fn given_direction(&self, local: DVec3) -> DVec3 {
        let given = self.cloud.frame.direction_to_given(local).normalize();
        let exact = given.to_array().map(|x| if x.abs() <= f64::EPSILON { 0.0 } else { x });
        DVec3::from_array(exact)
    }
}

/// Prepares, observes and ranks points, and passes the result to `then`.
pub(super) fn with_ranked_cloud<T>(
    points: &[DVec3],
    axes: Axes,
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
    then: impl FnOnce(RankedCloud<'_>, &mut dyn Observer) -> Result<T>,
) -> Result<T> {
    let mut times = StageTimes::start();
    let ReconstructOptions { weights, clean, component, .. } = *options;
    let prepare = PrepareOptions { weights, clean, component, axis_scale: axes.scale };
    let (settings, select) = (ObserveSettings::STANDARD, RankingSettings::default());
    let mut phase = Phase::Prepare.observed(points.len(), settings.max_sample, observer);
    let cloud = PreparedCloud::of(points, &prepare, &mut phase)?;
    let mut phase = Phase::Rank.observed(points.len(), settings.max_sample, observer);
    times.end_stage("prepare");
    let sample_indices = random_sample(&cloud.points, settings.max_sample);
    let sample = items_at(&cloud.points, &sample_indices);
    let fold_sample = random_sample(&cloud.points, DefectSettings::STANDARD.max_points);
    let fold_sample = items_at(&cloud.points, &fold_sample);
    let observations = Observations::of(&sample, settings);
    times.end_stage("observe");
    let local = |axis: DVec3| cloud.frame.direction_to_local(axis).normalize();
    let xyz =
        DMat3::from_cols(local(axes.xyz.x_axis), local(axes.xyz.y_axis), local(axes.xyz.z_axis));
    let ranking = rank_allowed(&observations, xyz, axes.kind, options.init, &select, &mut phase)?;
    times.end_stage("rank");
    let (cloud, frame) = (&cloud, cloud.frame);
    let given_sample: Vec<DVec3> =
        sample.iter().map(|point| frame.to_given(*point) / axes.scale).collect();
    then(
        RankedCloud {
            cloud,
            sample_indices,
            tree: KdTree::new(&fold_sample),
            sample: &sample,
            observations: &observations,
            diagonal: frame.length_to_local(Bounds::of(&given_sample).diagonal()),
            ranking,
            axis_scale: axes.scale,
            settings: select,
            times,
        },
        observer,
    )
}

/// Ranks the charts that the start of the map allows, and all charts if those propose nothing.
/// Given nodes need no ranking.
fn rank_allowed(
    observations: &Observations<'_>,
    xyz: DMat3,
    kind: Option<Kind>,
    start: Start<'_>,
    settings: &RankingSettings,
    observer: &mut dyn Observer,
) -> Result<Ranking> {
    if let Start::Given { .. } = start {
        return Ok(Ranking::default());
    }
    let allowed: Vec<_> = CHARTS.into_iter().filter(|chart| start.allows(chart.name())).collect();
    let found = rank(observations, xyz, kind, &allowed, settings, observer)?;
    if found.models.is_empty() && allowed.len() < CHARTS.len() {
        return rank(observations, xyz, kind, &CHARTS, settings, observer);
    }
    Ok(found)
}
