//! Batches of eight numbers in the layout of SIMD registers, and arithmetic on them.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec3;
use pulp::Simd;

/// Numbers in a batch: as many as the widest registers hold.
pub(super) const BATCH: usize = 8;

/// Eight numbers, aligned to one cache line: loads and stores across lines are slow.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(super) struct Batch(pub [f64; BATCH]);

/// Eight homogeneous points: x coordinates, y coordinates, z coordinates, weights.
pub(super) type PointBatch = [Batch; 4];

/// The homogeneous point with index k among batches.
#[inline(always)]
pub(super) fn point(batches: &[PointBatch], k: usize) -> [f64; 4] {
    let ([x, y, z, w], lane) = (&batches[k / BATCH], k % BATCH);
    [x.0[lane], y.0[lane], z.0[lane], w.0[lane]]
}

/// The larger of two numbers; `most` if `x` is NaN. Unlike `f64::max`, one instruction.
#[inline(always)]
pub(super) fn larger(most: f64, x: f64) -> f64 {
    if x > most { x } else { most }
}

/// Vectors from `origin` to points.
#[inline(always)]
pub(super) fn from_origin<S: Simd>(
    simd: S,
    [x, y, z]: [S::f64s; 3],
    origin: DVec3,
) -> [S::f64s; 3] {
    [
        simd.sub_f64s(x, simd.splat_f64s(origin.x)),
        simd.sub_f64s(y, simd.splat_f64s(origin.y)),
        simd.sub_f64s(z, simd.splat_f64s(origin.z)),
    ]
}

/// Dot products of vectors with one direction.
#[inline(always)]
pub(super) fn dot<S: Simd, const N: usize>(
    simd: S,
    vectors: [S::f64s; N],
    direction: [f64; N],
) -> S::f64s {
    let mut sum = simd.mul_f64s(vectors[0], simd.splat_f64s(direction[0]));
    for k in 1..N {
        sum = simd.mul_add_e_f64s(vectors[k], simd.splat_f64s(direction[k]), sum);
    }
    sum
}
