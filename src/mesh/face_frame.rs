//! A convex bound of a point's distance from the triangles of a cell, in the frame of one face.
//!
//! The bound of a point over the face is its height over the face's plane. Beyond an inner edge,
//! the point lies over the next face, and the bound adds the slope of that face. Beyond an outer
//! edge, the height and the distance from the edge are the legs of a right triangle; the bound is
//! its hypotenuse.
//!
//! A fold between two faces can be farther from the surface than the planes are. On the side where
//! the fold is a valley, a surface within a height h of both planes can be h / cos(θ / 2) away from
//! the fold, where θ is the angle between the planes. Heights on that side get this factor.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec2, DVec3};
use pulp::Simd;

use super::distance_bound::DistanceBound;
use super::lanes::{dot, from_origin, larger};

/// Coordinates of a face: along its longest edge, across that edge in its plane, and its normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceFrame {
    origin: DVec3,
    axes: [DVec3; 3],
    /// The edges; inner edges, shared with another face, come first.
    edges: [Edge; 3],
    /// Number of inner edges.
    inner: usize,
    /// The factors of heights above and below the plane.
    height_factors: [f64; 2],
}

/// An edge of a face, in the plane coordinates of its frame.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    /// The unit normal that points out of the face.
    outward: DVec2,
    /// The coordinate of the edge in this direction.
    offset: f64,
    /// The coordinates of its ends along the edge.
    ends: [f64; 2],
    /// How far the next face falls below the plane of this one, per unit beyond the edge.
    falls: f64,
    /// How far the next face rises above the plane of this one, per unit beyond the edge.
    rises: f64,
}

impl Edge {
    /// The signed distances of points beyond the line of the edge.
    #[inline(always)]
    fn beyond<S: Simd>(&self, simd: S, [x, y]: [S::f64s; 2]) -> S::f64s {
        let at = dot(simd, [x, y], self.outward.to_array());
        simd.sub_f64s(at, simd.splat_f64s(self.offset))
    }

    /// The squared distances of points past the ends of the edge, along it.
    #[inline(always)]
    fn past_ends_squared<S: Simd>(&self, simd: S, [x, y]: [S::f64s; 2]) -> S::f64s {
        let along = dot(simd, [x, y], self.outward.perp().to_array());
        let before = simd.sub_f64s(simd.splat_f64s(self.ends[0]), along);
        let behind = simd.sub_f64s(along, simd.splat_f64s(self.ends[1]));
        let past = simd.max_f64s(simd.max_f64s(before, behind), simd.splat_f64s(0.0));
        simd.mul_f64s(past, past)
    }

    /// The squared distances from an outer edge of the points beyond it; infinite for other points.
    ///
    /// For points over the next face, the line of the edge replaces the edge.
    #[inline(always)]
    fn distance_squared<S: Simd>(&self, simd: S, at: [S::f64s; 2], over_next: S::m64s) -> S::f64s {
        let zero = simd.splat_f64s(0.0);
        let beyond = self.beyond(simd, at);
        let past = simd.select_f64s(over_next, zero, self.past_ends_squared(simd, at));
        let squared = simd.mul_add_e_f64s(beyond, beyond, past);
        let outside = simd.greater_than_f64s(beyond, zero);
        simd.select_f64s(outside, squared, simd.splat_f64s(f64::INFINITY))
    }
}

impl FaceFrame {
    /// The frame of a face; `neighbors` are the normals of the faces at its inner edges.
    #[inline(always)]
    pub(super) fn new(points: [DVec3; 3], normal: DVec3, neighbors: [Option<DVec3>; 3]) -> Self {
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
        let in_plane = |v: DVec3| DVec2::new(v.dot(x), v.dot(y));
        let corners = [DVec2::ZERO, in_plane(along[0]), in_plane(c - a)];
        let mut height_factors = [1.0; 2];
        let mut edge = |k: usize| {
            let (start, end) = (corners[k], corners[(k + 1) % 3]);
            let outward = -scales[k] * (end - start).perp();
            let mut edge = Edge { outward, offset: outward.dot(start), ..Edge::default() };
            let Some(other) = neighbors[k] else {
                edge.ends = [outward.perp_dot(start), outward.perp_dot(end)];
                return edge;
            };
            let slope = other.dot(outward.x * x + outward.y * y);
            (edge.falls, edge.rises) = (larger(0.0, slope), larger(0.0, -slope));
            let factor = &mut height_factors[usize::from(slope > 0.0)];
            *factor = larger(*factor, 1.0 / (0.5 + 0.5 * other.dot(normal)).sqrt());
            edge
        };
        let (mut edges, mut inner, mut outer) = ([Edge::default(); 3], 0, 3);
        for (k, other) in neighbors.iter().enumerate() {
            if other.is_some() {
                edges[inner] = edge(k);
                inner += 1;
            } else {
                outer -= 1;
                edges[outer] = edge(k);
            }
        }
        Self { origin: points[0], axes: [x, y, normal], edges, inner, height_factors }
    }
}

impl DistanceBound for FaceFrame {
    #[inline(always)]
    fn squared<S: Simd>(&self, simd: S, point: [S::f64s; 3]) -> S::f64s {
        let (zero, none) = (simd.splat_f64s(0.0), simd.splat_f64s(f64::INFINITY));
        let point = from_origin(simd, point, self.origin);
        let at =
            [dot(simd, point, self.axes[0].to_array()), dot(simd, point, self.axes[1].to_array())];
        let height = dot(simd, point, self.axes[2].to_array());
        let mut above = simd.mul_f64s(height, simd.splat_f64s(self.height_factors[0]));
        let mut below = simd.mul_f64s(height, simd.splat_f64s(-self.height_factors[1]));
        let mut over_next = zero;
        // A loop over all three edges is unrolled; one over the inner edges would not be.
        for k in 0..3 {
            if k < self.inner {
                let edge = &self.edges[k];
                let beyond = simd.max_f64s(edge.beyond(simd, at), zero);
                above = simd.mul_add_e_f64s(beyond, simd.splat_f64s(edge.falls), above);
                below = simd.mul_add_e_f64s(beyond, simd.splat_f64s(edge.rises), below);
                over_next = simd.max_f64s(over_next, beyond);
            }
        }
        // The nearest of the outer edges that a point is beyond.
        let over_next = simd.greater_than_f64s(over_next, zero);
        let mut lateral = none;
        for k in 0..3 {
            if k >= self.inner {
                lateral =
                    simd.min_f64s(lateral, self.edges[k].distance_squared(simd, at, over_next));
            }
        }
        let lateral = simd.select_f64s(simd.less_than_f64s(lateral, none), lateral, zero);
        let height = simd.max_f64s(above, below);
        simd.mul_add_e_f64s(height, height, lateral)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;
    use pulp::{Arch, WithSimd};

    use super::super::distance_bound::max_bound;
    use super::*;

    /// The bound of a homogeneous point.
    struct Bound<'a>(&'a FaceFrame, DVec4);

    impl WithSimd for Bound<'_> {
        type Output = f64;

        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            max_bound(simd, self.0, &[self.1], f64::INFINITY)
        }
    }

    fn bound(frame: &FaceFrame, h: DVec4) -> f64 {
        Arch::new().dispatch(Bound(frame, h))
    }

    /// A right triangle in z = 0; at its long edge the next face rises at 45°.
    fn valley() -> FaceFrame {
        let up = DVec3::new(-1.0, -1.0, 2.0_f64.sqrt()) / 2.0;
        FaceFrame::new([DVec3::ZERO, DVec3::X, DVec3::Y], DVec3::Z, [None, Some(up), None])
    }

    #[test]
    fn bounds_of_points_beside_one_edge_are_distances() {
        let bound =
            |x: f64, y: f64, z: f64| bound(&valley(), (2.0 * DVec3::new(x, y, z)).extend(2.0));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        close(bound(0.2, 0.2, -0.1), 0.1);
        close(bound(0.2, 0.2, 0.1), 0.1 / (std::f64::consts::PI / 8.0).cos());
        close(bound(0.4, -0.3, -0.4), 0.5);
        close(bound(-0.3, -0.4, 0.0), 0.5);
        // Over the next face, which rises: farther from it below.
        let (beyond, slope) = (0.2 * 2.0_f64.sqrt(), 0.5_f64.sqrt());
        close(bound(0.7, 0.7, -0.1), 0.1 + slope * beyond);
    }

    #[test]
    fn beyond_an_acute_corner_the_bound_is_the_distance_of_the_corner() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.5, 0.0)];
        let frame = FaceFrame::new(points, DVec3::Z, [None; 3]);
        let bound = |x: f64, y: f64| bound(&frame, DVec4::new(x, y, 0.0, 1.0));
        // Beyond one edge only, and past its end.
        assert!((bound(-0.03, -0.04) - 0.05).abs() < 1e-15);
        assert!((bound(0.03, -0.04) - 0.04).abs() < 1e-15);
        assert!((bound(1.04, -0.03) - 0.05).abs() < 1e-15);
    }
}
