//! What a reconstruction returns.

use glam::DVec2;

use super::report::Report;
use crate::error::Result;
use crate::mesh::{TessellateOptions, TriangleMesh};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::som::SelfOrganizingMap;

/// What [`reconstruct`](super::reconstruct) returns; everything in the points' own frame and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The surface.
    pub surface: NurbsSurface,
    /// The trained map.
    pub som: SelfOrganizingMap,
    /// Parameters of each point's projection onto the surface.
    pub uv: Vec<DVec2>,
    /// Each point's distance from there.
    pub deviations: Vec<f64>,
    /// True for points used in the fit and their duplicates. False for outliers, points without
    /// weight and those of other components.
    pub inliers: Vec<bool>,
    /// How it went.
    pub report: Report,
}

impl Reconstruction {
    /// The surface as triangles, none farther from it than a thousandth of the net's diagonal.
    ///
    /// # Errors
    ///
    /// Those of [`Tessellation::new`](crate::mesh::Tessellation::new);
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn tessellate(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        self.surface.tessellate(&TessellateOptions::default(), observer)
    }
}
