//! The cylinder that points lie near, which may be bent: of few points, or of few rings of them, it shows itself before
//! its loops do.

use std::f64::consts::TAU;

use glam::{DMat2, DMat3, DMat4, DVec2, DVec3, DVec4};

use super::axis::{gaps, is_closed};
use super::nearest_circle::nearest_circle;
use super::start::{Chart, covered};
use crate::cloud::Plane;

/// Rounds in which axis and circle follow one another.
const ROUNDS: usize = 20;

/// How far points are from the cylinder by root mean square at most, as a share of its radius, where a tube is asked
/// for: their angles are right then, and that is all that is asked of it; and where it may be none, as a share of its
/// length, too: some balls have 0.13, thin tori a third of their height.
const OFF: f64 = 0.15;
const OFF_UNASKED: f64 = 0.1;

/// Parts of the way around and along in all of which a cylinder has points: other surfaces may be near to a part of
/// one.
const PARTS: usize = 3;

/// The widest gap around a cylinder, in turns, that leaves enough to tell it by.
const GROOVE: f64 = 0.75;

/// Where the points are on the cylinder nearest to them, if they are near to one, in all parts of it; and all around
/// it, if no tube is asked for.
pub(super) fn cylinder(points: &[DVec3], asked: bool) -> Option<Chart> {
    let most = if asked { OFF } else { OFF_UNASKED };
    let nearest = Cylinder::nearest(points).filter(|found| found.off < most)?;
    let chart = nearest.chart(points)?;
    let whole = covered::<PARTS>(&chart.uv) == PARTS * PARTS;
    let is_tube = || nearest.is_long(&chart, most) && is_closed(&chart.uv);
    (whole && (asked || is_tube())).then_some(chart)
}

/// The same, if they are near to a part of one, a quarter of its way around at least.
pub(super) fn groove(points: &[DVec3]) -> Option<Chart> {
    let nearest = Cylinder::nearest(points).filter(|found| found.off < OFF_UNASKED)?;
    let chart = nearest.chart(points)?;
    (nearest.is_long(&chart, OFF_UNASKED) && gaps(&chart.uv)[0] < GROOVE).then_some(chart)
}

/// Directions so many that one is near to any axis, which need not be a principal one.
const DIRECTIONS: [DVec3; 13] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(1.0, -1.0, 0.0),
    DVec3::new(1.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, 1.0, -1.0),
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
];

struct Cylinder {
    /// On the axis.
    middle: DVec3,
    axis: DVec3,
    /// How the axis bends: by so much for the square of the way along it, of which the mean is taken off.
    bend: DVec3,
    square: f64,
    radius: f64,
    /// How far the points are from it by root mean square, as a share of its radius.
    off: f64,
}

impl Cylinder {
    /// The nearest.
    fn nearest(points: &[DVec3]) -> Option<Self> {
        let Plane { centre, axes, .. } = Plane::of(points.iter().copied());
        let axes = DMat3::from_cols(axes[0], axes[1], axes[2]);
        let found = DIRECTIONS.iter().map(|&way| Self::near(points, centre, axes * way));
        // Of what is no cylinder, numbers need not be finite.
        let found = found.filter(|found| found.off.is_finite());
        found.min_by(|a, b| a.off.total_cmp(&b.off))
    }

    /// The nearest, found from this axis.
    fn near(points: &[DVec3], centre: DVec3, way: DVec3) -> Self {
        let (axis, bend) = (way.normalize(), DVec3::ZERO);
        let mut found =
            Self { middle: centre, axis, bend, square: 0.0, radius: 0.0, off: f64::NAN };
        let share = 1.0 / points.len() as f64;
        for _ in 0..ROUNDS {
            let [x, y] = found.across();
            let along = |point: &DVec3| (*point - found.middle).dot(found.axis);
            found.square = points.iter().map(|point| along(point).powi(2)).sum::<f64>() * share;
            // The circle nearest to the points as they are seen along the axis.
            let across = points.iter().map(|point| found.place(*point, [x, y]).1);
            let (middle, radius) = nearest_circle(across);
            found.middle += middle.x * x + middle.y * y;
            found.radius = radius;
            // Then the axis is moved and turned by a step of Gauss and Newton, and bent by another.
            let (mut squares, mut right, mut off) = (DMat4::ZERO, DVec4::ZERO, 0.0);
            let (mut bends, mut bent) = (DMat2::ZERO, DVec2::ZERO);
            for point in points {
                let (along, across) = found.place(*point, [x, y]);
                let (way, far) = (across.normalize_or_zero(), across.length() - found.radius);
                let row = DVec4::new(-way.x, -way.y, -along * way.x, -along * way.y);
                squares += DMat4::from_cols(row.x * row, row.y * row, row.z * row, row.w * row);
                right -= far * row;
                let row = (found.square - along * along) * way;
                bends += DMat2::from_cols(row.x * row, row.y * row);
                bent -= far * row;
                off += far * far * share;
            }
            found.off = off.sqrt() / found.radius;
            let (step, bent) = (squares.inverse() * right, bends.inverse() * bent);
            found.middle += step.x * x + step.y * y;
            found.bend += bent.x * x + bent.y * y;
            found.axis = (found.axis + step.z * x + step.w * y).normalize();
            found.bend = found.bend.reject_from(found.axis);
        }
        found
    }

    /// Directions across the axis.
    fn across(&self) -> [DVec3; 2] {
        let (x, y) = self.axis.any_orthonormal_pair();
        [x, y]
    }

    /// Where a point is along the axis and, in these directions, across.
    fn place(&self, point: DVec3, [x, y]: [DVec3; 2]) -> (f64, DVec2) {
        let apart = point - self.middle;
        let along = apart.dot(self.axis);
        let apart = apart - (along * along - self.square) * self.bend;
        (along, DVec2::new(apart.dot(x), apart.dot(y)))
    }

    /// Whether it is longer than the points are far from it, as a multiple of this share of that.
    fn is_long(&self, chart: &Chart, share: f64) -> bool {
        self.off * self.radius < share * chart.lengths.1
    }

    /// Where the points are around it and along.
    fn chart(&self, points: &[DVec3]) -> Option<Chart> {
        // From the first point on, towards the end that it is nearer to, so that turning the cloud changes nothing.
        let [x, y] = self.across();
        let (ahead, first) = self.place(*points.first()?, [x, y]);
        let first = (first.x * x + first.y * y).normalize_or_zero();
        let across = [first, ahead.signum() * self.axis.cross(first)];
        let place = |point: &DVec3| {
            let (along, across) = self.place(*point, across);
            (ahead.signum() * along, across)
        };
        let places: Vec<(f64, DVec2)> = points.iter().map(place).collect();
        let along = places.iter().map(|place| place.0);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let uv = |&(along, across): &(f64, DVec2)| {
            DVec2::new((across.to_angle() / TAU).rem_euclid(1.0), (along - low) / (high - low))
        };
        let uv: Vec<DVec2> = places.iter().map(uv).collect();
        let lengths = (TAU * self.radius, high - low);
        Some(Chart { points: points.to_vec(), uv, lengths, closed_v: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of points around an axis that bends by an angle over its length, and that go so far around.
    fn rings(count: usize, length: f64, bend: f64, around: f64) -> Vec<DVec3> {
        let turn = glam::DQuat::from_rotation_x(0.7);
        let point = |i: usize| {
            let (ring, share) = (i / 24, (i % 24) as f64 / 24.0);
            let across = DVec2::from_angle(around * TAU * (share + 0.37 * ring as f64).fract());
            let (along, radius) = (ring as f64 / (count - 1) as f64 - 0.5, length / bend);
            let (y, x) = (bend * along).sin_cos();
            let place = DVec3::new((radius + across.x) * x, (radius + across.x) * y, across.y);
            turn * (place - radius * DVec3::X) + DVec3::new(50.0, 0.0, 9.0)
        };
        (0..24 * count).map(point).collect()
    }

    #[test]
    fn rings_far_from_one_another_lie_around_an_axis() {
        for (count, length, bend) in [(3, 6.0, 1e-3), (3, 2.5, 1e-3), (5, 6.0, 1.0)] {
            let Chart { uv, lengths: (around, along), .. } =
                cylinder(&rings(count, length, bend, 1.0), false).unwrap();
            assert!((around / TAU - 1.0).abs() < 0.1 && (along / length - 1.0).abs() < 0.2);
            let rings = uv.chunks(24).map(|ring| ring[0].y).collect::<Vec<_>>();
            assert!(rings.is_sorted() || rings.iter().rev().is_sorted(), "{rings:?}");
        }
    }

    #[test]
    fn half_a_pipe_tells_the_whole_but_a_plate_tells_none() {
        for (around, bend) in [(0.5, 1e-3), (0.5, 0.5), (0.35, 1e-3)] {
            let part = rings(5, 6.0, bend, around);
            assert!(cylinder(&part, true).is_none());
            let Chart { uv, lengths, .. } = groove(&part).unwrap();
            assert!((lengths.0 / TAU - 1.0).abs() < 0.1 && (lengths.1 / 6.0 - 1.0).abs() < 0.2);
            assert!((gaps(&uv)[0] - (1.0 - around)).abs() < 0.1);
        }
        assert!(groove(&rings(5, 6.0, 1e-3, 0.2)).is_none());
        let plate = (0..120).map(|i| DVec3::new(f64::from(i % 12), f64::from(i / 12), 0.0));
        assert!(groove(&plate.collect::<Vec<_>>()).is_none());
    }

    #[test]
    fn grooves_balls_and_thin_tori_are_none() {
        let groove = rings(5, 6.0, 1e-3, 0.8);
        assert!(cylinder(&groove, false).is_none() && cylinder(&groove, true).is_some());
        let part = |i: u32, step: f64| (step * f64::from(i)).fract();
        let even = (0..200).map(|i| [part(i, 0.754_877_666), part(i, 0.569_840_291)]);
        let ball = |[u, v]: [f64; 2]| {
            let z = 2.0 * v - 1.0;
            (DVec2::from_angle(TAU * u) * (1.0 - z * z).sqrt()).extend(z)
        };
        let torus = |[u, v]: [f64; 2]| {
            let section = DVec2::from_angle(TAU * v);
            (DVec2::from_angle(TAU * u) * (10.0 + section.x)).extend(section.y)
        };
        for points in [even.clone().map(ball).collect::<Vec<_>>(), even.map(torus).collect()] {
            assert!(cylinder(&points, false).is_none());
        }
    }
}
