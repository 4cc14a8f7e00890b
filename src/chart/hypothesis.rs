//! A guess how points lie on a surface.

use glam::{DVec2, DVec3};

use super::kind::Kind;

/// Parameters for the points that were observed, on a rectangle with none, one or two closed
/// directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The chart that proposed it.
    pub chart: &'static str,
    /// What kind of surface it is.
    pub kind: Kind,
    /// Parameters of each point in [0, 1]².
    pub uv: Vec<DVec2>,
    /// Lengths of the surface along u and v, in the points' unit.
    pub lengths: [f64; 2],
    /// Of heights: the plane's axes along u and v, and the direction of the heights.
    pub heights: Option<[DVec3; 3]>,
    /// Share of the rectangle under heights, as compared with that of evenly scattered points, that
    /// the points' convex hull leaves empty.
    pub unfilled: f64,
}

impl Hypothesis {
    /// Of a sheet, a tube or a torus.
    #[must_use]
    pub fn new(chart: &'static str, kind: Kind, uv: Vec<DVec2>, lengths: [f64; 2]) -> Self {
        Self { chart, kind, uv, lengths, heights: None, unfilled: 0.0 }
    }

    /// Which directions close, u and v.
    #[must_use]
    pub fn closed(&self) -> [bool; 2] {
        self.kind.closed().into()
    }
}
