//! Faces for tests.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::face::Face;
use crate::nurbs::{NurbsCurve, NurbsSurface};

/// Numbers in [0, 1) that look random.
pub(super) fn random(k: u32) -> f64 {
    let mut x = k.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    x = (x ^ (x >> 16)).wrapping_mul(0x85EB_CA6B);
    x = (x ^ (x >> 13)).wrapping_mul(0xC2B2_AE35);
    f64::from((x ^ (x >> 16)) >> 8) / f64::from(1 << 24)
}

/// A random point in [-1, 1]³.
pub(super) fn random_point(k: u32) -> DVec3 {
    2.0 * DVec3::new(random(3 * k), random(3 * k + 1), random(3 * k + 2)) - 1.0
}

/// The square [0, size]² in the plane z = 0.
pub(super) fn plane(size: f64) -> NurbsSurface {
    NurbsSurface::plane(DVec3::ZERO, size * DVec3::X, size * DVec3::Y).unwrap()
}

/// The loop of a polygon.
pub(super) fn polygon(points: &[(f64, f64)]) -> Vec<NurbsCurve> {
    let point = |k: usize| DVec2::from(points[k % points.len()]).extend(0.0);
    (0..points.len()).map(|k| NurbsCurve::line(point(k), point(k + 1)).unwrap()).collect()
}

/// The loop around a rectangle.
pub(super) fn rectangle((u0, v0): (f64, f64), (u1, v1): (f64, f64)) -> Vec<NurbsCurve> {
    polygon(&[(u0, v0), (u1, v0), (u1, v1), (u0, v1)])
}

/// The loop of a circle.
pub(super) fn circle((u, v): (f64, f64), radius: f64) -> Vec<NurbsCurve> {
    let center = DVec3::new(u, v, 0.0);
    vec![NurbsCurve::arc(center, radius * DVec3::X, radius * DVec3::Y, TAU).unwrap()]
}

/// The part of a surface in the unit square of (u, v) outside these loops.
pub(super) fn pierced(surface: NurbsSurface, holes: Vec<Vec<NurbsCurve>>) -> Face {
    let mut loops = vec![rectangle((0.0, 0.0), (1.0, 1.0))];
    loops.extend(holes);
    Face::trimmed(surface, loops).unwrap()
}

/// Twenty circles in the unit square, of radius 0.06 to 0.09.
pub(super) fn twenty_circles() -> Vec<Vec<NurbsCurve>> {
    let place = |k: u32| (0.1 + 0.2 * f64::from(k % 5), 0.125 + 0.25 * f64::from(k / 5));
    (0..20).map(|k| circle(place(k), 0.06 + 0.03 * random(k))).collect()
}

/// A wavy bicubic surface over the unit square, with rational weights.
pub(super) fn waves() -> NurbsSurface {
    let knots = crate::nurbs::KnotVector::clamped_uniform(3, 8).unwrap();
    let point = |k: u32| {
        let (i, j) = (f64::from(k / 8), f64::from(k % 8));
        DVec3::new(i / 7.0, j / 7.0, 0.5 * random(k))
    };
    let weights = (0..64).map(|k| 0.5 + random(k + 100)).collect();
    NurbsSurface::new((0..64).map(point).collect(), Some(weights), knots.clone(), knots).unwrap()
}

/// A steep surface of degree 4 over the unit square, with rational weights.
pub(super) fn steep(seed: u32) -> NurbsSurface {
    let knots = crate::nurbs::KnotVector::clamped_uniform(4, 6).unwrap();
    let point = |k: u32| {
        let (i, j) = (f64::from(k / 6), f64::from(k % 6));
        DVec3::new(i / 5.0, j / 5.0, 3.0 * random(seed + k))
    };
    let weights = (0..36).map(|k| 0.3 + random(seed + k + 36)).collect();
    NurbsSurface::new((0..36).map(point).collect(), Some(weights), knots.clone(), knots).unwrap()
}
