//! How to reconstruct.

use crate::error::{Error, Result, positive};
use crate::nurbs::{OrderedSurface, check_degree};
use crate::som::{Lattice, Topology};

/// How to reconstruct; the default derives everything from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReconstructOptions {
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
    /// Directions in which the surface closes. Of [`Method::Fit`].
    pub topology: Topology,
    /// Weight of the energy of bending against the points: 1 gives it as large a say as all of
    /// them. `None`: by cross-validation. Of [`Method::Fit`].
    pub fairness: Option<f64>,
    /// How far the surface goes on beyond the points at open borders, in their mean spacings.
    /// `None`: half of one. Of [`Method::Fit`].
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

impl Default for ReconstructOptions {
    fn default() -> Self {
        Self {
            tolerance: None,
            method: Method::Fit,
            surface: OrderedSurface::ControlNet,
            grid: None,
            degree: 3,
            topology: Topology::Sheet,
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

impl ReconstructOptions {
    /// Refuses what no method can work with, and what the method has no use for.
    pub(super) fn check(&self) -> Result<()> {
        check_degree(self.degree)?;
        self.check_use()?;
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

impl ReconstructOptions {
    /// Refuses options of another method, which would have no effect.
    fn check_use(&self) -> Result<()> {
        let standard = Self { method: self.method, ..Self::default() };
        let (other, useless) = match self.method {
            Method::Fit => (
                Method::Paper,
                [
                    ("surface", self.surface != standard.surface),
                    ("max_steps", self.max_steps.is_some()),
                    ("reach", self.reach.is_some()),
                    ("min_change", self.min_change.is_some()),
                ],
            ),
            Method::Paper => (
                Method::Fit,
                [
                    ("tolerance", self.tolerance.is_some()),
                    ("topology", self.topology != standard.topology),
                    ("fairness", self.fairness.is_some()),
                    ("border", self.border.is_some()),
                ],
            ),
        };
        match useless.into_iter().find(|(_, given)| *given) {
            Some((name, _)) => {
                let must = format!("left out unless method is '{}'", other.name());
                Err(Error::parameter(name, must, format!("method '{}'", self.method.name())))
            }
            None => Ok(()),
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
    /// As given.
    Fixed,
}

names!(Aspect, 2, Data => "data", Fixed => "fixed");
