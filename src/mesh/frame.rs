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

use glam::{DVec2, DVec3, DVec4};

use super::triangle::larger;

/// Coordinates about a face: along its longest edge, across it in its plane, and above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    axes: [DVec3; 3],
    corners: [DVec2; 3],
    edges: [Edge; 3],
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
    /// Whether no other face is beside it.
    outer: bool,
    /// By how much the next face falls away below the plane of this one, and by how much it rises
    /// above it, on each unit.
    falls: f64,
    rises: f64,
}

impl Frame {
    /// Of a face with this normal, and those of the faces beside its edges.
    pub(super) fn new(points: [DVec3; 3], normal: DVec3, beside: [Option<DVec3>; 3]) -> Self {
        let along = [0, 1, 2].map(|k| points[(k + 1) % 3] - points[k]);
        let longest = (1..3).fold(0, |most, k| {
            if along[k].length_squared() > along[most].length_squared() { k } else { most }
        });
        let x = along[longest].normalize_or_zero();
        let y = normal.cross(x);
        let flat = |point: DVec3| DVec2::new(point.dot(x), point.dot(y));
        let corners = points.map(|point| flat(point - points[0]));
        let (mut edges, mut valleys) = ([Edge::default(); 3], [1.0; 2]);
        for (k, edge) in edges.iter_mut().enumerate() {
            let out = along[k].cross(normal).normalize_or_zero();
            edge.out = flat(out);
            edge.at = edge.out.dot(corners[k]);
            let Some(other) = beside[k] else {
                edge.outer = true;
                continue;
            };
            let slope = other.dot(out);
            (edge.falls, edge.rises) = (larger(0.0, slope), larger(0.0, -slope));
            let valley = &mut valleys[usize::from(slope > 0.0)];
            *valley = larger(*valley, 1.0 / (0.5 + 0.5 * other.dot(normal)).sqrt());
        }
        Self { origin: points[0], axes: [x, y, normal], corners, edges, valleys }
    }

    /// The coordinates of a point times its weight, and the weight.
    pub(super) fn coordinates(&self, h: DVec4) -> DVec4 {
        let away = h.truncate() - h.w * self.origin;
        let [x, y, z] = self.axes.map(|axis| axis.dot(away));
        DVec4::new(x, y, z, h.w)
    }

    /// What a point costs.
    pub(super) fn cost(&self, h: &DVec4) -> f64 {
        let one = 1.0 / h.w;
        let (at, height) = (DVec2::new(h.x, h.y) * one, h.z * one);
        let (above, below) = (height * self.valleys[0], -height * self.valleys[1]);
        let beyond = self.edges.each_ref().map(|edge| at.dot(edge.out) - edge.at);
        if beyond.iter().all(|&beyond| beyond <= 0.0) {
            return larger(above, below);
        }
        self.cost_beyond(at, (above, below), beyond)
    }

    /// What a point costs that is not over the face.
    fn cost_beyond(&self, at: DVec2, (mut above, mut below): (f64, f64), beyond: [f64; 3]) -> f64 {
        let (mut aside, mut left, mut over_next) = (0.0, None, false);
        for (k, (edge, beyond)) in self.edges.iter().zip(beyond).enumerate() {
            if beyond <= 0.0 {
                continue;
            }
            if !edge.outer {
                above += edge.falls * beyond;
                below += edge.rises * beyond;
                over_next = true;
                continue;
            }
            aside = match left {
                None => beyond * beyond,
                // Over two edges: from the corner between them.
                Some(before) => {
                    at.distance_squared(self.corners[if before + 1 == k { k } else { 0 }])
                }
            };
            left = Some(k);
        }
        if let Some(k) = left.filter(|_| !over_next) {
            // Past the end of the edge, where another meets it at an acute angle.
            let ends = [self.corners[k], self.corners[(k + 1) % 3]];
            let along = ends[1] - ends[0];
            let share = (at - ends[0]).dot(along);
            if share < 0.0 || share > along.length_squared() {
                aside = larger(aside, at.distance_squared(ends[usize::from(share > 0.0)]));
            }
        }
        let height = larger(above, below);
        (height * height + aside).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A right angle in z = 0, beside the long edge of which a face rises at 45°.
    fn valley() -> Frame {
        let up = DVec3::new(-1.0, -1.0, 2.0_f64.sqrt()) / 2.0;
        Frame::new([DVec3::ZERO, DVec3::X, DVec3::Y], DVec3::Z, [None, Some(up), None])
    }

    #[test]
    fn points_cost_their_distance() {
        let cost = |x: f64, y: f64, z: f64| {
            let point = DVec3::new(x, y, z);
            valley().cost(&valley().coordinates((2.0 * point).extend(2.0)))
        };
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
        let cost = |x: f64, y: f64| frame.cost(&DVec4::new(x, y, 0.0, 1.0));
        // Beyond one edge only, but beside its end.
        assert!((cost(-0.03, -0.04) - 0.05).abs() < 1e-15);
        assert!((cost(0.03, -0.04) - 0.04).abs() < 1e-15);
        assert!((cost(1.04, -0.03) - 0.05).abs() < 1e-15);
    }
}
