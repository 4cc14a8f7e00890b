//! Options of a reconstruction, and their checks.

use glam::DVec3;

use crate::chart::Kind;
use crate::error::{Error, Result, positive};
use crate::fit::{check_fairness, check_weights};
use crate::numeric::Short;
use crate::nurbs::check_degree;
use crate::som::Lattice;

/// Options of [`reconstruct`](super::reconstruct). The default derives everything from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReconstructOptions<'a> {
    /// Largest distance of the points from the surface, in their unit. The net grows until it
    /// holds. `None`: the net grows until cross-validation finds that a finer one would follow
    /// noise.
    pub tolerance: Option<f64>,
    /// Rows and columns of the control net. Their product is a budget that is split by `aspect`.
    /// `None`: the net grows as `tolerance` describes.
    pub grid: Option<(usize, usize)>,
    /// Degree of the surface in both directions, lowered where the net has too few rows or
    /// columns for it.
    pub degree: usize,
    /// The kind of surface; `None`: that of the best candidate. [`Kind::Height`] means z = f(x, y).
    /// [`Kind::Body`] is not supported yet.
    pub kind: Option<Kind>,
    /// The map's nodes before training.
    pub init: Start<'a>,
    /// Weight of each point's squared distance; `None`: 1. Points with weight 0 are left out.
    pub weights: Option<&'a [f64]>,
    /// Whether [`clean`](crate::cloud::clean) merges duplicates and leaves out gross outliers
    /// first.
    pub clean: bool,
    /// Whether outliers of the fitted surface lose their weight, by
    /// [`biweights`](crate::fit::biweights).
    pub robust: bool,
    /// The component of the cloud that is fitted, 0 being the largest; `None`: all together.
    pub component: Option<usize>,
    /// Divisor of each coordinate for the fit, for axes in different units. `None`: 1, unless the
    /// extents show mixed units. The result is in the points' units.
    pub axis_scale: Option<DVec3>,
    /// Whether the weights of the control points are fitted last, by
    /// [`fit_weights`](crate::fit::fit_weights).
    pub rational: bool,
    /// Weight of the fairness energy against the points: with 1 it weighs as much as all of them.
    /// The energy sums squared third derivatives, or second ones where points are few. `None`: by
    /// cross-validation.
    pub fairness: Option<f64>,
    /// Distance to which the whole surface extends beyond the points at open sides, in mean
    /// spacings. `None`: the default.
    pub border: Option<f64>,
    /// Whether faces end where the points end.
    pub trim: Trimming,
    /// Largest number of control points to which the net grows.
    pub max_control_points: usize,
    /// How the budget of control points is split between rows and columns.
    pub aspect: Aspect,
    /// Seed of the random numbers; the same seed gives the same bits.
    pub seed: u64,
}

/// Default of [`ReconstructOptions::max_control_points`]: CAD systems handle nets of this size.
const DEFAULT_MAX_CONTROL_POINTS: usize = 40_000;

/// Range of [`ReconstructOptions::max_control_points`]: a bilinear patch, and the largest lattice.
const CONTROL_POINT_RANGE: (usize, usize) = (4, 1 << 24);

impl Default for ReconstructOptions<'_> {
    fn default() -> Self {
        Self {
            tolerance: None,
            grid: None,
            degree: 3,
            kind: None,
            init: Start::Auto,
            weights: None,
            clean: true,
            robust: true,
            component: None,
            axis_scale: None,
            rational: false,
            fairness: None,
            border: None,
            trim: Trimming::Auto,
            max_control_points: DEFAULT_MAX_CONTROL_POINTS,
            aspect: Aspect::Data,
            seed: 0,
        }
    }
}

impl ReconstructOptions<'_> {
    /// Checks that each option is in its range.
    pub(crate) fn check(&self, points: usize) -> Result<()> {
        check_degree(self.degree)?;
        if self.kind == Some(Kind::Body) {
            let must = "'height', 'sheet', 'tube' or 'torus' (bodies are not supported yet)";
            return Err(Error::parameter("kind", must, "'body'"));
        }
        if let Some(scale) =
            self.axis_scale.filter(|by| !(by.is_finite() && by.min_element() > 0.0))
        {
            return Err(Error::parameter("axis_scale", "positive and finite", scale));
        }
        if let Some(weights) = self.weights {
            check_weights(weights, points)?;
        }
        if let Start::Given { nodes, shape } = self.init
            && nodes.len() != shape.0.saturating_mul(shape.1)
        {
            let must = format!("of {} × {} nodes", shape.0, shape.1);
            return Err(Error::parameter("init", must, nodes.len()));
        }
        if let Some(tolerance) = self.tolerance {
            positive("tolerance", tolerance)?;
        }
        self.fairness.map_or(Ok(()), check_fairness)?;
        if let Some(border) = self.border.filter(|border| !(*border >= 0.0 && border.is_finite())) {
            return Err(Error::parameter("border", "finite and at least 0", Short(border)));
        }
        if let Some((rows, cols)) = self.grid {
            // The limits of a net are those of a lattice.
            Lattice::quad(rows, cols)?;
        }
        let (least, most) = CONTROL_POINT_RANGE;
        if !(least..=most).contains(&self.max_control_points) {
            let must = format!("from {least} to {most}");
            return Err(Error::parameter("max_control_points", must, self.max_control_points));
        }
        Ok(())
    }
}

/// The nodes of a map before training.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start<'a> {
    /// On the candidate with the best score.
    Auto,
    /// On the best candidate by distances along the surface, if there is one.
    Geodesic,
    /// On the best candidate over a plane, if there is one.
    Pca,
    /// At given places, row by row.
    Given {
        /// The nodes.
        nodes: &'a [DVec3],
        /// Rows and columns.
        shape: (usize, usize),
    },
}

impl Start<'_> {
    /// The starts that have a name.
    pub const NAMED: [Self; 3] = [Self::Auto, Self::Geodesic, Self::Pca];

    /// Whether a map may start on a candidate of the chart with this name.
    pub(super) fn allows(self, chart: &str) -> bool {
        match self {
            Self::Auto | Self::Given { .. } => true,
            Self::Geodesic => ["isomap", "polar", "center line"].contains(&chart),
            Self::Pca => chart == "plane",
        }
    }

    /// The name, as Python and the command line spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Geodesic => "geodesic",
            Self::Pca => "pca",
            Self::Given { .. } => "given",
        }
    }
}

/// Whether faces end where the points end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trimming {
    /// Where loops are certain, and say more than the sides of the surface.
    Auto,
    /// Wherever loops are found.
    Yes,
    /// As `Yes`, but holes are covered.
    Outer,
    /// Nowhere: the face is the whole surface.
    No,
}

impl Trimming {
    /// All choices.
    pub const ALL: [Self; 4] = [Self::Auto, Self::Yes, Self::Outer, Self::No];

    /// The name, as the command line spells it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Yes => "yes",
            Self::Outer => "outer",
            Self::No => "no",
        }
    }
}

/// How a budget of control points is split between rows and columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// By the lengths of the surface along u and v.
    Data,
    /// Rows and columns as given.
    Fixed,
}

impl Aspect {
    /// All ways.
    pub const ALL: [Self; 2] = [Self::Data, Self::Fixed];

    /// The name, as Python and the command line spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Data => "data",
            Self::Fixed => "fixed",
        }
    }
}
