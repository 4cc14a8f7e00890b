//! Options of an adaptive tessellation, and their checked limits.

use crate::error::{Error, Result, positive};
use crate::nurbs::NurbsSurface;

/// The default limit on the triangles of a mesh, some 6 GB.
pub const MAX_TRIANGLES: usize = 100_000_000;

/// The default tolerance, relative to the diagonal of the control net's box.
const DEFAULT_TOLERANCE: f64 = 1e-3;

/// Rounding errors of points on a surface, as a share of the largest coordinate.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The smallest limit of the aspect ratio: the triangles of a halved square already have √5.
const MIN_ASPECT_LIMIT: f64 = 4.0;

/// Limits of an adaptive tessellation.
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
    /// Largest distance between the surface and its triangles, in the points' unit.
    ///
    /// If `relative`, a fraction of the diagonal of the control net's box. `None`: 1e-3 of the
    /// diagonal.
    pub tolerance: Option<f64>,
    /// Whether `tolerance` is a fraction of the diagonal.
    pub relative: bool,
    /// Largest angle between the surface's normals at the ends of an edge, in radians.
    pub max_angle: Option<f64>,
    /// Largest length of an edge, in the points' unit.
    pub max_edge: Option<f64>,
    /// Largest ratio of the longer to the shorter side of a cell, which becomes two triangles or a
    /// few more; at least 4. At a pole, triangles may be narrower.
    pub max_aspect: Option<f64>,
    /// Whether closed directions are split at the seam: each vertex on it then occurs twice.
    pub split_seams: bool,
    /// Largest number of triangles.
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

/// Checked limits in the points' unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub tolerance: f64,
    /// Cosine of the largest angle between normals at the ends of an edge.
    pub cosine: Option<f64>,
    /// Largest length of an edge.
    pub edge: Option<f64>,
    /// Largest aspect ratio of a cell.
    pub aspect: Option<f64>,
}

impl Limits {
    /// Whether the tolerance is the only limit.
    pub(super) fn only_distance(&self) -> bool {
        self.cosine.is_none() && self.edge.is_none() && self.aspect.is_none()
    }
}

impl TessellateOptions {
    /// The options for several surfaces, with a common tolerance in the points' unit.
    ///
    /// A relative tolerance is a fraction of the diagonal of the box around all control nets.
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
        let tolerance = Some(self.limits(surfaces)?.tolerance);
        Ok(Self { tolerance, relative: false, ..*self })
    }

    /// Checks the options for these surfaces, and converts a relative tolerance.
    pub(super) fn limits(&self, surfaces: &[&NurbsSurface]) -> Result<Limits> {
        let (diagonal, magnitude) = extent(surfaces);
        let tolerance = match self.tolerance {
            None => DEFAULT_TOLERANCE * diagonal,
            Some(tolerance) => {
                let tolerance = positive("tolerance", tolerance)?;
                if self.relative { tolerance * diagonal } else { tolerance }
            }
        };
        let rounding = ROUNDING * magnitude;
        if diagonal > 0.0 && tolerance < rounding {
            let must = format!(
                "at least {rounding:.1e}, the rounding of coordinates up to {magnitude:.1e}: move the \
                 surface to the origin"
            );
            return Err(Error::parameter("tolerance", must, format!("{tolerance:.1e}")));
        }
        let cosine = self.max_angle.map(|angle| positive("max_angle", angle)).transpose()?;
        let edge = self.max_edge.map(|edge| positive("max_edge", edge)).transpose()?;
        let aspect = match self.max_aspect {
            Some(aspect) if !(aspect >= MIN_ASPECT_LIMIT && aspect.is_finite()) => {
                let must = format!("finite and at least {MIN_ASPECT_LIMIT}");
                return Err(Error::parameter("max_aspect", must, aspect));
            }
            aspect => aspect,
        };
        let cosine = cosine.map(|angle| angle.min(std::f64::consts::PI).cos());
        // A net in one point has diagonal 0, for which any tolerance is met.
        Ok(Limits { tolerance: tolerance.max(f64::MIN_POSITIVE), cosine, edge, aspect })
    }
}

/// The diagonal of the box around the control nets of surfaces, and their largest coordinate.
fn extent(surfaces: &[&NurbsSurface]) -> (f64, f64) {
    let boxes = surfaces.iter().map(|surface| surface.net_box());
    let whole = boxes.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)));
    whole.map_or((0.0, 0.0), |(low, high)| {
        (low.distance(high), low.abs().max(high.abs()).max_element())
    })
}
