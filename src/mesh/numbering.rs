//! The indices of vertices and triangles.
//!
//! The corners of blocks come first, then the vertices inside block edges, then those inside
//! blocks. So every block can find the indices of its own vertices, and neighbors agree on shared
//! ones.

use glam::DVec2;

use super::block::parameter;
use super::block_edges::EdgeIndex;
use super::block_vertices::BlockVertices;
use super::cell::Cell;
use super::partition::Partition;

/// The indices of vertices and triangles.
#[derive(Debug, Default)]
pub(super) struct Numbering {
    /// The vertex at each block corner, row by row.
    pub corners: Vec<u32>,
    /// The first vertex of each block edge at constant u, and whether the edge is that vertex (a
    /// pole).
    pub edges_u: Vec<(u32, bool)>,
    /// The same for block edges at constant v.
    pub edges_v: Vec<(u32, bool)>,
    /// Parameters of the vertices at block corners and on block edges, in order of their indices.
    pub edge_uv: Vec<DVec2>,
    /// The first inner vertex of each block, and the end.
    pub vertices: Vec<usize>,
    /// The first triangle of each block, and the end.
    pub triangles: Vec<usize>,
}

impl Numbering {
    /// Assigns indices; `split` keeps both sides of a seam as separate vertices.
    pub(super) fn new(partition: &Partition<'_>, split: bool) -> Self {
        let closed = if split { (false, false) } else { partition.grid.closed };
        let mut this = Self::default();
        this.number_corners(partition, closed);
        this.number_edges_u(partition, closed.0);
        this.number_edges_v(partition, closed.1);
        this.vertices.push(this.edge_uv.len());
        this.triangles.push(0);
        for index in 0..partition.grid.blocks() {
            let (inside, faces) = count(partition, index);
            this.vertices.push(this.vertices[index] + inside);
            this.triangles.push(this.triangles[index] + faces);
        }
        this
    }

    /// The index of the next vertex on an edge.
    fn next(&self) -> u32 {
        vertex_index(self.edge_uv.len())
    }

    fn number_corners(&mut self, partition: &Partition<'_>, closed: (bool, bool)) {
        let grid = &partition.grid;
        let (rows, cols) = grid.shape();
        for (i, j) in (0..=rows).flat_map(|i| (0..=cols).map(move |j| (i, j))) {
            let owner = grid.owner((i, j), closed);
            let index = if owner == (i, j) {
                let index = self.next();
                self.edge_uv.push(DVec2::new(grid.nets.u[grid.u[i]], grid.nets.v[grid.v[j]]));
                index
            } else {
                self.corners[owner.0 * (cols + 1) + owner.1]
            };
            self.corners.push(index);
        }
    }

    fn number_edges_u(&mut self, partition: &Partition<'_>, closed: bool) {
        let grid = &partition.grid;
        let (rows, cols) = grid.shape();
        for (i, j) in (0..=rows).flat_map(|i| (0..cols).map(move |j| (i, j))) {
            let entry = if grid.is_pole_u(i) {
                (self.corners[i * (cols + 1) + j], true)
            } else if i == rows && closed {
                self.edges_u[j]
            } else {
                let u = grid.nets.u[grid.u[i]];
                let uv = |step| DVec2::new(u, parameter(&grid.nets.v, grid.v[j], step));
                self.number_edge(partition, partition.edges.at_u(i, j), uv)
            };
            self.edges_u.push(entry);
        }
    }

    fn number_edges_v(&mut self, partition: &Partition<'_>, closed: bool) {
        let grid = &partition.grid;
        let (rows, cols) = grid.shape();
        for (i, j) in (0..rows).flat_map(|i| (0..=cols).map(move |j| (i, j))) {
            let entry = if grid.is_pole_v(j) {
                (self.corners[i * (cols + 1) + j], true)
            } else if j == cols && closed {
                self.edges_v[i * (cols + 1)]
            } else {
                let v = grid.nets.v[grid.v[j]];
                let uv = |step| DVec2::new(parameter(&grid.nets.u, grid.u[i], step), v);
                self.number_edge(partition, partition.edges.at_v(i, j), uv)
            };
            self.edges_v.push(entry);
        }
    }

    /// Numbers the vertices inside an edge, at the parameters `uv` of their coordinates.
    fn number_edge(
        &mut self,
        partition: &Partition<'_>,
        edge: EdgeIndex,
        uv: impl Fn(u32) -> DVec2,
    ) -> (u32, bool) {
        let first = self.next();
        self.edge_uv.extend(partition.edges.vertices(edge).iter().map(|&step| uv(step)));
        (first, false)
    }

    /// Replaces `out` by the indices of a block's vertices, in order of their ranks.
    ///
    /// `inner` is the index of the first vertex inside the block.
    pub(super) fn vertex_indices(
        &self,
        (partition, index): (&Partition<'_>, usize),
        vertices: &BlockVertices,
        mut inner: u32,
        out: &mut Vec<u32>,
    ) {
        let (_, cols) = partition.grid.shape();
        let (i, j) = partition.grid.at(index);
        let whole = Cell::of(partition.grid.block(index));
        let edges = partition.edge_vertices(index);
        let on_edge = |(first, pole): (u32, bool), steps: &[u32], step: u32| {
            if pole { first } else { first + vertex_index(steps.partition_point(|&at| at < step)) }
        };
        out.clear();
        out.extend(vertices.points().map(|(u, v)| {
            let (last_u, last_v) = (u == whole.u.1, v == whole.v.1);
            let (on_u, on_v) = (u == 0 || last_u, v == 0 || last_v);
            let (line_u, line_v) = (i + usize::from(last_u), j + usize::from(last_v));
            match (on_u, on_v) {
                (true, true) => self.corners[line_u * (cols + 1) + line_v],
                (true, false) => {
                    on_edge(self.edges_u[line_u * cols + j], edges[usize::from(last_u)], v)
                }
                (false, true) => {
                    let edge = edges[2 + usize::from(last_v)];
                    on_edge(self.edges_v[i * (cols + 1) + line_v], edge, u)
                }
                (false, false) => {
                    inner += 1;
                    inner - 1
                }
            }
        }));
    }
}

/// Numbers of inner vertices and of triangles in a block.
fn count(partition: &Partition<'_>, index: usize) -> (usize, usize) {
    let corners = partition.cells[index].iter().map(|cell| cell.triangulation.corner_count());
    let triangles = corners.map(|count| count - 2).sum::<usize>();
    let edges = partition.edge_vertices(index).map(<[u32]>::len);
    let boundary = 4 + edges.iter().sum::<usize>();
    // A triangulated disc with n inner and m boundary vertices has 2 n + m - 2 triangles.
    let inside = (triangles + 2 - boundary) / 2;
    // Triangles with two corners at the same pole are left out: one for each edge there.
    let grid = &partition.grid;
    let (i, j) = grid.at(index);
    let poles =
        [grid.is_pole_u(i), grid.is_pole_u(i + 1), grid.is_pole_v(j), grid.is_pole_v(j + 1)];
    let collapsed = poles.iter().zip(edges).filter(|(pole, _)| **pole).map(|(_, n)| n + 1);
    (inside, triangles - collapsed.sum::<usize>())
}

/// An index as 32 bits; the limit on triangles keeps all indices below 2^32.
pub(super) fn vertex_index(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
