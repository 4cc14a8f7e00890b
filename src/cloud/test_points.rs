//! Points for tests.

use glam::DVec3;

/// A pseudorandom number between 0 and 1 from two integers (`SplitMix64`).
pub(super) fn random(number: u32, salt: u32) -> f64 {
    let mut z = (u64::from(number) << 32 | u64::from(salt)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

/// Random points in the unit cube.
pub(super) fn cube(count: u32, salt: u32) -> Vec<DVec3> {
    let along = |i: u32| [0, 1, 2].map(|axis| random(i, 3 * salt + axis));
    (0..count).map(along).map(DVec3::from_array).collect()
}

/// Random points in the unit square, in z = 0.
pub(super) fn square(count: u32, salt: u32) -> Vec<DVec3> {
    cube(count, salt).into_iter().map(|point| DVec3::new(point.x, point.y, 0.0)).collect()
}

/// The point of a hilly sheet above a point of the unit square.
pub(super) fn hill(point: DVec3) -> DVec3 {
    DVec3::new(point.x, point.y, 0.2 * (3.0 * point.x).sin() * (2.0 * point.y).cos())
}

/// The point of an upright tube for a point of the unit square.
pub(super) fn tube(point: DVec3) -> DVec3 {
    let (sin, cos) = (std::f64::consts::TAU * point.x).sin_cos();
    DVec3::new(0.5 * cos, 0.5 * sin, 2.0 * point.y)
}

/// A spiral that is a hundred times denser in the middle, far from the origin.
pub(super) fn spiral() -> Vec<DVec3> {
    let place = |i: u32| {
        let (angle, radius) = (f64::from(i) * 2.4, (f64::from(i) / 40_000.0).powi(3));
        DVec3::new(5e6 + radius * angle.cos(), radius * angle.sin(), 0.1 * radius)
    };
    (0..40_000).map(place).collect()
}
