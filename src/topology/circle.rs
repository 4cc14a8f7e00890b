//! Angles around the loops of a surface.
//!
//! A loop's cocycle counts whole turns along edges; the harmonic one in its class spreads each
//! turn evenly along the surface (de Silva, Morozov, Vejdemo-Johansson 2011, section 3.3).

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cohomology::{Edge, loops};
use super::form::{Course, Form, evenest, shorten, weight};
use super::laplacian::Laplacian;
use super::spread_out::spread_out;
use crate::cloud::{Front, NeighborGraph};

/// One of so many points is a landmark, between which loops are looked for. With fewer points to a
/// landmark, accidental holes between points look like loops.
const POINTS_PER_LANDMARK: usize = 5;

/// Fewer landmarks show no loop.
const LEAST_LANDMARKS: usize = 60;

/// Landmarks for who looks closest.
const CLOSE_LANDMARKS: usize = 400;

/// Longest edge of the complex, as a multiple of the landmarks' covering radius. Loops around
/// accidental holes between landmarks are filled by 4.8 at the latest (thirty clouds of 200 to 20,000
/// points with and without noise); a loop of the surface is seen if it is longer than three edges.
pub(super) const REACH: f64 = 5.0;

/// A loop of the surface closes by short edges; one of long edges is a gap in the points.
const CLOSED_BY: f64 = 0.75;

/// Landmarks among which a point's angle is interpolated.
const NEAR: usize = 3;

/// The landmarks nearest to a point, by their numbers, and how much each counts.
type Near = [(f64, usize); NEAR];

/// Rounds in which each point takes the mean angle of its neighbours.
const SMOOTHING: usize = 6;

/// Angles around a loop of the surface.
pub(super) struct Circle {
    /// For each point, in turns, from 0 to 1.
    pub(super) turns: Vec<f64>,
    /// What loops along it are like.
    pub(super) course: Course,
}

/// Loops of a surface: each other one is a sum of the shortest.
pub(super) struct Loops {
    /// Longest first.
    pub(super) shortest: Vec<Circle>,
    /// Their sum or difference that is the evenest, if it is none of them.
    pub(super) sum: Option<Circle>,
}

impl Loops {
    pub(super) fn all(&self) -> impl Iterator<Item = &Circle> {
        self.shortest.iter().chain(&self.sum)
    }
}

/// Points spread out over all, and the ways to those around them.
pub(super) struct Landmarks<'a> {
    graph: &'a NeighborGraph,
    chosen: Vec<u32>,
    /// The distance from points to their landmarks, the largest.
    apart: f64,
    /// For each landmark the points within reach of it with the lengths of the ways to them.
    around: Vec<Vec<(u32, f64)>>,
}

impl<'a> Landmarks<'a> {
    pub(super) fn of(points: &[DVec3], graph: &'a NeighborGraph) -> Self {
        let count = (points.len() / POINTS_PER_LANDMARK).max(LEAST_LANDMARKS);
        Self::so_many(count, points, graph)
    }

    /// More of them, all of few points: among these holes between points look like loops, too.
    pub(super) fn close(points: &[DVec3], graph: &'a NeighborGraph) -> Self {
        Self::so_many(CLOSE_LANDMARKS, points, graph)
    }

    fn so_many(count: usize, points: &[DVec3], graph: &'a NeighborGraph) -> Self {
        let (chosen, radius) = spread_out(points, count.min(points.len()));
        let apart = radius.max(usual_spacing(graph));
        let around = surroundings(graph, &chosen, REACH * apart);
        Self { graph, chosen, apart, around }
    }

    /// The loops of the surface that points lie on: those that no piece of the surface fills, and
    /// that are longer than three times `reach` times the distance from points to their landmarks.
    pub(super) fn loops(&self, reach: f64) -> Loops {
        debug_assert!(reach <= REACH);
        let reach = reach * self.apart;
        let edges = self.edges(reach);
        let vertices = self.chosen.len();
        let both_ways = |edge: &Edge| {
            let weight = weight(edge);
            [(edge.from, edge.to, weight), (edge.to, edge.from, weight)]
        };
        let laplacian = Laplacian::of(vertices, edges.iter().flat_map(both_ways));
        let forms = || -> Vec<Form> {
            let lasting = loops(vertices, &edges).into_par_iter();
            lasting
                .filter(|cocycle| cocycle.birth <= CLOSED_BY * reach)
                .map(|cocycle| Form::harmonic(&laplacian, &edges, &cocycle.values, vertices))
                .collect()
        };
        let (mut forms, near) = rayon::join(forms, || self.nearest(reach));
        shorten(&mut forms, &edges);
        let circle = |form: &Form| self.circle(form, &edges, &near);
        let sum = evenest(&forms, &edges).as_ref().map(circle);
        Loops { sum, shortest: forms.iter().map(circle).collect() }
    }

    fn circle(&self, form: &Form, edges: &[Edge], near: &[Near]) -> Circle {
        Circle { turns: self.turns_of_points(form, near), course: form.course(edges) }
    }

    /// The angles of all points: between those of the nearest landmarks, then smoothed.
    fn turns_of_points(&self, form: &Form, near: &[Near]) -> Vec<f64> {
        let direction = |near: &Near| {
            let weighted = near
                .iter()
                .map(|&(weight, landmark)| weight * DVec2::from_angle(TAU * form.angles[landmark]));
            weighted.sum::<DVec2>().normalize_or(DVec2::X)
        };
        let mut directions: Vec<DVec2> = near.par_iter().map(direction).collect();
        for _ in 0..SMOOTHING {
            let mean = |point: usize| {
                let around =
                    self.graph.edges(point).iter().map(|edge| directions[edge.to as usize]);
                (directions[point] + around.sum::<DVec2>()).normalize_or(directions[point])
            };
            directions = (0..near.len()).into_par_iter().map(mean).collect();
        }
        directions.iter().map(|d| (d.y.atan2(d.x) / TAU).rem_euclid(1.0)).collect()
    }

    /// The pairs of landmarks within reach of one another, nearest first.
    fn edges(&self, reach: f64) -> Vec<Edge> {
        let mut numbers = vec![u32::MAX; self.graph.len()];
        (0..).zip(&self.chosen).for_each(|(number, &point)| numbers[point as usize] = number);
        let mut edges = Vec::new();
        for (from, around) in (0_u32..).zip(&self.around) {
            for &(point, length) in around {
                let to = numbers[point as usize];
                if to != u32::MAX && from < to && length <= reach {
                    edges.push(Edge { from, to, length });
                }
            }
        }
        edges.sort_unstable_by(|a, b| {
            a.length.total_cmp(&b.length).then((a.from, a.to).cmp(&(b.from, b.to)))
        });
        edges
    }

    /// For each point the landmarks nearest to it, with their weights.
    fn nearest(&self, reach: f64) -> Vec<Near> {
        let mut near = vec![[(f64::INFINITY, 0); NEAR + 1]; self.graph.len()];
        for (landmark, around) in self.around.iter().enumerate() {
            for &(point, distance) in around.iter().filter(|(_, distance)| *distance <= reach) {
                let known = &mut near[point as usize];
                if distance < known[NEAR].0 {
                    let at = known.partition_point(|(other, _)| *other <= distance);
                    known[at..].rotate_right(1);
                    known[at] = (distance, landmark);
                }
            }
        }
        let weighted = |known: [(f64, usize); NEAR + 1]| {
            let mut found = known.iter().map(|near| near.0).filter(|distance| distance.is_finite());
            let farthest = found.next_back().unwrap_or(1.0).max(f64::MIN_POSITIVE);
            std::array::from_fn(|k| {
                let (distance, landmark) = known[k];
                let weight = (1.0 - distance / farthest).max(0.01);
                (if distance.is_finite() { weight } else { 0.0 }, landmark)
            })
        };
        near.into_iter().map(weighted).collect()
    }
}

/// The median spacing.
fn usual_spacing(graph: &NeighborGraph) -> f64 {
    let mut spacings: Vec<f64> = (0..graph.len()).map(|node| graph.spacing(node)).collect();
    spacings.sort_by(f64::total_cmp);
    spacings.get(spacings.len() / 2).copied().unwrap_or(0.0)
}

/// For each landmark the points around it with the lengths of the ways to them.
fn surroundings(graph: &NeighborGraph, landmarks: &[u32], reach: f64) -> Vec<Vec<(u32, f64)>> {
    let around = |(distances, front): &mut (Vec<f64>, Front), &landmark: &u32| {
        graph.walk(&[landmark], reach, distances, front);
        let length = |&point: &u32| {
            (point, std::mem::replace(&mut distances[point as usize], f64::INFINITY))
        };
        front.reached.iter().map(length).collect()
    };
    let nothing = || (vec![f64::INFINITY; graph.len()], Front::default());
    landmarks.par_iter().map_init(nothing, around).collect()
}
