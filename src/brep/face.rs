//! The face: a surface with one outer loop and any number of inner ones.

use std::sync::Arc;

use glam::DAffine3;

use super::loop_check::check_loops;
use super::loops::Loop;
use super::sides::rectangle;
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsCurve, NurbsSurface};
use crate::progress::Silent;

/// A surface, or the part of it inside an outer loop and outside the inner ones.
///
/// ```
/// use neurbs::{DVec3, Face, nurbs::{NurbsCurve, NurbsSurface}};
/// let plane = NurbsSurface::plane(DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y)?;
/// let center = DVec3::new(0.5, 0.5, 0.0);
/// let circle = NurbsCurve::arc(center, 0.25 * DVec3::X, 0.25 * DVec3::Y, std::f64::consts::TAU)?;
/// let disc = Face::trimmed(plane, vec![vec![circle]])?;
/// assert!(disc.is_trimmed() && disc.inner().is_empty());
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    surface: Arc<NurbsSurface>,
    /// The outer loop, then the inner ones.
    loops: Vec<Loop>,
    trimmed: bool,
    reversed: bool,
    name: Option<String>,
    color: Option<[f64; 3]>,
}

impl Face {
    /// A whole surface, bounded by the sides of its rectangle. Knots that are not clamped are
    /// clamped.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface};
    /// let face = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// assert_eq!(face.outer().curves().len(), 4);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if clamping overflows.
    pub fn whole(surface: impl Into<Arc<NurbsSurface>>) -> Result<Self> {
        let surface = clamped(surface.into())?;
        let loops = vec![rectangle(&surface)?];
        Ok(Self { surface, loops, trimmed: false, reversed: false, name: None, color: None })
    }

    /// The part of a surface inside the first loop and outside the others.
    ///
    /// Each loop is a list of curves in (u, v), with z = 0; each curve begins where the one before
    /// ends. Loops are turned to have the face on their left.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, Face, nurbs::{NurbsCurve, NurbsSurface}};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// let open = vec![NurbsCurve::line(DVec3::ZERO, DVec3::X)?];
    /// assert!(matches!(Face::trimmed(plane, vec![open]), Err(Error::Loop { index: 0, .. })));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Loop`] with the place, if a loop:
    ///
    /// - is open, or has a curve with z ≠ 0;
    /// - leaves the surface's rectangle;
    /// - crosses or touches itself or another loop;
    /// - is not the first, and lies outside the first or inside another one.
    pub fn trimmed(
        surface: impl Into<Arc<NurbsSurface>>,
        loops: Vec<Vec<NurbsCurve>>,
    ) -> Result<Self> {
        if loops.is_empty() {
            let must = "at least one, the outer loop";
            return Err(Error::parameter("loops", must, "none"));
        }
        let surface = clamped(surface.into())?;
        let loops = check_loops(&surface, loops)?;
        Ok(Self { surface, loops, trimmed: true, reversed: false, name: None, color: None })
    }

    /// The surface, with clamped knots.
    #[must_use]
    pub fn surface(&self) -> &Arc<NurbsSurface> {
        &self.surface
    }

    /// The outer loop, counter-clockwise in (u, v).
    #[must_use]
    pub fn outer(&self) -> &Loop {
        &self.loops[0]
    }

    /// The inner loops, clockwise in (u, v).
    #[must_use]
    pub fn inner(&self) -> &[Loop] {
        &self.loops[1..]
    }

    /// The outer loop, then the inner ones.
    #[must_use]
    pub fn loops(&self) -> &[Loop] {
        &self.loops
    }

    /// Whether the face was made with loops of its own.
    #[must_use]
    pub fn is_trimmed(&self) -> bool {
        self.trimmed
    }

    /// Whether the face's normals are opposite to the surface's.
    #[must_use]
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    /// The same face with opposite normals.
    ///
    /// ```
    /// use neurbs::{DVec3, Face, NurbsSurface};
    /// let face = Face::whole(NurbsSurface::sphere(DVec3::ZERO, 1.0)?)?;
    /// assert!(face.reversed().is_reversed());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { reversed: !self.reversed, ..self.clone() }
    }

    /// The name, if it is known.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The color as red, green and blue in [0, 1], if it is known.
    #[must_use]
    pub fn color(&self) -> Option<[f64; 3]> {
        self.color
    }

    /// The same face with a name.
    #[must_use]
    pub fn with_name(self, name: Option<String>) -> Self {
        Self { name, ..self }
    }

    /// The same face with a color.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a component is not in [0, 1].
    pub fn with_color(self, color: Option<[f64; 3]>) -> Result<Self> {
        if let Some(color) = color.filter(|color| !color.iter().all(|c| (0.0..=1.0).contains(c))) {
            let must = "red, green and blue between 0 and 1";
            return Err(Error::parameter("color", must, format!("{color:?}")));
        }
        Ok(Self { color, ..self })
    }

    /// Applies an affine map, a reflection included: normals stay on their side of the surface.
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if a coordinate overflows.
    pub fn transformed(&self, map: &DAffine3) -> Result<Self> {
        let surface = Arc::new(self.surface.transformed(map)?);
        // A reflection turns the surface's own normals to the other side.
        let reversed = self.reversed != (map.matrix3.determinant() < 0.0);
        Ok(Self { surface, reversed, ..self.clone() })
    }
}

/// The surface with clamped knots, the outermost ones included: they have no effect, but readers
/// of files take them for the domain.
fn clamped(surface: Arc<NurbsSurface>) -> Result<Arc<NurbsSurface>> {
    let starts_and_ends_in_domain = |knots: &KnotVector| {
        let all = knots.as_slice();
        (all[0], all[all.len() - 1]) == knots.domain()
    };
    if [surface.knots_u(), surface.knots_v()].into_iter().all(starts_and_ends_in_domain) {
        return Ok(surface);
    }
    Ok(Arc::new(surface.clamp(&mut Silent)?))
}
