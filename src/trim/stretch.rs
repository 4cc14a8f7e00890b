//! Stretches: parts of a border, from one place on to another.

use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};

use super::arc_length::shares;
use super::border::Border;
use super::level::Closeness;
use super::spline_fit::{Form, SplineFit, Targets};
use crate::error::Result;

/// Some places of a border in their order.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    pub uv: Vec<DVec2>,
    pub tangents: Vec<[DVec3; 2]>,
    pub depth: Vec<f64>,
    /// Parameters in [0, 1], by the length along the places.
    pub at: Vec<f64>,
    /// The length in space.
    pub length: f64,
}

impl Stretch {
    /// The places in these ranges of indices, which may be a turn ahead.
    pub(super) fn of(border: &Border, ranges: &[RangeInclusive<usize>]) -> Self {
        let count = border.len();
        let places: Vec<usize> = ranges.iter().cloned().flatten().collect();
        let points: Vec<DVec3> = places.iter().map(|k| border.points[k % count]).collect();
        let steps = points.windows(2).map(|pair| pair[0].distance(pair[1]));
        Self {
            uv: places.iter().map(|k| border.uv_at(*k)).collect(),
            tangents: places.iter().map(|k| border.tangents[k % count]).collect(),
            depth: places.iter().map(|k| border.depth[k % count]).collect(),
            at: shares(steps.clone()),
            length: steps.sum(),
        }
    }

    pub(super) fn targets(&self) -> Targets<'_> {
        Targets { at: &self.at, uv: &self.uv, tangents: &self.tangents }
    }

    /// The curve with free ends and as few control points as cross-validation allows.
    pub(super) fn choose(&self, spacing: f64, closeness: Closeness) -> Result<Option<SplineFit>> {
        self.targets().choose(Form::Open([None; 2]), (spacing, self.length), closeness)
    }
}
