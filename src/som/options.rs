//! Training options, and the plan derived from them.

use glam::DVec3;

use super::lattice::{Distances, Lattice};
use super::schedule::{GAIN_SCALE_SHARE, Schedule, paper_gain, scale_for};
use crate::error::{Error, Result, positive};

/// Default presentations per node in online training. Kohonen recommends at least 500 times the
/// number of nodes.
const STEPS_PER_NODE: u64 = 500;

/// Default epochs of batch training. Ten suffice from an ordered start; from the principal plane a
/// curved sheet needs about twice as many to unfold.
const EPOCHS: u64 = 20;

/// Default share of the steps after which the paper's radius is zero. By then the gain is small
/// enough that nodes settle on the points without losing their order. On 4,000 terrain points, 0.4
/// leaves 3 % of the cells folded, 0.7 at most one.
const ORDERING_SHARE: f64 = 0.7;

/// Default presentations of each point after which the paper's radius is zero, where there are no
/// more points than nodes. Until then all points are presented, so that a longer time leaves the
/// special presentation nothing to save: on 40 points it takes a fifth of the steps of the random
/// one with 20, and nine tenths with 40. With 10, several points are not reached.
const ORDERING_PRESENTATIONS: f64 = 20.0;

/// Default scale q of the gain for few points, as a multiple of t₀: the gain after t₀ is still
/// large enough to bring the nodes to the points.
const GAIN_SCALE_FACTOR: f64 = 2.0;

/// Initial radius of the Gaussian neighborhood, as a share of the lattice's longer side: wide
/// enough to order the whole lattice, narrow enough not to shrink it to a point.
const RADIUS_SHARE: f64 = 0.25;

/// Largest initial radius as a share of a closed side. A Gaussian of radius r shrinks a ring of n
/// nodes by `exp(-(2π r / n)² / 2)`: this share to 0.58 of its size, from which it recovers. A
/// wider radius collapses the ring to a line, which may open again inside out.
const CLOSED_SHARE: f64 = 1.0 / 6.0;

/// Final radius of the Gaussian neighborhood, in cells. Neighbors still influence each node, which
/// keeps the order where points are few.
const RADIUS_END: f64 = 0.7;

/// Default `reach`, as a share of the diagonal of the points' bounding box.
const REACH: f64 = 1e-3;

/// Default `min_change`, as a share of the lattice's mean spacing (bounding box diagonal over the
/// square root of the number of nodes). In one epoch a node moves by about five times the gain, in
/// cells: the limit is reached at a gain of about 1 %.
const MIN_CHANGE: f64 = 0.05;

/// Largest number of steps per node in an epoch of online training. An epoch is otherwise one
/// presentation of each point; for millions of points a part of them shows whether the nodes still
/// move.
const EPOCH_PER_NODE: u64 = 5;

/// The training algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Training {
    /// Kohonen's batch map. Each epoch finds the winners of all points, then moves every node to a
    /// mean of the points, weighted by their winners' distance on the lattice. There is no gain.
    #[default]
    Batch,
    /// One point at a time: steps 2 to 7 of the paper's section 4.
    Online,
}

/// Node positions before training.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Init {
    /// Ordered on the principal plane of the points. On a closed lattice, ordered by angles about
    /// the principal axes.
    #[default]
    Pca,
    /// Ordered by distances along the surface, which unrolls folded and rolled sheets.
    Geodesic,
    /// The better of [`Init::Geodesic`] and [`Init::Pca`]. Where layers touch, the graph has
    /// shortcuts and its distances mislead. The better start has fewer points whose two nearest
    /// nodes are not adjacent, and nodes nearer to the points.
    Auto,
    /// Small random values around the centroid of the points (section 4, step 1).
    Centroid,
    /// Small random values around the centroid of the densest cluster (section 4.2).
    DensestCluster,
    /// Small random values around the origin (section 4.2).
    Random,
    /// Given positions, one per node, row by row, in the points' unit.
    Given(Vec<DVec3>),
}

/// The weight of the winner's neighbors on the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Neighborhood {
    /// `exp(-(d / radius)² / 2)`, where d is the distance in cells: Euclidean on a quadrilateral
    /// grid, the number of edges on any other lattice.
    #[default]
    Gaussian,
    /// 1 up to `radius` edges away, 0 beyond: the paper's N(t).
    Bubble,
}

/// How a node's position follows from the weighted points around it, in batch training.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The weighted mean (Kohonen). At the border all points lie on one side, which shrinks the
    /// lattice.
    Mean,
    /// Local linear regression, which keeps the border in place. For Gaussian neighborhoods on
    /// quadrilateral grids.
    Linear,
}

/// The choice of the next point in online training (section 4.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Presentation {
    /// Random with replacement: the paper's original presentation.
    #[default]
    Random,
    /// Random, without points that the lattice has reached once the radius is zero: the paper's
    /// special presentation.
    SkipReached,
    /// Each point once per epoch, in random order.
    Shuffled,
}

macro_rules! names {
    ($kind:ident, $count:literal, $($variant:ident => $name:literal),+) => {
        impl $kind {
            /// All variants.
            pub const ALL: [Self; $count] = [$(Self::$variant),+];

            /// The name, as Python spells it.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    };
}

names!(Training, 2, Batch => "batch", Online => "online");
names!(Neighborhood, 2, Gaussian => "gaussian", Bubble => "bubble");
names!(Kernel, 2, Mean => "mean", Linear => "linear");
names!(Presentation, 3, Random => "random", SkipReached => "skip-reached", Shuffled => "shuffled");

impl Init {
    /// The variants without given positions.
    pub const NAMED: [Self; 6] =
        [Self::Pca, Self::Geodesic, Self::Auto, Self::Centroid, Self::DensestCluster, Self::Random];

    /// The name, as Python spells it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pca => "pca",
            Self::Geodesic => "geodesic",
            Self::Auto => "auto",
            Self::Centroid => "centroid",
            Self::DensestCluster => "densest-cluster",
            Self::Random => "random",
            Self::Given(_) => "given",
        }
    }
}

/// Training options. `None` selects the default that the field describes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SomOptions {
    /// The training algorithm.
    pub training: Training,
    /// Node positions before training.
    pub init: Init,
    /// The weight of the winner's neighbors.
    pub neighborhood: Neighborhood,
    /// For batch training. `None`: linear where possible, else the mean.
    pub kernel: Option<Kernel>,
    /// For online training.
    pub presentation: Presentation,
    /// For online training, from 0 to 1. `None`: the paper's Gaussian from 0.4, with a third of the
    /// steps as its scale q; for few points (see `radius`) twice the time at which the radius is
    /// zero.
    pub gain: Option<Schedule>,
    /// In cells of the lattice. `None` with a Gaussian neighborhood: exponential from a quarter of
    /// the longer side (at most a sixth of a closed side, at least 1) to 0.7. `None` with a bubble:
    /// the paper's Gaussian from half the number of points, at most the lattice's diameter, with
    /// the scale s at which the radius is zero after seven tenths of the steps; for few points, at
    /// most as many as nodes, after 20 presentations of each.
    pub radius: Option<Schedule>,
    /// Passes over the points. `None`: 20 for batch training; for online training `max_steps`
    /// decides.
    pub epochs: Option<u64>,
    /// Largest number of steps: epochs of batch training, presentations of online training. `None`:
    /// by `epochs`, else 500 per node for online training.
    pub max_steps: Option<u64>,
    /// Largest distance between a point on the lattice and its nearest node, in the points' unit.
    /// Training ends when all points are on the lattice. `None`: 0.001 of the diagonal of the
    /// points' bounding box.
    pub reach: Option<f64>,
    /// Training ends when no node has moved farther than this in an epoch, in the points' unit,
    /// once the radius is zero or constant. `None`: 0.05 of the lattice's mean spacing, the
    /// diagonal divided by the square root of the number of nodes; for few points, when no node
    /// moves at all, since the paper ends their training when all are on the lattice. An epoch of online training has
    /// one step per point, at most five per node.
    pub min_change: Option<f64>,
    /// Seed of the random numbers. The same seed gives the same bits.
    pub seed: u64,
}

impl SomOptions {
    /// The options of the paper's section 4: online training, random presentation, a start around
    /// the centroid, a bubble whose radius and gain fall as Gaussians.
    ///
    /// ```
    /// use neurbs::som::{Neighborhood, SomOptions};
    /// let options = SomOptions { seed: 3, ..SomOptions::paper() };
    /// assert_eq!(options.neighborhood, Neighborhood::Bubble);
    /// ```
    #[must_use]
    pub fn paper() -> Self {
        Self {
            training: Training::Online,
            init: Init::Centroid,
            neighborhood: Neighborhood::Bubble,
            ..Self::default()
        }
    }
}

/// [`SomOptions`] checked, with all defaults filled in and lengths in the points' unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    pub(super) training: Training,
    pub(super) neighborhood: Neighborhood,
    pub(super) kernel: Kernel,
    pub(super) presentation: Presentation,
    pub(super) gain: Schedule,
    pub(super) radius: Schedule,
    pub(super) max_steps: u64,
    /// Number of points of an epoch.
    pub(super) epoch_points: u64,
    /// Steps of an epoch of online training.
    pub(super) epoch_steps: u64,
    /// The paper's t₀.
    pub(super) ordered_at: u64,
    pub(super) reach: f64,
    pub(super) min_change: f64,
    pub(super) seed: u64,
}

impl Plan {
    /// The plan for `epoch_points` points per epoch, in a box with this diagonal.
    pub(super) fn new(
        epoch_points: u64,
        diagonal: f64,
        lattice: &Lattice,
        options: &SomOptions,
    ) -> Result<Self> {
        let SomOptions { training, neighborhood, presentation, seed, .. } = *options;
        let max_steps = max_steps(epoch_points, lattice, options)?;
        let spacing = diagonal / (lattice.len() as f64).sqrt();
        let (steps, farthest) = (max_steps as f64, lattice.diameter() as f64);
        // The paper starts at half the number of points. A radius beyond the lattice's diameter has
        // no effect, so steps with it would order nothing.
        let start = (epoch_points as f64 / 2.0).min(farthest);
        let radius =
            options.radius.clone().unwrap_or_else(|| default_radius(lattice, neighborhood));
        let few =
            radius == PAPER && training == Training::Online && epoch_points <= lattice.len() as u64;
        let ordering = if few { ORDERING_PRESENTATIONS * epoch_points as f64 } else { steps };
        let ordering = ordering.min(ORDERING_SHARE * steps);
        let radius = radius.or(start, |start| scale_for(start, 1.0, ordering));
        radius.check("radius", f64::INFINITY)?;
        let gain = options.gain.clone().unwrap_or(PAPER);
        let gain_scale = if few { GAIN_SCALE_FACTOR * ordering } else { GAIN_SCALE_SHARE * steps };
        let gain = gain.or(paper_gain(), |_| gain_scale);
        gain.check("gain", 1.0)?;
        let min_change = if few { f64::MIN_POSITIVE } else { MIN_CHANGE * spacing };
        Ok(Self {
            training,
            neighborhood,
            kernel: kernel(lattice, options)?,
            presentation,
            ordered_at: radius.falls_under(1.0, last_time(training, max_steps)),
            gain,
            radius,
            max_steps,
            epoch_points,
            epoch_steps: epoch_points.min(EPOCH_PER_NODE * lattice.len() as u64),
            reach: positive("reach", options.reach.unwrap_or(REACH * diagonal))?,
            min_change: positive("min_change", options.min_change.unwrap_or(min_change))?,
            seed,
        })
    }

    /// The radius at a step. Steps count from 0 in batch training, from 1 in online training.
    pub(super) fn radius_at(&self, step: u64) -> f64 {
        self.radius.at(step, last_time(self.training, self.max_steps))
    }

    /// Whether the order is final after `step` steps: the radius is zero or stays constant.
    pub(super) fn ordered_after(&self, step: u64) -> bool {
        step >= self.ordered_at
            || self.radius.constant_after(step, last_time(self.training, self.max_steps))
    }
}

/// The paper's Gaussian with start and scale to be derived.
const PAPER: Schedule = Schedule::Gaussian { start: None, scale: None };

/// The last step of a schedule: presentations are numbered from 1, epochs from 0.
fn last_time(training: Training, max_steps: u64) -> u64 {
    match training {
        Training::Batch => max_steps.saturating_sub(1),
        Training::Online => max_steps,
    }
}

fn max_steps(epoch_points: u64, lattice: &Lattice, options: &SomOptions) -> Result<u64> {
    let in_epochs = |epochs: u64| match options.training {
        Training::Batch => epochs,
        Training::Online => epochs.saturating_mul(epoch_points),
    };
    for (name, count) in [("epochs", options.epochs), ("max_steps", options.max_steps)] {
        if count == Some(0) {
            return Err(Error::parameter(name, "at least 1", 0));
        }
    }
    let by_default = match options.training {
        Training::Batch => EPOCHS,
        Training::Online => STEPS_PER_NODE * lattice.len() as u64,
    };
    let requested = options.epochs.map_or(options.max_steps.unwrap_or(by_default), in_epochs);
    Ok(requested.min(options.max_steps.unwrap_or(u64::MAX)))
}

fn default_radius(lattice: &Lattice, neighborhood: Neighborhood) -> Schedule {
    match neighborhood {
        Neighborhood::Bubble => PAPER,
        Neighborhood::Gaussian => {
            let (rows, cols) = lattice.shape();
            let side = if lattice.is_grid() { rows.max(cols) } else { lattice.diameter() + 1 };
            let (closed_u, closed_v) = lattice.topology().closed();
            let limit = |count: usize, closed| {
                if closed { count as f64 * CLOSED_SHARE } else { f64::INFINITY }
            };
            let max_start = limit(rows, closed_u).min(limit(cols, closed_v));
            let start = (RADIUS_SHARE * side as f64).min(max_start).max(1.0);
            Schedule::Exponential { start, end: RADIUS_END }
        }
    }
}

fn kernel(lattice: &Lattice, options: &SomOptions) -> Result<Kernel> {
    let can_be_linear = options.neighborhood == Neighborhood::Gaussian
        && matches!(lattice.distances(), Distances::Grid(_));
    match options.kernel {
        Some(Kernel::Linear) if !can_be_linear => {
            let must = "'mean' unless the neighborhood is Gaussian and the lattice quadrilateral";
            Err(Error::parameter("kernel", must, "'linear'"))
        }
        Some(kernel) => Ok(kernel),
        None => Ok(if can_be_linear { Kernel::Linear } else { Kernel::Mean }),
    }
}
