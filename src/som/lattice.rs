//! The lattice: the nodes of the map and their connections.

use super::graph::{Graph, Visits};
use super::grid::Grid;
use super::topology::{Cells, Topology};
use crate::error::{Error, Result};
use crate::memory;

/// Largest number of nodes of a lattice: 16.8 million, which take 8.6 GB to train.
pub const MAX_NODES: usize = 1 << 24;

/// Memory that training takes per node, in bytes: positions and their copies, sums of each thread,
/// and smoothed sums.
const BYTES_PER_NODE: usize = 512;

/// The paper's rule of four nodes per point holds up to this number of nodes.
const PAPER_RULE_MAX_NODES: usize = 400;

/// Fewest points per node beyond the paper's rule, so that a node's position is an average.
const POINTS_PER_NODE: usize = 5;

/// Largest number of nodes that [`Lattice::for_points`] chooses.
const MAX_DEFAULT_NODES: usize = 2500;

/// The nodes and their connections: a grid of rows × cols nodes, numbered row by row, or any other
/// connected graph.
///
/// The paper's lattice is the quadrilateral grid; "if a triangular or any other kind of grid would
/// be desired, the nodes can be connected accordingly" (section 4).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// For a graph, a single column.
    grid: Grid,
    links: Links,
}

/// The connections of the nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Links {
    Quad,
    Triangular(Graph),
    /// No rows and columns.
    Graph(Graph),
}

/// How distances between nodes are computed.
#[derive(Clone, Copy)]
pub(super) enum Distances<'a> {
    /// By arithmetic on rows and columns.
    Grid(&'a Grid),
    /// By breadth-first search.
    Graph(&'a Graph),
}

impl Lattice {
    /// A quadrilateral sheet of `rows` × `cols` nodes; see [`Lattice::grid`].
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::quad(3, 5)?.len(), 15);
    /// assert!(Lattice::quad(1, 5).is_err());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has fewer than 2 nodes, or there are more than [`MAX_NODES`]
    /// nodes.
    pub fn quad(rows: usize, cols: usize) -> Result<Self> {
        Self::grid(rows, cols, Cells::Quad, Topology::Sheet)
    }

    /// A grid of `rows` × `cols` nodes.
    ///
    /// ```
    /// use neurbs::som::{Cells, Lattice, Topology};
    /// let tube = Lattice::grid(6, 4, Cells::Quad, Topology::Tube)?;
    /// assert_eq!(tube.neighborhood(0, 1), [0, 1, 4, 20]);
    /// let triangles = Lattice::grid(3, 3, Cells::Triangular, Topology::Sheet)?;
    /// assert_eq!(triangles.neighborhood(4, 1), [0, 1, 3, 4, 5, 7, 8]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if a side has fewer than 2 nodes (3 if closed), or there are more
    ///   than [`MAX_NODES`] nodes.
    /// - [`Error::Memory`] if there is too little memory for a triangular grid.
    pub fn grid(rows: usize, cols: usize, cells: Cells, topology: Topology) -> Result<Self> {
        let fits = rows.checked_mul(cols).is_some_and(|m| m <= MAX_NODES);
        let min_nodes = |closed| if closed { 3 } else { 2 };
        let (closed_u, closed_v) = topology.closed();
        if rows < min_nodes(closed_u) || cols < min_nodes(closed_v) || !fits {
            let must = format!(
                "(rows, cols) of at least ({}, {}) for a {} and at most {MAX_NODES} nodes in all",
                min_nodes(closed_u),
                min_nodes(closed_v),
                topology.name()
            );
            let gigabytes = rows as f64 * cols as f64 * BYTES_PER_NODE as f64 / 1e9;
            let size =
                if fits { String::new() } else { format!(", about {gigabytes:.0} GB of memory") };
            return Err(Error::parameter("grid", must, format!("({rows}, {cols}){size}")));
        }
        let mut lattice = Self { grid: Grid { rows, cols, topology }, links: Links::Quad };
        if cells == Cells::Triangular {
            lattice.check_memory()?;
            let neighbors = |node| lattice.grid.triangular_neighbors(node);
            let graph = Graph::of_neighbors(rows * cols, neighbors);
            lattice.links = Links::Triangular(graph);
        }
        Ok(lattice)
    }

    /// Any other topology: `nodes` nodes and the edges between them.
    ///
    /// ```
    /// use neurbs::{Error, som::Lattice};
    /// let star = Lattice::graph(4, &[(0, 1), (0, 2), (0, 3)])?;
    /// assert_eq!(star.neighborhood(1, 1), [0, 1]);
    /// let pieces = Lattice::graph(4, &[(0, 1), (2, 3)]).unwrap_err();
    /// assert!(pieces.to_string().starts_with("edges must be those of a connected graph"));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if one of these holds:
    ///
    /// - There are fewer than 2 or more than [`MAX_NODES`] nodes.
    /// - An edge names a missing node, or joins a node to itself.
    /// - The graph is not connected.
    pub fn graph(nodes: usize, edges: &[(usize, usize)]) -> Result<Self> {
        if !(2..=MAX_NODES).contains(&nodes) {
            let must = format!("from 2 to {MAX_NODES}");
            return Err(Error::parameter("nodes", must, nodes));
        }
        let links = Links::Graph(Graph::new(nodes, edges)?);
        let grid = Grid { rows: nodes, cols: 1, topology: Topology::Sheet };
        Ok(Self { grid, links })
    }

    /// The default quadrilateral sheet for this many points, as square as possible. It has the
    /// paper's four nodes per point, up to 400 nodes; for more points one node for five points,
    /// from 400 to 2500.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::for_points(13).shape(), (7, 8));
    /// assert_eq!(Lattice::for_points(4_000).shape(), (28, 29));
    /// assert_eq!(Lattice::for_points(10_000_000).shape(), (50, 50));
    /// ```
    #[must_use]
    pub fn for_points(points: usize) -> Self {
        let limit = (points / POINTS_PER_NODE).clamp(PAPER_RULE_MAX_NODES, MAX_DEFAULT_NODES);
        let nodes = points.saturating_mul(4).min(limit);
        let rows = nodes.isqrt().max(2);
        let cols = nodes.div_ceil(rows).max(2);
        Self { grid: Grid { rows, cols, topology: Topology::Sheet }, links: Links::Quad }
    }

    /// Number of nodes along both sides (rows, cols); (nodes, 1) for a graph.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::quad(3, 5)?.shape(), (3, 5));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.grid.rows, self.grid.cols)
    }

    /// Whether the lattice has rows and columns.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert!(Lattice::quad(3, 5)?.is_grid());
    /// assert!(!Lattice::graph(3, &[(0, 1), (1, 2)])?.is_grid());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn is_grid(&self) -> bool {
        !matches!(self.links, Links::Graph(_))
    }

    /// The connection of a grid's nodes; `None` for a graph.
    ///
    /// ```
    /// use neurbs::som::{Cells, Lattice};
    /// assert_eq!(Lattice::quad(3, 5)?.cells(), Some(Cells::Quad));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn cells(&self) -> Option<Cells> {
        match self.links {
            Links::Quad => Some(Cells::Quad),
            Links::Triangular(_) => Some(Cells::Triangular),
            Links::Graph(_) => None,
        }
    }

    /// The closed directions of the grid.
    ///
    /// ```
    /// use neurbs::som::{Lattice, Topology};
    /// assert_eq!(Lattice::quad(3, 5)?.topology(), Topology::Sheet);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn topology(&self) -> Topology {
        self.grid.topology
    }

    /// Number of nodes.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::quad(3, 5)?.len(), 15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a lattice has at least two nodes")]
    pub fn len(&self) -> usize {
        self.grid.rows * self.grid.cols
    }

    /// Checks that there is memory for training.
    pub(super) fn check_memory(&self) -> Result<()> {
        let bytes = BYTES_PER_NODE as u128 * self.len() as u128;
        let (rows, cols) = self.shape();
        memory::check(bytes, || format!("a lattice of {rows} × {cols} nodes"))
    }

    /// Largest number of edges between two nodes. For graphs with loops it is a close lower bound,
    /// by two breadth-first searches.
    ///
    /// ```
    /// use neurbs::som::{Cells, Lattice, Topology};
    /// let torus = Lattice::grid(6, 8, Cells::Quad, Topology::Torus)?;
    /// assert_eq!((Lattice::quad(6, 8)?.diameter(), torus.diameter()), (12, 7));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn diameter(&self) -> usize {
        match &self.links {
            Links::Quad => self.grid.diameter(),
            // The diagonals join one pair of opposite corners only, so the other pair keeps its
            // distance.
            Links::Triangular(_) if self.topology() == Topology::Sheet => self.grid.diameter(),
            Links::Triangular(graph) | Links::Graph(graph) => graph.diameter(),
        }
    }

    /// The nodes at most `radius` edges from `node`, ascending: the paper's N(t).
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::quad(3, 5)?.neighborhood(6, 1), [1, 5, 6, 7, 11]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn neighborhood(&self, node: usize, radius: usize) -> Vec<usize> {
        let mut nodes = Vec::new();
        match self.distances() {
            Distances::Grid(grid) => grid.visit_ball(node, radius, |range| nodes.extend(range)),
            Distances::Graph(graph) => {
                graph.visit(node, radius, &mut Visits::default(), |node, _| nodes.push(node));
            }
        }
        nodes.sort_unstable();
        nodes
    }

    /// Each edge once, the lower node first.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::quad(2, 2)?.edges(), [(0, 1), (0, 2), (1, 3), (2, 3)]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn edges(&self) -> Vec<(usize, usize)> {
        match self.distances() {
            Distances::Grid(grid) => grid.edges(),
            Distances::Graph(graph) => graph.edges().collect(),
        }
    }

    /// How distances between nodes are computed.
    pub(super) fn distances(&self) -> Distances<'_> {
        match &self.links {
            Links::Quad => Distances::Grid(&self.grid),
            Links::Triangular(graph) | Links::Graph(graph) => Distances::Graph(graph),
        }
    }

    /// Whether two nodes share an edge or a cell.
    pub(super) fn adjacent(&self, a: usize, b: usize) -> bool {
        match &self.links {
            Links::Graph(graph) => u32::try_from(b).is_ok_and(|b| graph.neighbors(a).contains(&b)),
            Links::Quad | Links::Triangular(_) => self.grid.share_a_cell(a, b),
        }
    }

    /// Calls `visit` with each neighbor of `node`.
    pub(super) fn visit_neighbors(&self, node: usize, mut visit: impl FnMut(usize)) {
        match self.distances() {
            Distances::Grid(grid) => grid.visit_ball(node, 1, |range| {
                range.filter(|&other| other != node).for_each(&mut visit);
            }),
            Distances::Graph(graph) => {
                graph.neighbors(node).iter().for_each(|&other| visit(other as usize));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_and_graph_neighborhoods_agree() {
        for topology in Topology::ALL {
            for cells in Cells::ALL {
                let lattice = Lattice::grid(5, 7, cells, topology).unwrap();
                let graph = Lattice::graph(35, &lattice.edges()).unwrap();
                for node in 0..lattice.len() {
                    for radius in 0..=lattice.diameter() {
                        let got = lattice.neighborhood(node, radius);
                        assert_eq!(got, graph.neighborhood(node, radius), "{topology:?} {node}");
                    }
                }
            }
        }
    }

    #[test]
    fn diameter_is_the_largest_distance() {
        for topology in Topology::ALL {
            for cells in Cells::ALL {
                let lattice = Lattice::grid(4, 7, cells, topology).unwrap();
                let reached = |node, radius| lattice.neighborhood(node, radius).len();
                let diameter = lattice.diameter();
                assert!((0..28).all(|node| reached(node, diameter) == 28));
                assert!((0..28).any(|node| reached(node, diameter - 1) < 28));
            }
        }
    }

    #[test]
    fn sides_and_size_are_bounded() {
        assert!(Lattice::quad(2, 1).is_err());
        assert!(Lattice::quad(usize::MAX, 2).is_err());
        assert!(Lattice::quad(MAX_NODES / 2, 2).is_ok());
        let tube = Lattice::grid(2, 5, Cells::Quad, Topology::Tube).unwrap_err();
        assert!(tube.to_string().contains("at least (3, 2) for a tube"));
        assert!(Lattice::graph(1, &[]).is_err());
    }

    #[test]
    fn cells_make_nodes_adjacent() {
        let lattice = Lattice::grid(4, 5, Cells::Quad, Topology::Tube).unwrap();
        assert!(lattice.adjacent(6, 0) && lattice.adjacent(6, 12) && lattice.adjacent(0, 16));
        assert!(!lattice.adjacent(0, 4) && !lattice.adjacent(0, 2));
    }
}
