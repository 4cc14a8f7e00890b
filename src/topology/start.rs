//! Where the points of a closed surface lie on its lattice.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::circle::Circle;
use super::conjugate::Conjugate;
use crate::cloud::{KdTree, Neighbor, NeighborGraph};

/// Sectors of a tube in which its ends are looked for.
const SECTORS: usize = 24;

/// Radius with which nodes listen to the points around them, in cells: a ring of twelve nodes
/// shrinks by a fifteenth.
const RADIUS: f64 = 0.7;

/// Exponent from which on a share of the nearest point's weight is rounding.
const NEGLIGIBLE: f64 = 40.0;

/// Share of the longest way along a tube that is the least from either end: those of 15 to 60 radii have 0.94
/// and more, while charts that begin in the middle have 0.9 at most.
const FROM_END: f64 = 0.93;

/// Cells along each side of the chart in which a torus must have points.
const CHART: usize = 6;

/// Share of those cells that must have some.
const COVERED: f64 = 0.9;

/// Points beside one another on a chart are apart when they are as many spacings from one another: several
/// times as many as angles are off by.
const APART: f64 = 8.0;

/// Share of such points from which on a chart covers its surface twice. If it does so everywhere, half of the
/// points have the nearest on the other sheet; charts that cover it once have none.
const TWICE: f64 = 0.05;

/// Points of a closed surface with their places on it: an ordered start for its lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Points on the surface, evenly chosen from all.
    pub points: Vec<DVec3>,
    /// Their parameters in `[0, 1]²`: u around the tube, v along it; on a torus u along the ring, v
    /// around its section. Closed directions go from 0 to 1 around.
    pub uv: Vec<DVec2>,
    /// Lengths of the surface along u and v in its middle, in the points' unit.
    pub lengths: (f64, f64),
    /// Whether v is closed too.
    pub closed_v: bool,
}

impl Chart {
    /// That of a torus whose two ways change places.
    pub(crate) fn transposed(self) -> Self {
        let uv = self.uv.iter().map(|uv| DVec2::new(uv.y, uv.x)).collect();
        Self { uv, lengths: (self.lengths.1, self.lengths.0), ..self }
    }

    /// Nodes of a lattice of this shape in order on the surface, row by row: what
    /// [`Init::Given`](crate::som::Init::Given) takes.
    ///
    /// Each node is the mean of the points around it on the chart, weighted by a Gaussian of 0.7
    /// cells. O(points · nodes).
    #[must_use]
    pub fn lattice(&self, (rows, cols): (usize, usize)) -> Vec<DVec3> {
        let cells = DVec2::new(
            rows as f64,
            if self.closed_v { cols } else { cols.saturating_sub(1) } as f64,
        );
        let place = |i: usize, j: usize| DVec2::new(i as f64, j as f64);
        let node = |node: usize| {
            let at = place(node / cols, node % cols);
            let apart = |uv: &DVec2| {
                let mut apart = (*uv * cells - at).abs();
                apart.x = apart.x.min(cells.x - apart.x);
                if self.closed_v {
                    apart.y = apart.y.min(cells.y - apart.y);
                }
                apart.length_squared() / (2.0 * RADIUS * RADIUS)
            };
            let apart: Vec<f64> = self.uv.iter().map(apart).collect();
            // As shares of the nearest point's weight, which in a hole would vanish.
            let nearest = apart.iter().copied().fold(f64::INFINITY, f64::min);
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for (point, apart) in self.points.iter().zip(apart) {
                let farther = apart - nearest;
                if farther < NEGLIGIBLE {
                    let weight = (-farther).exp();
                    sum += weight * *point;
                    weights += weight;
                }
            }
            sum / weights
        };
        (0..rows * cols).into_par_iter().map(node).collect()
    }
}

/// Whether the chart of a tube covers it once: of a surface whose loops it counts twice, places that lie
/// apart come to lie beside one another.
pub(super) fn winds_once(chart: &Chart, graph: &NeighborGraph) -> bool {
    let height = chart.lengths.1 / chart.lengths.0;
    let place = |uv: &DVec2| (DVec2::from_angle(TAU * uv.x) / TAU).extend(height * uv.y);
    let places: Vec<DVec3> = chart.uv.iter().map(place).collect();
    let tree = KdTree::new(&places);
    let apart = |point: u32| {
        let mut found = Vec::new();
        tree.nearest_to(point, 1, &mut found);
        let own = chart.points[point as usize];
        let apart = |near: &Neighbor| own.distance(chart.points[near.index as usize]);
        found.first().map(apart) > Some(APART * graph.spacing(point as usize))
    };
    let all: Vec<u32> = (0..).zip(&places).map(|(point, _)| point).collect();
    let apart = all.par_iter().filter(|&&point| apart(point)).count() as f64;
    apart <= TWICE * places.len() as f64
}

/// Whether hardly any way along the surface is longer than one from where the chart of a tube begins.
pub(super) fn begins_at_an_end(chart: &Chart, graph: &NeighborGraph) -> bool {
    let farthest = |from: u32| {
        let ways = graph.distances_from(&[from]).into_iter().zip(0_u32..);
        ways.filter(|(way, _)| way.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let lowest = (0_u32..).zip(&chart.uv).min_by(|a, b| a.1.y.total_cmp(&b.1.y));
    let way = lowest.and_then(|(lowest, _)| farthest(lowest));
    let back = way.and_then(|(_, end)| farthest(end));
    way.zip(back).is_some_and(|((way, _), (whole, _))| way >= FROM_END * whole)
}

/// A torus by the angles around its two loops; `None` if the points do not cover one.
pub(super) fn torus(points: &[DVec3], ring: &Circle, section: &Circle) -> Option<Chart> {
    let turns = ring.turns.iter().zip(&section.turns);
    let uv: Vec<DVec2> = turns.map(|(&u, &v)| DVec2::new(u, v)).collect();
    let whole = covered::<CHART>(&uv) as f64 >= COVERED * (CHART * CHART) as f64;
    let lengths = (ring.course.length, section.course.length);
    whole.then(|| Chart { points: points.to_vec(), uv, lengths, closed_v: true })
}

/// In how many of so many parts along and around there are points.
pub(super) fn covered<const PARTS: usize>(uv: &[DVec2]) -> usize {
    let mut hit = [[false; PARTS]; PARTS];
    for uv in uv {
        hit[part(uv.x, PARTS)][part(uv.y, PARTS)] = true;
    }
    hit.as_flattened().iter().filter(|hit| **hit).count()
}

/// A tube by the angle around it and the coordinate across that angle; and whether it has one side only, as
/// a Moebius strip has: across it, neighbours then disagree which way is up, wherever that is cut.
pub(super) fn tube(points: &[DVec3], around: &Circle, graph: &NeighborGraph) -> (Chart, bool) {
    let turns = &around.turns;
    let conjugate = Conjugate::of_turns(points, turns, graph);
    let (across, opposite) = rayon::join(|| conjugate.coordinate(), || conjugate.opposite());
    let [first_rim, second_rim] = rims(turns, &across);
    let uv = between_rims(turns, &across);
    let from_first = graph.distances_from(&first_rim);
    let heights = second_rim.iter().map(|&end| from_first[end as usize]);
    let height = heights.filter(|height| height.is_finite()).sum::<f64>() / SECTORS as f64;
    let lengths = (around.course.length, height);
    // As many of them as there are points side by side.
    let one_sided =
        opposite as f64 * (around.course.length * height / points.len() as f64).sqrt() >= height;
    (Chart { points: points.to_vec(), uv, lengths, closed_v: false }, one_sided)
}

/// For each sector the points with the least and the greatest coordinate across.
pub(super) fn rims(along: &[f64], across: &[f64]) -> [Vec<u32>; 2] {
    [rim(along, |point| across[point]), rim(along, |point| -across[point])]
}

/// The coordinates along, with those across as shares of the way from rim to rim there.
pub(super) fn between_rims(along: &[f64], across: &[f64]) -> Vec<DVec2> {
    let rims = rims(along, across);
    let share = |along: f64, across_it: f64| {
        let sector = part(along, SECTORS);
        let [low, high] = [&rims[0], &rims[1]].map(|rim| across[rim[sector] as usize]);
        if high > low { (across_it - low) / (high - low) } else { 0.5 }
    };
    along
        .iter()
        .zip(across)
        .map(|(&along, &across)| DVec2::new(along, share(along, across)))
        .collect()
}

/// For each sector the point with the least value; of empty ones, that of the sector before.
fn rim(turns: &[f64], value: impl Fn(usize) -> f64) -> Vec<u32> {
    let mut least = [(f64::INFINITY, 0_u32); SECTORS];
    for (point, &turns) in (0_u32..).zip(turns) {
        let own = value(point as usize);
        if own < least[part(turns, SECTORS)].0 {
            least[part(turns, SECTORS)] = (own, point);
        }
    }
    let filled = |sector: usize| {
        let before = (0..SECTORS).map(|back| least[(sector + SECTORS - back) % SECTORS]);
        before.into_iter().find(|least| least.0.is_finite()).map_or(0, |least| least.1)
    };
    (0..SECTORS).map(filled).collect()
}

/// The one of so many equal parts of a circle that an angle lies in.
fn part(turns: f64, parts: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "turns lie between 0 and 1"
    )]
    let part = (turns * parts as f64) as usize;
    part.min(parts - 1)
}
