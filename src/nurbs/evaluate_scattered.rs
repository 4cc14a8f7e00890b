//! Inner loops of evaluation at scattered parameters, one block of points at a time.
//!
//! One loop evaluates the basis functions in u; the other those in v and the sums over the net. So
//! each loop is compiled for one order, and all pairs of degrees are covered.
//!
//! The four lanes of a homogeneous point are one register. No loop uses fused multiply-add, and the
//! net is summed along u first, so results are the same on every machine and equal to those of
//! [`evaluate_grid`](super::evaluate_grid).

use glam::DVec2;
use pulp::{Arch, Simd, WithSimd};

use super::basis::{Basis, order_of, with_capacity, with_order};
use super::control_net::HomogeneousPoint;
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;

/// Points whose basis functions stay in the L1 cache.
pub(super) const BLOCK: usize = 32;

/// Evaluates the homogeneous points at up to [`BLOCK`] parameters; if `SUMS` is 3, also the
/// derivatives by u and v. Entries after the last parameter are meaningless.
pub(super) fn homogeneous<const SUMS: usize>(
    surface: &NurbsSurface,
    arch: Arch,
    uv: &[DVec2],
) -> [[HomogeneousPoint; SUMS]; BLOCK] {
    with_capacity!(surface.knots_u().degree(), CAPACITY => {
        homogeneous_within::<SUMS, CAPACITY>(surface, arch, uv)
    })
}

/// The same for a degree in u below `CAPACITY`.
fn homogeneous_within<const SUMS: usize, const CAPACITY: usize>(
    surface: &NurbsSurface,
    arch: Arch,
    uv: &[DVec2],
) -> [[HomogeneousPoint; SUMS]; BLOCK] {
    let (knots_u, knots_v) = (surface.knots_u(), surface.knots_v());
    let mut rows = [Basis::<CAPACITY>::default(); BLOCK];
    with_order!(knots_u.degree(), ORDER => {
        arch.dispatch(Rows::<ORDER, CAPACITY> { knots: knots_u, uv, out: &mut rows });
    });
    let (rows, mut sums) = (&rows, [[[0.0; 4]; SUMS]; BLOCK]);
    with_order!(knots_v.degree(), ORDER => {
        arch.dispatch(Sums::<ORDER, SUMS, CAPACITY> { surface, uv, rows, out: &mut sums });
    });
    sums
}

/// Evaluates the basis functions in u.
struct Rows<'a, const ORDER: usize, const CAPACITY: usize> {
    knots: &'a KnotVector,
    uv: &'a [DVec2],
    out: &'a mut [Basis<CAPACITY>; BLOCK],
}

impl<const ORDER: usize, const CAPACITY: usize> WithSimd for Rows<'_, ORDER, CAPACITY> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (at, row) in self.uv.iter().zip(self.out) {
            *row = Basis::<ORDER>::at(self.knots, at.x).padded();
        }
    }
}

/// Sums the control points weighted by basis functions.
struct Sums<'a, const ORDER: usize, const SUMS: usize, const CAPACITY: usize> {
    surface: &'a NurbsSurface,
    uv: &'a [DVec2],
    rows: &'a [Basis<CAPACITY>; BLOCK],
    out: &'a mut [[HomogeneousPoint; SUMS]; BLOCK],
}

impl<const ORDER: usize, const SUMS: usize, const CAPACITY: usize> WithSimd
    for Sums<'_, ORDER, SUMS, CAPACITY>
{
    type Output = ();

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let net: &[HomogeneousPoint] = bytemuck::cast_slice(self.surface.homogeneous());
        let (cols, order_u) = (self.surface.shape().1, self.surface.knots_u().degree() + 1);
        let order_v = order_of::<ORDER>(self.surface.knots_v().degree());
        let tangents = SUMS == 3;
        for ((at, rows), sums) in self.uv.iter().zip(self.rows).zip(self.out) {
            let columns = Basis::<ORDER>::at(self.surface.knots_v(), at.y);
            let (mut along, mut along_slopes) = ([[0.0; 4]; ORDER], [[0.0; 4]; ORDER]);
            for k in 0..order_u {
                let points = &net[(rows.first + k) * cols + columns.first..][..order_v];
                add(&mut along, rows.values[k], points);
                if tangents {
                    add(&mut along_slopes, rows.slopes[k], points);
                }
            }
            sums[0] = weighted(&along, &columns.values);
            if tangents {
                sums[1] = weighted(&along_slopes, &columns.values);
                sums[2] = weighted(&along, &columns.slopes);
            }
        }
    }
}

/// Adds `factor` times `points` to `sums`.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn add<const ORDER: usize>(
    sums: &mut [HomogeneousPoint; ORDER],
    factor: f64,
    points: &[HomogeneousPoint],
) {
    for (sum, point) in sums.iter_mut().zip(points) {
        for c in 0..4 {
            sum[c] += factor * point[c];
        }
    }
}

/// Returns the sum of points weighted by `factors`.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn weighted<const ORDER: usize>(
    points: &[HomogeneousPoint; ORDER],
    factors: &[f64; ORDER],
) -> HomogeneousPoint {
    let mut sum = points[0].map(|c| factors[0] * c);
    for (point, factor) in points.iter().zip(factors).skip(1) {
        for c in 0..4 {
            sum[c] += factor * point[c];
        }
    }
    sum
}
