//! A quadrilateral grid: distances, edges and neighborhoods by arithmetic on rows and columns.

use std::ops::Range;

use super::topology::Topology;

/// A quadrilateral grid of rows × cols nodes, numbered row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) rows: usize,
    pub(super) cols: usize,
    pub(super) topology: Topology,
}

impl Grid {
    /// Largest number of edges between two nodes.
    pub(super) fn diameter(&self) -> usize {
        let across = |count: usize, closed| if closed { count / 2 } else { count - 1 };
        let (closed_u, closed_v) = self.topology.closed();
        across(self.rows, closed_u) + across(self.cols, closed_v)
    }

    /// Number of rows between two rows, the shorter way around if closed.
    fn row_distance(&self, a: usize, b: usize) -> usize {
        around(a.abs_diff(b), self.rows, self.topology.closed().0)
    }

    /// Whether two nodes are corners of the same cell.
    pub(super) fn share_a_cell(&self, a: usize, b: usize) -> bool {
        let cols = (a % self.cols).abs_diff(b % self.cols);
        self.row_distance(a / self.cols, b / self.cols) <= 1
            && around(cols, self.cols, self.topology.closed().1) <= 1
    }

    /// Calls `visit` with the nodes at most `radius` edges from `node`, as one or two ranges of
    /// node indices for each row.
    pub(super) fn visit_ball(
        &self,
        node: usize,
        radius: usize,
        mut visit: impl FnMut(Range<usize>),
    ) {
        let (row, col) = (node / self.cols, node % self.cols);
        let (closed_u, closed_v) = self.topology.closed();
        let (from, to) = if closed_u {
            (0, self.rows)
        } else {
            (row.saturating_sub(radius), self.rows.min(row.saturating_add(radius + 1)))
        };
        for r in from..to {
            let Some(left) = radius.checked_sub(self.row_distance(r, row)) else { continue };
            let first = r * self.cols;
            if closed_v && left >= self.cols / 2 {
                visit(first..first + self.cols);
            } else if closed_v {
                let start = (col + self.cols - left) % self.cols;
                let end = start + 2 * left + 1;
                visit(first + start..first + end.min(self.cols));
                visit(first..first + end.saturating_sub(self.cols));
            } else {
                visit(first + col.saturating_sub(left)..first + self.cols.min(col + left + 1));
            }
        }
    }

    /// The neighbors of `node` along rows, columns and one diagonal of each cell, ascending.
    pub(super) fn triangular_neighbors(&self, node: usize) -> impl Iterator<Item = usize> {
        let (row, col) = (node / self.cols, node % self.cols);
        let (closed_u, closed_v) = self.topology.closed();
        let (above, below) = (previous(row, self.rows, closed_u), next(row, self.rows, closed_u));
        let (left, right) = (previous(col, self.cols, closed_v), next(col, self.cols, closed_v));
        let pairs = [
            above.zip(left),
            above.zip(Some(col)),
            Some(row).zip(left),
            Some(row).zip(right),
            below.zip(Some(col)),
            below.zip(right),
        ];
        let mut nodes = pairs.map(|pair| pair.map(|(row, col)| row * self.cols + col));
        nodes.sort_unstable();
        nodes.into_iter().flatten()
    }

    /// The edges along rows and columns, each once, the lower node first.
    pub(super) fn edges(&self) -> Vec<(usize, usize)> {
        let (closed_u, closed_v) = self.topology.closed();
        let mut edges = Vec::with_capacity(2 * self.rows * self.cols);
        for node in 0..self.rows * self.cols {
            let (row, col) = (node / self.cols, node % self.cols);
            let below = next(row, self.rows, closed_u).map(|r| r * self.cols);
            let right = next(col, self.cols, closed_v);
            let mut join = |other: usize| edges.push((node.min(other), node.max(other)));
            if let Some(col) = right {
                join(row * self.cols + col);
            }
            if let Some(first) = below {
                join(first + col);
            }
        }
        edges
    }
}

/// The index after `index` on a line or ring of `count`.
fn next(index: usize, count: usize, closed: bool) -> Option<usize> {
    if index + 1 < count { Some(index + 1) } else { closed.then_some(0) }
}

/// The index before `index` on a line or ring of `count`.
fn previous(index: usize, count: usize, closed: bool) -> Option<usize> {
    index.checked_sub(1).or(closed.then(|| count - 1))
}

/// A distance on a line, or the shorter way around a ring of `count`.
fn around(distance: usize, count: usize, closed: bool) -> usize {
    if closed { distance.min(count - distance) } else { distance }
}
