//! Distances along the surface, and the flat map that keeps them: landmark Isomap.
//!
//! Tenenbaum, de Silva and Langford, A Global Geometric Framework for Nonlinear Dimensionality
//! Reduction, Science 290 (2000); de Silva and Tenenbaum, Sparse multidimensional scaling using
//! landmark points (2004).

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::landmark_map::{LandmarkMap, spread_out};
use crate::cloud::{Edge, NeighborGraph, in_axes, min_area_rectangle};
use crate::error::Result;
use crate::progress::{self, Listen, Observer, Progress, Stage};

/// Neighbours that each point is joined to: enough to connect a sheet, too few to reach the next fold.
const NEIGHBORS: usize = 8;

/// Points from which distances to all others are found.
const LANDMARKS: usize = 60;

/// Places in the plane whose distances are nearly those along the surface through the points, the
/// long side of the rectangle around them along x; `None` if the points have no two dimensions.
///
/// Costs O(n log n) for n points: a thousand spread evenly over the surface are enough for its shape.
///
/// # Errors
///
/// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
pub fn unroll(points: &[DVec3], observer: &mut dyn Observer) -> Result<Option<Vec<DVec2>>> {
    let graph = NeighborGraph::connected(points, NEIGHBORS, observer)?;
    let mut listen = progress::listener(observer, Stage::Training, points.len());
    embed(&graph, spread_out(points, LANDMARKS), &mut listen)
}

/// As [`unroll`].
pub(super) fn unrolled(points: &[DVec3], listen: &mut Listen<'_>) -> Result<Option<Vec<DVec2>>> {
    let mut observer = |_: &Progress| match listen() {
        Ok(()) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    };
    unroll(points, &mut observer)
}

/// Places in the plane for the nodes of a graph whose edges have length 1.
pub(super) fn draw(
    nodes: usize,
    edges: &[(usize, usize)],
    listen: &mut Listen<'_>,
) -> Result<Option<Vec<DVec2>>> {
    let mut lists: Vec<Vec<Edge>> = vec![Vec::new(); nodes];
    for &(a, b) in edges {
        lists[a].push(edge(b, 1.0));
    }
    let roads = NeighborGraph::symmetric(lists);
    let step = nodes.div_ceil(LANDMARKS);
    let landmarks: Vec<usize> = (0..nodes).step_by(step).collect();
    embed(&roads, landmarks, listen)
}

fn edge(to: usize, length: f64) -> Edge {
    Edge { to: u32::try_from(to).unwrap_or(u32::MAX), length }
}

/// The flat map by distances from these nodes; turned into the rectangle of least area, its long side
/// along x.
fn embed(
    graph: &NeighborGraph,
    landmarks: Vec<usize>,
    listen: &mut Listen<'_>,
) -> Result<Option<Vec<DVec2>>> {
    let found = LandmarkMap::from(graph, landmarks, listen)?;
    Ok(found.map(|map| straighten(&map.places)))
}

/// Turns places so that the rectangle of least area around them has its long side along x.
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
    fn a_rolled_sheet_unrolls_to_its_own_size() {
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
        // Ways over the edges of the graph are some percent longer than straight ones.
        assert!(worst < 0.5 && sum < 0.15, "worst {worst}, mean {sum}");
    }

    #[test]
    fn rectangles_lie_straight() {
        let turn = DVec2::from_angle(0.7);
        let grid = (0..50).map(|i| DVec2::new(f64::from(i % 5), 3.0 * f64::from(i / 5)));
        let places: Vec<DVec2> = grid.map(|p| turn.rotate(p)).collect();
        let straight = straighten(&places);
        let low = straight.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = straight.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        assert!((high - low).distance(DVec2::new(27.0, 4.0)) < 1e-12);
    }
}
