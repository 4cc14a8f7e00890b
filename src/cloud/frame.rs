//! The local frame in which a cloud is worked on.

use std::ops::ControlFlow;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::bounds::centroid;
use super::normalization::Normalization;
use crate::progress::{Epoch, Observer, Progress};

/// Steps of local coordinates within half the usual distance from the centre: far finer than any
/// measurement, and far coarser than rounding.
const STEPS: f64 = (1_u64 << 31) as f64;

/// Distances over this share of the largest count as equal to it, up to rounding.
const AS_FAR: f64 = 1.0 - 1e-9;

/// Equally far points that may define an axis, at most.
const MOST_AXES: usize = 4;

/// A frame that turns, moves and scales with the points.
///
/// Local coordinates are rounded to whole steps. So they are the same bits in any pose and any unit
/// of the points, and so is all that is computed from them. The points lie within 0.5 of the origin.
///
/// Given coordinates are first divided by a scale for each axis, (1, 1, 1) as a rule. Local lengths
/// and directions are those of the points after this division.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    axis_scale: DVec3,
    normalization: Normalization,
    axes: DMat3,
    /// Local coordinates are whole multiples of it.
    step: f64,
}

impl Frame {
    /// The frame of points, already divided by `axis_scale`, in the order from the farthest from
    /// their centroid to the nearest.
    ///
    /// # Panics
    ///
    /// If there are no points.
    #[must_use]
    pub fn of(scaled: &[DVec3], axis_scale: DVec3) -> Self {
        let centre = mean(scaled);
        let radius = scaled[0].distance(centre);
        let usual = 0.5 * scaled[scaled.len() / 2].distance(centre) / radius;
        Self {
            axis_scale,
            normalization: Normalization { centre, scale: 0.5 / radius },
            axes: own_axes(scaled, centre),
            step: usual.log2().ceil().exp2() / STEPS,
        }
    }

    /// A given point in the local frame.
    #[must_use]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.scaled_to_local(point / self.axis_scale)
    }

    /// As [`Self::to_local`], of a point already divided by the axis scale.
    pub(super) fn scaled_to_local(&self, point: DVec3) -> DVec3 {
        let local = self.axes.transpose() * self.normalization.apply(point);
        (local / self.step).round() * self.step
    }

    /// A local point in the given frame.
    #[must_use]
    pub fn to_given(&self, point: DVec3) -> DVec3 {
        self.normalization.undo(self.axes * point) * self.axis_scale
    }

    /// A tangent direction in the local frame; it keeps its length if there is no axis scale.
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

/// The mean of points to nearly the last digit, by pairwise summation.
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

/// Axes that turn with the points: to the outermost, and to the one farthest from that line. Several
/// points of a symmetric cloud may be outermost: among their axes, those along which the third
/// moments are largest.
fn own_axes(points: &[DVec3], centre: DVec3) -> DMat3 {
    let moment = |axes: &DMat3| -> f64 {
        let cubes = |apart: DVec3| apart.dot(axes.y_axis).powi(3) + apart.dot(axes.z_axis).powi(3);
        points.iter().map(|point| cubes(*point - centre)).sum()
    };
    let around = |first: DVec3| {
        let first = first.normalize();
        let off = |point: &DVec3| (*point - centre).reject_from_normalized(first);
        outermost(points, off).into_iter().map(move |second| {
            let second = second.normalize();
            DMat3::from_cols(first, second, first.cross(second))
        })
    };
    let all = outermost(points, |point| *point - centre).into_iter().flat_map(around);
    let larger = |a: DMat3, b: DMat3| if moment(&b) > moment(&a) { b } else { a };
    all.reduce(larger).unwrap_or(DMat3::IDENTITY)
}

/// The longest of the points' vectors, and others as long.
fn outermost(points: &[DVec3], vector: impl Fn(&DVec3) -> DVec3 + Sync) -> Vec<DVec3> {
    let lengths = points.par_iter().map(|point| vector(point).length());
    let longest = lengths.reduce(|| 0.0, f64::max);
    let as_far = |vector: &DVec3| vector.length() >= AS_FAR * longest;
    let mut found: Vec<DVec3> = points.par_iter().map(&vector).filter(as_far).collect();
    found.truncate(MOST_AXES);
    found
}

/// Hands reports of work in the local frame on to an observer, in the given frame.
pub struct LocalObserver<'a> {
    /// The frame of the work.
    pub frame: Frame,
    /// Who is to be informed.
    pub observer: &'a mut dyn Observer,
}

impl Observer for LocalObserver<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let length = |length: f64| self.frame.length_to_given(length);
        let (change, error) = (progress.change.map(length), progress.error.map(length));
        self.observer.observe(&Progress { change, error, ..*progress })
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let to_given = |&node: &DVec3| self.frame.to_given(node);
        let lattice: Vec<DVec3> = epoch.lattice.iter().map(to_given).collect();
        let [error, change] = [epoch.error, epoch.change].map(|x| self.frame.length_to_given(x));
        self.observer.learned(&Epoch { error, change, lattice: &lattice, ..*epoch })
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

    fn outwards(mut points: Vec<DVec3>) -> Vec<DVec3> {
        let centre = centroid(&points);
        points.sort_by(|a, b| b.distance(centre).total_cmp(&a.distance(centre)));
        points
    }

    fn local(points: &[DVec3]) -> Vec<DVec3> {
        let frame = Frame::of(points, DVec3::ONE);
        points.iter().map(|&point| frame.to_local(point)).collect()
    }

    #[test]
    fn local_coordinates_are_the_same_bits_in_any_pose() {
        let points = outwards(helix(300).collect());
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
        let moved: Vec<DVec3> =
            points.iter().map(|&p| 3.7 * (turn * p) + DVec3::new(9.0, -20.0, 5.0)).collect();
        assert_eq!(local(&points), local(&moved));
    }

    #[test]
    fn mirrored_points_have_one_frame_in_any_order() {
        let mirror = DVec3::new(1.0, 1.0, -1.0);
        let half: Vec<DVec3> = helix(150).collect();
        let pairs =
            |first: DVec3, second: DVec3| half.iter().flat_map(move |&p| [p * first, p * second]);
        let one = outwards(pairs(DVec3::ONE, mirror).collect());
        let other = outwards(pairs(mirror, DVec3::ONE).collect());
        let of = |points: &[DVec3]| {
            let mut local = local(points);
            local.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.z.total_cmp(&b.z)));
            local
        };
        assert_eq!(of(&one), of(&other));
    }

    #[test]
    fn points_and_directions_come_back() {
        let axis_scale = DVec3::new(1.0, 2.0, 100.0);
        let given: Vec<DVec3> = outwards(helix(50).collect());
        let scaled: Vec<DVec3> = given.iter().map(|&point| point / axis_scale).collect();
        let frame = Frame::of(&outwards(scaled), axis_scale);
        let [a, b] = [given[3], given[40]];
        assert!(frame.to_given(frame.to_local(a)).distance(a) < 1e-6);
        let way = frame.direction_to_local(b - a) * frame.length_to_local(1.0);
        assert!((frame.to_local(b) - frame.to_local(a)).distance(way) < 1e-8);
        assert!(frame.direction_to_given(frame.direction_to_local(b - a)).distance(b - a) < 1e-9);
    }
}
