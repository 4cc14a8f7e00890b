//! Convex upper bounds of a point's distance, evaluated on many points at once.
//!
//! Because a bound is convex, a Bézier patch nowhere exceeds the largest bound of its control
//! points.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec4;
use pulp::{Scalar, Simd};

use super::lanes::{BATCH, Batch, PointBatch, larger};

/// An upper bound of a point's distance that is a convex function of the point.
pub(super) trait DistanceBound {
    /// The squared bounds of points whose coordinates fill three registers.
    fn squared<S: Simd>(&self, simd: S, point: [S::f64s; 3]) -> S::f64s;
}

/// The largest bound of some homogeneous points; infinite once it exceeds the limit.
#[inline(always)]
pub(super) fn max_bound<S: Simd>(
    simd: S,
    bound: &impl DistanceBound,
    points: &[DVec4],
    limit: f64,
) -> f64 {
    let lanes = S::F64_LANES;
    let (whole, rest) = points.split_at(points.len() / lanes * lanes);
    let (mut all, high) = (simd.splat_f64s(0.0), simd.splat_f64s(limit * limit));
    for group in whole.chunks_exact(lanes) {
        all = simd.max_f64s(all, squared_of_lanes(simd, bound, group));
        if simd.first_true_m64s(simd.greater_than_f64s(all, high)) < lanes {
            return f64::INFINITY;
        }
    }
    let mut most = if whole.is_empty() { 0.0 } else { simd.reduce_max_f64s(all) };
    // Too few points are left for registers to pay off.
    for point in rest {
        most = larger(most, squared_of_homogeneous(Scalar::new(), bound, point.to_array()));
    }
    most.sqrt()
}

/// The squared bounds of as many points as a register has lanes.
#[inline(always)]
fn squared_of_lanes<S: Simd>(simd: S, bound: &impl DistanceBound, points: &[DVec4]) -> S::f64s {
    let held = S::as_simd_f64s(bytemuck::cast_slice(points)).0;
    let held = [held[0], held[1], held[2], held[3]];
    squared_of_homogeneous(simd, bound, simd.deinterleave_shfl_f64s(held))
}

/// Writes (w b, w, b, b) for each homogeneous point of weight w and bound b; returns the largest b.
#[inline(always)]
pub(super) fn weighted_bounds<S: Simd>(
    simd: S,
    bound: &impl DistanceBound,
    points: &[DVec4],
    out: &mut [DVec4],
) -> f64 {
    let lanes = S::F64_LANES;
    let Some(last) = points.len().checked_sub(lanes) else {
        let mut most = 0.0;
        for (point, out) in points.iter().zip(out) {
            let (point, out) = (std::slice::from_ref(point), std::slice::from_mut(out));
            most = larger(most, weighted_bounds_of_lanes(Scalar::new(), bound, point, out));
        }
        return most;
    };
    let mut all = simd.splat_f64s(0.0);
    for start in (0..points.len()).step_by(lanes) {
        // The last group overlaps the one before it, to fill the registers.
        let group = start.min(last)..start.min(last) + lanes;
        all = simd.max_f64s(
            all,
            weighted_bounds_of_lanes(simd, bound, &points[group.clone()], &mut out[group]),
        );
    }
    simd.reduce_max_f64s(all)
}

/// The same for as many points as a register has lanes; returns the bound of each.
#[inline(always)]
fn weighted_bounds_of_lanes<S: Simd>(
    simd: S,
    bound: &impl DistanceBound,
    points: &[DVec4],
    out: &mut [DVec4],
) -> S::f64s {
    let held = S::as_simd_f64s(bytemuck::cast_slice(points)).0;
    let [x, y, z, w] = simd.deinterleave_shfl_f64s([held[0], held[1], held[2], held[3]]);
    let bound = simd.sqrt_f64s(squared_of_homogeneous(simd, bound, [x, y, z, w]));
    let weighted = simd.interleave_shfl_f64s([simd.mul_f64s(w, bound), w, bound, bound]);
    S::as_mut_simd_f64s(bytemuck::cast_slice_mut(out)).0.copy_from_slice(&weighted);
    bound
}

/// The largest quotient of the first batch by the second, which is positive.
#[inline(always)]
pub(super) fn max_quotient<S: Simd>(simd: S, batches: &[[Batch; 2]]) -> f64 {
    let mut most = simd.splat_f64s(0.0);
    for [sums, weights] in batches {
        let (sums, weights) = (S::as_simd_f64s(&sums.0).0, S::as_simd_f64s(&weights.0).0);
        for (sum, weight) in sums.iter().zip(weights) {
            most = simd.max_f64s(most, simd.div_f64s(*sum, *weight));
        }
    }
    simd.reduce_max_f64s(most)
}

/// The largest bound of homogeneous points in batches.
#[inline(always)]
pub(super) fn max_bound_of_batches<S: Simd>(
    simd: S,
    bound: &impl DistanceBound,
    batches: &[PointBatch],
) -> f64 {
    let mut most = simd.splat_f64s(0.0);
    for [x, y, z, w] in batches {
        let (x, y) = (S::as_simd_f64s(&x.0).0, S::as_simd_f64s(&y.0).0);
        let (z, w) = (S::as_simd_f64s(&z.0).0, S::as_simd_f64s(&w.0).0);
        for k in 0..BATCH / S::F64_LANES {
            most =
                simd.max_f64s(most, squared_of_homogeneous(simd, bound, [x[k], y[k], z[k], w[k]]));
        }
    }
    simd.reduce_max_f64s(most).sqrt()
}

/// The squared bounds of points with these homogeneous coordinates.
#[inline(always)]
fn squared_of_homogeneous<S: Simd>(
    simd: S,
    bound: &impl DistanceBound,
    [x, y, z, w]: [S::f64s; 4],
) -> S::f64s {
    let one = simd.div_f64s(simd.splat_f64s(1.0), w);
    let point = [simd.mul_f64s(x, one), simd.mul_f64s(y, one), simd.mul_f64s(z, one)];
    bound.squared(simd, point)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use pulp::{Arch, WithSimd};

    use super::super::triangle_conversion::{Buffers, TriangleConversion};
    use super::*;

    /// The distance from the x-axis.
    struct FromAxis;

    impl DistanceBound for FromAxis {
        fn squared<S: Simd>(&self, simd: S, [_, y, z]: [S::f64s; 3]) -> S::f64s {
            simd.add_f64s(simd.mul_f64s(y, y), simd.mul_f64s(z, z))
        }
    }

    /// Bounds of a net's points, and over a triangle: by its points, and by interpolated bounds.
    struct Bounds<'a>(&'a TriangleConversion, &'a [DVec4], [DVec2; 3]);

    impl WithSimd for Bounds<'_> {
        type Output = (Vec<DVec4>, f64, [f64; 2]);

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self(conversion, net, at) = self;
            let mut weighted = vec![DVec4::ZERO; net.len()];
            let most = weighted_bounds(simd, &FromAxis, net, &mut weighted);
            let (mut buffers, batches) = (Buffers::default(), conversion.batches());
            let mut points = vec![[Batch::default(); 4]; batches];
            conversion.triangle(simd, net, at, &mut buffers, &mut points);
            let mut quotients = vec![[Batch::default(); 2]; batches];
            conversion.triangle(simd, &weighted, at, &mut buffers, &mut quotients);
            let by_points = max_bound_of_batches(simd, &FromAxis, &points);
            (weighted, most, [by_points, max_quotient(simd, &quotients)])
        }
    }

    #[test]
    fn interpolated_bounds_are_above_the_bounds_of_interpolated_points() {
        let triangles = [
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)],
            [(0.5, 0.75), (0.5, 0.25), (0.75, 0.75)],
            [(0.1, 0.9), (0.75, 0.5), (1.0, 0.25)],
        ];
        for (p, q) in [(1, 1), (2, 2), (3, 3), (2, 5), (14, 10)] {
            let conversion = TriangleConversion::of((p, q));
            for seed in 0..20 {
                let point = |k: usize| {
                    let k = (100 * seed + k) as f64;
                    let (y, z) = ((2.9 * k).cos(), (0.7 * k * k).sin());
                    (1.5 + (3.1 * k).sin()) * DVec4::new((1.3 * k).sin(), y, z, 1.0)
                };
                let net: Vec<DVec4> = (0..(p + 1) * (q + 1)).map(point).collect();
                for at in triangles.map(|corners| corners.map(DVec2::from)) {
                    let bounds = Bounds(conversion, &net, at);
                    let (weighted, most, [exact, interpolated]) = Arch::new().dispatch(bounds);
                    let mut largest = 0.0_f64;
                    for (h, found) in net.iter().zip(&weighted) {
                        let point = h.project();
                        let bound = point.y.hypot(point.z);
                        let expected = h.w * DVec4::new(bound, 1.0, bound / h.w, bound / h.w);
                        assert!(found.abs_diff_eq(expected, 1e-14));
                        largest = largest.max(bound);
                    }
                    assert!((most - largest).abs() < 1e-14);
                    assert!(exact <= interpolated + 1e-14, "{exact} {interpolated}");
                    assert!(interpolated <= most + 1e-14, "{interpolated} {most}");
                }
            }
        }
    }
}
