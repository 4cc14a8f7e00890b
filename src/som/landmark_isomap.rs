//! Landmark Isomap: planar coordinates that preserve distances along a graph.
//!
//! J. Tenenbaum, V. de Silva, J. Langford, *A global geometric framework for nonlinear
//! dimensionality reduction*, 2000; V. de Silva, J. Tenenbaum, *Sparse multidimensional scaling
//! using landmark points*, 2004.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::eigen;
use crate::cloud::NeighborGraph;
use crate::error::Result;
use crate::numeric::index;
use crate::progress::InterruptCheck;
use crate::worker_pool;

/// Distances computed between two reports, about ten milliseconds.
const DISTANCES_PER_REPORT: usize = 160_000;

/// Coordinates in the plane whose distances approximate those along a graph.
#[derive(Clone, Debug)]
pub struct LandmarkMap {
    /// Nodes from which distances were computed, by farthest-point sampling.
    pub landmarks: Vec<usize>,
    /// For each landmark, the lengths of the shortest paths to all nodes.
    pub distances: Vec<Vec<f64>>,
    /// Each node's coordinates, the longer direction along x.
    pub places: Vec<DVec2>,
}

impl LandmarkMap {
    /// The map of a connected graph over these points; `None` if they are not two-dimensional.
    #[must_use]
    pub fn of(graph: &NeighborGraph, points: &[DVec3], landmarks: usize) -> Option<Self> {
        // The listener never interrupts.
        Self::from(graph, spread_out(points, landmarks), &mut || Ok(())).ok().flatten()
    }

    /// The map by distances from these landmarks.
    pub(super) fn from(
        graph: &NeighborGraph,
        landmarks: Vec<usize>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Option<Self>> {
        let mut distances: Vec<Vec<f64>> = Vec::with_capacity(landmarks.len());
        for several in landmarks.chunks((DISTANCES_PER_REPORT / graph.len().max(1)).max(1)) {
            check_interrupt()?;
            let found = several.par_iter().map(|&from| graph.distances_from(&[index(from)]));
            worker_pool::install(|| distances.par_extend(found));
        }
        let places = embedded(&landmarks, &distances);
        Ok(places.map(|places| Self { landmarks, distances, places }))
    }
}

/// Farthest-point sampling: at most `count` points, each as far as possible from those before.
pub(super) fn spread_out(points: &[DVec3], count: usize) -> Vec<usize> {
    let count = count.min(points.len());
    let mut chosen = vec![0];
    let mut nearest: Vec<f64> = points.iter().map(|p| p.distance_squared(points[0])).collect();
    while chosen.len() < count {
        let farthest = (0..points.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        let farthest = farthest.unwrap_or(0);
        chosen.push(farthest);
        for (nearest, point) in nearest.iter_mut().zip(points) {
            *nearest = nearest.min(point.distance_squared(points[farthest]));
        }
    }
    chosen
}

/// Multidimensional scaling of the landmarks, then triangulation of every node by its distances to
/// them.
fn embedded(landmarks: &[usize], distances: &[Vec<f64>]) -> Option<Vec<DVec2>> {
    let count = landmarks.len();
    let square = |a: usize, b: usize| distances[a][landmarks[b]].powi(2);
    let between = |a: usize, b: usize| 0.5 * (square(a, b) + square(b, a));
    let mean = |a: usize| (0..count).map(|b| between(a, b)).sum::<f64>() / count as f64;
    let means: Vec<f64> = (0..count).map(mean).collect();
    let whole = means.iter().sum::<f64>() / count as f64;
    let centered = |i: usize| {
        let (a, b) = (i / count, i % count);
        -0.5 * (between(a, b) - means[a] - means[b] + whole)
    };
    let axes = eigen::largest((0..count * count).map(centered).collect(), count, 2);
    let [(first, along), (second, across)] = &axes[..] else { return None };
    if *second <= f64::EPSILON * first {
        return None;
    }
    let place = |node: usize| {
        let coordinate = |value: f64, axis: &[f64]| {
            let terms = (0..count).map(|l| axis[l] * (distances[l][node].powi(2) - means[l]));
            -0.5 * terms.sum::<f64>() / value.sqrt()
        };
        DVec2::new(coordinate(*first, along), coordinate(*second, across))
    };
    Some(worker_pool::install(|| (0..distances[0].len()).into_par_iter().map(place).collect()))
}
