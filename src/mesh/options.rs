//! What a tessellation is asked for.

use crate::error::{Error, Result, positive};
use crate::nurbs::NurbsSurface;

/// Most triangles that a mesh may have by default: 100 million, some 6 GB.
pub const MAX_TRIANGLES: usize = 100_000_000;

/// Share of the diagonal that the tolerance is by default.
const DEFAULT_TOLERANCE: f64 = 1e-3;

/// Smallest limit of the aspect ratio: half a cell split into two has one of 2.2.
const LEAST_ASPECT: f64 = 4.0;

/// How fine an adaptive tessellation is.
///
/// ```
/// use neurbs::{DVec3, mesh::TessellateOptions, nurbs::NurbsSurface, progress::Silent};
/// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
/// let options = TessellateOptions { tolerance: Some(0.01), ..TessellateOptions::default() };
/// let mesh = sphere.tessellate(&options, &mut Silent)?;
/// assert!(mesh.max_deviation.is_some_and(|bound| bound <= 0.01));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellateOptions {
    /// The largest distance between the surface and its triangles, in the points' unit, or as a
    /// share of the diagonal of the control net's box if `relative`; `None`: 1e-3 of the diagonal.
    pub tolerance: Option<f64>,
    /// Whether `tolerance` is a share of the diagonal.
    pub relative: bool,
    /// Largest angle between the surface's normals at the ends of an edge, in radians.
    pub max_angle: Option<f64>,
    /// Largest length of an edge, in the points' unit.
    pub max_edge: Option<f64>,
    /// Largest ratio of the longer to the shorter side of a piece of the surface that becomes two
    /// triangles, at least 4. Where parameters run into a pole, triangles may stay narrower.
    pub max_aspect: Option<f64>,
    /// Whether closed directions are split at the seam, where vertices then stand twice.
    pub split_seams: bool,
    /// Most triangles that the mesh may have.
    pub max_triangles: usize,
}

impl Default for TessellateOptions {
    fn default() -> Self {
        Self {
            tolerance: None,
            relative: false,
            max_angle: None,
            max_edge: None,
            max_aspect: None,
            split_seams: false,
            max_triangles: MAX_TRIANGLES,
        }
    }
}

/// Limits in the points' unit, checked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub tolerance: f64,
    /// Cosine of the largest angle.
    pub cosine: Option<f64>,
    pub edge: Option<f64>,
    pub aspect: Option<f64>,
}

impl Limits {
    /// Whether nothing is limited but the distance.
    pub(super) fn only_distance(&self) -> bool {
        self.cosine.is_none() && self.edge.is_none() && self.aspect.is_none()
    }
}

impl TessellateOptions {
    /// The same limits for several surfaces at once: with the tolerance in the points' unit, where
    /// it is a share of the diagonal of the box around all control nets.
    ///
    /// ```
    /// use neurbs::{DVec3, mesh::TessellateOptions, nurbs::NurbsSurface};
    /// let spheres = [1.0, 10.0].map(|r| NurbsSurface::sphere(DVec3::ZERO, r).unwrap());
    /// let options = TessellateOptions::default().of_surfaces(&[&spheres[0], &spheres[1]])?;
    /// assert_eq!(options.tolerance, Some(1e-3 * spheres[1].size()));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a limit is out of its range.
    pub fn of_surfaces(&self, surfaces: &[&NurbsSurface]) -> Result<Self> {
        let tolerance = Some(self.limits(diagonal(surfaces))?.tolerance);
        Ok(Self { tolerance, relative: false, ..*self })
    }

    /// The tolerance in the points' unit for a surface, or several with this common diagonal.
    pub(super) fn limits(&self, diagonal: f64) -> Result<Limits> {
        let tolerance = match self.tolerance {
            None => DEFAULT_TOLERANCE * diagonal,
            Some(tolerance) => {
                let tolerance = positive("tolerance", tolerance)?;
                if self.relative { tolerance * diagonal } else { tolerance }
            }
        };
        let cosine = self.max_angle.map(|angle| positive("max_angle", angle)).transpose()?;
        let edge = self.max_edge.map(|edge| positive("max_edge", edge)).transpose()?;
        let aspect = match self.max_aspect {
            Some(aspect) if !(aspect >= LEAST_ASPECT && aspect.is_finite()) => {
                let must = format!("finite and at least {LEAST_ASPECT}");
                return Err(Error::parameter("max_aspect", must, aspect));
            }
            aspect => aspect,
        };
        let cosine = cosine.map(|angle| angle.min(std::f64::consts::PI).cos());
        // A net in one point has no diagonal; any tolerance does.
        Ok(Limits { tolerance: tolerance.max(f64::MIN_POSITIVE), cosine, edge, aspect })
    }
}

/// The diagonal of the box around the control nets of surfaces.
pub(super) fn diagonal(surfaces: &[&NurbsSurface]) -> f64 {
    let boxes = surfaces.iter().map(|surface| surface.net_box());
    let whole = boxes.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)));
    whole.map_or(0.0, |(low, high)| low.distance(high))
}
