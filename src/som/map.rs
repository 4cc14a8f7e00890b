//! The self-organizing map: lattice, node positions and state of the training.

use glam::DVec3;

use super::frame::Frame;
use super::initialize;
use super::lattice::Lattice;
use super::online_state::OnlineState;
use super::options::{Plan, SomOptions, Training};
use super::random::Random;
use super::sampling::{START_POINTS, start_indices};
use super::stop_criterion::StoppedBy;
use crate::cloud::{self, Bounds};
use crate::error::Result;
use crate::progress::{self, Observer, Progress, Stage};

/// A lattice of nodes in space that is trained on points.
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
    /// The nodes' connections.
    pub lattice: Lattice,
    /// Steps done: presentations of online training, epochs of batch training.
    pub steps: u64,
    /// The paper's t₀: the first step at which the radius is below one edge, so that with a bubble
    /// neighborhood only the winner moves.
    pub ordered_at: u64,
    /// The criterion that ended the training.
    pub stopped_by: StoppedBy,
    /// Number of points on the lattice, within `reach` of a node, at their last presentation or
    /// check.
    pub reached: usize,
    /// Largest move of a node in the last finished epoch, in the points' unit; `None` before the
    /// first epoch has finished.
    pub change: Option<f64>,
    /// Mean distance from points to their nearest nodes in the last finished epoch, before or while
    /// the nodes moved, in the points' unit; `None` before the first epoch has finished.
    pub error: Option<f64>,
    /// Node positions, in the frame.
    pub(super) nodes: Vec<DVec3>,
    pub(super) frame: Frame,
    pub(super) plan: Plan,
    pub(super) random: Random,
    pub(super) online: Option<OnlineState>,
}

impl SelfOrganizingMap {
    /// An untrained map with the initial node positions of `options`.
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
    /// - Those of [`cloud::check`].
    /// - [`Error::Parameter`](crate::Error::Parameter) for an option out of range or not allowed
    ///   for this lattice.
    /// - [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    /// - [`Error::Memory`](crate::Error::Memory) if there is too little memory.
    pub fn new(
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let bounds = cloud::checked_bounds(points, observer)?;
        Self::over(&bounds, points, lattice, options, observer)
    }

    /// An untrained map for checked points within `bounds`. Of many points, a sample determines the
    /// initial positions.
    pub(super) fn over(
        bounds: &Bounds,
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let count = points.len() as u64;
        if points.len() <= START_POINTS {
            return Self::within(bounds, points, count, lattice, options, observer);
        }
        let chosen = start_indices(count).into_iter().filter_map(|i| usize::try_from(i).ok());
        let sample: Vec<DVec3> = chosen.map(|index| points[index]).collect();
        Self::within(bounds, &sample, count, lattice, options, observer)
    }

    /// An untrained map for points within `bounds`. The initial positions are computed from
    /// `sample`; `epoch_points` is the number of points per epoch.
    pub(super) fn within(
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
        let mut check_interrupt = || {
            let now = Progress::of_stage(Stage::Training, 0, plan.max_steps, count);
            progress::report(observer, &now)
        };
        let init = &options.init;
        let mut nodes =
            initialize::nodes(sample, bounds, &lattice, init, &mut random, &mut check_interrupt)?;
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

    /// The node positions, row by row, in the points' unit.
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

    /// The radius of the neighborhood at the next step, in cells.
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

    /// The training algorithm.
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

    /// Whether step 7's criterion for many points holds after this epoch: no node moved farther
    /// than `min_change`.
    pub(super) fn settled(&self) -> bool {
        let rests = |change| change <= self.plan.min_change;
        self.plan.ordered_after(self.steps) && self.change.is_some_and(rests)
    }

    /// Ends the training if all steps are done: step 7's criterion for any number of points.
    pub(super) fn stop_at_last_step(&mut self) {
        if self.stopped_by == StoppedBy::Unfinished && self.steps >= self.plan.max_steps {
            self.stopped_by = StoppedBy::MaxSteps;
        }
    }
}
