//! Neighbour graphs that follow the surface.

use rayon::prelude::*;

use super::local_planes::LocalPlanes;
use super::settings::ObserveSettings;
use crate::cloud::{Edge, KdTree, Neighbor, NeighborGraph};
use crate::numeric::index;

/// Links that each point keeps whatever their angle.
const KEPT: usize = 2;

/// Each point linked to its nearest, but for links that leave a local plane at either end: they
/// lead to another layer. Parts are joined by their shortest links.
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
        let kept = kept.filter(|(rank, (sine, _))| *rank < KEPT || *sine < settings.link_sine);
        kept.map(|(_, (_, edge))| *edge).collect()
    };
    joined(tree, (0..points.len()).into_par_iter().map(links).collect())
}

/// The links of a graph of few neighbours that are not much longer than is usual at both ends.
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
            near.distance() <= settings.tight_length * usual
        };
        few(from).filter(short).map(Edge::from).collect()
    };
    joined(tree, (0..near.len()).map(links).collect())
}

/// The graph of these links, its parts joined: the smallest by its shortest way to another, until
/// one is left.
fn joined(tree: &KdTree<'_>, mut links: Vec<Vec<Edge>>) -> NeighborGraph {
    let points = tree.points();
    let mut parts = parts(&links);
    while let Some(smallest) = smallest(&parts) {
        let own: Vec<usize> = (0..points.len()).filter(|&i| parts[i] == smallest).collect();
        let foreign = |other: u32| parts[other as usize] != smallest;
        let shortest = |found: &mut Vec<Neighbor>, &from: &usize| {
            tree.nearest_where(points[from], 1, f64::INFINITY, found, foreign);
            found.first().map(|near| (near.distance_squared, from, near.index))
        };
        let ways = own.par_iter().map_init(Vec::new, shortest).flatten();
        let nearer = |a: &(f64, usize, u32), b: &(f64, usize, u32)| {
            a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2)))
        };
        let Some((square, from, to)) = ways.min_by(nearer) else { break };
        links[from].push(Edge { to, length: square.sqrt() });
        let other = parts[to as usize];
        own.into_iter().for_each(|i| parts[i] = other);
    }
    NeighborGraph::symmetric(links)
}

/// The number of its part for each node.
fn parts(links: &[Vec<Edge>]) -> Vec<u32> {
    fn root(parents: &mut [u32], mut node: u32) -> u32 {
        while parents[node as usize] != node {
            let parent = parents[parents[node as usize] as usize];
            parents[node as usize] = parent;
            node = parent;
        }
        node
    }
    let mut parents: Vec<u32> = (0..).take(links.len()).collect();
    for (from, links) in links.iter().enumerate() {
        for link in links {
            let (a, b) = (root(&mut parents, index(from)), root(&mut parents, link.to));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    (0..links.len()).map(|node| root(&mut parents, index(node))).collect()
}

/// The part with the fewest nodes, of equal ones the first; `None` if there is only one.
fn smallest(parts: &[u32]) -> Option<u32> {
    let mut counts = vec![0_usize; parts.len()];
    parts.iter().for_each(|&part| counts[part as usize] += 1);
    let mut left = (0..).zip(&counts).filter(|(_, count)| **count > 0);
    let several = left.clone().nth(1).is_some();
    let least = left.by_ref().min_by_key(|(_, count)| **count);
    least.filter(|_| several).map(|(part, _)| part)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::observe::Observations;

    #[test]
    fn layers_two_spacings_apart_are_linked_once() {
        let layer = |z: f64| {
            (0..900_u32).map(move |i| {
                DVec3::new(f64::from(i / 30), f64::from(i % 30), z + 0.01 * f64::from(i % 7))
            })
        };
        let points: Vec<DVec3> = layer(0.0).chain(layer(2.0)).collect();
        let seen = Observations::of(&points, ObserveSettings::default());
        let graph = seen.graph();
        let across = (0..900).flat_map(|i| graph.edges(i)).filter(|edge| edge.to >= 900).count();
        assert_eq!(across, 1);
        assert!(graph.distances_from(&[0]).iter().all(|distance| distance.is_finite()));
    }
}
