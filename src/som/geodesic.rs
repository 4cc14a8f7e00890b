//! Planar coordinates that preserve distances along a surface, by landmark Isomap.
//!
//! Tenenbaum, de Silva and Langford, A Global Geometric Framework for Nonlinear Dimensionality
//! Reduction, Science 290 (2000); de Silva and Tenenbaum, Sparse multidimensional scaling using
//! landmark points (2004).

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::landmark_isomap::{LandmarkMap, spread_out};
use crate::cloud::{Edge, NeighborGraph, in_axes, min_area_rectangle};
use crate::error::Result;
use crate::progress::{self, InterruptCheck, Observer, Progress, Stage};

/// Neighbors per point: enough to connect a sheet, too few to reach the next fold.
const K_NEIGHBORS: usize = 8;

/// Number of points from which distances to all others are computed.
const N_LANDMARKS: usize = 60;

/// Coordinates in the plane whose distances approximate those along the surface through the points.
/// Their minimum-area rectangle has its long side along x. `None` if the points are not
/// two-dimensional.
///
/// Costs O(n log n) for n points. A thousand points spread evenly over the surface capture its
/// shape.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn unroll(points: &[DVec3], observer: &mut dyn Observer) -> Result<Option<Vec<DVec2>>> {
    let graph = NeighborGraph::connected(points, K_NEIGHBORS, observer)?;
    let mut check_interrupt = progress::interrupt_check(observer, Stage::Training, points.len());
    embed(&graph, spread_out(points, N_LANDMARKS), &mut check_interrupt)
}

/// As [`unroll`], with a listener in place of an observer.
pub(super) fn unroll_listening(
    points: &[DVec3],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Option<Vec<DVec2>>> {
    let mut observer = |_: &Progress| match check_interrupt() {
        Ok(()) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    };
    unroll(points, &mut observer)
}

/// Coordinates in the plane for the nodes of a graph with edges of length 1.
pub(super) fn draw_graph(
    nodes: usize,
    edges: &[(usize, usize)],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Option<Vec<DVec2>>> {
    let mut lists: Vec<Vec<Edge>> = vec![Vec::new(); nodes];
    for &(a, b) in edges {
        lists[a].push(edge(b, 1.0));
    }
    let graph = NeighborGraph::symmetric(lists);
    let step = nodes.div_ceil(N_LANDMARKS);
    let landmarks: Vec<usize> = (0..nodes).step_by(step).collect();
    embed(&graph, landmarks, check_interrupt)
}

fn edge(to: usize, length: f64) -> Edge {
    Edge { to: u32::try_from(to).unwrap_or(u32::MAX), length }
}

/// The Isomap coordinates by distances from these landmarks, rotated by [`straighten`].
fn embed(
    graph: &NeighborGraph,
    landmarks: Vec<usize>,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Option<Vec<DVec2>>> {
    let found = LandmarkMap::from(graph, landmarks, check_interrupt)?;
    Ok(found.map(|map| straighten(&map.places)))
}

/// Rotates coordinates so that their minimum-area rectangle has its long side along x.
fn straighten(places: &[DVec2]) -> Vec<DVec2> {
    let along = min_area_rectangle(places).0;
    places.iter().map(|&place| in_axes(place, along)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::random::Random;
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn a_rolled_sheet_unrolls_to_its_flat_size() {
        let mut random = Random::new(2);
        // Five sixths of a cylinder of radius 1, height 2.
        let (arc, height) = (5.0 / 3.0 * PI, 2.0);
        let flat: Vec<DVec2> =
            (0..2000).map(|_| DVec2::new(random.unit() * arc, random.unit() * height)).collect();
        let rolled: Vec<DVec3> =
            flat.iter().map(|p| DVec3::new(p.x.cos(), p.x.sin(), p.y)).collect();
        let places = unroll(&rolled, &mut Silent).unwrap().unwrap();
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for _ in 0..1000 {
            let (a, b) = (random.index(2000), random.index(2000));
            let error = (places[a].distance(places[b]) - flat[a].distance(flat[b])).abs();
            worst = worst.max(error);
            sum += error / 1000.0;
        }
        // Paths along the graph's edges are a few percent longer than straight lines.
        assert!(worst < 0.5 && sum < 0.15, "worst {worst}, mean {sum}");
    }

    #[test]
    fn straighten_aligns_a_rotated_rectangle() {
        let turn = DVec2::from_angle(0.7);
        let grid = (0..50).map(|i| DVec2::new(f64::from(i % 5), 3.0 * f64::from(i / 5)));
        let places: Vec<DVec2> = grid.map(|p| turn.rotate(p)).collect();
        let straight = straighten(&places);
        let low = straight.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = straight.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        assert!((high - low).distance(DVec2::new(27.0, 4.0)) < 1e-12);
    }
}
