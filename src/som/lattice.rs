//! The graph of the output nodes.

use std::ops::Range;

use crate::error::{Error, Result};

/// Largest number of nodes: 16.8 million, whose net alone is 400 MB.
pub const MAX_NODES: usize = 1 << 24;

/// The paper's `m = 4 n` nodes are for few points, up to this many nodes.
const FEW_NODES: usize = 400;

/// For many points the number of nodes is "convenient": with at least this many points for each
/// node its place is an average, not a single sample.
const POINTS_PER_NODE: usize = 5;

/// Most nodes that [`Lattice::for_points`] chooses by itself.
const MOST_CHOSEN: usize = 2500;

/// A quadrilateral lattice of `rows` × `cols` nodes, numbered row by row; each inner node is
/// connected to four others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lattice {
    rows: usize,
    cols: usize,
}

impl Lattice {
    /// A lattice of `rows` × `cols` nodes.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has fewer than 2 nodes, or all together are more than
    /// [`MAX_NODES`].
    pub fn quad(rows: usize, cols: usize) -> Result<Self> {
        let fits = rows.checked_mul(cols).is_some_and(|m| m <= MAX_NODES);
        if rows >= 2 && cols >= 2 && fits {
            return Ok(Self { rows, cols });
        }
        let must = format!("(rows, cols) of at least 2 each and at most {MAX_NODES} nodes in all");
        Err(Error::parameter("grid", must, format!("({rows}, {cols})")))
    }

    /// The lattice for this many points: the paper's four nodes for each of few points, and a
    /// convenient number for many (at least 400, one for five points, at most 2500); as square
    /// as it can be.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// assert_eq!(Lattice::for_points(13).shape(), (7, 8));
    /// assert_eq!(Lattice::for_points(4_000).shape(), (28, 29));
    /// assert_eq!(Lattice::for_points(10_000_000).shape(), (50, 50));
    /// ```
    #[must_use]
    pub fn for_points(points: usize) -> Self {
        let many = (points / POINTS_PER_NODE).clamp(FEW_NODES, MOST_CHOSEN);
        let nodes = points.saturating_mul(4).min(many);
        let rows = nodes.isqrt().max(2);
        Self { rows, cols: nodes.div_ceil(rows).max(2) }
    }

    /// Number of nodes along both sides: (rows, cols).
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.rows, self.cols)
    }

    /// Number of nodes.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a lattice has at least four nodes")]
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    /// Largest number of edges between two nodes.
    #[must_use]
    pub fn diameter(&self) -> usize {
        self.rows + self.cols - 2
    }

    /// The nodes at most `radius` edges from `node`: the paper's N(t), as ranges of node numbers,
    /// one for each row that is reached.
    ///
    /// ```
    /// use neurbs::som::Lattice;
    /// let lattice = Lattice::quad(3, 5)?;
    /// let near: Vec<usize> = lattice.neighborhood(6, 1).flatten().collect();
    /// assert_eq!(near, [1, 5, 6, 7, 11]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    pub fn neighborhood(&self, node: usize, radius: usize) -> impl Iterator<Item = Range<usize>> {
        let (row, col) = (node / self.cols, node % self.cols);
        let rows = row.saturating_sub(radius)..self.rows.min(row.saturating_add(radius + 1));
        let cols = self.cols;
        rows.map(move |r| {
            let left = radius - r.abs_diff(row);
            let from = col.saturating_sub(left);
            let to = cols.min(col + left + 1);
            r * cols + from..r * cols + to
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighborhood_is_the_graph_distance() {
        let lattice = Lattice::quad(6, 9).unwrap();
        for node in 0..lattice.len() {
            for radius in 0..=lattice.diameter() {
                let distance =
                    |other: usize| (node / 9).abs_diff(other / 9) + (node % 9).abs_diff(other % 9);
                let expected: Vec<usize> =
                    (0..lattice.len()).filter(|&other| distance(other) <= radius).collect();
                let got: Vec<usize> = lattice.neighborhood(node, radius).flatten().collect();
                assert_eq!(got, expected, "node {node}, radius {radius}");
            }
        }
    }

    #[test]
    fn the_diameter_reaches_everything_and_less_does_not() {
        let lattice = Lattice::quad(4, 7).unwrap();
        let reached = |radius| lattice.neighborhood(0, radius).flatten().count();
        assert_eq!(reached(lattice.diameter()), lattice.len());
        assert!(reached(lattice.diameter() - 1) < lattice.len());
    }

    #[test]
    fn sides_and_size_are_bounded() {
        assert!(Lattice::quad(2, 1).is_err());
        assert!(Lattice::quad(usize::MAX, 2).is_err());
        assert!(Lattice::quad(MAX_NODES / 2, 2).is_ok());
    }
}
