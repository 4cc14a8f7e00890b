//! The tube or the torus around an ellipse that scatters as points do: what is left where no other of its kind is tame.

use std::f64::consts::{SQRT_2, TAU};

use glam::{DVec2, DVec3};

use crate::cloud::Plane;
use crate::topology::{Chart, Kind};

/// How narrow a tube is at least, and the ellipse along a torus, as a share of how wide: a normal that turns more from
/// sample to sample looks like a fold.
const TUBE: f64 = 0.25;
const RING: f64 = 0.5;

/// How thick a torus is at least, as a share of how wide its ellipse is, and at most, as a share of the least radius of
/// that, beyond which it would go through itself.
const THIN: f64 = 0.1;
const THICK: f64 = 0.4;

/// Places on either along each side of a net, for each control point.
const PLACES: usize = 4;

/// Places on the tube around the first principal axis, as long as the points reach along it, or on the torus in the
/// plane nearest to them, that are enough for a net of so many rows and columns. An ellipse scatters by half of its
/// squared radii.
pub(super) fn around(points: &[DVec3], kind: Kind, (rows, cols): (usize, usize)) -> Chart {
    let Plane { centre, axes, deviations } = Plane::of(points.iter().copied());
    let [first, second, third] = deviations.map(|deviation| SQRT_2 * deviation);
    let closed_v = kind == Kind::Torus;
    let along = points.iter().map(|point| (*point - centre).dot(axes[0]));
    let (low, high) = along
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let narrow = third.max(TUBE * second);
    let wide = second.max(RING * first);
    let thick = third.clamp(THIN * wide, THICK * wide * wide / first);
    let place = |uv: DVec2| {
        let (around, across) = (DVec2::from_angle(TAU * uv.x), DVec2::from_angle(TAU * uv.y));
        let local = if closed_v {
            let ring = around * DVec2::new(first, wide);
            let outwards = (around * DVec2::new(wide, first)).normalize_or_zero();
            (ring + thick * across.x * outwards).extend(thick * across.y)
        } else {
            DVec3::new(low + uv.y * (high - low), second * around.x, narrow * around.y)
        };
        centre + local.x * axes[0] + local.y * axes[1] + local.z * axes[2]
    };
    let (rows, cols) = (PLACES * rows, PLACES * cols);
    let steps = DVec2::new(rows as f64, if closed_v { cols } else { cols - 1 } as f64);
    let at = |i: usize| DVec2::new((i / cols) as f64, (i % cols) as f64) / steps;
    let uv: Vec<DVec2> = (0..rows * cols).map(at).collect();
    let points = uv.iter().map(|&uv| place(uv)).collect();
    // A circle as long as an ellipse has nearly the mean of its squared radii.
    let girth = |a: f64, b: f64| TAU * (0.5 * (a * a + b * b)).sqrt();
    let lengths = if closed_v {
        (girth(first, wide), TAU * thick)
    } else {
        (girth(second, narrow), high - low)
    };
    Chart { points, uv, lengths, closed_v }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a pipe along y, of radius 2 and 12 long, or on a torus around y, of radii 5 and 1.
    fn points(kind: Kind) -> Vec<DVec3> {
        let place = |i: i32| {
            let around = DVec2::from_angle(TAU * f64::from(i % 24) / 24.0);
            let across = DVec2::from_angle(TAU * f64::from(i / 24) / 24.0);
            match kind {
                Kind::Torus => {
                    let ring = (5.0 + across.x) * around;
                    DVec3::new(ring.x, across.y, ring.y)
                }
                _ => DVec3::new(2.0 * around.x, 12.0 * f64::from(i / 24) / 23.0, 2.0 * around.y),
            }
        };
        (0..24 * 24).map(place).collect()
    }

    #[test]
    fn what_is_round_has_its_own_radii() {
        let pipe = around(&points(Kind::Tube), Kind::Tube, (8, 4));
        let off = |p: &DVec3| (DVec2::new(p.x, p.z).length() - 2.0).abs();
        assert!(pipe.points.iter().all(|place| off(place) < 1e-9));
        let ends = pipe.points.iter().map(|place| place.y);
        assert!((ends.clone().fold(f64::INFINITY, f64::min)).abs() < 1e-9);
        assert!((ends.fold(0.0, f64::max) - 12.0).abs() < 1e-9);
        assert!((pipe.lengths.0 - 2.0 * TAU).abs() < 1e-9 && (pipe.lengths.1 - 12.0).abs() < 1e-9);

        let torus = around(&points(Kind::Torus), Kind::Torus, (8, 8));
        // The section scatters, too: by a fiftieth of the squared radius.
        let off = |p: &DVec3| DVec2::new(DVec2::new(p.x, p.z).length() - 5.0, p.y).length();
        assert!(torus.points.iter().all(|place| (off(place) - 1.0).abs() < 0.06));
        assert!(torus.closed_v);
    }

    #[test]
    fn what_is_flat_or_a_line_goes_around_something_all_the_same() {
        let line: Vec<DVec3> = (0..50).map(|i| DVec3::X * f64::from(i)).collect();
        let flat: Vec<DVec3> =
            (0..50).map(|i| DVec3::new(f64::from(i % 10), f64::from(i / 10), 0.0)).collect();
        for (points, kind) in [(&line, Kind::Torus), (&flat, Kind::Tube), (&flat, Kind::Torus)] {
            let chart = around(points, kind, (8, 8));
            let plane = Plane::of(chart.points);
            assert!(plane.deviations[2] > 0.01 * plane.deviations[0]);
        }
    }
}
