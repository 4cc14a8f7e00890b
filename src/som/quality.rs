//! Quality measures of a map: distances to points, preserved neighborhoods, folds.

use glam::DVec3;
use rayon::prelude::*;

use super::map::SelfOrganizingMap;
use super::nearest_lists::Lookup;
use super::search;
use crate::cloud;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};
use crate::worker_pool;

/// Nodes processed between two reports, a few milliseconds.
const NODES_PER_REPORT: usize = 1 << 18;

/// Largest distance of a coordinate from the frame's center. Squared distances beyond it would
/// overflow.
const MAX_COORDINATE: f64 = 1e150;

impl SelfOrganizingMap {
    /// The index of each point's nearest node. Ties go to the lowest index.
    ///
    /// O(n log m) for points near the lattice.
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
    /// - [`Error::NotFinite`] for a point that is not finite.
    /// - [`Error::Parameter`] if points lie more than 1e150 from the center of the map's points.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn predict(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<usize>> {
        let mut winners = Vec::with_capacity(points.len());
        self.winners(points, observer, |piece| winners.extend_from_slice(piece))?;
        Ok(winners)
    }

    /// As [`Self::predict`], passing the results on in pieces.
    pub(crate) fn winners(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
        take: impl FnMut(&[usize]),
    ) -> Result<()> {
        self.measure(points, 1, observer, |lookup, point| lookup.nearest(point).0, take)
    }

    /// Mean distance from a point to its nearest node, in the points' unit; NaN if there are no
    /// points.
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
    /// As [`Self::predict`].
    pub fn quantization_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let mut sum = 0.0;
        let distance = |lookup: &mut Lookup<'_>, point| lookup.nearest(point).1.sqrt();
        self.measure(points, 1, observer, distance, |piece| sum += piece.iter().sum::<f64>())?;
        Ok(sum / points.len() as f64)
    }

    /// Share of the points whose two nearest nodes share neither an edge nor a cell of the lattice;
    /// NaN if there are no points. Kiviluoto, *Topology preservation in self-organizing maps*,
    /// 1996.
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
    /// As [`Self::predict`].
    pub fn topographic_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let torn = |lookup: &mut Lookup<'_>, point| {
            let [first, second] = lookup.nearest_two(point);
            !self.lattice.adjacent(first, second)
        };
        let mut count = 0;
        let take = |piece: &[bool]| count += piece.iter().filter(|&&torn| torn).count();
        self.measure(points, 2, observer, torn, take)?;
        Ok(count as f64 / points.len() as f64)
    }

    /// Number of points nearest to each node.
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
    /// As [`Self::predict`].
    pub fn hits(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<u64>> {
        let mut hits = vec![0; self.nodes.len()];
        self.winners(points, observer, |piece| piece.iter().for_each(|&node| hits[node] += 1))?;
        Ok(hits)
    }

    /// Mean distance from each node to its neighbors on the lattice, in the points' unit: Ultsch's
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

    /// Number of folded pairs of adjacent cells, whose normals are more than a right angle apart;
    /// `None` for a graph, which has no cells. O(m).
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
    /// As [`Self::u_matrix`].
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

    /// Computes a value for each node, in parallel.
    fn by_nodes<T: Send>(
        &self,
        observer: &mut dyn Observer,
        query: impl Fn(usize) -> T + Sync,
    ) -> Result<Vec<T>> {
        let total = self.nodes.len();
        let mut answers = Vec::with_capacity(total);
        for first in (0..total).step_by(NODES_PER_REPORT) {
            let now = Progress::of_stage(Stage::Measuring, first as u64, total as u64, 0);
            progress::report(observer, &now)?;
            let piece = first..total.min(first + NODES_PER_REPORT);
            worker_pool::install(|| answers.par_extend(piece.into_par_iter().map(&query)));
        }
        Ok(answers)
    }

    /// Computes a value for each point from a nearest-node search, in parallel. `take` receives the
    /// values in pieces, in order.
    pub(super) fn measure<T: Send + Clone + Default>(
        &self,
        points: &[DVec3],
        k_nearest: usize,
        observer: &mut dyn Observer,
        query: impl Fn(&mut Lookup<'_>, DVec3) -> T + Sync,
        take: impl FnMut(&[T]),
    ) -> Result<()> {
        let total = points.len();
        let mut report = |done: usize| {
            let progress = Progress::of_stage(Stage::Measuring, done as u64, total as u64, total);
            progress::report(observer, &progress)
        };
        let bounds = cloud::finite_bounds(points, &mut || report(0))?;
        let farthest = self.frame.farthest(&bounds);
        if farthest > MAX_COORDINATE && !points.is_empty() {
            let must = format!("at most {MAX_COORDINATE:e} from the center of the first points");
            return Err(Error::parameter(
                "points",
                must,
                format!("a coordinate {farthest:e} away"),
            ));
        }
        search::query(
            &self.nodes,
            &self.frame,
            (points, &bounds),
            k_nearest,
            &mut report,
            query,
            take,
        )
    }
}
