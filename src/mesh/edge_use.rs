//! A use of a shell's edge: its curve in (u, v) on the surface of one face.

use glam::{DVec2, DVec3};

use super::surface_bound::SurfaceBound;
use crate::brep::Face;
use crate::error::Result;
use crate::nurbs::{BezierCurve, NurbsCurve, NurbsSurface};

/// Newton steps to the closest point of a curve.
const MAX_STEPS: u32 = 20;

/// Samples of a curve among which a search for the closest point starts.
const SAMPLES: u32 = 16;

/// Last change of the parameter, relative to its range, in a search for a point. The error that is
/// left is of the order of its square.
const CONVERGED: f64 = 1e-8;

/// Parts that a curve is divided into to bound its distance from a chord: their control polygons
/// are close to the curve.
const PARTS: u32 = 4;

/// A curve in (u, v) along an edge.
pub(super) struct EdgeUse<'a> {
    surface: &'a NurbsSurface,
    curve: &'a NurbsCurve,
    /// The Bézier pieces; empty if the curve is a straight line.
    pieces: Vec<BezierCurve>,
    /// Whether the curve runs in the direction of the edge.
    forward: bool,
    bound: SurfaceBound,
    /// Lengths in space per unit of u and v.
    scale: DVec2,
}

impl<'a> EdgeUse<'a> {
    pub(super) fn new(
        face: &'a Face,
        curve: &'a NurbsCurve,
        forward: bool,
        scale: DVec2,
    ) -> Result<Self> {
        let surface: &NurbsSurface = face.surface();
        let straight = curve.control_points().len() == 2;
        let pieces = if straight { vec![] } else { BezierCurve::of(curve)? };
        Ok(Self { surface, curve, pieces, forward, bound: SurfaceBound::new(surface), scale })
    }

    /// The curve's parameters at the start and the end of the edge.
    pub(super) fn ends(&self) -> [f64; 2] {
        let (start, end) = self.curve.knots().domain();
        if self.forward { [start, end] } else { [end, start] }
    }

    pub(super) fn uv(&self, at: f64) -> DVec2 {
        let (points, uv) = (self.curve.control_points(), self.curve.point(at).truncate());
        let &[a, b] = points else { return uv };
        // Without rounding: points on a line of constant u or v must stay on it.
        DVec2::new(if a.x == b.x { a.x } else { uv.x }, if a.y == b.y { a.y } else { uv.y })
    }

    pub(super) fn point(&self, at: f64) -> DVec3 {
        let uv = self.uv(at);
        self.surface.point(uv.x, uv.y)
    }

    pub(super) fn normal(&self, at: f64) -> DVec3 {
        let uv = self.uv(at);
        self.surface.normal(uv.x, uv.y)
    }

    /// The parameter between two others whose point is closest to a point in space.
    pub(super) fn closest(&self, point: DVec3, [from, to]: [f64; 2], near: f64) -> f64 {
        let middle = self.descend(point, [from, to], 0.5 * (from + to));
        let distance = |at: f64| self.point(at).distance(point);
        if distance(middle) <= near {
            return middle;
        }
        let sample = |k: u32| from + f64::from(k) / f64::from(SAMPLES) * (to - from);
        let samples = (1..SAMPLES).map(sample);
        let best = samples.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let other = self.descend(point, [from, to], best.unwrap_or(middle));
        if distance(other) < distance(middle) { other } else { middle }
    }

    /// Newton's method for the closest point, between two parameters.
    fn descend(&self, point: DVec3, [from, to]: [f64; 2], start: f64) -> f64 {
        let mut at = start;
        for _ in 0..MAX_STEPS {
            let (uv, along) = (self.uv(at), self.curve.velocity(at));
            let [foot, by_u, by_v] = self.surface.tangents(uv.x, uv.y);
            let velocity = along.x * by_u + along.y * by_v;
            let step = velocity.dot(point - foot) / velocity.length_squared();
            let next = (at + step).clamp(from.min(to), from.max(to));
            if !next.is_finite() {
                break;
            }
            let change = (next - at).abs();
            at = next;
            if change <= CONVERGED * (to - from).abs() {
                break;
            }
        }
        at
    }

    /// An upper bound of the distance from a segment in space of the surface between the curve and
    /// the straight line in (u, v) that replaces it.
    pub(super) fn bound(&mut self, [from, to]: [f64; 2], ends: [DVec3; 2], limit: f64) -> f64 {
        let (a, b) = (self.uv(from), self.uv(to));
        if self.pieces.is_empty() {
            return self.bound.along([a, b], ends, limit);
        }
        let along = self.scale * (b - a);
        let length = along.length();
        if length == 0.0 {
            return f64::INFINITY;
        }
        let (x, y) = (along / length, along.perp() / length);
        let (mut low, mut high) = (DVec2::ZERO, DVec2::new(length, 0.0));
        self.control_points(from.min(to), from.max(to), |point| {
            let away = self.scale * (point - a);
            let at = DVec2::new(away.dot(x), away.dot(y));
            (low, high) = (low.min(at), high.max(at));
        });
        let corner = |at: DVec2| a + (at.x * x + at.y * y) / self.scale;
        let [p, q, r, s] = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let [p, q, r, s] = [p, q, r, s].map(corner);
        if low.y == high.y {
            return self.bound.along([a, b], ends, limit);
        }
        let first = self.bound.segment_distance([p, q, r], ends, limit);
        if first > limit {
            return first;
        }
        first.max(self.bound.segment_distance([p, r, s], ends, limit))
    }

    /// Passes on points whose convex hull contains the curve between two parameters.
    fn control_points(&self, low: f64, high: f64, mut take: impl FnMut(DVec2)) {
        for piece in &self.pieces {
            let (start, end) = piece.domain();
            let (from, to) = (low.max(start), high.min(end));
            if from >= to {
                continue;
            }
            let share = |at: f64| (at - start) / (end - start);
            for k in 0..PARTS {
                let inside = |k: u32| {
                    let k = f64::from(k) / f64::from(PARTS);
                    share(from) + k * (share(to) - share(from))
                };
                piece.part(inside(k), inside(k + 1)).control_points().for_each(|point| {
                    take(point.truncate());
                });
            }
        }
    }

    /// The largest distance of the curve from the straight line between two of its parameters,
    /// sampled, in coordinates with lengths like those in space.
    pub(super) fn bulge(&self, [from, to]: [f64; 2]) -> f64 {
        if self.pieces.is_empty() {
            return 0.0;
        }
        let a = self.scale * self.uv(from);
        let along = (self.scale * self.uv(to) - a).normalize_or_zero();
        let sample = |k: u32| from + f64::from(k) / f64::from(2 * PARTS) * (to - from);
        let away = |at: f64| along.perp_dot(self.scale * self.uv(at) - a).abs();
        (1..2 * PARTS).map(|k| away(sample(k))).fold(0.0, f64::max)
    }
}
