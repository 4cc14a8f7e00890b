//! How to reconstruct.

use glam::DVec3;

use crate::error::{Error, Result, positive};
use crate::nurbs::{OrderedSurface, check_degree};
use crate::som::Lattice;
use crate::topology::Kind;

/// How to reconstruct; the default derives everything from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReconstructOptions<'a> {
    /// Distance from the surface within which points shall lie, in their unit: the net grows until
    /// they do. `None`: it grows until cross-validation says that it would follow noise. Of
    /// [`Method::Fit`].
    pub tolerance: Option<f64>,
    /// How the surface comes from the points.
    pub method: Method,
    /// What the lattice is to the surface. Of [`Method::Paper`].
    pub surface: OrderedSurface,
    /// Rows and columns of the control net. [`Method::Fit`] takes their product as a budget, and
    /// splits it as `aspect` says; `None`: as `tolerance` says. [`Method::Paper`] takes them as
    /// those of the lattice; `None`: see [`Lattice::for_points`](crate::som::Lattice::for_points),
    /// but no more of a Bézier surface than it can have.
    pub grid: Option<(usize, usize)>,
    /// Degree of the surface in both directions, lowered where the net has too few rows or
    /// columns for it.
    pub degree: usize,
    /// What kind of surface the points lie on; `None`: as [`detect`](crate::topology::detect) finds.
    /// Sheets that are heights over a rectangle, or over a strip that bends at corners and has straight
    /// sides, are fitted as such, as is a ground on which things stand, and what would fold over or run away as a sheet
    /// whatever its net; where tubes and tori would, they become round ones. Of [`Method::Fit`].
    pub topology: Option<Kind>,
    /// Where the nodes lie before the map learns. Of [`Method::Fit`].
    pub init: Start<'a>,
    /// What each point's squared distance counts; `None`: 1. Those with 0 are left out. Of
    /// [`Method::Fit`].
    pub weights: Option<&'a [f64]>,
    /// Whether duplicates are merged and gross outliers left out first, as
    /// [`clean`](crate::cloud::clean) finds them. Of [`Method::Fit`].
    pub clean: bool,
    /// Whether points that the fitted surface shows to be outliers lose their weight, by
    /// [`biweights`](crate::fit::biweights). Of [`Method::Fit`].
    pub robust: bool,
    /// Which of the [`pieces`](crate::cloud::pieces) of the cloud is fitted, 0 being the
    /// largest; `None`: all together. Of [`Method::Fit`].
    pub piece: Option<usize>,
    /// Whether the net's weights are optimized at last, see [`rational`](crate::fit::rational). Of
    /// [`Method::Fit`].
    pub rational: bool,
    /// Weight of the energy of bending against the points: 1 gives it as large a say as all of
    /// them. `None`: by cross-validation. Of [`Method::Fit`].
    pub fairness: Option<f64>,
    /// About how far the surface goes on beyond the points at open borders, in their mean spacings:
    /// less where the border is sure, more where it is in doubt. `None`: half of one. Of
    /// [`Method::Fit`].
    pub border: Option<f64>,
    /// Control points at most, when the net grows. Of [`Method::Fit`].
    pub max_control_points: usize,
    /// How a budget of control points is split between rows and columns. Of [`Method::Fit`].
    pub aspect: Aspect,
    /// Seed of everything random; the same seed gives the same bits.
    pub seed: u64,
    /// See [`SomOptions::max_steps`](crate::som::SomOptions::max_steps). Of [`Method::Paper`].
    pub max_steps: Option<u64>,
    /// See [`SomOptions::reach`](crate::som::SomOptions::reach); in the points' unit. Of
    /// [`Method::Paper`].
    pub reach: Option<f64>,
    /// See [`SomOptions::min_change`](crate::som::SomOptions::min_change); in the points' unit. Of
    /// [`Method::Paper`].
    pub min_change: Option<f64>,
}

/// Control points at most by default: what CAD systems still handle at ease.
const MAX_CONTROL_POINTS: usize = 40_000;

/// Most control points that may be asked for.
const MOST_CONTROL_POINTS: usize = 1 << 24;

impl Default for ReconstructOptions<'_> {
    fn default() -> Self {
        Self {
            tolerance: None,
            method: Method::Fit,
            surface: OrderedSurface::ControlNet,
            grid: None,
            degree: 3,
            topology: None,
            init: Start::Auto,
            weights: None,
            clean: true,
            robust: true,
            piece: None,
            rational: false,
            fairness: None,
            border: None,
            max_control_points: MAX_CONTROL_POINTS,
            aspect: Aspect::Data,
            seed: 0,
            max_steps: None,
            reach: None,
            min_change: None,
        }
    }
}

impl ReconstructOptions<'_> {
    /// Refuses what no method can work with, and what the method has no use for.
    pub(super) fn check(&self, points: usize) -> Result<()> {
        check_degree(self.degree)?;
        self.check_use()?;
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

impl ReconstructOptions<'_> {
    /// Refuses options of another method, which would have no effect.
    fn check_use(&self) -> Result<()> {
        let standard = Self { method: self.method, ..Self::default() };
        let (other, useless): (_, &[(&'static str, bool)]) = match self.method {
            Method::Fit => (
                Method::Paper,
                &[
                    ("surface", self.surface != standard.surface),
                    ("max_steps", self.max_steps.is_some()),
                    ("reach", self.reach.is_some()),
                    ("min_change", self.min_change.is_some()),
                ],
            ),
            Method::Paper => (
                Method::Fit,
                &[
                    ("tolerance", self.tolerance.is_some()),
                    ("topology", self.topology.is_some()),
                    ("init", self.init != standard.init),
                    ("weights", self.weights.is_some()),
                    ("piece", self.piece.is_some()),
                    ("rational", self.rational),
                    ("fairness", self.fairness.is_some()),
                    ("border", self.border.is_some()),
                ],
            ),
        };
        match useless.iter().find(|(_, given)| *given) {
            Some((name, _)) => {
                let must = format!("left out unless method is '{}'", other.name());
                Err(Error::parameter(name, must, format!("method '{}'", self.method.name())))
            }
            None => Ok(()),
        }
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
    /// In order along the surface, or in the principal plane where that is found to be better.
    Auto,
    /// In order by distances along the surface, however it is folded; angles around it where it
    /// closes.
    Geodesic,
    /// In the principal plane.
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

macro_rules! names {
    ($kind:ident, $count:literal, $($variant:ident => $name:literal),+) => {
        impl $kind {
            /// All of them.
            pub const ALL: [Self; $count] = [$(Self::$variant),+];

            /// The name, as Python and the command line spell it.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    };
}

/// How the surface comes from the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The trained map gives parameters; least squares with parameter correction give the surface.
    Fit,
    /// The paper's method: the surface of the trained lattice, by [`ReconstructOptions::surface`].
    Paper,
}

names!(Method, 2, Fit => "fit", Paper => "paper");

/// How a budget of control points is split between rows and columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// By the lengths of the surface in both directions.
    Data,
    /// As given. Points of a surface with this net give it back, as far as it is found and nothing else
    /// is asked for; see `docs/fitting.md`.
    Fixed,
}

names!(Aspect, 2, Data => "data", Fixed => "fixed");
