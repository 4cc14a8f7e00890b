//! The input of all charts: observations, axes, and the flat maps that several charts share.

use std::sync::OnceLock;

use glam::DMat3;

use super::kind::Kind;
use super::settings::IsomapSettings;
use crate::observe::Observations;
use crate::som::LandmarkMap;

const SETTINGS: IsomapSettings = IsomapSettings::STANDARD;

/// A cloud's observations, with flat maps that several charts share.
pub struct ChartInput<'a> {
    /// The observations.
    pub observations: &'a Observations<'a>,
    /// The given axes x, y and z, in the frame of the observations.
    pub given_axes: DMat3,
    /// The kind of the options; `None`: any.
    pub requested: Option<Kind>,
    maps: [OnceLock<Option<LandmarkMap>>; 2],
}

/// The graph along which distances are measured.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Graph {
    /// The links along the local planes.
    Surface,
    /// The shortest links only.
    Tight,
}

impl<'a> ChartInput<'a> {
    /// The input with these observations.
    #[must_use]
    pub fn new(
        observations: &'a Observations<'a>,
        given_axes: DMat3,
        requested: Option<Kind>,
    ) -> Self {
        Self { observations, given_axes, requested, maps: [const { OnceLock::new() }; 2] }
    }

    /// Distances along the surface, and the flat map that preserves them. `None` if the map is not
    /// two-dimensional.
    pub(super) fn landmark_map(&self, graph: Graph) -> Option<&LandmarkMap> {
        let (place, links) = match graph {
            Graph::Surface => (0, self.observations.graph()),
            Graph::Tight => (1, self.observations.tight_graph()),
        };
        self.maps[place]
            .get_or_init(|| LandmarkMap::of(links, self.observations.points(), SETTINGS.landmarks))
            .as_ref()
    }
}
