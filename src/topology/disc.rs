//! A body that is closed but for an opening, as a disc.
//!
//! Distances along such a body have no flat map without folds. But between a pole and the opening it is
//! a tube, whose angles and heights are polar coordinates.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{FEWEST, Kind, NEIGHBORS, border, detect_wanted};
use crate::error::Result;
use crate::point_cloud::NeighborGraph;
use crate::progress::Observer;

/// Radius of the caps around the pole and around the point of the opening farthest from it, beyond
/// which angles are those of a tube, as a share of the way between both. On a sphere loops around a cap
/// are then half as long as the equator.
const CAP: f64 = 0.16;

/// Sweeps in which each point of a cap takes the mean of its neighbours: some hundred points hardly
/// move any more.
const SWEEPS: usize = 400;

/// Places on the unit disc of points on a body that is closed but for one opening at most, so that
/// equal areas there have about equally many points; the pole opposite to the opening, or any if there
/// is none, is its middle. `None` if the body is no tube between the two.
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub(crate) fn disc(points: &[DVec3], observer: &mut dyn Observer) -> Result<Option<Vec<DVec2>>> {
    let graph = NeighborGraph::of(points, NEIGHBORS, observer)?;
    let opening = opening(points, &graph);
    let Some((pole, _)) = farthest(&graph.distances_from(&opening)) else { return Ok(None) };
    let from_pole = graph.distances_from(&[pole]);
    let Some((end, length)) = farthest(&of(&from_pole, &opening)) else { return Ok(None) };
    let from_end = graph.distances_from(&[opening[end as usize]]);
    let between = |i: &usize| from_pole[*i].min(from_end[*i]) > CAP * length;
    let belt: Vec<usize> = (0..points.len()).filter(between).collect();
    let tube: Vec<DVec3> = belt.iter().map(|&i| points[i]).collect();
    if tube.len() < FEWEST {
        return Ok(None);
    }
    let Some(chart) = detect_wanted(&tube, Kind::Tube, observer)?.chart else { return Ok(None) };
    if chart.closed_v || chart.points != tube {
        return Ok(None);
    }
    let from_middle = |i: usize| from_pole[i] - from_end[i];
    let rises = belt.iter().zip(&chart.uv).map(|(&i, uv)| (uv.y - 0.5) * from_middle(i));
    let upside_down = rises.sum::<f64>() < 0.0;
    let (mut turns, mut heights) = (vec![DVec2::ZERO; points.len()], vec![None; points.len()]);
    for (&i, uv) in belt.iter().zip(&chart.uv) {
        turns[i] = DVec2::from_angle(TAU * uv.x);
        heights[i] = Some(if upside_down { 1.0 - uv.y } else { uv.y });
    }
    let caps: Vec<usize> = (0..points.len()).filter(|&i| heights[i].is_none()).collect();
    extend(&mut turns, &caps, &graph);
    // The farther inside a cap, the shorter the mean of all directions around it.
    let inside = |i: usize| 1.0 - turns[i].length();
    let cap = |i: usize| if from_middle(i) < 0.0 { -inside(i) } else { 1.0 + inside(i) };
    let height = |i: &usize| heights[*i].unwrap_or_else(|| cap(*i));
    let mut ranked: Vec<usize> = (0..points.len()).collect();
    ranked.sort_by(|a, b| height(a).total_cmp(&height(b)));
    let mut places = vec![DVec2::ZERO; points.len()];
    for (rank, at) in ranked.into_iter().enumerate() {
        let radius = ((rank as f64 + 0.5) / points.len() as f64).sqrt();
        places[at] = radius * turns[at].normalize_or_zero();
    }
    Ok(Some(places))
}

/// The points on the longest border; of a body without any, one of its points.
fn opening(points: &[DVec3], graph: &NeighborGraph) -> Vec<u32> {
    let mut open = border::open(points);
    let mut longest = vec![0];
    for first in 0..points.len() {
        let mut found = Vec::new();
        let mut stack = Vec::new();
        if std::mem::take(&mut open[first]) {
            stack.push(first);
        }
        while let Some(point) = stack.pop() {
            found.push(u32::try_from(point).unwrap_or(u32::MAX));
            for edge in graph.edges(point) {
                if std::mem::take(&mut open[edge.to as usize]) {
                    stack.push(edge.to as usize);
                }
            }
        }
        if found.len() > longest.len() {
            longest = found;
        }
    }
    longest
}

/// The number of the largest finite distance, and that.
fn farthest(distances: &[f64]) -> Option<(u32, f64)> {
    let finite = (0..).zip(distances).filter(|(_, distance)| distance.is_finite());
    finite.map(|(i, distance)| (i, *distance)).max_by(|a, b| a.1.total_cmp(&b.1))
}

fn of(distances: &[f64], points: &[u32]) -> Vec<f64> {
    points.iter().map(|&point| distances[point as usize]).collect()
}

/// Gives each of the values at `unknown` the mean of its neighbours'.
fn extend(values: &mut [DVec2], unknown: &[usize], graph: &NeighborGraph) {
    for _ in 0..SWEEPS {
        for &i in unknown {
            let edges = graph.edges(i);
            let sum: DVec2 = edges.iter().map(|edge| values[edge.to as usize]).sum();
            values[i] = sum / edges.len() as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    /// Points evenly on the unit sphere, the angle around z growing from one to the next.
    fn sphere(count: u32) -> Vec<DVec3> {
        let point = |i: u32| {
            let (z, angle) =
                (1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count), f64::from(i) * 2.4);
            DVec2::from_angle(angle).extend(0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn a_sphere_with_a_hole_is_a_disc_around_the_opposite_pole() {
        let points: Vec<DVec3> = sphere(2500).into_iter().filter(|p| p.z < 0.9).collect();
        let places = disc(&points, &mut Silent).unwrap().unwrap();
        let turned = |i: usize| {
            let (place, along) = (places[i], points[i].truncate().normalize());
            (place.normalize(), DVec2::new(along.x, along.y))
        };
        // Angles are those around z within some ten degrees, up to a turn and perhaps the other way
        // around.
        let spread = |sense: f64| {
            let turn = |i: usize| {
                let (place, along) = turned(i);
                DVec2::new(along.x, sense * along.y).rotate(place)
            };
            let belt: Vec<usize> = (0..points.len()).filter(|&i| points[i].z.abs() < 0.7).collect();
            let mean = belt.iter().map(|&i| turn(i)).sum::<DVec2>() / belt.len() as f64;
            1.0 - mean.length()
        };
        let found = spread(1.0).min(spread(-1.0));
        assert!(found < 0.02, "{found}");
        let by_radius = |a: &usize, b: &usize| places[*a].length().total_cmp(&places[*b].length());
        let mut outwards: Vec<usize> = (0..points.len()).collect();
        outwards.sort_by(by_radius);
        let height =
            |ranks: &[usize]| ranks.iter().map(|&i| points[i].z).sum::<f64>() / ranks.len() as f64;
        // Heights grow from the pole to the hole, ring by ring.
        let rings: Vec<f64> = outwards.chunks(points.len().div_ceil(10)).map(height).collect();
        assert!(rings.is_sorted(), "{rings:?}");
    }

    #[test]
    fn what_is_no_tube_is_no_disc() {
        let curve = |i: u32| DVec3::new(f64::from(i), (f64::from(i) / 90.0).sin(), 0.0);
        let part = |i: u32, step: f64| (f64::from(i) * step).fract();
        let volume = |i: u32| DVec3::new(part(i, 0.618), part(i, 0.7548), part(i, 0.5698));
        for points in [(0..900).map(curve).collect::<Vec<_>>(), (0..2500).map(volume).collect()] {
            assert!(disc(&points, &mut Silent).unwrap().is_none());
        }
    }
}
