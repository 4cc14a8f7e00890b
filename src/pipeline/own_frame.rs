//! The frame that work is done in, and what is told of that in the points' own frame and unit.

use std::ops::ControlFlow;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::units::Units;
use crate::cloud::{Normalization, centroid};
use crate::progress::{Epoch, Observer, Progress};
use crate::topology::Chart;

/// Steps in which coordinates are counted in a frame that is the points' own, to the distance of half of them
/// from their middle: far below what anyone measures, and as far above what rounding is off by.
const STEPS: f64 = (1_u64 << 31) as f64;

/// So few points are summed one by one, and so few by one thread.
const SUMMED: usize = 16;
const SUMMED_ALONE: usize = 1 << 14;

/// Share of the largest distance that is as large but for rounding, and points at most that are looked at there.
const AS_FAR: f64 = 1.0 - 1e-9;
const MOST_AXES: usize = 4;

/// Where points are in work, by what their coordinates count.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) units: Units,
    counted: Normalization,
    axes: DMat3,
    /// What coordinates are whole multiples of; 0 if of nothing.
    step: f64,
}

impl Frame {
    /// Along the axes of points.
    pub(super) fn upright(units: Units, points: &[DVec3]) -> Self {
        Self { units, counted: Normalization::of(points), axes: DMat3::IDENTITY, step: 0.0 }
    }

    /// Along axes that turn, move and grow with points, from the farthest from their centroid to the nearest.
    ///
    /// Whether a net grows once more, or a fold is turned, may hang on the last digit. Coordinates in whole steps
    /// are the same to that digit wherever the points lie and whatever their unit.
    pub(super) fn own(units: Units, points: &[DVec3]) -> Self {
        let centre = middle(points);
        let radius = points[0].distance(centre);
        let usual = 0.5 * points[points.len() / 2].distance(centre) / radius;
        Self {
            units,
            counted: Normalization { centre, scale: 0.5 / radius },
            axes: own_axes(points, centre),
            step: usual.log2().ceil().exp2() / STEPS,
        }
    }

    /// From the points' frame.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        self.apply_counted(self.units.apply(point))
    }

    fn apply_counted(&self, point: DVec3) -> DVec3 {
        let place = self.direction(self.counted.apply(point));
        if self.step > 0.0 { (place / self.step).round() * self.step } else { place }
    }

    /// Points whose coordinates are what they count.
    pub(super) fn counted(&self, points: &[DVec3]) -> Vec<DVec3> {
        points.par_iter().map(|&point| self.apply_counted(point)).collect()
    }

    /// A direction in which coordinates are what they count.
    pub(super) fn direction(&self, direction: DVec3) -> DVec3 {
        self.axes.transpose() * direction
    }

    /// Back to the points' frame.
    pub(super) fn undo(&self, point: DVec3) -> DVec3 {
        self.units.undo(self.undo_counted(point))
    }

    fn undo_counted(&self, point: DVec3) -> DVec3 {
        self.counted.undo(self.axes * point)
    }

    /// A chart of points in the frame, as one of points whose coordinates are what they count.
    pub(super) fn undo_chart(&self, chart: Chart) -> Chart {
        let points = chart.points.into_iter().map(|point| self.undo_counted(point)).collect();
        let lengths = (self.length(chart.lengths.0), self.length(chart.lengths.1));
        Chart { points, lengths, ..chart }
    }

    /// A length of the frame as the points' coordinates count.
    pub(super) fn length(&self, length: f64) -> f64 {
        length / self.counted.scale
    }

    /// What a length is in the frame.
    pub(super) fn counted_length(&self, length: f64) -> f64 {
        length * self.counted.scale
    }
}

/// The mean of points to nearly the last digit: halves are summed apart, from where it nearly is.
fn middle(points: &[DVec3]) -> DVec3 {
    fn sum(points: &[DVec3], near: DVec3) -> DVec3 {
        if points.len() <= SUMMED {
            return points.iter().map(|point| *point - near).sum();
        }
        let (first, second) = points.split_at(points.len() / 2);
        let (first, second) = if points.len() <= SUMMED_ALONE {
            (sum(first, near), sum(second, near))
        } else {
            rayon::join(|| sum(first, near), || sum(second, near))
        };
        first + second
    }
    let near = centroid(points);
    near + sum(points, near) / points.len() as f64
}

/// Axes that turn with points: to the outermost, and to the one farthest off that line. Of points that a mirror
/// does not change several may be that; among their axes the points are farthest out along these.
fn own_axes(points: &[DVec3], centre: DVec3) -> DMat3 {
    let reach = |axes: &DMat3| -> f64 {
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
    let farther_out = |a: DMat3, b: DMat3| if reach(&b) > reach(&a) { b } else { a };
    all.reduce(farther_out).unwrap_or(DMat3::IDENTITY)
}

/// The longest of the points' vectors, or some of them if several are as long.
fn outermost(points: &[DVec3], vector: impl Fn(&DVec3) -> DVec3 + Sync) -> Vec<DVec3> {
    let lengths = points.par_iter().map(|point| vector(point).length());
    let longest = lengths.reduce(|| 0.0, f64::max);
    let as_far = |vector: &DVec3| vector.length() >= AS_FAR * longest;
    let mut found: Vec<DVec3> = points.par_iter().map(&vector).filter(as_far).collect();
    found.truncate(MOST_AXES);
    found
}

/// Hands on what work in a frame tells.
pub(super) struct OwnFrame<'a> {
    pub(super) frame: Frame,
    pub(super) observer: &'a mut dyn Observer,
}

impl Observer for OwnFrame<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        let length = |length: f64| self.frame.length(length);
        let (change, error) = (progress.change.map(length), progress.error.map(length));
        self.observer.observe(&Progress { change, error, ..*progress })
    }

    fn learned(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
        let lattice: Vec<DVec3> = epoch.lattice.iter().map(|&node| self.frame.undo(node)).collect();
        let (error, change) = (self.frame.length(epoch.error), self.frame.length(epoch.change));
        self.observer.learned(&Epoch { error, change, lattice: &lattice, ..*epoch })
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::pipeline::ReconstructOptions;

    fn units() -> Units {
        let flat: Vec<DVec3> = helix(40).collect();
        Units::of(&flat, &ReconstructOptions::default(), &mut crate::progress::Silent).unwrap().0
    }

    /// Points from the farthest from their centroid to the nearest.
    fn helix(count: u32) -> impl Iterator<Item = DVec3> {
        let angle = move |i: u32| 0.37 * f64::from(count - i);
        (0..count).map(angle).map(|a| DVec3::new(a * a.cos(), 0.9 * a * a.sin(), 0.1 * a * a))
    }

    fn outwards(mut points: Vec<DVec3>) -> Vec<DVec3> {
        let centre = centroid(&points);
        points.sort_by(|a, b| b.distance(centre).total_cmp(&a.distance(centre)));
        points
    }

    #[test]
    fn own_coordinates_are_the_same_bits_wherever_points_lie() {
        let points = outwards(helix(300).collect());
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
        let moved: Vec<DVec3> =
            points.iter().map(|&p| 3.7 * (turn * p) + DVec3::new(9.0, -20.0, 5.0)).collect();
        let [own, other] = [&points, &moved].map(|points| Frame::own(units(), points));
        assert_eq!(own.counted(&points), other.counted(&moved));
        let back = own.undo(own.apply(points[7]));
        assert!(back.distance(points[7]) < 1e-9 * points[0].distance(points[299]));
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
            let mut local = Frame::own(units(), points).counted(points);
            local.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.z.total_cmp(&b.z)));
            local
        };
        assert_eq!(of(&one), of(&other));
    }
}
