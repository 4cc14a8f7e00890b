//! The whole job: scattered points in, a surface out.

mod alternatives;
mod candidate;
mod corners;
mod counted;
mod feet;
mod fitted;
mod flattening;
mod flaws;
mod heights;
mod job;
mod measured;
mod options;
mod outline;
mod own_frame;
mod paper;
mod recovery;
mod region;
mod relay;
mod relief;
mod report;
mod robust;
mod round;
mod score;
mod select;
mod shape;
mod start;
mod strip;
mod telling;
mod torus;
mod tube;
mod units;
mod unwound;

use glam::{DVec2, DVec3};

use crate::cloud;
use crate::error::Result;
use crate::mesh::{TessellateOptions, TriangleMesh};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;
use crate::som::SelfOrganizingMap;

pub use self::options::{Aspect, Method, ReconstructOptions, Start};
pub use self::report::{Distances, PERCENTILES, Report, TrainingReport};
pub use self::score::{Score, ScoreSettings};
pub use self::select::{DropSettings, Model, Ranking, SelectSettings, rank};

/// What [`reconstruct`] returns; everything in the points' own frame and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The surface.
    pub surface: NurbsSurface,
    /// The trained map.
    pub som: SelfOrganizingMap,
    /// Where on the surface each point has its foot; of heights in another unit than x and y, where it
    /// lies straight above or below.
    pub uv: Vec<DVec2>,
    /// Each point's distance from there.
    pub distances: Vec<f64>,
    /// Which points count: neither gross outliers, nor shown to be outliers by the surface, nor of
    /// another piece or without weight.
    pub inliers: Vec<bool>,
    /// How it went.
    pub report: Report,
}

impl Reconstruction {
    /// The surface as triangles, none farther from it than a thousandth of the net's diagonal.
    ///
    /// # Errors
    ///
    /// Those of [`Tessellation::new`](crate::mesh::Tessellation::new); [`crate::Error::Interrupted`] if the observer stops it.
    pub fn tessellate(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        self.surface.tessellate(&TessellateOptions::default(), observer)
    }
}

/// Turns scattered points into a NURBS surface; [`Reconstruction::tessellate`] turns that into
/// triangles.
///
/// [`Method::Fit`] brings the points in order by a map that learns them from an ordered start,
/// takes their places on it as parameters, and fits the surface by least squares with fairness and
/// parameter correction. [`Method::Paper`] is the paper alone: a Kohonen network learns the points, and its lattice becomes the control net of a clamped
/// B-spline surface, a grid to interpolate, or a Bézier net. Points that are in order already need
/// no network: [`OrderedSurface::through`](crate::nurbs::OrderedSurface::through) is this last stage.
///
/// # Errors
///
/// Those of [`cloud::check`]; [`crate::Error::Parameter`] for an option out of its range;
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn reconstruct(
    points: &[DVec3],
    options: &ReconstructOptions<'_>,
    observer: &mut dyn Observer,
) -> Result<Reconstruction> {
    options.check(points.len())?;
    relay::in_pool(points.len(), observer, |observer| {
        let bounds = cloud::checked_bounds(points, observer)?;
        match options.method {
            Method::Fit => fitted::reconstruct(points, &bounds, options, observer),
            Method::Paper => paper::reconstruct(points, &bounds, options, observer),
        }
    })
}
