//! The triangles between the loops of a face and its kept cells, refined until the tolerance holds.
//!
//! A triangle is certified alone. The surface over its part of (u, v) is close to it, and the
//! surface's curve over each inner side is close to that side. Along the loops the edges' chords
//! are certified with the strip between the curve and the chord. So, seen along a triangle's
//! normal, the face covers it except near its sides, and the bound holds in both directions.

use std::collections::{BTreeSet, HashMap};

use glam::{DVec2, DVec3};

use super::edge_points::tolerance_with_gap;
use super::options::Limits;
use super::outline::{Node, Origin};
use super::strip_triangulation::{StripTriangle, StripTriangulation};
use super::surface_bound::SurfaceBound;
use crate::nurbs::NurbsSurface;

/// Rounds of refinement at most.
const MAX_ROUNDS: usize = 24;

/// Cosine of the largest angle between a triangle and the surface at its center.
const MIN_FOLD_COSINE: f64 = 0.5;

/// Length of an inner side, relative to the longest side, from which on it is halved. The center of
/// the triangle is added if all inner sides are shorter.
const MIN_HALVED_SIDE: f64 = 0.5;

/// The refinement of a strip.
pub(super) struct Strip<'a> {
    pub surface: &'a NurbsSurface,
    pub limits: &'a Limits,
    pub nodes: Vec<Node>,
    /// The distance of each node of the outline from its place on the surface.
    gaps: Vec<f64>,
    bound: SurfaceBound,
    /// The bounds of triangles that are fine.
    certified: HashMap<[usize; 3], f64>,
    /// The bounds of inner sides.
    sides: HashMap<[usize; 2], f64>,
    /// The largest certified distance.
    pub deviation: f64,
    /// Whether all triangles are certified within the tolerance.
    pub is_proven: bool,
}

/// How a triangle that is not fine is divided.
#[derive(Clone, Copy, Debug)]
enum Cut {
    /// At the middle of a side.
    Side([usize; 2]),
    /// At the center.
    Center([usize; 3]),
}

impl<'a> Strip<'a> {
    pub(super) fn new(surface: &'a NurbsSurface, limits: &'a Limits, nodes: Vec<Node>) -> Self {
        let gap = |node: &Node| surface.point(node.uv.x, node.uv.y).distance(node.point);
        let outline = nodes.iter().take_while(|node| node.origin != Origin::Inside);
        let gaps = outline.map(gap).collect();
        let bound = SurfaceBound::new(surface);
        let (certified, sides) = (HashMap::new(), HashMap::new());
        let (deviation, is_proven) = (0.0, false);
        Self { surface, limits, nodes, gaps, bound, certified, sides, deviation, is_proven }
    }

    /// Refines a triangulation; returns the triangles, without those that are a line at a pole.
    ///
    /// Inner sides between two of the `forbidden` pairs of origins are halved.
    pub(super) fn refine(
        &mut self,
        triangulation: &mut StripTriangulation,
        forbidden: &BTreeSet<[Origin; 2]>,
    ) -> Vec<[usize; 3]> {
        for round in 0.. {
            let triangles = triangulation.triangles();
            let mut cuts = vec![];
            self.deviation = 0.0;
            for triangle in &triangles {
                match self.bound(triangle, self.limit(triangle.nodes)) {
                    Ok(bound) => self.deviation = self.deviation.max(bound),
                    Err(cut) => cuts.push(cut),
                }
            }
            self.is_proven = cuts.is_empty();
            cuts.extend(self.overused(&triangles, forbidden));
            if round < MAX_ROUNDS && self.cut(&cuts, triangulation) > 0 {
                continue;
            }
            if !self.is_proven {
                let bounds = triangles.iter().map(|t| self.bound(t, f64::INFINITY));
                self.deviation = bounds.map(|b| b.unwrap_or(f64::INFINITY)).fold(0.0, f64::max);
            }
            let proper = triangles.iter().filter(|triangle| !self.is_line(triangle.nodes));
            return proper.map(|triangle| triangle.nodes).collect();
        }
        vec![]
    }

    /// Cuts of inner sides that are forbidden, or that more than two triangles would share.
    fn overused(&self, triangles: &[StripTriangle], forbidden: &BTreeSet<[Origin; 2]>) -> Vec<Cut> {
        let vertex = |k: usize| match self.nodes[k].origin {
            Origin::Inside => (Origin::Inside, k),
            origin => (origin, 0),
        };
        let mut sides = vec![];
        for triangle in triangles.iter().filter(|triangle| !self.is_line(triangle.nodes)) {
            for k in 0..3 {
                let ends = [triangle.nodes[k], triangle.nodes[(k + 1) % 3]];
                let [a, b] = ends.map(vertex);
                sides.push(([a.min(b), a.max(b)], triangle.fixed[k], ends));
            }
        }
        sides.sort_unstable();
        let shared = sides.chunk_by(|a, b| a.0 == b.0).filter(|run| {
            let [a, b] = run[0].0;
            run.len() > 2 || forbidden.contains(&[a.0, b.0])
        });
        shared.flatten().filter(|side| !side.1).map(|side| Cut::Side(side.2)).collect()
    }

    /// The limit for a triangle.
    fn limit(&self, nodes: [usize; 3]) -> f64 {
        let gap = |k: usize| self.gaps.get(k).copied().unwrap_or(0.0);
        tolerance_with_gap(self.limits, nodes.map(gap).into_iter().fold(0.0, f64::max))
    }

    /// Whether two nodes are the same vertex.
    fn same(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.nodes[a].origin, self.nodes[b].origin);
        a == b && a != Origin::Inside
    }

    /// Whether two corners of a triangle are the same vertex.
    fn is_line(&self, [a, b, c]: [usize; 3]) -> bool {
        self.same(a, b) || self.same(b, c) || self.same(c, a)
    }

    fn uv(&self, nodes: [usize; 3]) -> [DVec2; 3] {
        nodes.map(|k| self.nodes[k].uv)
    }

    fn points(&self, nodes: [usize; 3]) -> [DVec3; 3] {
        nodes.map(|k| self.nodes[k].point)
    }

    /// The certified distance of a triangle, or how to divide it.
    fn bound(&mut self, triangle: &StripTriangle, limit: f64) -> Result<f64, Cut> {
        if self.is_line(triangle.nodes) {
            return self.bound_of_line(triangle, limit);
        }
        let mut key = triangle.nodes;
        key.rotate_left((0..3).min_by_key(|k| triangle.nodes[*k]).unwrap_or(0));
        let mut most = if let Some(bound) = self.certified.get(&key) {
            *bound
        } else {
            let (uv, points) = (self.uv(triangle.nodes), self.points(triangle.nodes));
            let found = self.bound.triangle_distance(uv, points, limit);
            if limit.is_finite() && (found > limit || self.is_folded(uv, points)) {
                return Err(self.cut_of(triangle));
            }
            self.certified.insert(key, found);
            found
        };
        for k in 0..3 {
            let ends = [triangle.nodes[k], triangle.nodes[(k + 1) % 3]];
            // A line beyond the side is certified with its own sides.
            let line = triangle.opposite[k].is_some_and(|o| self.is_line([ends[1], ends[0], o]));
            if triangle.fixed[k] || line {
                continue;
            }
            let found = self.bound_of_side(ends, limit);
            if limit.is_finite() && (found > limit || self.exceeds_other_limits(ends)) {
                return Err(Cut::Side(ends));
            }
            most = most.max(found);
        }
        Ok(most)
    }

    /// The same for a triangle that is a line in space. It is close to the triangle beyond one of
    /// its two long sides, whose other sides bound both.
    fn bound_of_line(&mut self, triangle: &StripTriangle, limit: f64) -> Result<f64, Cut> {
        let short = (0..3).find(|&k| self.same(triangle.nodes[k], triangle.nodes[(k + 1) % 3]));
        let short = short.unwrap_or(0);
        let uv = self.uv(triangle.nodes);
        for (beyond, other) in [(short + 1, short + 2), (short + 2, short + 1)] {
            let (beyond, other) = (beyond % 3, other % 3);
            let side = |k: usize| [triangle.nodes[k], triangle.nodes[(k + 1) % 3]];
            let Some(opposite) = triangle.opposite[beyond].filter(|_| !triangle.fixed[beyond])
            else {
                continue;
            };
            let next = [side(beyond)[1], side(beyond)[0], opposite];
            if self.is_line(next) {
                continue;
            }
            let found = self.bound.triangle_distance(uv, self.points(next), limit);
            if found > limit {
                continue;
            }
            let rest =
                if triangle.fixed[other] { 0.0 } else { self.bound_of_side(side(other), limit) };
            if rest <= limit {
                return Ok(found.max(rest));
            }
        }
        let [a, b] = [triangle.nodes[short], triangle.nodes[(short + 2) % 3]];
        let ends = [self.nodes[a].point, self.nodes[b].point];
        let found = self.bound.segment_distance(uv, ends, limit);
        if found <= limit { Ok(found) } else { Err(Cut::Center(triangle.nodes)) }
    }

    /// The distance of the surface's curve over a side from that side.
    fn bound_of_side(&mut self, [a, b]: [usize; 2], limit: f64) -> f64 {
        let key = [a.min(b), a.max(b)];
        if let Some(found) = self.sides.get(&key).filter(|found| **found <= limit) {
            return *found;
        }
        let (uv, points) = (key.map(|k| self.nodes[k].uv), key.map(|k| self.nodes[k].point));
        let found = self.bound.along(uv, points, limit);
        self.sides.insert(key, found);
        found
    }

    /// Whether a triangle turns away from the surface.
    fn is_folded(&self, uv: [DVec2; 3], [a, b, c]: [DVec3; 3]) -> bool {
        let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let center = (uv[0] + uv[1] + uv[2]) / 3.0;
        let cross = (b - a).cross(c - a);
        size > self.limits.tolerance
            && cross.dot(self.surface.normal(center.x, center.y)) < MIN_FOLD_COSINE * cross.length()
    }

    /// Whether a side exceeds the limits of lengths or angles.
    fn exceeds_other_limits(&self, ends: [usize; 2]) -> bool {
        let [a, b] = ends.map(|k| self.nodes[k]);
        if self.limits.edge.is_some_and(|most| a.point.distance(b.point) > most) {
            return true;
        }
        let normal = |node: &Node| self.surface.normal(node.uv.x, node.uv.y);
        self.limits.cosine.is_some_and(|cosine| normal(&a).dot(normal(&b)) < cosine)
    }

    /// How to divide a triangle: at its longest inner side, or in its center if that is short.
    fn cut_of(&self, triangle: &StripTriangle) -> Cut {
        let side = |k: usize| [triangle.nodes[k], triangle.nodes[(k + 1) % 3]];
        let length = |k: usize| {
            let [a, b] = side(k).map(|k| self.nodes[k].point);
            a.distance(b)
        };
        let all = (0..3).map(length).fold(0.0, f64::max);
        let longest = |a: &usize, b: &usize| length(*a).total_cmp(&length(*b));
        match (0..3).filter(|k| !triangle.fixed[*k]).max_by(longest) {
            Some(k) if length(k) >= MIN_HALVED_SIDE * all => Cut::Side(side(k)),
            _ => Cut::Center(triangle.nodes),
        }
    }

    /// Adds the nodes of some cuts; returns their number.
    fn cut(&mut self, cuts: &[Cut], triangulation: &mut StripTriangulation) -> usize {
        let mut done = BTreeSet::new();
        let before = self.nodes.len();
        for cut in cuts {
            let uv = match *cut {
                Cut::Side([a, b]) => {
                    if !done.insert([a.min(b), a.max(b)]) {
                        continue;
                    }
                    0.5 * (self.nodes[a].uv + self.nodes[b].uv)
                }
                Cut::Center(nodes) => {
                    let [a, b, c] = self.uv(nodes);
                    (a + b + c) / 3.0
                }
            };
            if triangulation.insert(uv, self.nodes.len()) {
                let point = self.surface.point(uv.x, uv.y);
                self.nodes.push(Node { uv, point, origin: Origin::Inside });
            }
        }
        self.nodes.len() - before
    }
}
