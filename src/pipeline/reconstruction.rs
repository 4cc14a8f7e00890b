//! The result of a reconstruction.

use glam::DVec2;

use super::report::Report;
use crate::error::Result;
use crate::mesh::{TessellateOptions, TriangleMesh};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::som::{SelfOrganizingMap, SomOptions};

/// The result of [`reconstruct`](super::reconstruct), in the points' own frame and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The surface.
    pub surface: NurbsSurface,
    /// The trained map.
    pub som: SelfOrganizingMap,
    /// The options that the map was trained with, lengths in the points' unit.
    pub som_options: SomOptions,
    /// Parameters of each point's projection onto the surface.
    pub uv: Vec<DVec2>,
    /// Each point's distance from its projection, in the points' unit.
    pub deviations: Vec<f64>,
    /// True for points used in the fit and their duplicates. False for outliers, zero-weight points
    /// and points of other components.
    pub inliers: Vec<bool>,
    /// The report.
    pub report: Report,
}

impl Reconstruction {
    /// The surface as triangles, within the default tolerance of [`TessellateOptions`].
    ///
    /// # Errors
    ///
    /// Those of [`Tessellation::new`](crate::mesh::Tessellation::new);
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn tessellate(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        self.surface.tessellate(&TessellateOptions::default(), observer)
    }
}
