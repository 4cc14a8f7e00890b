//! Parametrizations that a search for a net begins at, all from one.
//!
//! The one that is known is about in proportion to lengths; that of the net that is looked for may be
//! faster or slower at the ends of the domain, and at one end than at the other.

use std::f64::consts::TAU;

use glam::{BVec2, DVec2};

use super::space::SplineSpace;
use crate::nurbs::{KnotVector, padded};

/// Ways from the parameters that were found, about in proportion to lengths, towards those of a net
/// whose control points are evenly spaced, which begin and end three times as fast.
const EVENNESS: [f64; 6] = [0.5, -0.25, 0.75, 0.25, 0.0, 1.0];

/// Turns in closed directions, in spans.
const TURNS: [f64; 3] = [0.0, 1.0 / 3.0, 2.0 / 3.0];

/// Speeds at the beginning beside those in the middle, the inverse of those at the end, of parametrizations that are
/// graded, from one end to the other up to eight times as fast, and their ways towards evenness.
const SKEWS: [f64; 7] = [0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8];
const EVENNESS_OF_GRADED: [f64; 2] = [1.0, 0.5];

/// How far around a place parameters are moved and by how much, in spans, and in how many directions.
const RADII: [f64; 2] = [1.0, 2.0];
const LENGTHS: [f64; 2] = [0.3, 0.8];
const DIRECTIONS: usize = 8;

/// Places of a net's parameters that are known, for those between.
const PLACES: usize = 256;

/// How parameters are moved in a direction.
#[derive(Clone, Copy)]
enum Move {
    /// By so many spans, in a closed direction.
    Turn(f64),
    /// So far towards evenness, and then skewed, in an open one.
    Stretch { evenness: f64, skew: f64 },
}

/// Parameters of points on a surface of a space, from which others are made.
#[derive(Clone, Copy)]
pub(super) struct Starts<'a> {
    pub(super) space: &'a SplineSpace,
    pub(super) uv: &'a [DVec2],
}

impl Starts<'_> {
    /// The first ones, as fast at either end.
    pub(super) fn first(&self) -> Vec<Vec<DVec2>> {
        self.moved_by(&EVENNESS.map(|evenness| Move::Stretch { evenness, skew: 1.0 }))
    }

    /// The first ones of parameters that are evenly distributed in open directions, as those of points are that were
    /// taken at even parameters.
    pub(super) fn ranked(&self) -> Vec<Vec<DVec2>> {
        let mut uv = self.uv.to_vec();
        for d in (0..2).filter(|&d| !self.space.closed[d]) {
            let (start, end) = self.space.knots[d].domain();
            let mut order: Vec<usize> = (0..uv.len()).collect();
            order.sort_by(|&a, &b| self.uv[a][d].total_cmp(&self.uv[b][d]));
            for (rank, &i) in order.iter().enumerate() {
                uv[i][d] = start + (end - start) * (rank as f64 + 0.5) / self.uv.len() as f64;
            }
        }
        Starts { uv: &uv, ..*self }.first()
    }

    /// Those that get faster or slower from one end to the other in open directions, otherwise along u than along v.
    pub(super) fn graded(&self) -> Vec<Vec<DVec2>> {
        let skewed = |evenness| SKEWS.map(|skew| Move::Stretch { evenness, skew });
        self.moved_by(EVENNESS_OF_GRADED.map(skewed).as_flattened())
    }

    /// Those that are moved around a place, the less the farther from it: what holds a surface off its points in one
    /// place alone no change of all parameters alike mends.
    pub(super) fn moved_around(&self, place: DVec2) -> Vec<Vec<DVec2>> {
        let &Starts { space, uv } = self;
        let ends = space.knots.each_ref().map(KnotVector::domain);
        let [low, high] = [ends.map(|end| end.0), ends.map(|end| end.1)].map(DVec2::from);
        let breaks = space.knots.each_ref().map(|knots| (knots.breaks().len() - 1) as f64);
        let (size, closed) = (high - low, BVec2::from(space.closed));
        let span = size / DVec2::from(breaks);
        let inside = |uv: DVec2| {
            let round = low + (uv - low).rem_euclid(size);
            DVec2::select(closed, round, uv.clamp(low, high))
        };
        let nearer_way = |by: DVec2| DVec2::select(closed, by - size * (by / size).round(), by);
        let turn = TAU / DIRECTIONS as f64;
        let ways = (0..DIRECTIONS).map(|i| span * DVec2::from_angle(turn * i as f64));
        let moves = ways.flat_map(|way| LENGTHS.map(|length| length * way));
        let moves = moves.flat_map(|by| RADII.map(|radius| (by, radius)));
        let moved = |(by, radius): (DVec2, f64)| {
            let share = |apart: DVec2| (-0.5 * (apart / (radius * span)).length_squared()).exp();
            uv.iter().map(|&uv| inside(uv + share(nearer_way(uv - place)) * by)).collect()
        };
        moves.map(moved).collect()
    }

    /// Pairs of moves, in open directions those, as even along u as along v.
    fn moved_by(&self, stretches: &[Move]) -> Vec<Vec<DVec2>> {
        let ([rows, cols], closed) = (self.space.shape(), self.space.closed);
        let turns = TURNS.map(Move::Turn);
        let choices = closed.map(|closed| if closed { &turns[..] } else { stretches });
        let pairs = choices[0].iter().flat_map(|u| choices[1].iter().map(move |v| [*u, *v]));
        let alike = |pair: &[Move; 2]| match *pair {
            [Move::Stretch { evenness: u, .. }, Move::Stretch { evenness: v, .. }] => u == v,
            _ => true,
        };
        let pairs: Vec<[Move; 2]> = pairs.filter(alike).collect();
        // Points do not tell which way the larger side of the net goes.
        let swapped: Vec<DVec2> = self.uv.iter().map(|uv| DVec2::new(uv.y, uv.x)).collect();
        let both = [self.uv, &swapped];
        let ways = if closed[0] == closed[1] && rows != cols { &both[..] } else { &both[..1] };
        let moved = |uv: &&[DVec2]| pairs.iter().map(|by| self.moved(uv, *by)).collect::<Vec<_>>();
        ways.iter().flat_map(moved).collect()
    }

    fn moved(&self, uv: &[DVec2], by: [Move; 2]) -> Vec<DVec2> {
        let mut moved = uv.to_vec();
        for (d, by) in by.into_iter().enumerate() {
            let knots = &self.space.knots[d];
            let (start, end) = knots.domain();
            let size = end - start;
            let net = EvenNet::of(knots);
            let place = |at: f64| match by {
                Move::Turn(by) => {
                    let turn = by * size / self.space.shape()[d] as f64;
                    start + (at + turn - start).rem_euclid(size)
                }
                Move::Stretch { evenness, skew } => {
                    let share = (at + evenness * (net.parameter(at) - at) - start) / size;
                    start + size * skew * share / (1.0 + (skew - 1.0) * share)
                }
            };
            for uv in &mut moved {
                uv[d] = place(uv[d]);
            }
        }
        moved
    }
}

/// The places on a line whose control points are evenly spaced, as shares of its length.
struct EvenNet<'a> {
    knots: &'a KnotVector,
    places: Vec<f64>,
}

impl<'a> EvenNet<'a> {
    fn of(knots: &'a KnotVector) -> Self {
        let (start, end) = knots.domain();
        let last = (knots.control_points() - 1) as f64;
        let place = |i: usize| {
            let basis = padded(knots, start + (end - start) * i as f64 / PLACES as f64);
            let numbers = basis.values.iter().zip(basis.first..);
            numbers.map(|(value, number)| value * number as f64).sum::<f64>() / last
        };
        Self { knots, places: (0..=PLACES).map(place).collect() }
    }

    /// The parameter that has the place which another parameter is in the domain.
    fn parameter(&self, of: f64) -> f64 {
        let (start, end) = self.knots.domain();
        let place = (of - start) / (end - start);
        let i = self.places.partition_point(|at| *at <= place).clamp(1, PLACES);
        let (low, high) = (self.places[i - 1], self.places[i]);
        let share = (i - 1) as f64 + (place - low) / (high - low);
        start + (end - start) * share / PLACES as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_starts_differ_keep_the_order_and_end_where_the_domain_does() {
        let knots = [6, 7].map(|count| KnotVector::clamped_uniform(3, count).unwrap());
        let space = SplineSpace::new(knots, [false; 2]).unwrap();
        let at = |i: i32| f64::from(i) / 20.0;
        let uv: Vec<DVec2> = (0..=20).map(|i| DVec2::new(at(i), at(i) * at(i))).collect();
        let starts = Starts { space: &space, uv: &uv };
        let (first, graded) = (starts.first(), starts.graded());
        assert_eq!((first.len(), graded.len()), (2 * 6, 2 * 2 * 49));
        for starts in [first, graded] {
            for (i, start) in starts.iter().enumerate() {
                assert!(start.windows(2).all(|pair| pair[0].cmplt(pair[1]).all()));
                assert!(start[0].length() < 1e-12 && start[20].distance(DVec2::ONE) < 1e-12);
                for other in &starts[..i] {
                    assert!(start.iter().zip(other).any(|(a, b)| a.distance(*b) > 0.01));
                }
            }
        }
    }

    #[test]
    fn what_is_moved_around_a_place_stays_elsewhere() {
        let knots = [6, 7].map(|count| KnotVector::clamped_uniform(3, count).unwrap());
        let space = SplineSpace::new(knots, [false; 2]).unwrap();
        let uv = [DVec2::ZERO, DVec2::splat(0.5), DVec2::new(0.5, 1.0)];
        let starts = Starts { space: &space, uv: &uv }.moved_around(DVec2::new(0.5, 1.0));
        assert_eq!(starts.len(), 32);
        let spans = DVec2::new(3.0, 4.0);
        for start in &starts {
            let by = [0, 1, 2].map(|i| ((start[i] - uv[i]) * spans).length());
            assert!(by[0] < 0.1 && by[1] < 0.5 && by[0] <= by[1], "{by:?}");
            assert!(start.iter().all(|uv| uv.clamp(DVec2::ZERO, DVec2::ONE) == *uv));
        }
        // Upwards, from the end of the domain, nothing moves.
        assert!(starts.iter().any(|start| start[2].distance(uv[2]) < 1e-12));
        assert!(starts.iter().any(|start| (start[2].y - 0.8).abs() < 1e-12));
    }

    #[test]
    fn what_is_moved_around_a_place_on_a_seam_moves_on_both_sides() {
        let knots = KnotVector::periodic_uniform(3, 6).unwrap();
        let space = SplineSpace::new([knots.clone(), knots], [true; 2]).unwrap();
        let uv = [0.05, 0.95].map(|at| DVec2::new(at, 0.5));
        for start in (Starts { space: &space, uv: &uv }).moved_around(DVec2::new(0.0, 0.5)) {
            let by = [0, 1].map(|i| (start[i] - uv[i]) - (start[i] - uv[i]).round());
            assert!(by[0].length() > 0.03 && by[0].distance(by[1]) < 1e-12, "{by:?}");
        }
    }

    #[test]
    fn ranks_are_even_in_open_directions_and_keep_the_order() {
        let knots = [
            KnotVector::clamped_uniform(3, 6).unwrap(),
            KnotVector::periodic_uniform(3, 6).unwrap(),
        ];
        let space = SplineSpace::new(knots, [false, true]).unwrap();
        let uv = [0.9, 0.1, 0.2, 0.3].map(|at| DVec2::new(at, 0.7));
        let ranked = Starts { space: &space, uv: &uv }.ranked();
        let even = [0.875, 0.125, 0.375, 0.625].map(|at| DVec2::new(at, 0.7));
        assert_eq!(ranked, Starts { space: &space, uv: &even }.first());
    }
}
