//! Points joined to their nearest ones, and distances along the edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::kd_tree::{KdTree, Neighbor};
use super::neighborhoods::Neighborhoods;
use crate::error::Result;
use crate::progress::Observer;

/// What lies beside a line is seen from it at more than this cosine's angle, 45 degrees.
const BESIDE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Points beside a line that each of its points is joined to.
const BESIDE_COUNT: usize = 2;

/// A graph whose edges join points that are among the nearest of one another, for clouds of some
/// ten thousand points.
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
    /// Where each node's edges begin; one more than nodes.
    starts: Vec<usize>,
    edges: Vec<Edge>,
}

/// An edge, seen from one of its ends.
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
    /// Each point joined to its `count` nearest, and to those that it is among the nearest of. Where
    /// these lie in a line, as on scan lines, also to the nearest two beside it.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn of(points: &[DVec3], count: usize, observer: &mut dyn Observer) -> Result<Self> {
        let tree = KdTree::new(points);
        let known = Neighborhoods::of(&tree, count, observer)?;
        Ok(Self::over(points, &known, &OnceLock::from(tree)))
    }

    /// As [`Self::of`], of points around which is known what is near.
    pub(crate) fn among(points: &[DVec3], known: &Neighborhoods) -> Self {
        Self::over(points, known, &OnceLock::new())
    }

    /// The tree over the points is made where it is needed first.
    fn over<'a>(
        points: &'a [DVec3],
        Neighborhoods { near, planes }: &Neighborhoods,
        tree: &OnceLock<KdTree<'a>>,
    ) -> Self {
        let edges = |found: &mut Vec<Neighbor>, own: usize| {
            let mut edges: Vec<Edge> = near[own].iter().map(Edge::from).collect();
            let (plane, own) = (&planes[own], points[own]);
            if plane.is_line() {
                let tree = tree.get_or_init(|| KdTree::new(points));
                tree.nearest_where(own, BESIDE_COUNT, f64::INFINITY, found, |other| {
                    let apart = points[other as usize] - own;
                    apart.dot(plane.axes[0]).abs() < BESIDE * apart.length()
                });
                found.retain(|near| edges.iter().all(|edge| edge.to != near.index));
                edges.extend(found.iter().map(Edge::from));
            }
            edges
        };
        let nodes = (0..points.len()).into_par_iter();
        Self::symmetric(nodes.map_init(Vec::new, edges).collect())
    }

    /// The graph of these edges, each listed at one of its ends at least.
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

    /// How many nodes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there are no nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The edges at a node.
    #[must_use]
    pub fn edges(&self, node: usize) -> &[Edge] {
        &self.edges[self.starts[node]..self.starts[node + 1]]
    }

    /// The mean length of the edges at a node; 0 if there are none.
    #[must_use]
    pub fn spacing(&self, node: usize) -> f64 {
        let edges = self.edges(node);
        let sum: f64 = edges.iter().map(|edge| edge.length).sum();
        sum / edges.len().max(1) as f64
    }

    /// Lengths of the shortest ways from the nearest of some nodes to all; infinite where there is
    /// none (Dijkstra).
    #[must_use]
    pub fn distances_from(&self, sources: &[u32]) -> Vec<f64> {
        let mut distances = vec![f64::INFINITY; self.len()];
        self.walk(sources, f64::INFINITY, &mut distances, &mut Front::default());
        distances
    }

    /// Writes the lengths of the ways that are no longer than `limit` into `distances`, which are
    /// infinite before, and to which nodes these lead into `front`.
    pub(crate) fn walk(
        &self,
        sources: &[u32],
        limit: f64,
        distances: &mut [f64],
        Front { reached, queue }: &mut Front,
    ) {
        reached.clear();
        for &source in sources {
            distances[source as usize] = 0.0;
            reached.push(source);
            queue.push(stop(0.0, source));
        }
        while let Some(Reverse(next)) = queue.pop() {
            #[expect(clippy::cast_possible_truncation, reason = "its lower half")]
            let node = next as u32;
            let distance = distances[node as usize];
            if Reverse(next) < stop(distance, node) {
                // It has been come to by a shorter way.
                continue;
            }
            for &Edge { to, length } in self.edges(node as usize) {
                let there = distance + length;
                let known = &mut distances[to as usize];
                if there < *known && there <= limit {
                    if known.is_infinite() {
                        reached.push(to);
                    }
                    *known = there;
                    queue.push(stop(there, to));
                }
            }
        }
    }
}

/// How far a search has come. It is kept for the next one of the same thread: to get and give back memory that
/// grows takes longer than many a search, where another thread does so, too.
#[derive(Default)]
pub(crate) struct Front {
    /// The nodes that were reached.
    pub(crate) reached: Vec<u32>,
    /// Those to go on from.
    queue: BinaryHeap<Reverse<u64>>,
}

/// A place in Dijkstra's queue; the nearest is the greatest. The upper halves of positive numbers' bits are in their
/// order, to a millionth of them: of nodes that are as nearly as far one may have to wait for the other, and is then
/// come to once more.
fn stop(distance: f64, node: u32) -> Reverse<u64> {
    Reverse(distance.to_bits() >> 32 << 32 | u64::from(node))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn ways_lead_around_a_gap() {
        // Three quarters of a low cylinder: the way is the long one.
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
    fn every_edge_is_seen_once_from_both_ends() {
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
    fn walks_end_at_their_limit() {
        let line: Vec<DVec3> = (0..50).map(|i| DVec3::X * f64::from(i)).collect();
        let graph = NeighborGraph::of(&line, 2, &mut Silent).unwrap();
        let mut distances = vec![f64::INFINITY; 50];
        let mut front = Front::default();
        graph.walk(&[10], 3.0, &mut distances, &mut front);
        front.reached.sort_unstable();
        assert_eq!(front.reached, [7, 8, 9, 10, 11, 12, 13]);
        assert_eq!(distances[14], f64::INFINITY);
    }
}
