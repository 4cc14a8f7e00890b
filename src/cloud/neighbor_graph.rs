//! The graph of nearest neighbors, and shortest paths along its edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::kd_tree::{KdTree, Neighbor};
use super::plane::Plane;
use super::set_links::shortest_links;
use crate::disjoint_sets::DisjointSets;
use crate::error::Result;
use crate::numeric::index;
use crate::progress::Observer;

/// A graph whose edges join neighboring points.
///
/// ```
/// use neurbs::{DVec3, cloud::NeighborGraph, progress::Silent};
/// let line: Vec<DVec3> = (0..50).map(|i| DVec3::X * f64::from(i)).collect();
/// let graph = NeighborGraph::of(&line, 4, &mut Silent)?;
/// assert_eq!(graph.distances_from(&[0])[49], 49.0);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NeighborGraph {
    /// Index of each node's first edge; one more entry than nodes.
    starts: Vec<usize>,
    edges: Vec<Edge>,
}

/// An edge as one of its ends lists it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The other end.
    pub to: u32,
    /// Its length, in the points' unit.
    pub length: f64,
}

impl From<&Neighbor> for Edge {
    fn from(near: &Neighbor) -> Self {
        Self { to: near.index, length: near.distance() }
    }
}

impl NeighborGraph {
    /// Joins each point to its `count` nearest neighbors, in both directions.
    ///
    /// Where these lie on a line, as on scan lines, the point is also joined to the nearest two
    /// beside that line. O(n log n).
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn of(points: &[DVec3], count: usize, observer: &mut dyn Observer) -> Result<Self> {
        Ok(Self::symmetric(nearest(&KdTree::over(points, observer)?, count, observer)?))
    }

    /// As [`Self::of`], with its parts joined by [`Self::joined`].
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn connected(points: &[DVec3], count: usize, observer: &mut dyn Observer) -> Result<Self> {
        let tree = KdTree::over(points, observer)?;
        let lists = nearest(&tree, count, observer)?;
        Ok(Self::joined(&tree, lists))
    }

    /// The connected graph of these edges between the points of a tree.
    ///
    /// Each part but the largest is joined to the nearest other part, until one is left (O.
    /// Borůvka's algorithm).
    #[must_use]
    pub fn joined(tree: &KdTree<'_>, mut lists: Vec<Vec<Edge>>) -> Self {
        let mut parts = DisjointSets::new(lists.len());
        for (from, list) in lists.iter().enumerate() {
            for edge in list {
                parts.unite(index(from), edge.to);
            }
        }
        loop {
            let links = shortest_links(tree, &parts.roots());
            if links.is_empty() {
                return Self::symmetric(lists);
            }
            for link in links {
                // Each of two parts may have found a link to the other.
                if parts.root(link.from) != parts.root(link.to) {
                    parts.unite(link.from, link.to);
                    lists[link.from as usize].push(Edge { to: link.to, length: link.length });
                }
            }
        }
    }

    /// The graph of these edges. Each may be listed at one of its ends or at both.
    #[must_use]
    pub fn symmetric(mut lists: Vec<Vec<Edge>>) -> Self {
        for node in 0..lists.len() {
            for at in 0..lists[node].len() {
                let Edge { to, length } = lists[node][at];
                let from = u32::try_from(node).unwrap_or(u32::MAX);
                let back = &mut lists[to as usize];
                if !back.iter().any(|edge| edge.to == from) {
                    back.push(Edge { to: from, length });
                }
            }
        }
        let mut starts = vec![0];
        starts.extend(lists.iter().scan(0, |sum, list| {
            *sum += list.len();
            Some(*sum)
        }));
        Self { starts, edges: lists.into_iter().flatten().collect() }
    }

    /// The number of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether the graph has no nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The edges at a node.
    #[must_use]
    pub fn edges(&self, node: usize) -> &[Edge] {
        &self.edges[self.starts[node]..self.starts[node + 1]]
    }

    /// Lengths of the shortest paths from the nearest source to all nodes; infinite where there is
    /// no path (Dijkstra's algorithm).
    #[must_use]
    pub fn distances_from(&self, sources: &[u32]) -> Vec<f64> {
        let mut distances = vec![f64::INFINITY; self.len()];
        // The bits of positive numbers sort as the numbers do.
        let mut queue: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
        for &source in sources {
            distances[source as usize] = 0.0;
            queue.push(Reverse((0, source)));
        }
        while let Some(Reverse((bits, node))) = queue.pop() {
            let distance = distances[node as usize];
            if bits > distance.to_bits() {
                // A shorter path was found meanwhile.
                continue;
            }
            for &Edge { to, length } in self.edges(node as usize) {
                let there = distance + length;
                if there < distances[to as usize] {
                    distances[to as usize] = there;
                    queue.push(Reverse((there.to_bits(), to)));
                }
            }
        }
        distances
    }
}

/// Edges from each point to its `count` nearest neighbors, and to the nearest two beside their
/// line.
fn nearest(tree: &KdTree<'_>, count: usize, observer: &mut dyn Observer) -> Result<Vec<Vec<Edge>>> {
    let points = tree.points();
    tree.map(observer, |own, found| {
        tree.nearest_to(own, count, found);
        let mut edges: Vec<Edge> = found.iter().map(Edge::from).collect();
        let own = points[own as usize];
        let around = found.iter().map(|near| points[near.index as usize]);
        let plane = Plane::of(std::iter::once(own).chain(around));
        if plane.is_line() {
            tree.nearest_where(own, 2, f64::INFINITY, found, |other| {
                let apart = points[other as usize] - own;
                // More than 45 degrees from the line.
                2.0 * apart.dot(plane.axes[0]).powi(2) < apart.length_squared()
            });
            found.retain(|near| edges.iter().all(|edge| edge.to != near.index));
            edges.extend(found.iter().map(Edge::from));
        }
        edges
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn paths_go_around_a_gap() {
        // Three quarters of a low cylinder: the path is the long one.
        let ring: Vec<DVec3> = (0..=200)
            .flat_map(|i| (0..5).map(move |j| (f64::from(i), f64::from(j))))
            .map(|(i, j)| (i / 200.0 * 1.5 * std::f64::consts::PI, j / 40.0))
            .map(|(angle, z)| DVec3::new(angle.cos(), angle.sin(), z))
            .collect();
        let graph = NeighborGraph::of(&ring, 8, &mut Silent).unwrap();
        let far = graph.distances_from(&[2])[1002];
        assert!((far - 1.5 * std::f64::consts::PI).abs() < 1e-3, "{far}");
        let middle = graph.distances_from(&[2, 1002])[502];
        assert!((middle - 0.75 * std::f64::consts::PI).abs() < 1e-3, "{middle}");
    }

    #[test]
    fn scan_lines_are_joined() {
        let lines: Vec<DVec3> = (0..1000)
            .map(|i| DVec3::new(f64::from(i / 100), f64::from(i % 100) / 20.0, 0.0))
            .collect();
        let graph = NeighborGraph::of(&lines, 8, &mut Silent).unwrap();
        assert!((graph.distances_from(&[0])[900] - 9.0).abs() < 0.5);
    }

    #[test]
    fn each_edge_is_listed_once_at_both_ends() {
        let scattered: Vec<DVec3> = (0..2000)
            .map(f64::from)
            .map(|i| DVec3::new((i * 0.754_877_666).fract(), (i * i * 0.618).fract(), 0.0))
            .collect();
        let graph = NeighborGraph::of(&scattered, 6, &mut Silent).unwrap();
        for node in 0..graph.len() {
            for edge in graph.edges(node) {
                let of = |node: usize, to: usize| {
                    graph.edges(node).iter().filter(|edge| edge.to as usize == to).count()
                };
                assert_eq!(of(node, edge.to as usize), 1);
                assert_eq!(of(edge.to as usize, node), 1);
            }
        }
    }

    #[test]
    fn parts_are_joined_by_their_shortest_links() {
        let pair = |x: f64| [DVec3::X * x, DVec3::new(x + 1.0, 0.0, 0.0)];
        let points: Vec<DVec3> = [0.0, 20.0, 9.0, 50.0].into_iter().flat_map(pair).collect();
        let lists = (0..8).map(|i: u32| vec![Edge { to: i ^ 1, length: 1.0 }]).collect();
        let graph = NeighborGraph::joined(&KdTree::new(&points), lists);
        let ends = |node: usize| graph.edges(node).iter().map(|edge| edge.to).collect::<Vec<_>>();
        assert_eq!([ends(1), ends(5), ends(3)], [vec![0, 4], vec![4, 2], vec![2, 6]]);
        assert_eq!(graph.distances_from(&[0])[7], 51.0);
    }
}
