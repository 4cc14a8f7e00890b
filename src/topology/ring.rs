//! The torus around a circle that points lie near: of few points it shows itself before its loops do.

use std::f64::consts::TAU;

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::nearest_circle::nearest_circle;
use super::start::{Chart, covered};
use crate::cloud::{Plane, centroid};

/// Rounds in which circle and section follow one another: ten settle to a thousandth of the section.
const ROUNDS: usize = 12;

/// How far points are from the torus by root mean square at most, as a share of its section's radius: their angles
/// are right then, and that is all that is asked of it.
const OFF: f64 = 0.15;

/// Parts of either way around in all of which a torus has points: other surfaces may be near to a part of one.
const PARTS: usize = 3;

/// Where the points are on the torus nearest to them, if they are near to one, whose hole is wider than they are apart.
pub(crate) fn ring(points: &[DVec3]) -> Option<Chart> {
    let (mut centre, mut axis) = (centroid(points), Plane::of(points.iter().copied()).normal());
    let (mut major, mut minor) = (0.0, 0.0);
    for _ in 0..ROUNDS {
        let (x, y) = axis.any_orthonormal_pair();
        // The circle nearest to the places of the section.
        let sections = points.iter().map(|point| section(*point - centre, axis).1);
        let (middle, radius) = nearest_circle(sections);
        (major, minor) = (middle.x, radius);
        centre += middle.y * axis;
        // Then the ring is moved and turned by a step of Gauss and Newton.
        let (mut squares, mut right) = (DMat4::ZERO, DVec4::ZERO);
        for point in points {
            let (outwards, at) = section(*point - centre, axis);
            let from_ring = at - major * DVec2::X;
            let way = from_ring.normalize_or_zero();
            let outwards = DVec2::new(outwards.dot(x), outwards.dot(y));
            let (moved, turned) = (-way.x * outwards, way.y * major * outwards);
            let row = DVec4::new(moved.x, moved.y, turned.x, turned.y);
            squares += DMat4::from_cols(row.x * row, row.y * row, row.z * row, row.w * row);
            right -= (from_ring.length() - minor) * row;
        }
        let step = squares.inverse() * right;
        centre += step.x * x + step.y * y;
        axis = (axis + step.z * x + step.w * y).normalize();
    }
    let (x, y) = axis.any_orthonormal_pair();
    let mut off = 0.0;
    let place = |point: &DVec3| {
        let (outwards, at) = section(*point - centre, axis);
        let from_ring = at - major * DVec2::X;
        off += (from_ring.length() - minor).powi(2) / points.len() as f64;
        let angles = DVec2::new(outwards.dot(y).atan2(outwards.dot(x)), from_ring.to_angle());
        (angles / TAU).map(|turns| turns.rem_euclid(1.0))
    };
    let uv: Vec<DVec2> = points.iter().map(place).collect();
    let spacing = TAU * (major * minor / points.len() as f64).sqrt();
    // Of what is no ring, numbers need not be finite.
    let is_ring = 2.0 * (major - minor) > spacing
        && off.sqrt() < OFF * minor
        && covered::<PARTS>(&uv) == PARTS * PARTS;
    let lengths = (TAU * major, TAU * minor);
    is_ring.then(|| Chart { points: points.to_vec(), uv, lengths, closed_v: true })
}

/// The direction from an axis, and the place in the half plane there: how far from the axis, and along it.
fn section(apart: DVec3, axis: DVec3) -> (DVec3, DVec2) {
    let along = apart.dot(axis);
    let across = apart - along * axis;
    (across.normalize_or_zero(), DVec2::new(across.length(), along))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(ratio: f64, count: usize) -> Vec<DVec3> {
        let turn = glam::DQuat::from_rotation_x(0.7);
        let point = |i: usize| {
            let [u, v] = [0.754_877_666, 0.569_840_291].map(|step| TAU * (step * i as f64).fract());
            let out = ratio + v.cos();
            turn * DVec3::new(out * u.cos(), out * u.sin(), v.sin()) + DVec3::new(50.0, 0.0, 9.0)
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn places_on_a_torus_are_found_from_few_points() {
        for (ratio, count) in [(1.3, 200), (2.0, 60), (6.0, 60)] {
            let chart = ring(&scattered(ratio, count)).unwrap();
            let (long, short) = chart.lengths;
            assert!((long - TAU * ratio).abs() < 1e-3 && (short - TAU).abs() < 1e-3, "{ratio}");
        }
    }

    #[test]
    fn a_ball_a_cap_and_a_flat_ring_are_none() {
        for centre in [DVec3::new(50.0, 0.0, 9.0), DVec3::new(50.0, 0.0, 0.0)] {
            let points = scattered(2.0, 200).into_iter();
            let on_sphere: Vec<DVec3> = points.map(|p| (p - centre).normalize()).collect();
            assert!(ring(&on_sphere).is_none(), "{centre}");
        }
        let flat: Vec<DVec3> = scattered(2.0, 200).iter().map(|p| p.with_z(0.0)).collect();
        assert!(ring(&flat).is_none());
    }
}
