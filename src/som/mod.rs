//! The Kohonen network: a lattice of nodes that learns scattered points.
//!
//! The output nodes form a [`Lattice`]; the three weights of a node are its place in space.
//! Training brings the nodes to the points and keeps them in order, because a point moves not only
//! the node nearest to it, its *winner*, but the winner's neighbours *on the lattice* too, less and
//! less of them. It is either the paper's, one point at a time ([`Training::Online`],
//! [`SomOptions::paper`]), or Kohonen's batch map ([`Training::Batch`]), which looks at all points
//! in each epoch and costs O(n log m + m (rows + cols)).
//!
//! ```
//! use neurbs::{DVec3, progress::Silent};
//! use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
//!
//! let points: Vec<DVec3> = (0..2000)
//!     .map(|i| {
//!         let (x, y) = (f64::from(i % 50) / 49.0, f64::from(i / 50) / 39.0);
//!         DVec3::new(x, y, 0.2 * (3.0 * x).sin() * y)
//!     })
//!     .collect();
//! let options = SomOptions::default();
//! let som = SelfOrganizingMap::fit(&points, Lattice::quad(12, 10)?, &options, &mut Silent)?;
//! assert!(som.quantization_error(&points, &mut Silent)? < 0.05);
//! let uv = som.parametrize(&points, 0.75, &mut Silent)?;
//! assert!(uv.iter().all(|uv| uv.min_element() > -0.1 && uv.max_element() < 1.1));
//! # Ok::<(), neurbs::Error>(())
//! ```
//!
//! A map is whole at every moment: [`SelfOrganizingMap::new`] has the nodes at their start,
//! [`SelfOrganizingMap::train`] goes on from where the map is, and what an interruption leaves can
//! be asked, saved ([`SelfOrganizingMap::to_bytes`]) and trained further with the same result as
//! without the interruption.

mod batch;
mod bell;
mod boxes;
mod bytes;
mod candidates;
mod distribution;
mod eigen;
mod field;
mod frame;
mod geodesic;
mod graph;
mod grid;
mod initialize;
mod landmark_map;
mod lattice;
mod online;
mod options;
mod ordered_start;
mod parametrize;
mod presentation;
mod quality;
mod random;
mod report;
mod schedule;
mod search;
mod smoothing;
mod state;
mod stop;
mod sums;
mod topology;
mod triangular;

use glam::DVec3;

use self::frame::Frame;
use self::online::OnlineState;
use self::options::Plan;
use self::random::Random;

pub use self::distribution::Sampler;
pub use self::geodesic::unroll;
pub use self::landmark_map::LandmarkMap;
pub use self::lattice::{Lattice, MAX_NODES};
pub use self::options::{Init, Kernel, Neighborhood, Presentation, SomOptions, Training};
pub use self::ordered_start::spread_out;
pub use self::schedule::Schedule;
pub use self::stop::StoppedBy;
pub use self::sums::BatchSums;
pub use self::topology::{Cells, Topology};
use crate::cloud::{self, Bounds};
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};

/// A lattice of nodes in space that learns points.
///
/// ```
/// use neurbs::{DVec3, progress::Silent};
/// use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions, StoppedBy};
/// let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5), DVec3::splat(0.5)];
/// let lattice = Lattice::for_points(points.len());
/// let som = SelfOrganizingMap::fit(&points, lattice, &SomOptions::paper(), &mut Silent)?;
/// assert_eq!((som.reached, som.stopped_by), (5, StoppedBy::Reached));
/// assert!(som.quantization_error(&points, &mut Silent)? < 1e-3);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SelfOrganizingMap {
    /// How the nodes are connected.
    pub lattice: Lattice,
    /// Steps made: presentations of online training, epochs of batch training.
    pub steps: u64,
    /// The paper's t₀: the step from which on the radius is less than one edge, so that of a bubble
    /// only the winner moves.
    pub ordered_at: u64,
    /// Which criterion ended the training.
    pub stopped_by: StoppedBy,
    /// How many points lay on the lattice when they were last presented or counted.
    pub reached: usize,
    /// Largest move of a node during the last finished epoch, in the points' unit; `None` if not
    /// even one was finished.
    pub change: Option<f64>,
    /// Mean distance from points to their winners during the last finished epoch, while the lattice
    /// moved or before it did, in the points' unit; `None` if not even one was finished.
    pub error: Option<f64>,
    /// Where the nodes are, in the frame.
    nodes: Vec<DVec3>,
    frame: Frame,
    plan: Plan,
    random: Random,
    online: Option<OnlineState>,
}

impl SelfOrganizingMap {
    /// A map with its nodes at the start that the options ask for.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let options = SomOptions::default();
    /// let mut som = SelfOrganizingMap::new(&points, Lattice::quad(5, 6)?, &options, &mut Silent)?;
    /// assert_eq!(som.steps, 0);
    /// som.train(&points, &mut Silent)?;
    /// assert!((1..=20).contains(&som.steps));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`cloud::check`]; [`Error::Parameter`] for an option out of its range or one
    /// that the lattice does not allow; [`Error::Interrupted`] if the observer stops it;
    /// [`Error::Memory`] if there is not enough of it.
    pub fn new(
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let bounds = cloud::checked_bounds(points, observer)?;
        Self::within(&bounds, points, points.len() as u64, lattice, options, observer)
    }

    /// A map for points within `bounds`, of which `sample` are known and `epoch_points` make an
    /// epoch.
    fn within(
        bounds: &Bounds,
        sample: &[DVec3],
        epoch_points: u64,
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        lattice.check_memory()?;
        let plan = Plan::new(epoch_points, bounds.diagonal(), &lattice, options)?;
        let frame = Frame::of(bounds);
        let mut random = Random::new(options.seed);
        let count = usize::try_from(epoch_points).unwrap_or(usize::MAX);
        let mut listen = || {
            let now = Progress::of_stage(Stage::Training, 0, plan.max_steps, count);
            progress::report(observer, &now)
        };
        let init = &options.init;
        let mut nodes =
            initialize::nodes(sample, bounds, &lattice, init, &mut random, &mut listen)?;
        for node in &mut nodes {
            *node = frame.apply(*node);
        }
        Ok(Self {
            lattice,
            steps: 0,
            ordered_at: plan.ordered_at,
            stopped_by: StoppedBy::Unfinished,
            reached: 0,
            change: None,
            error: None,
            nodes,
            frame,
            plan,
            random,
            online: None,
        })
    }

    /// Trains a lattice on scattered points: [`Self::new`], then [`Self::train`].
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// let options = SomOptions { epochs: Some(10), ..SomOptions::default() };
    /// let som = SelfOrganizingMap::fit(&points, Lattice::quad(5, 6)?, &options, &mut Silent)?;
    /// assert_eq!((som.steps, som.codebook().len()), (10, 30));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Self::new`]; [`Error::Interrupted`] if the observer stops it.
    pub fn fit(
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let bounds = cloud::checked_bounds(points, observer)?;
        Self::fit_within(&bounds, points, lattice, options, observer)
    }

    /// As [`Self::fit`], on points that are checked and lie within `bounds`.
    pub(crate) fn fit_within(
        bounds: &Bounds,
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let count = points.len() as u64;
        let mut map = Self::within(bounds, points, count, lattice, options, observer)?;
        map.train_within(bounds, points, observer)?;
        Ok(map)
    }

    /// Goes on until one of the criteria of step 7 ends the training, on the points that the map
    /// was made for. A training that has ended stays as it is.
    ///
    /// The same seed gives the same bits on any number of threads. A step of online training costs
    /// O(m), an epoch of batch training O(n log m + m (rows + cols)) on a grid.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let mut som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// // It has ended, and stays as it is.
    /// let before = som.clone();
    /// som.train(&points, &mut Silent)?;
    /// assert_eq!(som, before);
    /// assert!(som.train(&points[1..], &mut Silent).is_err());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it; the map keeps what it has learned, and may
    /// be trained on with the same result as without the interruption. [`Error::Parameter`] if
    /// these are not the points that the map was made for.
    pub fn train(&mut self, points: &[DVec3], observer: &mut dyn Observer) -> Result<()> {
        let bounds = cloud::finite_bounds(points, &mut || self.report(observer))?;
        let same =
            points.len() as u64 == self.plan.epoch_points && Frame::of(&bounds) == self.frame;
        if !same {
            let must = format!("the {} points that the map was made for", self.plan.epoch_points);
            return Err(Error::parameter("points", must, format!("{} others", points.len())));
        }
        self.train_within(&bounds, points, observer)
    }

    fn train_within(
        &mut self,
        bounds: &Bounds,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<()> {
        match self.plan.training {
            Training::Batch => batch::train(self, points, bounds, observer),
            Training::Online => online::train(self, points, bounds, observer),
        }
    }

    /// The nodes' positions, row by row, in the points' unit.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.codebook().len(), 5 * 6);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn codebook(&self) -> Vec<DVec3> {
        self.nodes.iter().map(|&node| self.frame.undo(node)).collect()
    }

    /// The radius of the neighbourhood at the next step, in cells.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// // By default it falls to 0.7.
    /// assert!((0.7..1.5).contains(&som.radius()));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.plan.radius_at(self.steps)
    }

    /// How nodes learn.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions, Training};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(som.training(), Training::Batch);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn training(&self) -> Training {
        self.plan.training
    }
}
