//! How to train.

use glam::DVec3;

use super::lattice::{Distances, Lattice};
use super::schedule::{GAIN_SCALE_SHARE, Schedule, paper_gain, scale_for};
use crate::error::{Error, Result, positive};

/// Presentations for each node in an online training of the default length. Kohonen's rule of
/// thumb is that the number of steps should be at least 500 times the number of units.
const STEPS_PER_NODE: u64 = 500;

/// Epochs of a batch training of the default length. From an ordered start ten are enough; from
/// the principal plane twice as many let a curved sheet unbend.
const EPOCHS: u64 = 20;

/// Share of the steps after which the paper's radius is zero by default. By then the gain is small
/// enough that nodes settle on the points without leaving their order: with 0.4 and 4,000 points
/// of terrain, 3 % of the lattice's cells end folded over, with 0.7 none or one.
const ORDERING_SHARE: f64 = 0.7;

/// Start of the Gaussian neighbourhood's default radius, as a share of the lattice's longer side:
/// wide enough to keep the whole in order, narrow enough not to shrink it to a point.
const RADIUS_SHARE: f64 = 0.25;

/// Most that it starts with as a share of a closed side. A Gaussian of radius r shrinks a ring of n
/// nodes by `exp(-(2π r / n)² / 2)`: this one to 0.58 of its size, from where it grows again; a
/// wider one to a line, which may grow back inside out.
const CLOSED_SHARE: f64 = 1.0 / 6.0;

/// End of the Gaussian neighbourhood's default radius, in cells. At 0.7 a node still listens to its
/// neighbours, which keeps the lattice even where points are few.
const RADIUS_END: f64 = 0.7;

/// Default `reach`, as a share of the diagonal of the points' bounding box.
const REACH: f64 = 1e-3;

/// Default `min_change`, as a share of the lattice's mean spacing (the diagonal of the points'
/// bounding box, divided by the square root of the number of nodes). A node moves by about five
/// times the gain of its cell during an epoch, so that this is reached when the gain is about 1 %.
const MIN_CHANGE: f64 = 0.05;

/// Steps of an epoch of online training for each node, at most. An epoch is one presentation of
/// each point; but of millions of points a fraction shows just as well whether the lattice moves.
const EPOCH_PER_NODE: u64 = 5;

/// How nodes learn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Training {
    /// Kohonen's batch map: each epoch looks at all points, then every node becomes the weighted
    /// mean of them, by their winners' distance on the lattice. There is no gain.
    #[default]
    Batch,
    /// One point at a time: the paper's section 4, steps 2 to 7.
    Online,
}

/// Where the nodes are before training.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Init {
    /// In order on the principal plane of the points; on a closed lattice in order by angles about
    /// the principal axes.
    #[default]
    Pca,
    /// In order by distances along the surface, so that folded and rolled sheets unroll.
    Geodesic,
    /// The better of [`Init::Geodesic`] and [`Init::Pca`]: distances along the surface mislead where
    /// layers touch, since their graph is short-circuited there. That start counts as better whose
    /// nodes tear fewer points' neighbourhoods and lie nearer to them.
    Auto,
    /// Small random values around the centroid of the points (section 4, step 1).
    Centroid,
    /// Small random values around the centroid of the densest cluster (section 4.2).
    DensestCluster,
    /// Small random values around the origin (section 4.2).
    Random,
    /// Given positions, one for each node, row by row, in the points' unit.
    Given(Vec<DVec3>),
}

/// The share of the winner's move that its neighbours on the lattice make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Neighborhood {
    /// `exp(-(d / radius)² / 2)`, where d is the distance in cells: the straight one on a
    /// quadrilateral grid, edges on any other lattice.
    #[default]
    Gaussian,
    /// 1 up to `radius` edges away, 0 beyond: the paper's N(t).
    Bubble,
}

/// What a node makes of the points around it on the lattice, in batch training.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Their weighted mean, as Kohonen has it. At the border all of them lie on one side, which
    /// draws the lattice inwards.
    Mean,
    /// The value of a straight line fitted to them (local linear regression): the border stays
    /// where the points end. For Gaussian neighbourhoods on quadrilateral grids.
    Linear,
}

/// Which points are presented in online training (section 4.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Presentation {
    /// Any, at random with replacement: the original presentation.
    #[default]
    Random,
    /// The special one: once the radius is zero, a point that the lattice has reached is presented
    /// no more.
    SkipReached,
    /// All, each epoch in another random order.
    Shuffled,
}

macro_rules! names {
    ($kind:ident, $count:literal, $($variant:ident => $name:literal),+) => {
        impl $kind {
            /// All of them.
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
    /// Those that need no positions.
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

/// How to train; `None` means: derived, as the field says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SomOptions {
    /// How nodes learn.
    pub training: Training,
    /// Where the nodes are before.
    pub init: Init,
    /// How neighbours follow the winner.
    pub neighborhood: Neighborhood,
    /// Of batch training; `None`: linear where it can be, else the mean.
    pub kernel: Option<Kernel>,
    /// Of online training.
    pub presentation: Presentation,
    /// Of online training, from 0 to 1; `None`: the paper's Gaussian from 0.4, its scale q a third
    /// of the steps.
    pub gain: Option<Schedule>,
    /// In cells of the lattice; `None`, Gaussian neighbourhood: exponential from a quarter of the
    /// longer side (at most a sixth of a closed one, at least 1) to 0.7; `None`, bubble: the paper's Gaussian from half the number
    /// of points, but no more than the lattice's diameter, its scale s such that the radius is zero
    /// after seven tenths of the steps.
    pub radius: Option<Schedule>,
    /// Passes over the points; `None`: 20 for batch, as `max_steps` says for online.
    pub epochs: Option<u64>,
    /// Steps after which training ends in any case: epochs of batch, presentations of online
    /// training; `None`: as `epochs` says, or else 500 for each node of online training.
    pub max_steps: Option<u64>,
    /// A point is on the lattice when a node is at most this far, in the points' unit. Training
    /// ends when all are. `None`: 0.001 of the diagonal of the points' bounding box.
    pub reach: Option<f64>,
    /// Training ends when no node has moved farther than this during an epoch (online: as many
    /// steps as there are points, but at most five for each node) after the radius has become zero
    /// or ceased to change, in the points' unit; `None`: 0.05 of the lattice's mean spacing, which
    /// is the diagonal divided by the square root of the number of nodes.
    pub min_change: Option<f64>,
    /// Seed of all that is random; the same seed gives the same bits.
    pub seed: u64,
}

impl SomOptions {
    /// The paper's section 4: online, a bubble whose radius and gain fall as Gaussians, random
    /// presentation, a start around the centroid.
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

/// [`SomOptions`] with everything decided and checked, lengths in the points' unit.
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
    /// Presentations between two looks at how online training goes.
    pub(super) epoch_steps: u64,
    /// The paper's t₀.
    pub(super) ordered_at: u64,
    pub(super) reach: f64,
    pub(super) min_change: f64,
    pub(super) seed: u64,
}

impl Plan {
    /// Decides for an epoch of `epoch_points` points in a box of this diagonal.
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
        // The paper starts at half the number of points. A radius beyond the lattice's diameter
        // reaches no further node, so that time spent above it would order nothing.
        let start = (epoch_points as f64 / 2.0).min(farthest);
        let radius =
            options.radius.clone().unwrap_or_else(|| default_radius(lattice, neighborhood));
        let radius = radius.or(start, |start| scale_for(start, 1.0, ORDERING_SHARE * steps));
        radius.check("radius", f64::INFINITY)?;
        let gain = options.gain.clone().unwrap_or(PAPER);
        let gain = gain.or(paper_gain(), |_| GAIN_SCALE_SHARE * steps);
        gain.check("gain", 1.0)?;
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
            min_change: positive("min_change", options.min_change.unwrap_or(MIN_CHANGE * spacing))?,
            seed,
        })
    }

    /// The radius at a step; steps of batch training count from 0, of online training from 1.
    pub(super) fn radius_at(&self, step: u64) -> f64 {
        self.radius.at(step, last_time(self.training, self.max_steps))
    }

    /// Whether order is no longer at stake after `step` steps: the radius is zero or will stay.
    pub(super) fn ordered_after(&self, step: u64) -> bool {
        step >= self.ordered_at
            || self.radius.rests_after(step, last_time(self.training, self.max_steps))
    }
}

/// A Gaussian with everything left to be derived.
const PAPER: Schedule = Schedule::Gaussian { start: None, scale: None };

/// The time at which schedules end: the paper's presentations count from 1, epochs from 0.
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
    let wished = options.epochs.map_or(options.max_steps.unwrap_or(by_default), in_epochs);
    Ok(wished.min(options.max_steps.unwrap_or(u64::MAX)))
}

fn default_radius(lattice: &Lattice, neighborhood: Neighborhood) -> Schedule {
    match neighborhood {
        Neighborhood::Bubble => PAPER,
        Neighborhood::Gaussian => {
            let (rows, cols) = lattice.shape();
            let side = if lattice.is_grid() { rows.max(cols) } else { lattice.diameter() + 1 };
            let (closed_u, closed_v) = lattice.topology().closed();
            let most = |count: usize, closed| {
                if closed { count as f64 * CLOSED_SHARE } else { f64::INFINITY }
            };
            let most = most(rows, closed_u).min(most(cols, closed_v));
            let start = (RADIUS_SHARE * side as f64).min(most).max(1.0);
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
