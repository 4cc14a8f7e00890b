//! A body that is closed but for an opening, as a disc.
//!
//! Distances along such a body have no flat map without folds. But between a pole and the opening it is
//! a tube, whose angles and heights are polar coordinates.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Chart, FEWEST, border, tube_by_loops};
use crate::cloud::{NEIGHBORS, NeighborGraph};
use crate::error::Result;
use crate::progress::Observer;

/// Radii of the cap around the pole beyond which angles are those of a tube, as shares of the way to the
/// opening: on a sphere loops around the first are half as long as the equator, where the body is pointed the
/// others are wanted for that. The first is that of the cap around the point of the opening farthest from the
/// pole, too.
const CAPS: [f64; 3] = [0.16, 0.3, 0.45];

/// How far points of an opening lie from one another, as a share of that way, that is so wide that there need
/// be no cap around any of them.
const WIDE: f64 = 0.4;

/// Resultant of the angles of all points, as a share of their number, from which on they are those around a
/// hole on one side.
const ONE_SIDED: f64 = 0.5;

/// Sweeps in which each point of a cap takes the mean of its neighbours: some hundred points hardly
/// move any more.
const SWEEPS: usize = 400;

/// Rounds in which places become those amid their neighbours: angles between landmarks gather along
/// lines.
const SMOOTHING: usize = 10;

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
    let from_opening = graph.distances_from(&opening);
    let Some((pole, _)) = farthest(&from_opening) else { return Ok(None) };
    let from_pole = graph.distances_from(&[pole]);
    let Some((end, length)) = farthest(&of(&from_pole, &opening)) else { return Ok(None) };
    let from_end = graph.distances_from(&[opening[end as usize]]);
    let wide = of(&from_end, &opening).iter().any(|apart| *apart > WIDE * length);
    let below = |i: usize| wide || from_end[i] > CAPS[0] * length;
    for cap in CAPS {
        let between = |i: &usize| from_pole[*i] > cap * length && below(*i);
        let belt: Vec<usize> = (0..points.len()).filter(between).collect();
        if belt.len() < FEWEST {
            break;
        }
        let tube: Vec<DVec3> = belt.iter().map(|&i| points[i]).collect();
        let chart = tube_by_loops(&tube, observer)?.chart;
        if let Some(chart) = chart.filter(|chart| chart.points == tube && goes_round(chart)) {
            let mut turns = vec![DVec2::ZERO; points.len()];
            for (&i, uv) in belt.iter().zip(&chart.uv) {
                turns[i] = DVec2::from_angle(TAU * uv.x);
            }
            extend(&mut turns, |i| !between(&i), &graph);
            let height = |i: usize| from_pole[i] / (from_pole[i] + from_opening[i]);
            let heights: Vec<f64> = (0..points.len()).map(height).collect();
            return Ok(Some(smoothed(filled(&turns, &heights), &graph)));
        }
    }
    Ok(None)
}

/// Whether the angles of a tube are those around all of it, and not around a hole on one side.
fn goes_round(chart: &Chart) -> bool {
    let sum: DVec2 = chart.uv.iter().map(|uv| DVec2::from_angle(TAU * uv.x)).sum();
    !chart.closed_v && sum.length() < ONE_SIDED * chart.uv.len() as f64
}

/// Places on the unit disc in these directions from its middle, in the order of these radii, which become
/// such that they fill it evenly.
fn filled(ways: &[DVec2], radii: &[f64]) -> Vec<DVec2> {
    let mut ranked: Vec<usize> = (0..radii.len()).collect();
    ranked.sort_by(|a, b| radii[*a].total_cmp(&radii[*b]));
    let mut places = vec![DVec2::ZERO; radii.len()];
    for (rank, at) in ranked.into_iter().enumerate() {
        let radius = ((rank as f64 + 0.5) / radii.len() as f64).sqrt();
        places[at] = radius * ways[at].normalize_or_zero();
    }
    places
}

/// Places on the unit disc amid those of their neighbours.
fn smoothed(mut places: Vec<DVec2>, graph: &NeighborGraph) -> Vec<DVec2> {
    for _ in 0..SMOOTHING {
        let mean = |i: usize| {
            let edges = graph.edges(i);
            let around: DVec2 = edges.iter().map(|edge| places[edge.to as usize]).sum();
            (places[i] + around) / (edges.len() + 1) as f64
        };
        let means: Vec<DVec2> = (0..places.len()).map(mean).collect();
        let radii: Vec<f64> = means.iter().map(|mean| mean.length()).collect();
        places = filled(&means, &radii);
    }
    places
}

/// The points on the longest border; of a body without any, one of its points.
fn opening(points: &[DVec3], graph: &NeighborGraph) -> Vec<u32> {
    let open = border::open(points);
    // Points beside one another on a border need not be neighbours, but theirs are.
    let mut beside = open.clone();
    for point in (0..points.len()).filter(|&point| open[point]) {
        graph.edges(point).iter().for_each(|edge| beside[edge.to as usize] = true);
    }
    let mut longest = vec![0];
    for first in 0..points.len() {
        let mut found = Vec::new();
        let mut stack = Vec::new();
        if std::mem::take(&mut beside[first]) {
            stack.push(first);
        }
        while let Some(point) = stack.pop() {
            if open[point] {
                found.push(u32::try_from(point).unwrap_or(u32::MAX));
            }
            for edge in graph.edges(point) {
                if std::mem::take(&mut beside[edge.to as usize]) {
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

/// Gives each of the unknown values the mean of its neighbours'.
fn extend(values: &mut [DVec2], is_unknown: impl Fn(usize) -> bool, graph: &NeighborGraph) {
    let unknown: Vec<usize> = (0..values.len()).filter(|&i| is_unknown(i)).collect();
    for _ in 0..SWEEPS {
        for &i in &unknown {
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

    /// How far angles of places are from those of their points around z, up to a turn and perhaps the other
    /// way around, where heights are such: one less the resultant of the differences, 0.02 for ten degrees.
    fn spread(points: &[DVec3], places: &[DVec2], belt: impl Fn(f64) -> bool) -> f64 {
        let of = |sense: f64| {
            let belt = points.iter().zip(places).filter(|(point, _)| belt(point.z));
            let turns = belt.map(|(point, place)| {
                let along = point.truncate().normalize();
                DVec2::new(along.x, sense * along.y).rotate(place.normalize())
            });
            let turns: Vec<DVec2> = turns.collect();
            1.0 - turns.iter().sum::<DVec2>().length() / turns.len() as f64
        };
        of(1.0).min(of(-1.0))
    }

    #[test]
    fn a_sphere_with_a_hole_is_a_disc_around_the_opposite_pole() {
        let points: Vec<DVec3> = sphere(2500).into_iter().filter(|p| p.z < 0.9).collect();
        let places = disc(&points, &mut Silent).unwrap().unwrap();
        let found = spread(&points, &places, |z| z.abs() < 0.7);
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
    fn a_pointed_cone_is_a_disc_around_its_apex() {
        // Places by golden angles stand evenly on it.
        let count = 2000;
        let points: Vec<DVec3> = (0..count)
            .map(|i| {
                let radius = ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
                (radius * DVec2::from_angle(f64::from(i) * 2.4)).extend(4.0 * radius)
            })
            .collect();
        let places = disc(&points, &mut Silent).unwrap().unwrap();
        // The apex is the middle, up to what the few points near it weigh, and the rim the circle.
        let off =
            |(point, place): (&DVec3, &DVec2)| (place.length() - point.truncate().length()).abs();
        let off: Vec<f64> = points.iter().zip(&places).map(off).collect();
        let (mean, most) =
            (off.iter().sum::<f64>() / 2000.0, off.iter().copied().fold(0.0, f64::max));
        assert!(mean < 0.02 && most < 0.2, "{mean} {most}");
        let found = spread(&points, &places, |z| z > 2.0);
        assert!(found < 0.02, "{found}");
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
