//! What a point costs a face: how far it may be from the triangles of which the face is one.
//!
//! The cost is convex, so a Bézier patch costs no more than its costliest control point. It is the
//! height over the plane of the face. A point that has left the face over an inner edge lies over the
//! next face, where its height differs by what that falls away. One that has left it over an outer
//! edge is as far away as the third side of a right angle.
//!
//! At a fold between two faces, that is not yet how far the fold is from the surface: on the side from
//! which it is a valley, a surface within a height h of both planes may pass at h / cos(θ / 2), where
//! θ is the angle between the planes. So heights on that side cost so much more.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::{DVec2, DVec3};
use pulp::Simd;

use super::cost::{Cost, away, dot};
use super::triangle::larger;

/// Coordinates about a face: along its longest edge, across it in its plane, and above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    axes: [DVec3; 3],
    /// Those beside which is another face come first.
    edges: [Edge; 3],
    /// How many these are.
    inner: usize,
    /// What heights above and below cost.
    valleys: [f64; 2],
}

/// An edge of a face, in its frame.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    /// The direction out of the face, of length one.
    out: DVec2,
    /// The coordinate of the edge in this direction.
    at: f64,
    /// The coordinates of its ends along the edge.
    ends: [f64; 2],
    /// By how much the next face falls away below the plane of this one, and by how much it rises
    /// above it, on each unit.
    falls: f64,
    rises: f64,
}

impl Edge {
    /// How far points are beyond the edge.
    #[inline(always)]
    fn beyond<S: Simd>(&self, simd: S, [x, y]: [S::f64s; 2]) -> S::f64s {
        let at = dot(simd, [x, y], self.out.to_array());
        simd.sub_f64s(at, simd.splat_f64s(self.at))
    }

    /// How far points are past its ends, squared.
    #[inline(always)]
    fn past<S: Simd>(&self, simd: S, [x, y]: [S::f64s; 2]) -> S::f64s {
        let along = dot(simd, [x, y], self.out.perp().to_array());
        let before = simd.sub_f64s(simd.splat_f64s(self.ends[0]), along);
        let behind = simd.sub_f64s(along, simd.splat_f64s(self.ends[1]));
        let past = simd.max_f64s(simd.max_f64s(before, behind), simd.splat_f64s(0.0));
        simd.mul_f64s(past, past)
    }

    /// Of an edge beside which is no other face: the squares of how far points that are beyond it are
    /// from it, infinite for others. Of those that lie over the next face it is the line that counts,
    /// not where it ends.
    #[inline(always)]
    fn aside<S: Simd>(&self, simd: S, at: [S::f64s; 2], over_next: S::m64s) -> S::f64s {
        let zero = simd.splat_f64s(0.0);
        let beyond = self.beyond(simd, at);
        let past = simd.select_f64s(over_next, zero, self.past(simd, at));
        let squared = simd.mul_add_e_f64s(beyond, beyond, past);
        let left = simd.greater_than_f64s(beyond, zero);
        simd.select_f64s(left, squared, simd.splat_f64s(f64::INFINITY))
    }
}

impl Frame {
    /// Of a face with this normal, and those of the faces beside its edges.
    #[inline(always)]
    pub(super) fn new(points: [DVec3; 3], normal: DVec3, beside: [Option<DVec3>; 3]) -> Self {
        let [a, b, c] = points;
        let along = [b - a, c - b, a - c];
        let lengths =
            [along[0].length_squared(), along[1].length_squared(), along[2].length_squared()];
        let longest = usize::from(lengths[0] < lengths[1]);
        let longest = if lengths[2] > lengths[longest] { 2 } else { longest };
        let mut scales = [0.0; 3];
        for (scale, length) in scales.iter_mut().zip(lengths) {
            *scale = if length > 0.0 { 1.0 / length.sqrt() } else { 0.0 };
        }
        let x = scales[longest] * along[longest];
        let y = normal.cross(x);
        let flat = |away: DVec3| DVec2::new(away.dot(x), away.dot(y));
        let corners = [DVec2::ZERO, flat(along[0]), flat(c - a)];
        let mut valleys = [1.0; 2];
        let mut edge = |k: usize| {
            let (start, end) = (corners[k], corners[(k + 1) % 3]);
            let out = -scales[k] * (end - start).perp();
            let mut edge = Edge { out, at: out.dot(start), ..Edge::default() };
            let Some(other) = beside[k] else {
                edge.ends = [out.perp_dot(start), out.perp_dot(end)];
                return edge;
            };
            let slope = other.dot(out.x * x + out.y * y);
            (edge.falls, edge.rises) = (larger(0.0, slope), larger(0.0, -slope));
            let valley = &mut valleys[usize::from(slope > 0.0)];
            *valley = larger(*valley, 1.0 / (0.5 + 0.5 * other.dot(normal)).sqrt());
            edge
        };
        let (mut edges, mut inner, mut outer) = ([Edge::default(); 3], 0, 3);
        for (k, other) in beside.iter().enumerate() {
            if other.is_some() {
                edges[inner] = edge(k);
                inner += 1;
            } else {
                outer -= 1;
                edges[outer] = edge(k);
            }
        }
        Self { origin: points[0], axes: [x, y, normal], edges, inner, valleys }
    }
}

impl Cost for Frame {
    #[inline(always)]
    fn squared<S: Simd>(&self, simd: S, point: [S::f64s; 3]) -> S::f64s {
        let (zero, none) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
        let away = away(simd, point, self.origin);
        let at =
            [dot(simd, away, self.axes[0].to_array()), dot(simd, away, self.axes[1].to_array())];
        let height = dot(simd, away, self.axes[2].to_array());
        let mut above = simd.mul_f64s(height, simd.splat_f64s(self.valleys[0]));
        let mut below = simd.mul_f64s(height, simd.splat_f64s(-self.valleys[1]));
        let mut over_next = zero;
        // Loops over all three unroll; over some of them they would not.
        for k in 0..3 {
            if k < self.inner {
                let edge = &self.edges[k];
                let beyond = simd.max_f64s(edge.beyond(simd, at), zero);
                above = simd.mul_add_e_f64s(beyond, simd.splat_f64s(edge.falls), above);
                below = simd.mul_add_e_f64s(beyond, simd.splat_f64s(edge.rises), below);
                over_next = simd.max_f64s(over_next, beyond);
            }
        }
        // Of the outer edges that a point has left the face over, the nearest.
        let over_next = simd.greater_than_f64s(over_next, zero);
        let mut aside = none;
        for k in 0..3 {
            if k >= self.inner {
                aside = simd.min_f64s(aside, self.edges[k].aside(simd, at, over_next));
            }
        }
        let aside = simd.select_f64s(simd.less_than_f64s(aside, none), aside, zero);
        let height = simd.max_f64s(above, below);
        simd.mul_add_e_f64s(height, height, aside)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;
    use pulp::{Arch, WithSimd};

    use super::super::cost::costliest;
    use super::*;

    /// What a point costs, given times a weight.
    struct Asked<'a>(&'a Frame, DVec4);

    impl WithSimd for Asked<'_> {
        type Output = f64;

        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            costliest(simd, self.0, &[self.1], f64::INFINITY)
        }
    }

    fn cost(frame: &Frame, h: DVec4) -> f64 {
        Arch::new().dispatch(Asked(frame, h))
    }

    /// A right angle in z = 0, beside the long edge of which a face rises at 45°.
    fn valley() -> Frame {
        let up = DVec3::new(-1.0, -1.0, 2.0_f64.sqrt()) / 2.0;
        Frame::new([DVec3::ZERO, DVec3::X, DVec3::Y], DVec3::Z, [None, Some(up), None])
    }

    #[test]
    fn points_cost_their_distance() {
        let cost =
            |x: f64, y: f64, z: f64| cost(&valley(), (2.0 * DVec3::new(x, y, z)).extend(2.0));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        close(cost(0.2, 0.2, -0.1), 0.1);
        close(cost(0.2, 0.2, 0.1), 0.1 / (std::f64::consts::PI / 8.0).cos());
        close(cost(0.4, -0.3, -0.4), 0.5);
        close(cost(-0.3, -0.4, 0.0), 0.5);
        // Over the next face, which rises: nearer to it from above, further from below.
        let (beyond, slope) = (0.2 * 2.0_f64.sqrt(), 0.5_f64.sqrt());
        close(cost(0.7, 0.7, -0.1), 0.1 + slope * beyond);
    }

    #[test]
    fn past_an_acute_corner_the_corner_is_nearest() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.5, 0.0)];
        let frame = Frame::new(points, DVec3::Z, [None; 3]);
        let cost = |x: f64, y: f64| cost(&frame, DVec4::new(x, y, 0.0, 1.0));
        // Beyond one edge only, but beside its end.
        assert!((cost(-0.03, -0.04) - 0.05).abs() < 1e-15);
        assert!((cost(0.03, -0.04) - 0.04).abs() < 1e-15);
        assert!((cost(1.04, -0.03) - 0.05).abs() < 1e-15);
    }
}
