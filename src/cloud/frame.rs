//! The local frame of a cloud: all later stages compute in it.

use std::ops::ControlFlow;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::bounds::centroid;
use super::normalization::Normalization;
use super::settings::FrameSettings;
use crate::progress::{Epoch, Observer, Progress};
use crate::worker_pool::install;

const SETTINGS: FrameSettings = FrameSettings::STANDARD;

/// A frame that rotates, moves and scales with the points.
///
/// Local coordinates are rounded to whole steps. They are therefore the same bits in any pose and
/// any unit of the points, and all results of later stages are, too. The points lie within 0.5 of
/// the origin.
///
/// Given coordinates are first divided by a scale for each axis, usually (1, 1, 1). Local lengths
/// and directions are those of the points after this division.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    axis_scale: DVec3,
    normalization: Normalization,
    axes: DMat3,
    /// Local coordinates are integer multiples of this step.
    step: f64,
}

impl Frame {
    /// The frame of points that are already divided by `axis_scale`, sorted by their distance from
    /// the centroid, the farthest first.
    ///
    /// # Panics
    ///
    /// If there are no points.
    #[must_use]
    pub fn of(scaled: &[DVec3], axis_scale: DVec3) -> Self {
        let center = mean(scaled);
        let radius = scaled[0].distance(center);
        let median = 0.5 * scaled[scaled.len() / 2].distance(center) / radius;
        Self {
            axis_scale,
            normalization: Normalization { center, scale: 0.5 / radius },
            axes: own_axes(scaled, center),
            step: median.log2().ceil().exp2() / SETTINGS.steps,
        }
    }

    /// A given point in the local frame.
    #[must_use]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.scaled_to_local(point / self.axis_scale)
    }

    /// As [`Self::to_local`], for a point already divided by the axis scale.
    pub(super) fn scaled_to_local(&self, point: DVec3) -> DVec3 {
        let local = self.axes.transpose() * self.normalization.apply(point);
        (local / self.step).round() * self.step
    }

    /// A local point in the given frame.
    #[must_use]
    pub fn to_given(&self, point: DVec3) -> DVec3 {
        self.normalization.undo(self.axes * point) * self.axis_scale
    }

    /// A tangent direction in the local frame. Its length stays the same without an axis scale.
    #[must_use]
    pub fn direction_to_local(&self, direction: DVec3) -> DVec3 {
        self.axes.transpose() * (direction / self.axis_scale)
    }

    /// A local tangent direction in the given frame.
    #[must_use]
    pub fn direction_to_given(&self, direction: DVec3) -> DVec3 {
        (self.axes * direction) * self.axis_scale
    }

    /// A length in the local frame.
    #[must_use]
    pub fn length_to_local(&self, length: f64) -> f64 {
        length * self.normalization.scale
    }

    /// A local length in the points' unit.
    #[must_use]
    pub fn length_to_given(&self, length: f64) -> f64 {
        length / self.normalization.scale
    }
}

/// The mean of points by pairwise summation, which is exact to nearly the last digit.
fn mean(points: &[DVec3]) -> DVec3 {
    fn sum(points: &[DVec3], near: DVec3) -> DVec3 {
        if points.len() <= 2 {
            return points.iter().map(|point| *point - near).sum();
        }
        let (first, second) = points.split_at(points.len() / 2);
        sum(first, near) + sum(second, near)
    }
    let near = centroid(points);
    near + sum(points, near) / points.len() as f64
}

/// Axes that rotate with the points: the first to the farthest point, the second to the point
/// farthest from that line.
///
/// Several points of a symmetric cloud may be equally far. Of their axes, those with the largest
/// third moments are taken.
fn own_axes(points: &[DVec3], center: DVec3) -> DMat3 {
    let moment = |axes: &DMat3| -> f64 {
        let cubes = |apart: DVec3| apart.dot(axes.y_axis).powi(3) + apart.dot(axes.z_axis).powi(3);
        points.iter().map(|point| cubes(*point - center)).sum()
    };
    let around = |first: DVec3| {
        let first = first.normalize();
        let off = |point: &DVec3| (*point - center).reject_from_normalized(first);
        farthest(points, off).into_iter().map(move |second| {
            let second = second.normalize();
            DMat3::from_cols(first, second, first.cross(second))
        })
    };
    let all = farthest(points, |point| *point - center).into_iter().flat_map(around);
    let larger = |a: DMat3, b: DMat3| if moment(&b) > moment(&a) { b } else { a };
    all.reduce(larger).unwrap_or(DMat3::IDENTITY)
}

/// The longest of the points' vectors, and others of equal length.
fn farthest(points: &[DVec3], vector: impl Fn(&DVec3) -> DVec3 + Sync) -> Vec<DVec3> {
    let lengths = points.par_iter().map(|point| vector(point).length());
    let longest = install(|| lengths.reduce(|| 0.0, f64::max));
    let equally_long = |vector: &DVec3| vector.length() >= SETTINGS.min_equal_ratio * longest;
    let found = points.par_iter().map(&vector).filter(equally_long);
    let mut found: Vec<DVec3> = install(|| found.collect());
    found.truncate(SETTINGS.max_axes);
    found
}

/// Passes reports from the local frame on to an observer, with lengths in the points' unit.
pub struct LocalObserver<'a> {
    /// The frame of the work.
    pub frame: Frame,
    /// The observer that gets the reports.
    pub observer: &'a mut dyn Observer,
}

impl Observer for LocalObserver<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let length = |length: f64| self.frame.length_to_given(length);
        let (change, error) = (progress.change.map(length), progress.error.map(length));
        self.observer.observe(&Progress { change, error, ..*progress })
    }

    fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let to_given = |&node: &DVec3| self.frame.to_given(node);
        let lattice: Vec<DVec3> = epoch.lattice.iter().map(to_given).collect();
        let [error, change] = [epoch.error, epoch.change].map(|x| self.frame.length_to_given(x));
        self.observer.observe_epoch(&Epoch { error, change, lattice: &lattice, ..*epoch })
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    fn helix(count: u32) -> impl Iterator<Item = DVec3> {
        let angle = move |i: u32| 0.37 * f64::from(count - i);
        (0..count).map(angle).map(|a| DVec3::new(a * a.cos(), 0.9 * a * a.sin(), 0.1 * a * a))
    }

    fn farthest_first(mut points: Vec<DVec3>) -> Vec<DVec3> {
        let center = centroid(&points);
        points.sort_by(|a, b| b.distance(center).total_cmp(&a.distance(center)));
        points
    }

    fn local(points: &[DVec3]) -> Vec<DVec3> {
        let frame = Frame::of(points, DVec3::ONE);
        points.iter().map(|&point| frame.to_local(point)).collect()
    }

    #[test]
    fn local_coordinates_are_the_same_bits_in_any_pose() {
        let points = farthest_first(helix(300).collect());
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
        let moved: Vec<DVec3> =
            points.iter().map(|&p| 3.7 * (turn * p) + DVec3::new(9.0, -20.0, 5.0)).collect();
        assert_eq!(local(&points), local(&moved));
    }

    #[test]
    fn a_mirror_symmetric_cloud_has_one_frame_in_any_order() {
        let mirror = DVec3::new(1.0, 1.0, -1.0);
        let half: Vec<DVec3> = helix(150).collect();
        let pairs =
            |first: DVec3, second: DVec3| half.iter().flat_map(move |&p| [p * first, p * second]);
        let one = farthest_first(pairs(DVec3::ONE, mirror).collect());
        let other = farthest_first(pairs(mirror, DVec3::ONE).collect());
        let of = |points: &[DVec3]| {
            let mut local = local(points);
            local.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.z.total_cmp(&b.z)));
            local
        };
        assert_eq!(of(&one), of(&other));
    }

    #[test]
    fn points_and_directions_survive_the_round_trip() {
        let axis_scale = DVec3::new(1.0, 2.0, 100.0);
        let given: Vec<DVec3> = farthest_first(helix(50).collect());
        let scaled: Vec<DVec3> = given.iter().map(|&point| point / axis_scale).collect();
        let frame = Frame::of(&farthest_first(scaled), axis_scale);
        let [a, b] = [given[3], given[40]];
        assert!(frame.to_given(frame.to_local(a)).distance(a) < 1e-6);
        let way = frame.direction_to_local(b - a) * frame.length_to_local(1.0);
        assert!((frame.to_local(b) - frame.to_local(a)).distance(way) < 1e-8);
        assert!(frame.direction_to_given(frame.direction_to_local(b - a)).distance(b - a) < 1e-9);
    }
}
