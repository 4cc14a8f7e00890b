//! Convex functions of points, of which a Bézier patch's control points have the largest values.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::{DVec3, DVec4};
use pulp::{Scalar, Simd};

use super::triangle::larger;

/// Numbers in the widest registers.
pub(super) const OCTET: usize = 8;

/// As many numbers, in one line of the cache: what crosses lines is slow to be stored and loaded again.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(super) struct Eight(pub [f64; OCTET]);

/// Eight homogeneous points side by side: first coordinates, second ones, third ones, weights.
pub(super) type Octet = [Eight; 4];

/// What a point costs.
pub(super) trait Cost {
    /// Squares of what points side by side in registers cost.
    fn squared<S: Simd>(&self, simd: S, point: [S::f64s; 3]) -> S::f64s;
}

/// What the costliest of some homogeneous points costs, or anything above the limit if one costs more
/// than it.
#[inline(always)]
pub(super) fn costliest<S: Simd>(simd: S, cost: &impl Cost, points: &[DVec4], limit: f64) -> f64 {
    let lanes = S::F64_LANES;
    let (whole, rest) = points.split_at(points.len() / lanes * lanes);
    let (mut all, high) = (simd.splat_f64s(0.0), simd.splat_f64s(limit * limit));
    for group in whole.chunks_exact(lanes) {
        all = simd.max_f64s(all, squared(simd, cost, group));
        if simd.first_true_m64s(simd.greater_than_f64s(all, high)) < lanes {
            return f64::INFINITY;
        }
    }
    let mut most = if whole.is_empty() { 0.0 } else { simd.reduce_max_f64s(all) };
    // What is left is too little to be worth the way into registers.
    for point in rest {
        most = larger(most, projected(Scalar::new(), cost, point.to_array()));
    }
    most.sqrt()
}

/// Squares of what as many points cost as registers hold numbers.
#[inline(always)]
fn squared<S: Simd>(simd: S, cost: &impl Cost, points: &[DVec4]) -> S::f64s {
    let held = S::as_simd_f64s(bytemuck::cast_slice(points)).0;
    let held = [held[0], held[1], held[2], held[3]];
    projected(simd, cost, simd.deinterleave_shfl_f64s(held))
}

/// What the costliest of some homogeneous points side by side costs.
#[inline(always)]
pub(super) fn costliest_of<S: Simd>(simd: S, cost: &impl Cost, octets: &[Octet]) -> f64 {
    let mut most = simd.splat_f64s(0.0);
    for [x, y, z, w] in octets {
        let (x, y) = (S::as_simd_f64s(&x.0).0, S::as_simd_f64s(&y.0).0);
        let (z, w) = (S::as_simd_f64s(&z.0).0, S::as_simd_f64s(&w.0).0);
        for k in 0..OCTET / S::F64_LANES {
            most = simd.max_f64s(most, projected(simd, cost, [x[k], y[k], z[k], w[k]]));
        }
    }
    simd.reduce_max_f64s(most).sqrt()
}

/// Squares of what points cost whose homogeneous coordinates these are.
#[inline(always)]
fn projected<S: Simd>(simd: S, cost: &impl Cost, [x, y, z, w]: [S::f64s; 4]) -> S::f64s {
    let one = simd.div_f64s(simd.splat_f64s(1.0), w);
    let point = [simd.mul_f64s(x, one), simd.mul_f64s(y, one), simd.mul_f64s(z, one)];
    cost.squared(simd, point)
}

/// Where points side by side lie from an origin.
#[inline(always)]
pub(super) fn away<S: Simd>(simd: S, [x, y, z]: [S::f64s; 3], origin: DVec3) -> [S::f64s; 3] {
    [
        simd.sub_f64s(x, simd.splat_f64s(origin.x)),
        simd.sub_f64s(y, simd.splat_f64s(origin.y)),
        simd.sub_f64s(z, simd.splat_f64s(origin.z)),
    ]
}

/// Products of points side by side with a direction.
#[inline(always)]
pub(super) fn dot<S: Simd, const N: usize>(
    simd: S,
    points: [S::f64s; N],
    direction: [f64; N],
) -> S::f64s {
    let mut sum = simd.mul_f64s(points[0], simd.splat_f64s(direction[0]));
    for k in 1..N {
        sum = simd.add_f64s(sum, simd.mul_f64s(points[k], simd.splat_f64s(direction[k])));
    }
    sum
}
