//! How well a map fits points and keeps their order.

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::Walk;
use super::{SelfOrganizingMap, search};
use crate::cloud;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};

/// Nodes looked at between two reports: a few milliseconds.
const NODES_PER_REPORT: usize = 1 << 18;

/// Farthest that a coordinate may lie from the middle of the points that the map was made for:
/// beyond, squares of distances are no numbers any more.
const FARTHEST: f64 = 1e150;

impl SelfOrganizingMap {
    /// The number of each point's nearest node, the lowest among equals.
    ///
    /// O(n log m) on points that lie near the lattice.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// let winners = som.predict(&points, &mut Silent)?;
    /// assert!(winners.len() == 400 && winners.iter().all(|&node| node < 30));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`] for such a point; [`Error::Parameter`] if points lie more than 1e150 away
    /// from those that the map was made for; [`Error::Interrupted`] if the observer stops it.
    pub fn predict(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<usize>> {
        let mut winners = Vec::with_capacity(points.len());
        self.winners(points, observer, |piece| winners.extend_from_slice(piece))?;
        Ok(winners)
    }

    /// Hands on what [`Self::predict`] returns, piece by piece.
    pub(crate) fn winners(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
        take: impl FnMut(&[usize]),
    ) -> Result<()> {
        self.measure(points, 1, observer, |walk, point| walk.nearest(point).0, take)
    }

    /// Mean distance from a point to its nearest node, in the points' unit; NaN of no points.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// let nodes = som.codebook();
    /// let nearest = |p: &DVec3| nodes.iter().map(|n| n.distance(*p)).fold(f64::INFINITY, f64::min);
    /// let mean = points.iter().map(nearest).sum::<f64>() / 400.0;
    /// assert!((som.quantization_error(&points, &mut Silent)? - mean).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::predict`] has them.
    pub fn quantization_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let mut sum = 0.0;
        let distance = |walk: &mut Walk<'_>, point| walk.nearest(point).1.sqrt();
        self.measure(points, 1, observer, distance, |piece| sum += piece.iter().sum::<f64>())?;
        Ok(sum / points.len() as f64)
    }

    /// Share of the points whose two nearest nodes are no neighbours: they share neither an edge
    /// nor a cell of the lattice (Kiviluoto, Topology preservation in self-organizing maps, 1996).
    /// NaN of no points.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert!((0.0..=1.0).contains(&som.topographic_error(&points, &mut Silent)?));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::predict`] has them.
    pub fn topographic_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let torn = |walk: &mut Walk<'_>, point| {
            let [first, second] = walk.nearest_two(point);
            !self.lattice.adjacent(first, second)
        };
        let mut count = 0;
        let take = |piece: &[bool]| count += piece.iter().filter(|&&torn| torn).count();
        self.measure(points, 2, observer, torn, take)?;
        Ok(count as f64 / points.len() as f64)
    }

    /// How many points each node is the nearest of.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.hits(&points, &mut Silent)?.iter().sum::<u64>(), 400);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::predict`] has them.
    pub fn hits(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<u64>> {
        let mut hits = vec![0; self.nodes.len()];
        self.winners(points, observer, |piece| piece.iter().for_each(|&node| hits[node] += 1))?;
        Ok(hits)
    }

    /// Mean distance from each node to its neighbours on the lattice, in the points' unit: Ultsch's
    /// unified distance matrix. O(m).
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.u_matrix(&mut Silent)?.len(), 5 * 6);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn u_matrix(&self, observer: &mut dyn Observer) -> Result<Vec<f64>> {
        let mean = |node: usize| {
            let (mut sum, mut count) = (0.0, 0.0);
            self.lattice.visit_neighbors(node, |other| {
                sum += self.nodes[node].distance(self.nodes[other]);
                count += 1.0;
            });
            sum / count
        };
        self.by_nodes(observer, mean)
    }

    /// How many pairs of neighbouring cells of a grid are folded over: their normals are more than
    /// a right angle apart. `None` for a graph, which has no cells. O(m).
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.fold_overs(&mut Silent)?, Some(0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::u_matrix`] has them.
    pub fn fold_overs(&self, observer: &mut dyn Observer) -> Result<Option<usize>> {
        if !self.lattice.is_grid() {
            return Ok(None);
        }
        let (rows, cols) = self.lattice.shape();
        let (closed_u, closed_v) = self.lattice.topology().closed();
        let cells = (rows - usize::from(!closed_u), cols - usize::from(!closed_v));
        let at = |row: usize, col: usize| self.nodes[row % rows * cols + col % cols];
        let normal = |row: usize, col: usize| {
            let along = at(row + 1, col + 1) - at(row, col);
            along.cross(at(row, col + 1) - at(row + 1, col))
        };
        let folded = |node: usize| {
            let (row, col) = (node / cols, node % cols);
            if row >= cells.0 || col >= cells.1 {
                return 0;
            }
            let here = normal(row, col);
            let look = |other: DVec3| usize::from(here.dot(other) < 0.0);
            let below = closed_u || row + 1 < cells.0;
            let right = closed_v || col + 1 < cells.1;
            let mut folded = 0;
            if below {
                folded += look(normal((row + 1) % cells.0, col));
            }
            if right {
                folded += look(normal(row, (col + 1) % cells.1));
            }
            folded
        };
        Ok(Some(self.by_nodes(observer, folded)?.into_iter().sum()))
    }

    /// Asks something of each node, in parallel.
    fn by_nodes<T: Send>(
        &self,
        observer: &mut dyn Observer,
        ask: impl Fn(usize) -> T + Sync,
    ) -> Result<Vec<T>> {
        let total = self.nodes.len();
        let mut answers = Vec::with_capacity(total);
        for first in (0..total).step_by(NODES_PER_REPORT) {
            let now = Progress::of_stage(Stage::Measuring, first as u64, total as u64, 0);
            progress::report(observer, &now)?;
            let piece = first..total.min(first + NODES_PER_REPORT);
            answers.par_extend(piece.into_par_iter().map(&ask));
        }
        Ok(answers)
    }

    /// Asks something of the nearest node or two for each point, in parallel, and hands on the
    /// answers piece by piece, in order.
    pub(super) fn measure<T: Send + Clone + Default>(
        &self,
        points: &[DVec3],
        wanted: usize,
        observer: &mut dyn Observer,
        ask: impl Fn(&mut Walk<'_>, DVec3) -> T + Sync,
        take: impl FnMut(&[T]),
    ) -> Result<()> {
        let total = points.len();
        let mut report = |done: usize| {
            let progress = Progress::of_stage(Stage::Measuring, done as u64, total as u64, total);
            progress::report(observer, &progress)
        };
        let bounds = cloud::finite_bounds(points, &mut || report(0))?;
        let farthest = self.frame.farthest(&bounds);
        if farthest > FARTHEST && !points.is_empty() {
            let must = format!("at most {FARTHEST:e} from where the first points lay");
            return Err(Error::parameter(
                "points",
                must,
                format!("a coordinate {farthest:e} away"),
            ));
        }
        search::ask(&self.nodes, &self.frame, (points, &bounds), wanted, &mut report, ask, take)
    }
}
