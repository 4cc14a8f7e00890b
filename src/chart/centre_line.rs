//! Tubes about a bent centre line, in the order of distances along them.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::angles::{Angles, radius, unit};
use super::hypothesis::Hypothesis;
use super::input::{ChartInput, Graph};
use super::kind::Kind;
use super::traits::Chart;
use crate::numeric::{median, whole};

/// Nodes of the centre line.
const NODES: (f64, f64) = (5.0, 24.0);

/// Distance between nodes, in median distances of points from the line in the flat map.
const STEP: f64 = 2.5;

/// Turns in which points are ordered by their projections onto the line.
const SETTLING: usize = 3;

/// Tubes by the first coordinate of Isomap and a frame carried along the line in parallel.
pub(super) struct CentreLine;

impl Chart for CentreLine {
    fn name(&self) -> &'static str {
        "centre line"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Tube]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        tube(input).into_iter().collect()
    }
}

fn tube(input: &ChartInput<'_>) -> Option<Hypothesis> {
    let (map, points) = (input.landmark_map(Graph::Surface)?, input.seen.points());
    let along: Vec<f64> = map.places.iter().map(|place| place.x).collect();
    let (along, length) = unit(&along);
    let width = STEP * median(map.places.iter().map(|place| place.y.abs()));
    let nodes = whole((length / width).clamp(NODES.0, NODES.1));
    let (along, length, line) = Line::settled(points, along, length, nodes)?;
    let sections: Vec<DVec2> =
        points.iter().zip(&along).map(|(point, at)| line.section(*point, *at)).collect();
    let angles = Angles::of(sections.iter().copied());
    if !angles.closed() {
        return None;
    }
    let uv = angles.turns.iter().zip(&along).map(|(u, v)| DVec2::new(*u, *v)).collect();
    Some(Hypothesis::new("centre line", Kind::Tube, uv, [TAU * radius(&sections), length]))
}

/// A polygon with a normal at each node, turned as little as can be (parallel transport).
struct Line {
    nodes: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl Line {
    /// Through points in an order that becomes that of their projections onto the line: sections
    /// are square to it then.
    fn settled(
        points: &[DVec3],
        mut along: Vec<f64>,
        mut length: f64,
        nodes: usize,
    ) -> Option<(Vec<f64>, f64, Self)> {
        for _ in 0..SETTLING {
            let line = Self::through(points, &along, nodes)?;
            let places: Vec<f64> = points.iter().map(|point| line.place(*point)).collect();
            (along, length) = unit(&places);
        }
        let line = Self::through(points, &along, nodes)?;
        Some((along, length, line))
    }

    /// The length along the line to the nearest place to a point; its end segments go on.
    fn place(&self, point: DVec3) -> f64 {
        let (mut start, mut best) = (0.0, (f64::INFINITY, 0.0));
        let last = self.nodes.len() - 2;
        for (i, ends) in self.nodes.windows(2).enumerate() {
            let (way, length) = (ends[1] - ends[0], ends[0].distance(ends[1]));
            let low = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
            let high = if i == last { f64::INFINITY } else { 1.0 };
            let share = ((point - ends[0]).dot(way) / (length * length)).clamp(low, high);
            let square = point.distance_squared(ends[0] + share * way);
            if square < best.0 {
                best = (square, start + share * length);
            }
            start += length;
        }
        best.1
    }

    /// Through the means of the points around each node, weighted by hat functions.
    fn through(points: &[DVec3], along: &[f64], count: usize) -> Option<Self> {
        let (mut sums, mut weights) = (vec![DVec3::ZERO; count], vec![0.0; count]);
        for (point, at) in points.iter().zip(along) {
            let (node, share) = between(*at, count);
            for (node, weight) in [(node, 1.0 - share), (node + 1, share)] {
                sums[node] += weight * *point;
                weights[node] += weight;
            }
        }
        let nodes: Vec<DVec3> =
            sums.iter().zip(&weights).map(|(sum, weight)| *sum / *weight).collect();
        let tangents: Vec<DVec3> = (0..count)
            .map(|i| {
                (nodes[(i + 1).min(count - 1)] - nodes[i.saturating_sub(1)]).normalize_or_zero()
            })
            .collect();
        let mut normals = vec![tangents[0].try_normalize()?.any_orthonormal_vector()];
        for tangent in &tangents[1..] {
            let carried = normals[normals.len() - 1].reject_from(*tangent);
            normals.push(carried.try_normalize()?);
        }
        Some(Self { nodes, normals })
    }

    /// A point by its coordinates across the line.
    fn section(&self, point: DVec3, at: f64) -> DVec2 {
        let (node, share) = between(at, self.nodes.len());
        let centre = self.nodes[node].lerp(self.nodes[node + 1], share);
        let tangent = (self.nodes[node + 1] - self.nodes[node]).normalize_or_zero();
        let normal = self.normals[node].lerp(self.normals[node + 1], share).normalize_or_zero();
        let apart = point - centre;
        DVec2::new(apart.dot(normal), apart.dot(tangent.cross(normal)))
    }
}

/// The node before a place in [0, 1], and the share of the way to the next.
fn between(at: f64, count: usize) -> (usize, f64) {
    let place = at * (count - 1) as f64;
    let node = whole(place).min(count - 2);
    (node, place - node as f64)
}
