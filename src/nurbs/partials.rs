//! A surface point with its first and second partial derivatives, and the normal at regular and at
//! degenerate points.

use glam::{DVec3, DVec4};

/// Tangents are parallel up to rounding if the length of their cross product is below this fraction
/// of the product of their lengths.
const PARALLEL_TANGENTS: f64 = 1e-12;

/// A tangent is zero up to rounding if it is shorter than this fraction of the net's size, divided
/// by the length of the domain.
const ZERO_TANGENT: f64 = 1e-13;

/// Squared lengths below which the tangents in u and v count as zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TangentThresholds {
    pub u: f64,
    pub v: f64,
}

impl TangentThresholds {
    /// Computes the thresholds for a net of this size (the diagonal of its bounding box) over a
    /// domain of these lengths.
    pub(super) fn new(size: f64, length_u: f64, length_v: f64) -> Self {
        // Positive even if all control points coincide, because the thresholds are divisors.
        let square = |length: f64| (ZERO_TANGENT * size / length).powi(2).max(f64::MIN_POSITIVE);
        Self { u: square(length_u), v: square(length_v) }
    }

    /// Returns a positive number if two tangents define a normal; otherwise, the normal is
    /// degenerate.
    ///
    /// The arguments are the squared lengths of the tangents and of their cross product. A NaN
    /// result counts as degenerate. Loops over this function vectorize, because it has no branches
    /// and no divisions.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn normal_margin(self, u: f64, v: f64, cross: f64) -> f64 {
        // One instruction, unlike `f64::min`; it returns `b` if that is NaN.
        let min = |a: f64, b: f64| if a < b { a } else { b };
        let min_cross = PARALLEL_TANGENTS * PARALLEL_TANGENTS * (u * v) + f64::MIN_POSITIVE;
        min(v - self.v, min(u - self.u, cross - min_cross))
    }

    /// Returns the unit normal of two tangents, unless it is degenerate.
    pub(super) fn normal(self, by_u: DVec3, by_v: DVec3) -> Option<DVec3> {
        let cross = by_u.cross(by_v);
        let square = cross.length_squared();
        let clear = self.normal_margin(by_u.length_squared(), by_v.length_squared(), square) > 0.0;
        clear.then(|| cross / square.sqrt())
    }
}

/// A surface point with its first and second partial derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Partials {
    pub point: DVec3,
    pub u: DVec3,
    pub v: DVec3,
    pub uu: DVec3,
    pub uv: DVec3,
    pub vv: DVec3,
}

impl Partials {
    /// Computes the derivatives from the homogeneous value and its derivatives by u, v, uu, uv, vv
    /// (The NURBS Book, equation 4.20).
    pub(super) fn new([value, u, v, uu, uv, vv]: [DVec4; 6]) -> Self {
        let scale = value.w.recip();
        let point = value.truncate() * scale;
        let first = |d: DVec4| (d.truncate() - d.w * point) * scale;
        let (by_u, by_v) = (first(u), first(v));
        Self {
            point,
            u: by_u,
            v: by_v,
            uu: (uu.truncate() - uu.w * point - 2.0 * u.w * by_u) * scale,
            uv: (uv.truncate() - uv.w * point - u.w * by_v - v.w * by_u) * scale,
            vv: (vv.truncate() - vv.w * point - 2.0 * v.w * by_v) * scale,
        }
    }

    /// Returns the limit of the unit normal when the point is approached from the direction (du, dv)
    /// of the parameters: the normalized first derivative of the tangents' cross product.
    pub(super) fn limit_normal(&self, (du, dv): (f64, f64)) -> Option<DVec3> {
        let (move_u, move_v) = (du * self.uu + dv * self.uv, du * self.uv + dv * self.vv);
        let (left, right) = (move_u.cross(self.v), self.u.cross(move_v));
        let change = left + right;
        let scale = move_u.length() * self.v.length() + self.u.length() * move_v.length();
        (change.length() > PARALLEL_TANGENTS * scale).then(|| change.normalize())
    }
}
