//! Center-line chart: tubes about a bent line, ordered by distances along the surface.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::angles::{Angles, radius, unit};
use super::hypothesis::Hypothesis;
use super::input::{ChartInput, Graph};
use super::kind::Kind;
use super::settings::CenterLineSettings;
use super::traits::Chart;
use crate::numeric::{median, whole};

const SETTINGS: CenterLineSettings = CenterLineSettings::STANDARD;

/// Tubes by the first coordinate of Isomap and a frame transported in parallel along the line.
pub(super) struct CenterLine;

impl Chart for CenterLine {
    fn name(&self) -> &'static str {
        "center line"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Tube]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        tube(input).into_iter().collect()
    }
}

/// The tube about the center line; `None` if a section is not closed.
fn tube(input: &ChartInput<'_>) -> Option<Hypothesis> {
    let (map, points) = (input.landmark_map(Graph::Surface)?, input.observations.points());
    let along: Vec<f64> = map.places.iter().map(|place| place.x).collect();
    let (along, length) = unit(&along);
    let width = SETTINGS.node_distance * median(map.places.iter().map(|place| place.y.abs()));
    let nodes = whole((length / width).clamp(SETTINGS.min_nodes, SETTINGS.max_nodes));
    let (along, length, line) = Line::iterated(points, along, length, nodes)?;
    let sections: Vec<DVec2> =
        points.iter().zip(&along).map(|(point, at)| line.section(*point, *at)).collect();
    let angles = Angles::of(sections.iter().copied());
    if !angles.closed() {
        return None;
    }
    let uv = angles.turns.iter().zip(&along).map(|(u, v)| DVec2::new(*u, *v)).collect();
    Some(Hypothesis::new("center line", Kind::Tube, uv, [TAU * radius(&sections), length]))
}

/// A polygon with a normal at each node that twists as little as possible (parallel transport).
struct Line {
    nodes: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl Line {
    /// The line through points, with the points' parameters along it and its length.
    ///
    /// The parameters are iterated until they are those of the projections onto the line. Sections
    /// are perpendicular to the line then.
    fn iterated(
        points: &[DVec3],
        mut along: Vec<f64>,
        mut length: f64,
        nodes: usize,
    ) -> Option<(Vec<f64>, f64, Self)> {
        for _ in 0..SETTINGS.iterations {
            let line = Self::through(points, &along, nodes)?;
            let places: Vec<f64> = points.iter().map(|point| line.place(*point)).collect();
            (along, length) = unit(&places);
        }
        let line = Self::through(points, &along, nodes)?;
        Some((along, length, line))
    }

    /// The length along the line to the projection of a point. The end segments are extended.
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

    /// The line through the means of the points around each node, weighted by hat functions.
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

    /// The coordinates of a point in the section across the line at `at`.
    fn section(&self, point: DVec3, at: f64) -> DVec2 {
        let (node, share) = between(at, self.nodes.len());
        let center = self.nodes[node].lerp(self.nodes[node + 1], share);
        let tangent = (self.nodes[node + 1] - self.nodes[node]).normalize_or_zero();
        let normal = self.normals[node].lerp(self.normals[node + 1], share).normalize_or_zero();
        let apart = point - center;
        DVec2::new(apart.dot(normal), apart.dot(tangent.cross(normal)))
    }
}

/// The node before a parameter in [0, 1], and the share of the way to the next.
fn between(at: f64, count: usize) -> (usize, f64) {
    let place = at * (count - 1) as f64;
    let node = whole(place).min(count - 2);
    (node, place - node as f64)
}
