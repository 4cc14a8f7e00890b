//! An undirected graph of nodes: the lattice of any other topology than a grid.

use crate::error::{Error, Result};

/// A connected undirected graph, as lists of neighbors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Graph {
    /// Index in `neighbors` of each node's first neighbor, and the total length at the end.
    starts: Vec<u32>,
    /// The neighbors of all nodes, ascending for each node.
    neighbors: Vec<u32>,
}

impl Graph {
    /// The graph of `nodes` nodes with these edges. Repeated edges are ignored.
    pub(super) fn new(nodes: usize, edges: &[(usize, usize)]) -> Result<Self> {
        let mut links: Vec<(u32, u32)> = Vec::with_capacity(2 * edges.len());
        for &(a, b) in edges {
            let (Ok(from), Ok(to)) = (u32::try_from(a), u32::try_from(b)) else {
                return Err(missing_node(nodes, a, b));
            };
            if a >= nodes || b >= nodes || a == b {
                return Err(missing_node(nodes, a, b));
            }
            links.extend([(from, to), (to, from)]);
        }
        links.sort_unstable();
        links.dedup();
        let mut starts = vec![0; nodes + 1];
        for &(from, _) in &links {
            starts[from as usize + 1] += 1;
        }
        for node in 0..nodes {
            starts[node + 1] += starts[node];
        }
        let graph = Self { starts, neighbors: links.into_iter().map(|(_, to)| to).collect() };
        let mut reached = 0;
        graph.visit(0, usize::MAX, &mut Visits::default(), |_, _| reached += 1);
        if reached == nodes {
            return Ok(graph);
        }
        let got = format!("{reached} of {nodes} nodes connected to node 0");
        Err(Error::parameter("edges", "those of a connected graph", got))
    }

    /// The graph with these neighbors of each node. They must be ascending, and the graph
    /// connected.
    #[expect(clippy::cast_possible_truncation, reason = "a node's number is under MAX_NODES")]
    pub(super) fn of_neighbors<T: Iterator<Item = usize>>(
        nodes: usize,
        neighbors: impl Fn(usize) -> T,
    ) -> Self {
        let mut graph = Self { starts: Vec::with_capacity(nodes + 1), neighbors: Vec::new() };
        graph.starts.push(0);
        for node in 0..nodes {
            graph.neighbors.extend(neighbors(node).map(|other| other as u32));
            graph.starts.push(graph.neighbors.len() as u32);
        }
        graph
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The neighbors of `node`, ascending.
    pub(super) fn neighbors(&self, node: usize) -> &[u32] {
        &self.neighbors[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// Each edge once, the lower node first.
    pub(super) fn edges(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.len()).flat_map(move |node| {
            let above = self.neighbors(node).iter().map(|&other| other as usize);
            above.filter(move |&other| other > node).map(move |other| (node, other))
        })
    }

    /// Calls `visit` with each node at most `radius` edges from `from`, and its number of edges, in
    /// breadth-first order.
    pub(super) fn visit(
        &self,
        from: usize,
        radius: usize,
        visits: &mut Visits,
        mut visit: impl FnMut(usize, usize),
    ) {
        visits.begin(self.len());
        visits.mark(from);
        let (mut done, mut hops) = (0, 0);
        while done < visits.queue.len() && hops <= radius {
            let ring = done..visits.queue.len();
            for place in ring.clone() {
                let node = visits.queue[place];
                visit(node, hops);
                for &next in self.neighbors(node) {
                    visits.mark(next as usize);
                }
            }
            done = ring.end;
            hops += 1;
        }
    }

    /// The largest number of edges between two nodes, by two breadth-first searches. Exact for
    /// trees and grids, otherwise a lower bound.
    pub(super) fn diameter(&self) -> usize {
        let mut visits = Visits::default();
        let mut farthest = (0, 0);
        self.visit(0, usize::MAX, &mut visits, |node, hops| farthest = (node, hops));
        self.visit(farthest.0, usize::MAX, &mut visits, |node, hops| farthest = (node, hops));
        farthest.1
    }
}

fn missing_node(nodes: usize, a: usize, b: usize) -> Error {
    let must = format!("pairs of different nodes from 0 to {}", nodes.saturating_sub(1));
    Error::parameter("edges", must, format!("({a}, {b})"))
}

/// Scratch memory of [`Graph::visit`], reused between calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Visits {
    /// The number of the visit that last marked each node.
    met: Vec<u32>,
    visit: u32,
    queue: Vec<usize>,
}

impl Visits {
    fn begin(&mut self, nodes: usize) {
        self.queue.clear();
        self.visit = self.visit.wrapping_add(1);
        if self.met.len() != nodes || self.visit == 0 {
            self.met = vec![0; nodes];
            self.visit = 1;
        }
    }

    fn mark(&mut self, node: usize) {
        if self.met[node] != self.visit {
            self.met[node] = self.visit;
            self.queue.push(node);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(nodes: usize) -> Graph {
        let edges: Vec<_> = (0..nodes).map(|i| (i, (i + 1) % nodes)).collect();
        Graph::new(nodes, &edges).unwrap()
    }

    #[test]
    fn visit_counts_edges_both_ways_around_a_ring() {
        let mut hops = [usize::MAX; 7];
        ring(7).visit(2, 2, &mut Visits::default(), |node, distance| hops[node] = distance);
        let far = usize::MAX;
        assert_eq!(hops, [2, 1, 0, 1, 2, far, far]);
        assert_eq!(ring(7).diameter(), 3);
    }

    #[test]
    fn edges_are_listed_once() {
        let graph = Graph::new(3, &[(2, 0), (0, 2), (1, 2)]).unwrap();
        assert_eq!(graph.edges().collect::<Vec<_>>(), [(0, 2), (1, 2)]);
    }

    #[test]
    fn missing_nodes_loops_and_disconnected_graphs_are_refused() {
        let message = |nodes, edges: &[_]| Graph::new(nodes, edges).unwrap_err().to_string();
        assert!(message(3, &[(0, 1), (1, 3)]).contains("got (1, 3)"));
        assert!(message(3, &[(0, 1), (1, 1)]).contains("got (1, 1)"));
        assert!(message(4, &[(0, 1), (2, 3)]).contains("2 of 4 nodes"));
    }
}
