//! What charts are made from.

use std::sync::OnceLock;

use glam::DMat3;

use super::kind::Kind;
use crate::observe::Observations;
use crate::som::LandmarkMap;

/// Landmarks from which distances along the surface are found.
const LANDMARKS: usize = 40;

/// A cloud's observations, and what several charts need of it.
pub struct ChartInput<'a> {
    /// The observations.
    pub seen: &'a Observations<'a>,
    /// The axes x, y and z in which the points were given, in the frame of the observations.
    pub given: DMat3,
    /// The kind that was asked for.
    pub asked: Option<Kind>,
    maps: [OnceLock<Option<LandmarkMap>>; 2],
}

/// Which graph distances follow.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Graph {
    /// Links along the local planes.
    Surface,
    /// The shortest links alone.
    Tight,
}

impl<'a> ChartInput<'a> {
    /// Of these observations.
    #[must_use]
    pub fn new(seen: &'a Observations<'a>, given: DMat3, asked: Option<Kind>) -> Self {
        Self { seen, given, asked, maps: [const { OnceLock::new() }; 2] }
    }

    /// Distances along the surface, and the flat map that keeps them; `None` if the points have no
    /// two dimensions.
    pub(super) fn landmark_map(&self, graph: Graph) -> Option<&LandmarkMap> {
        let (place, links) = match graph {
            Graph::Surface => (0, self.seen.graph()),
            Graph::Tight => (1, self.seen.tight_graph()),
        };
        self.maps[place]
            .get_or_init(|| LandmarkMap::of(links, self.seen.points(), LANDMARKS))
            .as_ref()
    }
}
