//! The edges between blocks and the vertices on them.

use super::block::Block;
use super::block_grid::BlockGrid;
use super::cell::Cell;

/// The vertices inside every block edge, sorted; a closed direction has one edge at its seam.
#[derive(Debug)]
pub(super) struct BlockEdges {
    /// Edges at constant u, indexed by (line, column) row by row; coordinates in v.
    at_u: Vec<Vec<u32>>,
    /// Edges at constant v, indexed by (row, line) row by row; coordinates in u.
    at_v: Vec<Vec<u32>>,
    shape: (usize, usize),
    closed: (bool, bool),
}

/// The index of a block edge.
#[derive(Clone, Copy, Debug)]
pub(super) enum EdgeIndex {
    /// An edge at constant u.
    U(usize),
    /// An edge at constant v.
    V(usize),
}

impl BlockEdges {
    /// The edges of a grid of blocks, without vertices.
    pub(super) fn new(grid: &BlockGrid) -> Self {
        let (rows, cols) = grid.shape();
        Self {
            at_u: vec![vec![]; (rows + 1) * cols],
            at_v: vec![vec![]; rows * (cols + 1)],
            shape: (rows, cols),
            closed: grid.closed,
        }
    }

    /// The edges of a block: at the start and the end in u, then at the start and the end in v.
    pub(super) fn of_block(&self, block: usize) -> [EdgeIndex; 4] {
        let (i, j) = (block / self.shape.1, block % self.shape.1);
        [self.at_u(i, j), self.at_u(i + 1, j), self.at_v(i, j), self.at_v(i, j + 1)]
    }

    /// The edge on a line of constant u, in a column of blocks.
    pub(super) fn at_u(&self, line: usize, col: usize) -> EdgeIndex {
        let line = if self.closed.0 { line % self.shape.0 } else { line };
        EdgeIndex::U(line * self.shape.1 + col)
    }

    /// The edge on a line of constant v, in a row of blocks.
    pub(super) fn at_v(&self, row: usize, line: usize) -> EdgeIndex {
        let line = if self.closed.1 { line % self.shape.1 } else { line };
        EdgeIndex::V(row * (self.shape.1 + 1) + line)
    }

    /// The vertices inside an edge.
    pub(super) fn vertices(&self, edge: EdgeIndex) -> &[u32] {
        match edge {
            EdgeIndex::U(index) => &self.at_u[index],
            EdgeIndex::V(index) => &self.at_v[index],
        }
    }

    /// Adds vertices to an edge; returns whether one of them is new.
    pub(super) fn add(&mut self, edge: EdgeIndex, added: &[u32]) -> bool {
        let vertices = match edge {
            EdgeIndex::U(index) => &mut self.at_u[index],
            EdgeIndex::V(index) => &mut self.at_v[index],
        };
        let before = vertices.len();
        vertices.extend_from_slice(added);
        vertices.sort_unstable();
        vertices.dedup();
        vertices.len() > before
    }

    /// The blocks on both sides of an edge.
    pub(super) fn adjacent_blocks(&self, edge: EdgeIndex) -> Vec<usize> {
        let (rows, cols) = self.shape;
        let both = |line: usize, count: usize, closed: bool| {
            let before = if line == 0 && closed { Some(count - 1) } else { line.checked_sub(1) };
            before.into_iter().chain((line < count).then_some(line))
        };
        match edge {
            EdgeIndex::U(index) => {
                let (line, col) = (index / cols, index % cols);
                both(line, rows, self.closed.0).map(|row| row * cols + col).collect()
            }
            EdgeIndex::V(index) => {
                let (row, line) = (index / (cols + 1), index % (cols + 1));
                both(line, cols, self.closed.1).map(|col| row * cols + col).collect()
            }
        }
    }
}

/// The vertices that the cells of a block have inside its four edges.
pub(super) fn cell_corners_on_edges(block: Block, cells: &[Cell]) -> [Vec<u32>; 4] {
    let whole = Cell::of(block);
    let mut edges: [Vec<u32>; 4] = Default::default();
    for cell in cells {
        // One end of each cell is enough: the other end belongs to its neighbor.
        let ends = [
            (cell.u.0 == whole.u.0, cell.v.1, whole.v.1),
            (cell.u.1 == whole.u.1, cell.v.1, whole.v.1),
            (cell.v.0 == whole.v.0, cell.u.1, whole.u.1),
            (cell.v.1 == whole.v.1, cell.u.1, whole.u.1),
        ];
        for (edge, (touches, step, end)) in edges.iter_mut().zip(ends) {
            if touches && step != end {
                edge.push(step);
            }
        }
    }
    edges
}
