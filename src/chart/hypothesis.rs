//! A hypothesis: a kind of surface and the points' parameters on it.

use glam::{DVec2, DVec3};

use super::kind::Kind;

/// Parameters for the observed points, on a rectangle with up to two closed directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The chart that proposed it.
    pub chart: &'static str,
    /// The kind of surface.
    pub kind: Kind,
    /// Parameters of each point in [0, 1]².
    pub uv: Vec<DVec2>,
    /// Lengths of the surface along u and v, in the points' unit.
    pub lengths: [f64; 2],
    /// Axes of a height field: along u and v in its plane, and the direction of the heights.
    pub heights: Option<[DVec3; 3]>,
    /// Share of a height field's rectangle outside the points' convex hull, compared with evenly
    /// scattered points.
    pub unfilled: f64,
}

impl Hypothesis {
    /// A hypothesis without heights: a sheet, a tube or a torus.
    #[must_use]
    pub fn new(chart: &'static str, kind: Kind, uv: Vec<DVec2>, lengths: [f64; 2]) -> Self {
        Self { chart, kind, uv, lengths, heights: None, unfilled: 0.0 }
    }

    /// Whether u and v are closed.
    #[must_use]
    pub fn closed(&self) -> [bool; 2] {
        self.kind.closed().into()
    }
}
