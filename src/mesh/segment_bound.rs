//! The distance from a segment in space, as a convex bound.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec3;
use pulp::Simd;

use super::distance_bound::DistanceBound;
use super::lanes::{dot, from_origin};

/// A segment in space.
pub(super) struct SegmentBound {
    start: DVec3,
    along: DVec3,
    /// The inverse of its squared length.
    scale: f64,
}

impl SegmentBound {
    pub(super) fn new([start, end]: [DVec3; 2]) -> Self {
        let along = end - start;
        Self { start, along, scale: 1.0 / along.length_squared().max(f64::MIN_POSITIVE) }
    }
}

impl DistanceBound for SegmentBound {
    #[inline(always)]
    fn squared<S: Simd>(&self, simd: S, point: [S::f64s; 3]) -> S::f64s {
        let away = from_origin(simd, point, self.start);
        let share = dot(simd, away, (self.scale * self.along).to_array());
        let share = simd.max_f64s(share, simd.splat_f64s(0.0));
        let share = simd.min_f64s(share, simd.splat_f64s(1.0));
        let rest = |axis: usize| {
            let along = simd.mul_f64s(share, simd.splat_f64s(self.along[axis]));
            simd.sub_f64s(away[axis], along)
        };
        let rest = [rest(0), rest(1), rest(2)];
        let sum = simd.mul_f64s(rest[0], rest[0]);
        let sum = simd.mul_add_e_f64s(rest[1], rest[1], sum);
        simd.mul_add_e_f64s(rest[2], rest[2], sum)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;
    use pulp::{Arch, WithSimd};

    use super::super::distance_bound::max_bound;
    use super::*;

    struct Bound(SegmentBound, DVec4);

    impl WithSimd for Bound {
        type Output = f64;

        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            max_bound(simd, &self.0, &[self.1], f64::INFINITY)
        }
    }

    #[test]
    fn the_bound_is_the_distance_from_the_segment() {
        let ends = [DVec3::ZERO, 2.0 * DVec3::X];
        let distance = |x: f64, y: f64| {
            Arch::new().dispatch(Bound(SegmentBound::new(ends), DVec4::new(x, y, 0.0, 1.0)))
        };
        assert!((distance(0.5, 0.25) - 0.25).abs() < 1e-15);
        assert!((distance(-3.0, 4.0) - 5.0).abs() < 1e-15);
        assert!((distance(5.0, -4.0) - 5.0).abs() < 1e-15);
        let point = SegmentBound::new([DVec3::ZERO; 2]);
        assert_eq!(Arch::new().dispatch(Bound(point, DVec4::new(3.0, 4.0, 0.0, 1.0))), 5.0);
    }
}
