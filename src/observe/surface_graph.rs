//! Neighbor graphs along the surface: links that leave the local planes are dropped.

use rayon::prelude::*;

use super::local_planes::LocalPlanes;
use super::settings::ObserveSettings;
use crate::cloud::{Edge, KdTree, Neighbor, NeighborGraph};

/// Links each point to its neighbors, except for links that leave the local plane at either end:
/// they lead to another layer. Parts are joined by their shortest links.
pub(super) fn surface_graph(
    tree: &KdTree<'_>,
    near: &[Vec<Neighbor>],
    planes: &LocalPlanes,
    settings: &ObserveSettings,
) -> NeighborGraph {
    let points = tree.points();
    let sine = |from: usize, to: usize| {
        let way = (points[to] - points[from]).normalize_or_zero();
        let off = |at: usize| way.dot(planes.normals[at]).abs();
        off(from).max(off(to))
    };
    let links = |from: usize| {
        let mut links: Vec<(f64, Edge)> = near[from]
            .iter()
            .map(|near| (sine(from, near.index as usize), Edge::from(near)))
            .collect();
        links.sort_by(|a, b| a.0.total_cmp(&b.0));
        let kept = links.iter().enumerate();
        let kept = kept.filter(|(rank, (sine, _))| {
            *rank < settings.min_links || *sine < settings.max_link_sine
        });
        kept.map(|(_, (_, edge))| *edge).collect()
    };
    NeighborGraph::joined(tree, (0..points.len()).into_par_iter().map(links).collect())
}

/// Links each point to few neighbors, except for links much longer than usual at either end. Parts
/// are joined by their shortest links.
pub(super) fn tight_graph(
    tree: &KdTree<'_>,
    near: &[Vec<Neighbor>],
    settings: &ObserveSettings,
) -> NeighborGraph {
    let few = |from: usize| near[from].iter().take(settings.tight_neighbors);
    let usual: Vec<f64> = (0..near.len())
        .map(|from| few(from).map(Neighbor::distance).sum::<f64>() / few(from).count() as f64)
        .collect();
    let links = |from: usize| {
        let short = |near: &&Neighbor| {
            let usual = usual[from].min(usual[near.index as usize]);
            near.distance() <= settings.max_tight_length * usual
        };
        few(from).filter(short).map(Edge::from).collect()
    };
    NeighborGraph::joined(tree, (0..near.len()).map(links).collect())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::observe::Observations;

    #[test]
    fn layers_two_spacings_apart_are_linked_only_at_corners() {
        let layer = |from: DVec3| {
            (0..900_u32).map(move |i| {
                let (x, y, z) = (f64::from(i / 30), f64::from(i % 30), 0.01 * f64::from(i % 7));
                from + DVec3::new(x, y, z)
            })
        };
        let above = DVec3::new(0.5, 0.5, 2.0);
        let points: Vec<DVec3> = layer(DVec3::ZERO).chain(layer(above)).collect();
        let observations = Observations::of(&points, ObserveSettings::default());
        let graph = observations.graph();
        let across = (0..900).flat_map(|i| graph.edges(i)).filter(|edge| edge.to >= 900).count();
        // At corners the nearest neighbors lie on both layers.
        assert!((1..20).contains(&across), "{across}");
        assert!(graph.distances_from(&[0]).iter().all(|distance| distance.is_finite()));
    }
}
