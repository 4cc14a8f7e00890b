//! A point of the surface with its derivatives: tangents and normals, ordinary and limits.

use glam::{DVec3, DVec4};

/// Tangents whose cross product is under this share of the product of their lengths give no
/// direction for a normal: what is left is rounding.
const DEGENERATE: f64 = 1e-12;

/// A tangent shorter than this share of the net's size, over the length of the domain, is zero up
/// to rounding.
const FLAT: f64 = 1e-13;

/// Squares of the lengths below which the tangents in u and v count as zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Flats {
    pub u: f64,
    pub v: f64,
}

impl Flats {
    /// For a net of this size (the diagonal of its box) over a domain of these lengths.
    pub(super) fn new(size: f64, length_u: f64, length_v: f64) -> Self {
        // Positive also for a net in one point, as it is divided by.
        let square = |length: f64| (FLAT * size / length).powi(2).max(f64::MIN_POSITIVE);
        Self { u: square(length_u), v: square(length_v) }
    }

    /// How clear the normal of two tangents is, from the squares of their lengths and of the
    /// length of their cross product: up to 0, and if NaN, it is rounding. Without branches and
    /// divisions, so that loops over it are vectorized and fast.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    pub(super) fn clearness(self, u: f64, v: f64, cross: f64) -> f64 {
        // Unlike `f64::min` one instruction, which hands on a `b` that is NaN.
        let lesser = |a: f64, b: f64| if a < b { a } else { b };
        let least = DEGENERATE * DEGENERATE * (u * v) + f64::MIN_POSITIVE;
        lesser(v - self.v, lesser(u - self.u, cross - least))
    }

    /// The direction of the cross product of two tangents, unless that is rounding.
    pub(super) fn normal(self, by_u: DVec3, by_v: DVec3) -> Option<DVec3> {
        let cross = by_u.cross(by_v);
        let square = cross.length_squared();
        let clear = self.clearness(by_u.length_squared(), by_v.length_squared(), square) > 0.0;
        clear.then(|| cross / square.sqrt())
    }
}

/// A point of the surface with its first and second partial derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub point: DVec3,
    pub u: DVec3,
    pub v: DVec3,
    pub uu: DVec3,
    pub uv: DVec3,
    pub vv: DVec3,
}

impl Frame {
    /// From the homogeneous value and derivatives by u, v, uu, uv, vv (The NURBS Book, equation
    /// 4.20).
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

    /// The limit of the unit normal for a point that moves in this direction of the parameters
    /// and comes from it: where the cross product of the tangents vanishes, the direction of its
    /// first derivative.
    pub(super) fn limit_normal(&self, (du, dv): (f64, f64)) -> Option<DVec3> {
        let (move_u, move_v) = (du * self.uu + dv * self.uv, du * self.uv + dv * self.vv);
        let (left, right) = (move_u.cross(self.v), self.u.cross(move_v));
        let change = left + right;
        let scale = move_u.length() * self.v.length() + self.u.length() * move_v.length();
        (change.length() > DEGENERATE * scale).then(|| change.normalize())
    }
}
