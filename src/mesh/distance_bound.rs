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

/// Writes what homogeneous points cost, each times its weight, beside the weight and what it costs
/// alone; what the costliest costs.
#[inline(always)]
pub(super) fn price<S: Simd>(
    simd: S,
    cost: &impl Cost,
    points: &[DVec4],
    out: &mut [DVec4],
) -> f64 {
    let lanes = S::F64_LANES;
    let Some(last) = points.len().checked_sub(lanes) else {
        let mut most = 0.0;
        for (point, out) in points.iter().zip(out) {
            let (point, out) = (std::slice::from_ref(point), std::slice::from_mut(out));
            most = larger(most, priced(Scalar::new(), cost, point, out));
        }
        return most;
    };
    let mut all = simd.splat_f64s(0.0);
    for start in (0..points.len()).step_by(lanes) {
        // Those at the end are priced together with some that have been before.
        let group = start.min(last)..start.min(last) + lanes;
        all = simd.max_f64s(all, priced(simd, cost, &points[group.clone()], &mut out[group]));
    }
    simd.reduce_max_f64s(all)
}

/// The same for as many points as registers hold numbers; what each costs.
#[inline(always)]
fn priced<S: Simd>(simd: S, cost: &impl Cost, points: &[DVec4], out: &mut [DVec4]) -> S::f64s {
    let held = S::as_simd_f64s(bytemuck::cast_slice(points)).0;
    let [x, y, z, w] = simd.deinterleave_shfl_f64s([held[0], held[1], held[2], held[3]]);
    let cost = simd.sqrt_f64s(projected(simd, cost, [x, y, z, w]));
    let prices = simd.interleave_shfl_f64s([simd.mul_f64s(w, cost), w, cost, cost]);
    S::as_mut_simd_f64s(bytemuck::cast_slice_mut(out)).0.copy_from_slice(&prices);
    cost
}

/// The largest quotient of numbers side by side, the second ones of which are positive.
#[inline(always)]
pub(super) fn quotient<S: Simd>(simd: S, octets: &[[Eight; 2]]) -> f64 {
    let mut most = simd.splat_f64s(0.0);
    for [sums, weights] in octets {
        let (sums, weights) = (S::as_simd_f64s(&sums.0).0, S::as_simd_f64s(&weights.0).0);
        for (sum, weight) in sums.iter().zip(weights) {
            most = simd.max_f64s(most, simd.div_f64s(*sum, *weight));
        }
    }
    simd.reduce_max_f64s(most)
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
        sum = simd.mul_add_e_f64s(points[k], simd.splat_f64s(direction[k]), sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use pulp::{Arch, WithSimd};

    use super::super::bernstein::{Bernstein, Blossoms};
    use super::*;

    /// The distance from the x-axis.
    struct FromAxis;

    impl Cost for FromAxis {
        fn squared<S: Simd>(&self, simd: S, [_, y, z]: [S::f64s; 3]) -> S::f64s {
            simd.add_f64s(simd.mul_f64s(y, y), simd.mul_f64s(z, z))
        }
    }

    /// What a net's points cost, and bounds of what it costs over a triangle: by their means, and by
    /// what they cost.
    struct Asked<'a>(&'a Bernstein, &'a [DVec4], [DVec2; 3]);

    impl WithSimd for Asked<'_> {
        type Output = (Vec<DVec4>, f64, [f64; 2]);

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self(bernstein, net, at) = self;
            let mut prices = vec![DVec4::ZERO; net.len()];
            let most = price(simd, &FromAxis, net, &mut prices);
            let (mut blossoms, octets) = (Blossoms::default(), bernstein.octets());
            let mut points = vec![[Eight::default(); 4]; octets];
            bernstein.triangle(simd, net, at, &mut blossoms, &mut points);
            let mut bounds = vec![[Eight::default(); 2]; octets];
            bernstein.triangle(simd, &prices, at, &mut blossoms, &mut bounds);
            let both = [costliest_of(simd, &FromAxis, &points), quotient(simd, &bounds)];
            (prices, most, both)
        }
    }

    #[test]
    fn means_of_points_cost_no_more_than_the_mean_of_what_they_cost() {
        let triangles = [
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)],
            [(0.5, 0.75), (0.5, 0.25), (0.75, 0.75)],
            [(0.1, 0.9), (0.75, 0.5), (1.0, 0.25)],
        ];
        for (p, q) in [(1, 1), (2, 2), (3, 3), (2, 5)] {
            let bernstein = Bernstein::of((p, q));
            for seed in 0..20 {
                let point = |k: usize| {
                    let k = (100 * seed + k) as f64;
                    let (y, z) = ((2.9 * k).cos(), (0.7 * k * k).sin());
                    (1.5 + (3.1 * k).sin()) * DVec4::new((1.3 * k).sin(), y, z, 1.0)
                };
                let net: Vec<DVec4> = (0..(p + 1) * (q + 1)).map(point).collect();
                for at in triangles.map(|corners| corners.map(DVec2::from)) {
                    let asked = Asked(bernstein, &net, at);
                    let (prices, most, [exact, bound]) = Arch::new().dispatch(asked);
                    let mut largest = 0.0_f64;
                    for (h, price) in net.iter().zip(&prices) {
                        let point = h.project();
                        let cost = point.y.hypot(point.z);
                        assert!(price.abs_diff_eq(
                            h.w * DVec4::new(cost, 1.0, cost / h.w, cost / h.w),
                            1e-14
                        ));
                        largest = largest.max(cost);
                    }
                    assert!((most - largest).abs() < 1e-14);
                    assert!(
                        exact <= bound + 1e-14 && bound <= most + 1e-14,
                        "{exact} {bound} {most}"
                    );
                }
            }
        }
    }
}
