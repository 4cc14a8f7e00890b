//! How well a map fits points and keeps their order.

use glam::DVec3;

use super::candidates::Candidates;
use super::{SelfOrganizingMap, search};
use crate::error::Result;
use crate::progress::{self, Observer, Progress, Stage};

impl SelfOrganizingMap {
    /// The number of each point's nearest node, the lowest among equals.
    ///
    /// O(n log m) on points that lie near the lattice.
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`](crate::Error::NotFinite) for such a point;
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn predict(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<usize>> {
        self.measure(points, 1, observer, |tree, point| tree.nearest(point).0)
    }

    /// Mean distance from a point to its nearest node, in the points' unit; NaN of no points.
    ///
    /// # Errors
    ///
    /// As [`Self::predict`] has them.
    pub fn quantization_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let squared = self.measure(points, 1, observer, |tree, point| tree.nearest(point).1)?;
        Ok(squared.iter().map(|squared| squared.sqrt()).sum::<f64>() / points.len() as f64)
    }

    /// Share of the points whose two nearest nodes are no neighbours: they share neither an edge
    /// nor a cell of the lattice (Kiviluoto, Topology preservation in self-organizing maps, 1996).
    /// NaN of no points.
    ///
    /// # Errors
    ///
    /// As [`Self::predict`] has them.
    pub fn topographic_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let torn = self.measure(points, 2, observer, |tree, point| {
            let [first, second] = tree.nearest_two(point);
            !self.lattice.adjacent(first, second)
        })?;
        Ok(torn.iter().filter(|&&torn| torn).count() as f64 / points.len() as f64)
    }

    /// How many points each node is the nearest of.
    ///
    /// # Errors
    ///
    /// As [`Self::predict`] has them.
    pub fn hits(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<u64>> {
        let mut hits = vec![0; self.nodes.len()];
        self.predict(points, observer)?.into_iter().for_each(|node| hits[node] += 1);
        Ok(hits)
    }

    /// Mean distance from each node to its neighbours on the lattice, in the points' unit: Ultsch's
    /// unified distance matrix. O(m).
    #[must_use]
    pub fn u_matrix(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.nodes.len()];
        for (a, b) in self.lattice.edges() {
            let distance = self.nodes[a].distance(self.nodes[b]);
            for node in [a, b] {
                sums[node].0 += distance;
                sums[node].1 += 1.0;
            }
        }
        sums.into_iter().map(|(sum, count): (f64, f64)| sum / count).collect()
    }

    /// How many pairs of neighbouring cells of a grid are folded over: their normals are more than
    /// a right angle apart. `None` for a graph, which has no cells. O(m).
    #[must_use]
    pub fn fold_overs(&self) -> Option<usize> {
        self.lattice.cells()?;
        let (rows, cols) = self.lattice.shape();
        let (closed_u, closed_v) = self.lattice.topology().closed();
        let cells = (rows - usize::from(!closed_u), cols - usize::from(!closed_v));
        let node = |row: usize, col: usize| self.nodes[row % rows * cols + col % cols];
        let normal = |row: usize, col: usize| {
            let along = node(row + 1, col + 1) - node(row, col);
            along.cross(node(row, col + 1) - node(row + 1, col))
        };
        let mut folded = 0;
        for row in 0..cells.0 {
            for col in 0..cells.1 {
                let here = normal(row, col);
                let mut look = |other: DVec3| folded += usize::from(here.dot(other) < 0.0);
                if closed_u || row + 1 < cells.0 {
                    look(normal((row + 1) % cells.0, col));
                }
                if closed_v || col + 1 < cells.1 {
                    look(normal(row, (col + 1) % cells.1));
                }
            }
        }
        Some(folded)
    }

    /// Asks something of the nearest node or two for each point, in parallel.
    pub(super) fn measure<T: Send + Clone + Default>(
        &self,
        points: &[DVec3],
        wanted: usize,
        observer: &mut dyn Observer,
        ask: impl Fn(&Candidates<'_>, DVec3) -> T + Sync,
    ) -> Result<Vec<T>> {
        crate::point_cloud::check_finite(points)?;
        let bounds = search::local_bounds(&self.frame, points);
        let tree = Candidates::new(&self.nodes, &bounds, points.len(), wanted);
        let mut answers = vec![T::default(); points.len()];
        let total = points.len();
        let mut report = |done: usize| {
            let step = done as u64;
            let now = Progress::of_stage(Stage::Measuring, step, total as u64, total);
            progress::report(observer, &now)
        };
        search::fill_from(&tree, &self.frame, points, &mut answers, &mut report, ask)?;
        Ok(answers)
    }
}
