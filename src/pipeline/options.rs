//! How to reconstruct.

use glam::DVec3;

use crate::chart::Kind;
use crate::error::{Error, Result, positive};
use crate::nurbs::check_degree;
use crate::som::Lattice;

/// How to reconstruct; the default derives everything from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReconstructOptions<'a> {
    /// Distance from the surface within which points shall lie, in their unit: the net grows until
    /// they do. `None`: it grows until cross-validation says that it would follow noise.
    pub tolerance: Option<f64>,
    /// Rows and columns of the control net. Their product is a budget, split as `aspect` says;
    /// `None`: as `tolerance` says.
    pub grid: Option<(usize, usize)>,
    /// Degree of the surface in both directions, lowered where the net has too few rows or
    /// columns for it.
    pub degree: usize,
    /// The kind of surface; `None`: the candidate with the best score decides. A height field that
    /// is asked for is z = f(x, y). [`Kind::Body`] is not supported yet.
    pub kind: Option<Kind>,
    /// Where the nodes lie before the map learns.
    pub init: Start<'a>,
    /// What each point's squared distance counts; `None`: 1. Those with 0 are left out.
    pub weights: Option<&'a [f64]>,
    /// Whether duplicates are merged and gross outliers left out first, as
    /// [`clean`](crate::cloud::clean) finds them.
    pub clean: bool,
    /// Whether points that the fitted surface shows to be outliers lose their weight, by
    /// [`biweights`](crate::fit::biweights).
    pub robust: bool,
    /// Which component of the cloud is fitted, 0 being the largest; `None`: all together.
    pub component: Option<usize>,
    /// What each coordinate is divided by for the fit, where axes have different units. `None`: 1,
    /// unless the extents show mixed units. The result is in the points' units.
    pub axis_scale: Option<DVec3>,
    /// Whether the net's weights are optimized at last, see [`rational`](crate::fit::rational).
    pub rational: bool,
    /// Weight of the energy of bending against the points: 1 gives it as large a say as all of
    /// them. `None`: by cross-validation.
    pub fairness: Option<f64>,
    /// About how far the surface goes on beyond the points at open borders, in their mean spacings:
    /// less where the border is sure, more where it is in doubt. `None`: half of one.
    pub border: Option<f64>,
    /// Control points at most, when the net grows.
    pub max_control_points: usize,
    /// How a budget of control points is split between rows and columns.
    pub aspect: Aspect,
    /// Seed of everything random; the same seed gives the same bits.
    pub seed: u64,
}

/// Control points at most by default: what CAD systems still handle at ease.
const MAX_CONTROL_POINTS: usize = 40_000;

/// Most control points that may be asked for.
const MOST_CONTROL_POINTS: usize = 1 << 24;

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
            max_control_points: MAX_CONTROL_POINTS,
            aspect: Aspect::Data,
            seed: 0,
        }
    }
}

impl ReconstructOptions<'_> {
    /// Refuses what no fit can work with.
    pub(super) fn check(&self, points: usize) -> Result<()> {
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
        for (name, value) in [("fairness", self.fairness), ("border", self.border)] {
            if let Some(value) = value.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                return Err(Error::parameter(name, "finite and at least 0", value));
            }
        }
        if let Some((rows, cols)) = self.grid {
            // The limits of a net are those of a lattice.
            Lattice::quad(rows, cols)?;
        }
        if !(4..=MOST_CONTROL_POINTS).contains(&self.max_control_points) {
            let must = format!("from 4 to {MOST_CONTROL_POINTS}");
            return Err(Error::parameter("max_control_points", must, self.max_control_points));
        }
        Ok(())
    }
}

fn check_weights(weights: &[f64], points: usize) -> Result<()> {
    if weights.len() != points {
        let must = format!("as many as the points, {points}");
        return Err(Error::parameter("weights", must, weights.len()));
    }
    if let Some(i) = weights.iter().position(|weight| !(*weight >= 0.0 && weight.is_finite())) {
        let got = format!("{} at index {i}", weights[i]);
        return Err(Error::parameter("weights", "finite and at least 0", got));
    }
    Ok(())
}

/// Where the nodes of a map lie before it learns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start<'a> {
    /// On the candidate with the best score.
    Auto,
    /// On the best candidate by distances along the surface, if there is one.
    Geodesic,
    /// On the best candidate over a plane, if there is one.
    Pca,
    /// Here, row by row.
    Given {
        /// The nodes.
        nodes: &'a [DVec3],
        /// Rows and columns.
        shape: (usize, usize),
    },
}

impl Start<'_> {
    /// Those with a name.
    pub const NAMED: [Self; 3] = [Self::Auto, Self::Geodesic, Self::Pca];

    /// Whether a map may start on a candidate of a chart of this name.
    pub(super) fn allows(self, chart: &str) -> bool {
        match self {
            Self::Auto | Self::Given { .. } => true,
            Self::Geodesic => ["isomap", "polar", "centre line"].contains(&chart),
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

/// How a budget of control points is split between rows and columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// By the lengths of the surface in both directions.
    Data,
    /// As given.
    Fixed,
}

impl Aspect {
    /// All of them.
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
