//! All observations of a cloud's sample.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::border::border;
use super::local_planes::LocalPlanes;
use super::settings::ObserveSettings;
use super::surface_graph::{surface_graph, tight_graph};
use crate::cloud::{KdTree, Neighbor, NeighborGraph, Plane};
use crate::numeric::median;

/// Observations of a sample of a cloud.
///
/// ```
/// use neurbs::{DVec3, observe::{Observations, ObserveSettings}};
/// let points: Vec<DVec3> =
///     (0..400).map(|i| DVec3::new(f64::from(i / 20), f64::from(i % 20), 0.0)).collect();
/// let observations = Observations::of(&points, ObserveSettings::default());
/// assert_eq!(observations.noise(), 0.0);
/// assert!(observations.normal_axes()[0].z.abs() > 0.999);
/// ```
pub struct Observations<'a> {
    settings: ObserveSettings,
    tree: KdTree<'a>,
    near: Vec<Vec<Neighbor>>,
    planes: LocalPlanes,
    /// Principal directions of the points.
    axes: Plane,
    graph: OnceLock<NeighborGraph>,
    tight: OnceLock<NeighborGraph>,
    border: OnceLock<Vec<bool>>,
}

impl<'a> Observations<'a> {
    /// Observations of these points, at least four. Graphs and border follow on first use.
    #[must_use]
    pub fn of(points: &'a [DVec3], settings: ObserveSettings) -> Self {
        let tree = KdTree::new(points);
        let count = settings.k_neighbors.min(points.len() - 1);
        let nearest = |&at: &u32| {
            let mut found = Vec::new();
            tree.nearest_to(at, count, &mut found);
            found
        };
        let all: Vec<u32> = (0..).take(points.len()).collect();
        let near = all.par_iter().map(nearest).collect();
        let planes = LocalPlanes::of(points, &tree, &settings);
        let axes = Plane::of(points.iter().copied());
        let [graph, tight] = [(); 2].map(|()| OnceLock::new());
        Self { settings, tree, near, planes, axes, graph, tight, border: OnceLock::new() }
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &'a [DVec3] {
        self.tree.points()
    }

    /// The tree over the points.
    #[must_use]
    pub fn tree(&self) -> &KdTree<'a> {
        &self.tree
    }

    /// The nearest neighbors of each point, nearest first.
    #[must_use]
    pub fn near(&self) -> &[Vec<Neighbor>] {
        &self.near
    }

    /// The local planes.
    #[must_use]
    pub fn planes(&self) -> &LocalPlanes {
        &self.planes
    }

    /// The noise floor: see [`LocalPlanes::noise`].
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.planes.noise
    }

    /// The principal directions of the points, that of the largest deviation first.
    #[must_use]
    pub fn axes(&self) -> &Plane {
        &self.axes
    }

    /// Root mean square distance of the points from their mean.
    #[must_use]
    pub fn size(&self) -> f64 {
        DVec3::from_array(self.axes.deviations).length()
    }

    /// The median over the points of [`Self::local_spacing`].
    #[must_use]
    pub fn spacing(&self) -> f64 {
        median(self.spacings())
    }

    /// The distance of each point to the neighbor whose rank the settings give.
    #[must_use]
    pub fn local_spacing(&self) -> Vec<f64> {
        self.spacings().collect()
    }

    fn spacings(&self) -> impl Iterator<Item = f64> + '_ {
        let rank = self.settings.spacing_rank;
        let last = move |near: &'_ Vec<Neighbor>| near.iter().take(rank).next_back().copied();
        self.near.iter().filter_map(last).map(|near| near.distance())
    }

    /// The principal directions of the local normals, the most frequent direction first.
    #[must_use]
    pub fn normal_axes(&self) -> [DVec3; 3] {
        // A normal and its opposite are the same direction, so both are included.
        let planes = &self.planes;
        let any = !planes.spread.contains(&true);
        let known = planes.normals.iter().zip(&planes.spread).filter(|(_, spread)| **spread || any);
        let both: Vec<DVec3> = known.flat_map(|(normal, _)| [*normal, -*normal]).collect();
        Plane::of(both.iter().copied()).axes
    }

    /// Share of the local normals whose angle to a direction has a larger cosine. Planes through
    /// lines of points are left out, unless there are no others.
    #[must_use]
    pub fn share_along(&self, direction: DVec3, cosine: f64) -> f64 {
        let planes = &self.planes;
        let any = !planes.spread.contains(&true);
        let (mut along, mut count) = (0.0, 0.0);
        for (normal, spread) in planes.normals.iter().zip(&planes.spread) {
            if *spread || any {
                count += 1.0;
                along += f64::from(normal.dot(direction).abs() > cosine);
            }
        }
        along / count
    }

    /// The connected graph of neighbors along the surface.
    #[must_use]
    pub fn graph(&self) -> &NeighborGraph {
        self.graph
            .get_or_init(|| surface_graph(&self.tree, &self.near, &self.planes, &self.settings))
    }

    /// The connected graph of few, near neighbors. It separates layers that are close.
    #[must_use]
    pub fn tight_graph(&self) -> &NeighborGraph {
        self.tight.get_or_init(|| tight_graph(&self.tree, &self.near, &self.settings))
    }

    /// Whether each point lies on the border.
    #[must_use]
    pub fn border(&self) -> &[bool] {
        self.border.get_or_init(|| border(&self.tree, &self.planes.normals, &self.settings))
    }

    /// Share of the points that lie on the border.
    #[must_use]
    pub fn border_share(&self) -> f64 {
        let border = self.border();
        border.iter().filter(|open| **open).count() as f64 / border.len() as f64
    }
}
