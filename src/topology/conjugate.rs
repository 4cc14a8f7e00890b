//! The conjugate of a harmonic function: what grows across it as fast as it does along itself.

use std::collections::{BinaryHeap, VecDeque};

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::circle::Circle;
use super::form::Course;
use super::laplacian::Laplacian;
use crate::cloud::{NeighborGraph, Plane};

/// Cosine of the angle from which on neighbours' vectors point to opposite sides: 120 degrees.
const OPPOSITE: f64 = -0.5;

/// Share of a period, by which a sum of steps may be off a whole number of them, and share of the edges where it is
/// farther off at most.
const OFF: f64 = 0.2;
const SELDOM: f64 = 0.05;

/// Neighbours whose slopes point to opposite sides, for each point across a surface, from which on it has one side
/// only.
const ONE_SIDED: f64 = 0.25;

/// Slopes across a function of which the steps between points near one another are known.
pub(super) struct Conjugate<'a> {
    points: &'a [DVec3],
    graph: &'a NeighborGraph,
    /// All to the same side of the surface, whichever that is.
    slopes: Vec<DVec3>,
}

impl<'a> Conjugate<'a> {
    /// That of an angle, in turns.
    pub(super) fn of_turns(points: &'a [DVec3], turns: &[f64], graph: &'a NeighborGraph) -> Self {
        Self::of(points, graph, |from, to| nearer_way(turns[to] - turns[from]))
    }

    /// That of a function with these steps from one of the points to another: its slopes in the tangent planes,
    /// turned by a quarter.
    pub(super) fn of(
        points: &'a [DVec3],
        graph: &'a NeighborGraph,
        step: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let new_list = || (Vec::new(), vec![usize::MAX; points.len()]);
        let mut slopes: Vec<DVec3> = (0..points.len())
            .into_par_iter()
            .map_init(new_list, |(around, seen_from), point| {
                let own = points[point];
                // Neighbours of neighbours show the slope through noise.
                around.clear();
                seen_from[point] = point;
                for edge in graph.edges(point) {
                    for edge in graph.edges(edge.to as usize) {
                        let other = edge.to as usize;
                        if std::mem::replace(&mut seen_from[other], point) != point {
                            around.push(other);
                        }
                    }
                }
                let around = around.iter().copied();
                let plane =
                    Plane::of(std::iter::once(own).chain(around.clone().map(|i| points[i])));
                let (mut moments, mut right) = (DMat2::ZERO, DVec2::ZERO);
                for other in around {
                    let apart = points[other] - own;
                    let apart = DVec2::new(plane.axes[0].dot(apart), plane.axes[1].dot(apart));
                    moments += DMat2::from_cols(apart * apart.x, apart * apart.y);
                    right += step(point, other) * apart;
                }
                let slope = if moments.determinant() > 1e-9 * moments.col(0).x.powi(2) {
                    moments.inverse() * right
                } else {
                    DVec2::ZERO
                };
                // A quarter turn in the tangent plane; on which side is settled below.
                -slope.y * plane.axes[0] + slope.x * plane.axes[1]
            })
            .collect();
        align(&mut slopes, graph);
        Self { points, graph, slopes }
    }

    /// By how much it grows from a point to a neighbour.
    fn rise(&self, from: usize, to: usize) -> f64 {
        0.5 * (self.slopes[from] + self.slopes[to]).dot(self.points[to] - self.points[from])
    }

    /// The coordinate that grows so, as nearly as one can, or its opposite: slopes that were turned by a quarter have
    /// no sense, and it has the one in which it reaches farther from its mean.
    pub(super) fn coordinate(&self) -> Vec<f64> {
        let found = self.nearest(|from, to| self.rise(from, to));
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        let skewness: f64 = found.iter().map(|along| (along - mean).powi(3)).sum();
        found.into_iter().map(|along| skewness.signum() * along).collect()
    }

    /// The angle that grows so, if it is one: who comes back from a way around a torus finds it grown by the same,
    /// a period, whatever the way.
    pub(super) fn circle(&self) -> Option<Circle> {
        if self.opposite() as f64 > ONE_SIDED * (self.points.len() as f64).sqrt() {
            return None;
        }
        let along = self.along_ways();
        let apart = |from: usize, to: usize| along[to] - along[from] - self.rise(from, to);
        let apart_by: Vec<f64> = self.pairs().map(|(from, to)| apart(from, to).abs()).collect();
        let (low, high) = along
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &a| (l.min(a), h.max(a)));
        let wide = |apart: &&f64| **apart > 0.5 * (high - low);
        let mut periods: Vec<f64> = apart_by.iter().filter(wide).copied().collect();
        periods.sort_by(f64::total_cmp);
        // The ways meet along a line as long as the surface.
        let enough = periods.len() as f64 >= (self.points.len() as f64).sqrt();
        let period = *periods.get(periods.len() / 2).filter(|_| enough)?;
        let off = |apart: &&f64| (**apart / period - (**apart / period).round()).abs() > OFF;
        if apart_by.iter().filter(off).count() as f64 > SELDOM * apart_by.len() as f64 {
            return None;
        }
        let turns = self
            .nearest(|from, to| self.rise(from, to) / period + (apart(from, to) / period).round());
        let course = Course::of(self.slopes.iter().map(|slope| period / slope.length()).collect());
        Some(Circle { turns: turns.iter().map(|turn| turn.rem_euclid(1.0)).collect(), course })
    }

    /// How far it has grown along ways of the fewest edges from the first point of each piece.
    fn along_ways(&self) -> Vec<f64> {
        let mut along = vec![f64::NAN; self.points.len()];
        for first in 0..self.points.len() {
            if along[first].is_nan() {
                along[first] = 0.0;
            }
            let mut queue = VecDeque::from([first]);
            while let Some(from) = queue.pop_front() {
                for edge in self.graph.edges(from) {
                    let to = edge.to as usize;
                    if along[to].is_nan() {
                        along[to] = along[from] + self.rise(from, to);
                        queue.push_back(to);
                    }
                }
            }
        }
        along
    }

    /// The numbers between which there are these steps from neighbour to neighbour, by least squares over the edges
    /// of the graph.
    fn nearest(&self, rise: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let ends = |from: usize| self.graph.edges(from).iter().map(|edge| edge.to as usize);
        let right = |from: usize| -ends(from).map(|to| rise(from, to)).sum::<f64>();
        let right: Vec<f64> = (0..self.graph.len()).map(right).collect();
        Laplacian::of_neighbors(self.graph).solve(&right)
    }

    /// Pairs of neighbours, each once.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let ends = |from| self.graph.edges(from).iter().map(move |edge| (from, edge.to as usize));
        (0..self.graph.len()).flat_map(ends).filter(|(from, to)| from < to)
    }

    /// Between how many neighbours its slopes point to opposite sides, though all have been aligned.
    pub(super) fn opposite(&self) -> usize {
        let units: Vec<DVec3> = self.slopes.iter().map(|slope| slope.normalize_or_zero()).collect();
        self.pairs().filter(|&(from, to)| units[from].dot(units[to]) < OPPOSITE).count()
    }
}

/// The shorter one of the two ways around between places on a circle, from one way in turns.
fn nearer_way(step: f64) -> f64 {
    if step > 0.5 {
        step - 1.0
    } else if step < -0.5 {
        step + 1.0
    } else {
        step
    }
}

/// Turns vectors so that neighbours point the same way, starting from the first of each piece and
/// going on where two are most nearly parallel (H. Hoppe and others, *Surface reconstruction from
/// unorganized points*, 1992).
fn align(vectors: &mut [DVec3], graph: &NeighborGraph) {
    let mut done = vec![false; vectors.len()];
    let units: Vec<DVec3> = vectors.iter().map(|vector| vector.normalize_or_zero()).collect();
    for first in 0..vectors.len() {
        let mut queue = BinaryHeap::from([(0, first, first)]);
        while let Some((_, point, from)) = queue.pop() {
            if std::mem::replace(&mut done[point], true) {
                continue;
            }
            if vectors[point].dot(vectors[from]) < 0.0 {
                vectors[point] = -vectors[point];
            }
            for edge in graph.edges(point) {
                let other = edge.to as usize;
                if !done[other] {
                    let parallel = units[point].dot(units[other]).abs();
                    // The bits of positive numbers are in the order of the numbers.
                    queue.push((parallel.to_bits(), other, point));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::progress::Silent;

    /// Points by two angles in turns, and the circle across the first.
    fn across(place: impl Fn(f64, f64) -> DVec3) -> (Vec<f64>, Option<Circle>) {
        let flat = (0..900)
            .map(f64::from)
            .map(|i| ((0.5 + i * 0.754_877_666).fract(), (i * i * 0.569_840_291).fract()));
        let (turns, other): (Vec<f64>, Vec<f64>) = flat.unzip();
        let points: Vec<DVec3> = turns.iter().zip(&other).map(|(&u, &v)| place(u, v)).collect();
        let graph = NeighborGraph::of(&points, 8, &mut Silent).unwrap();
        (other, Conjugate::of_turns(&points, &turns, &graph).circle())
    }

    #[test]
    fn the_other_loop_of_a_torus_is_found() {
        let torus = |u: f64, v: f64| {
            let out = 4.0 + (TAU * v).cos();
            (out * DVec2::from_angle(TAU * u)).extend((TAU * v).sin())
        };
        let (other, circle) = across(torus);
        let circle = circle.unwrap();
        assert!((circle.course.length / TAU - 1.0).abs() < 0.1, "{}", circle.course.length);
        // Up to sense and start they are the same; nowhere far, as on the outside steps are longer.
        let sum = |sense: f64| {
            let apart = |(a, b): (&f64, &f64)| DVec2::from_angle(TAU * (a - sense * b));
            other.iter().zip(&circle.turns).map(apart).sum::<DVec2>().length() / 900.0
        };
        assert!(sum(1.0).max(sum(-1.0)) > 0.95, "{} {}", sum(1.0), sum(-1.0));
    }

    #[test]
    fn across_a_tube_and_a_strip_with_one_side_is_none() {
        let tube = |u: f64, v: f64| DVec2::from_angle(TAU * u).extend(4.0 * v);
        assert!(across(tube).1.is_none());
        let strip = |u: f64, v: f64| {
            let half = (v - 0.5) * DVec2::from_angle(0.5 * TAU * u);
            ((2.0 + half.x) * DVec2::from_angle(TAU * u)).extend(half.y)
        };
        assert!(across(strip).1.is_none());
    }
}
