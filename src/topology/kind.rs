//! The kind of a surface, and why points lie on such a one.

use glam::DVec3;

use super::height_field::HeightField;
use super::start::Chart;
pub(crate) use crate::chart::Kind;

/// What a user should know of a ground that things stand on.
const STANDING: &str = "things stand on the ground, as trees do, and the surface rises to the middle of them; for \
    the ground alone, give only points that lie on it";

/// What [`detect`](super::detect) found.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// The kind of surface that fits the points.
    pub kind: Kind,
    /// Why.
    pub reason: String,
    /// What a user should know: points on a closed body, which a sheet does not cover.
    pub warning: Option<String>,
    /// Of [`Kind::Height`].
    pub height: Option<HeightField>,
    /// Of [`Kind::Tube`] and [`Kind::Torus`].
    pub chart: Option<Chart>,
}

impl Topology {
    pub(super) fn new(kind: Kind, reason: impl Into<String>) -> Self {
        Self { kind, reason: reason.into(), warning: None, height: None, chart: None }
    }

    /// A tube on which points have these places, around an axis.
    pub(super) fn around_axis(chart: Chart) -> Self {
        let (long, high) = chart.lengths;
        let reason = format!("it goes around an axis, {long:.4} long, and is {high:.4} high");
        Self { chart: Some(chart), ..Self::new(Kind::Tube, reason) }
    }

    /// That of heights.
    pub(crate) fn of_heights(height: HeightField) -> Self {
        let DVec3 { x, y, z } = height.up;
        let slope = height.slope.ceil();
        let reason = if height.ground {
            format!(
                "most of it is a ground over x and y whose slopes stay under {slope:.0} degrees, and things \
                 stand on it that are rough and high, as trees are"
            )
        } else {
            format!(
                "no part of it lies above another along ({x:.2}, {y:.2}, {z:.2}), and slopes stay under \
                 {slope:.0} degrees"
            )
        };
        let warning = height.ground.then(|| STANDING.to_string());
        Self { height: Some(height), warning, ..Self::new(Kind::Height, reason) }
    }
}
