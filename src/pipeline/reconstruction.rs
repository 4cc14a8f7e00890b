//! The result of a reconstruction.

use glam::DVec2;

use super::report::Report;
use crate::brep::Shell;
use crate::error::Result;
use crate::mesh::{TessellateOptions, TriangleMesh};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::som::{SelfOrganizingMap, SomOptions};

/// The result of [`reconstruct`](super::reconstruct), in the points' own frame and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The whole surface, which the deviations are measured from.
    pub surface: NurbsSurface,
    /// The faces of the surface: they end where the points end, unless that says no more than the
    /// sides of the surface. Each region with points has one.
    pub shell: Shell,
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
    /// The faces as triangles, within the default tolerance of [`TessellateOptions`].
    ///
    /// # Errors
    ///
    /// Those of [`Shell::tessellate`].
    pub fn tessellate(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        Ok(self.shell.tessellate(&TessellateOptions::default(), observer)?.mesh)
    }
}
