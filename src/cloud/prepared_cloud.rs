//! The prepared cloud: thinned, cleaned, one component, in the local frame.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::{POINTS_PER_REPORT, centroid};
use super::checks::{check, checked_extent};
use super::clean::{Fate, clean};
use super::components::{Components, components};
use super::even_sample::EvenSample;
use super::frame::Frame;
use super::no_data::{NoData, no_data};
use super::sampling::items_at;
use super::settings::PrepareSettings;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};

const SETTINGS: PrepareSettings = PrepareSettings::STANDARD;

/// Options of the preparation of a cloud.
#[derive(Clone, Copy, Debug)]
pub struct PrepareOptions<'a> {
    /// Weight of each point's squared distance; `None`: 1. Points with weight 0 are left out.
    pub weights: Option<&'a [f64]>,
    /// Whether no-data values and outliers are left out, and duplicates merged.
    pub clean: bool,
    /// The component to keep, 0 being the largest; `None`: all.
    pub component: Option<usize>,
    /// Divisor of each coordinate.
    pub axis_scale: DVec3,
}

impl Default for PrepareOptions<'_> {
    fn default() -> Self {
        Self { weights: None, clean: true, component: None, axis_scale: DVec3::ONE }
    }
}

/// The points that a surface is fitted to, in their local frame.
///
/// They are sorted by their distance from the centroid, the farthest first. The order depends
/// neither on the order nor on the pose of the given points.
#[derive(Clone, Debug)]
pub struct PreparedCloud {
    /// The points in the local frame.
    pub points: Vec<DVec3>,
    /// Weights of the squared distances; `None`: 1. A point that stands for duplicates has the sum
    /// of their weights.
    pub weights: Option<Vec<f64>>,
    /// The index of each point in the given cloud.
    pub indices: Vec<u32>,
    /// Indices of given points that were merged, each with that of the kept point for it.
    pub merged: Vec<(u32, u32)>,
    /// Indices of the gross outliers in the given cloud, ascending.
    pub outliers: Vec<u32>,
    /// The no-data value; points that have it are left out.
    pub no_data: Option<NoData>,
    /// All components, with the labels of the kept points.
    pub components: Components,
    /// The local frame.
    pub frame: Frame,
    /// Whether there were more given points than are fitted.
    pub thinned: bool,
}

impl PreparedCloud {
    /// Prepares a cloud: thins it, cleans it, chooses a component, moves it to the local frame.
    ///
    /// # Errors
    ///
    /// Those of [`check`], for the given points and for those that are left;
    /// [`Error::Parameter`] if the component does not exist; [`Error::Interrupted`].
    pub fn of(
        given: &[DVec3],
        options: &PrepareOptions<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        checked_extent(given, observer)?;
        let no_data = no_data(given).filter(|_| options.clean);
        let has_data = |&index: &u32| {
            let weight = options.weights.map_or(1.0, |weights| weights[index as usize]);
            weight > 0.0 && !no_data.is_some_and(|found| found.has(given[index as usize]))
        };
        let mut indices = thinned(given, observer)?;
        indices.retain(has_data);
        let scaled = |indices: &[u32]| -> Vec<DVec3> {
            indices.iter().map(|&index| given[index as usize] / options.axis_scale).collect()
        };
        let mut points = scaled(&indices);
        checked_extent(&points, observer)?;
        let mut weights = options.weights.map(|weights| items_at(weights, &indices));
        let (mut merged, mut outliers) = (Vec::new(), Vec::new());
        if options.clean {
            let found = clean(&points, observer)?;
            let fates = indices.iter().zip(&found.fates);
            outliers = fates.filter(|(_, fate)| **fate == Fate::Outlier).map(|(i, _)| *i).collect();
            if !found.merged.is_empty() {
                let weights = weights.get_or_insert_with(|| vec![1.0; points.len()]);
                for &(duplicate, keeper) in &found.merged {
                    weights[keeper as usize] += weights[duplicate as usize];
                    merged.push((indices[duplicate as usize], indices[keeper as usize]));
                }
            }
            weights = weights.map(|weights| items_at(&weights, &found.kept));
            indices = items_at(&indices, &found.kept);
            points = items_at(&points, &found.kept);
        }
        let mut components = components(&points, observer)?;
        if let Some(component) = options.component {
            let chosen = chosen(&components, component)?;
            weights = weights.map(|weights| items_at(&weights, &chosen));
            indices = items_at(&indices, &chosen);
            components.labels = items_at(&components.labels, &chosen);
            points = items_at(&points, &chosen);
            let mut is_left = vec![false; given.len()];
            for &index in &indices {
                is_left[index as usize] = true;
            }
            merged.retain(|(_, keeper)| is_left[*keeper as usize]);
        }
        check(&points)?;
        let (frame, points, order) = to_local(&points, options.axis_scale);
        components.labels = items_at(&components.labels, &order);
        Ok(Self {
            points,
            weights: weights.map(|weights| items_at(&weights, &order)),
            indices: items_at(&indices, &order),
            merged,
            outliers,
            no_data,
            components,
            frame,
            thinned: given.len() > SETTINGS.max_points,
        })
    }
}

/// Indices of the points of a component, ascending.
fn chosen(components: &Components, component: usize) -> Result<Vec<u32>> {
    let count = components.sizes.len();
    let number = u32::try_from(component).ok().filter(|_| component < count);
    let must = format!("less than the number of components, {count}");
    let number = number.ok_or_else(|| Error::parameter("component", must, component))?;
    Ok(components.indices(number))
}

/// Indices of all points, or of an even sample of as many as are fitted.
fn thinned(given: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<u32>> {
    if given.len() <= SETTINGS.max_points {
        return Ok((0..).take(given.len()).collect());
    }
    let mut sample = EvenSample::new(SETTINGS.max_points);
    for batch in given.chunks(POINTS_PER_REPORT) {
        let (step, total) = (sample.seen(), given.len());
        let progress = Progress::of_stage(Stage::Cleaning, step, total as u64, total);
        let mut check_interrupt = || progress::report(observer, &progress);
        check_interrupt()?;
        sample.extend_interruptible(batch, &mut check_interrupt)?;
    }
    Ok(sample.indices().into_iter().filter_map(|index| u32::try_from(index).ok()).collect())
}

/// The local frame of scaled points, the points in it, and their order, the farthest first.
fn to_local(scaled: &[DVec3], axis_scale: DVec3) -> (Frame, Vec<DVec3>, Vec<u32>) {
    let order = farthest_first(scaled, centroid(scaled));
    let frame = Frame::of(&items_at(scaled, &order), axis_scale);
    let local: Vec<DVec3> = scaled.par_iter().map(|&point| frame.scaled_to_local(point)).collect();
    // Distances that differ only by rounding are equal in the frame, so the order is found again.
    let order = farthest_first(&local, DVec3::ZERO);
    (frame, items_at(&local, &order), order)
}

/// The order of points by their distance from the center, the farthest first.
fn farthest_first(points: &[DVec3], center: DVec3) -> Vec<u32> {
    let mut keyed: Vec<(f64, u32)> =
        (0..).zip(points).map(|(index, point)| (point.distance_squared(center), index)).collect();
    keyed.par_sort_unstable_by(|a, b| {
        let [x, y] = [a, b].map(|key| points[key.1 as usize].to_array());
        let places = x.iter().zip(&y).map(|(x, y)| x.total_cmp(y));
        let farther = b.0.total_cmp(&a.0);
        places.fold(farther, Ordering::then).then(a.1.cmp(&b.1))
    });
    keyed.into_iter().map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::progress::Silent;

    fn unit(i: u32) -> (f64, f64) {
        let i = f64::from(i);
        ((i * 0.754_877_666).fract(), (i * 0.569_840_291).fract())
    }

    fn hill(i: u32) -> DVec3 {
        let (x, y) = unit(i);
        DVec3::new(x, y, 0.2 * (3.0 * x).sin() * (2.0 * y).cos())
    }

    fn prepared(points: &[DVec3], options: &PrepareOptions<'_>) -> PreparedCloud {
        PreparedCloud::of(points, options, &mut Silent).unwrap()
    }

    #[test]
    fn each_given_point_is_kept_merged_or_left_out() {
        let mut points: Vec<DVec3> = (0..1000).map(hill).collect();
        points.extend([points[7], points[7], DVec3::new(0.5, 0.5, 1.0)]);
        points.extend((0..200).map(|i| hill(i) + DVec3::Z * 2.0));
        let weights: Vec<f64> = (0..points.len()).map(|i| if i == 3 { 0.0 } else { 2.0 }).collect();
        let options = PrepareOptions {
            weights: Some(&weights),
            component: Some(0),
            ..PrepareOptions::default()
        };
        let cloud = prepared(&points, &options);
        assert_eq!(cloud.merged, [(1000, 7), (1001, 7)]);
        assert_eq!(cloud.outliers, [1002]);
        assert_eq!(cloud.components.sizes, [999, 200]);
        assert_eq!((cloud.points.len(), cloud.components.labels.len()), (999, 999));
        let seventh = cloud.indices.iter().position(|&index| index == 7).unwrap();
        assert_eq!(cloud.weights.unwrap()[seventh], 6.0);
        for (&point, &index) in cloud.points.iter().zip(&cloud.indices) {
            assert!(cloud.frame.to_given(point).distance(points[index as usize]) < 1e-8);
        }
        let options = PrepareOptions { component: Some(2), ..PrepareOptions::default() };
        let error = PreparedCloud::of(&points, &options, &mut Silent).unwrap_err();
        assert!(error.to_string().contains("less than the number of components, 2"));
    }

    #[test]
    fn the_cloud_is_the_same_for_any_pose_and_order() {
        let points: Vec<DVec3> = (0..500).map(hill).chain([DVec3::splat(3.0)]).collect();
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
        let moved: Vec<DVec3> =
            points.iter().rev().map(|&p| 0.7 * (turn * p) + DVec3::new(5.0, 9.0, -4.0)).collect();
        let [one, other] =
            [&points, &moved].map(|points| prepared(points, &PrepareOptions::default()));
        assert_eq!(one.points, other.points);
        assert_eq!(one.outliers, [500]);
        assert!(one.indices.iter().zip(&other.indices).all(|(a, b)| a + b == 500));
    }
}
