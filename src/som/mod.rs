//! The Kohonen network: a lattice of nodes that learns scattered points.
//!
//! The output nodes form a quadrilateral [`Lattice`]; the three weights of a node are its place
//! in space. Training ([`SelfOrganizingMap::fit`]) presents one point at a time; the nearest node
//! and its neighbours *on the lattice* move towards it, less and less of them and less and less
//! far ([`GaussianDecay`]), until the lattice lies on the points and is still in order.

mod bmu;
mod initialize;
mod lattice;
mod online;
mod presentation;
mod schedule;

use glam::DVec3;

pub use self::lattice::{Lattice, MAX_NODES};
pub use self::schedule::GaussianDecay;
use crate::error::{Error, Result, positive};
use crate::point_cloud::{self, Bounds};
use crate::progress::{self, Observer, Progress, Stage};

/// Presentations for each node in a training of the default length. Kohonen's rule of thumb is
/// that the number of steps should be at least 500 times the number of units.
const STEPS_PER_NODE: u64 = 500;

/// Share of the steps after which the radius is zero by default. By then the gain is small enough
/// that nodes settle on the points without leaving their order: with 0.4 and 4,000 points of
/// terrain, 3 % of the lattice's cells end folded over, with 0.7 none or one.
const ORDERING_SHARE: f64 = 0.7;

/// The gain's scale q as a share of the steps: the gain ends at `exp(-4.5)`, 1 % of its start.
const GAIN_SCALE_SHARE: f64 = 1.0 / 3.0;

/// Default `reach`, as a share of the diagonal of the points' bounding box.
const REACH: f64 = 1e-3;

/// Default `min_change`, as a share of the lattice's mean spacing (the diagonal of the points'
/// bounding box, divided by the square root of the number of nodes). A node moves by about five
/// times the gain of its cell during an epoch, so that this is reached when the gain is about 1 %.
const MIN_CHANGE: f64 = 0.05;

/// Steps of an epoch for each node, at most. An epoch is one presentation of each point; but of
/// millions of points a fraction shows just as well whether the lattice moves.
const EPOCH_PER_NODE: usize = 5;

/// How to train; the default is the paper's section 4 with everything it leaves open derived from
/// the points.
///
/// `None` means: derived, as the field says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SomOptions {
    /// Seed of the random start and of the presentation; the same seed gives the same bits.
    pub seed: u64,
    /// Scale q of the gain on the time axis, in steps; `None`: a third of `max_steps`.
    pub gain_scale: Option<f64>,
    /// Scale s of the radius on the time axis, in steps; `None`: such that the radius is zero
    /// after seven tenths of `max_steps`.
    pub radius_scale: Option<f64>,
    /// Steps after which training ends in any case; `None`: 500 for each node.
    pub max_steps: Option<u64>,
    /// A point is on the lattice when a node is at most this far, in the points' unit; `None`:
    /// 0.001 of the diagonal of the points' bounding box.
    pub reach: Option<f64>,
    /// Training ends when no node has moved farther than this during an epoch (as many steps as
    /// there are points, but at most five for each node) after the radius has become zero, in the
    /// points' unit; `None`: 0.05 of the lattice's mean spacing, which is the diagonal divided by
    /// the square root of the number of nodes.
    pub min_change: Option<f64>,
}

/// What ended a training (step 7 of the paper's section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoppedBy {
    /// All points are on the lattice: the paper's criterion for few points.
    Reached,
    /// The lattice no longer moves: the paper's criterion for many points.
    Settled,
    /// `max_steps` are over.
    MaxSteps,
}

impl StoppedBy {
    /// The criterion's name, as Python and reports spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Reached => "reached",
            Self::Settled => "settled",
            Self::MaxSteps => "max_steps",
        }
    }
}

/// A lattice of nodes in space, trained on points.
///
/// ```
/// use neurbs::{DVec3, progress::Silent, som::{Lattice, SelfOrganizingMap, SomOptions}};
/// let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5), DVec3::splat(0.5)];
/// let lattice = Lattice::for_points(points.len());
/// let som = SelfOrganizingMap::fit(&points, lattice, &SomOptions::default(), &mut Silent)?;
/// assert_eq!(som.reached, 5);
/// assert!(som.quantization_error(&points, &mut Silent)? < 1e-3);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SelfOrganizingMap {
    /// How the nodes are connected.
    pub lattice: Lattice,
    /// The nodes' positions, row by row, in the points' unit.
    pub codebook: Vec<DVec3>,
    /// Number of presentations made.
    pub steps: u64,
    /// The paper's t₀: the step from which on the radius is zero, so that only the winner moves.
    pub ordered_at: u64,
    /// Which criterion ended the training.
    pub stopped_by: StoppedBy,
    /// How many points lay on the lattice, when they were last presented or at the final check.
    pub reached: usize,
    /// Largest move of a node during the last finished epoch, in the points' unit; `None` if not
    /// even one was finished.
    pub change: Option<f64>,
}

impl SelfOrganizingMap {
    /// Trains a lattice on scattered points by the paper's algorithm (section 4, steps 1 to 7).
    ///
    /// Nodes start at random around the centroid of the points. Each step presents one point,
    /// chosen at random with replacement, and moves all nodes within the radius of the winner (in
    /// edges of the lattice) by the gain's share of their way to it. Radius and gain fall as
    /// Gaussians of time (section 4.1). One step costs O(nodes).
    ///
    /// # Errors
    ///
    /// Those of [`point_cloud::check`]; [`Error::Parameter`] for an option out of its range;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn fit(
        points: &[DVec3],
        lattice: Lattice,
        options: &SomOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        point_cloud::check(points)?;
        let plan = Plan::new(points, &lattice, options)?;
        online::train(points, lattice, &plan, observer)
    }

    /// The same map in another frame: nodes moved by `f`, a similarity that scales lengths by
    /// `scale`.
    pub(crate) fn mapped(mut self, scale: f64, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.codebook.iter_mut().for_each(|node| *node = f(*node));
        self.change = self.change.map(|change| change * scale);
        self
    }

    /// Mean distance from a point to its nearest node, in the points' unit.
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it. Of no points the mean is NaN.
    pub fn quantization_error(&self, points: &[DVec3], observer: &mut dyn Observer) -> Result<f64> {
        let now = Progress {
            stage: Stage::Measuring,
            step: 0,
            total: points.len() as u64,
            change: None,
            reached: 0,
            points: points.len(),
        };
        let mut sum = 0.0;
        let mut report = || progress::report(observer, &now);
        let nodes = bmu::Nodes::new(&self.codebook);
        nodes.visit_distances(points, &mut report, |_, squared| sum += squared.sqrt())?;
        let count = points.len() as f64;
        Ok(sum / count)
    }
}

/// [`SomOptions`] with everything decided and checked.
struct Plan {
    seed: u64,
    gain: GaussianDecay,
    radius: GaussianDecay,
    ordered_at: u64,
    max_steps: u64,
    reach: f64,
    min_change: f64,
    epoch: u64,
}

impl Plan {
    fn new(points: &[DVec3], lattice: &Lattice, options: &SomOptions) -> Result<Self> {
        let diagonal = Bounds::of(points).diagonal();
        let spacing = diagonal / (lattice.len() as f64).sqrt();
        let max_steps = options.max_steps.unwrap_or(STEPS_PER_NODE * lattice.len() as u64);
        if max_steps == 0 {
            return Err(Error::parameter("max_steps", "at least 1", max_steps));
        }
        let (steps, half_the_points) = (max_steps as f64, points.len() as f64 / 2.0);
        let farthest = lattice.diameter() as f64;
        // The paper starts at half the number of points. A radius beyond the lattice's diameter
        // reaches no further node, so that time spent above it would order nothing.
        let start = half_the_points.min(farthest);
        let radius_scale = options
            .radius_scale
            .unwrap_or_else(|| GaussianDecay::scale_for(start, 1.0, ORDERING_SHARE * steps));
        let radius = GaussianDecay { start, scale: positive("radius_scale", radius_scale)? };
        let gain_scale = options.gain_scale.unwrap_or(GAIN_SCALE_SHARE * steps);
        let gain = GaussianDecay::gain(positive("gain_scale", gain_scale)?);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a time is not negative; the cast saturates, and no training is as long"
        )]
        let ordered_at = radius.time_of(1.0).ceil() as u64;
        Ok(Self {
            seed: options.seed,
            gain,
            radius,
            ordered_at,
            max_steps,
            reach: positive("reach", options.reach.unwrap_or(REACH * diagonal))?,
            min_change: positive("min_change", options.min_change.unwrap_or(MIN_CHANGE * spacing))?,
            epoch: points.len().min(EPOCH_PER_NODE * lattice.len()) as u64,
        })
    }
}
