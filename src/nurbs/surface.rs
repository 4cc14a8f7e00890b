//! The NURBS surface: control net, weights and knots.

use std::sync::{Arc, OnceLock};

use glam::{DVec3, DVec4};

use super::control_net::{bounds, dehomogenize, to_homogeneous};
use super::knot_vector::{KnotVector, check_degree};
use super::partials::TangentThresholds;
use super::patch_nets::PatchNets;
use crate::error::{Error, Result};
use crate::progress::InterruptCheck;

/// A tensor-product NURBS surface.
///
/// The number of rows of the control net is the number of basis functions in u; that of columns, in
/// v. The net is stored row by row, v fastest. Control points are in space, not multiplied by their
/// weights.
///
/// ```
/// use neurbs::{DVec3, nurbs::NurbsSurface};
/// // A bilinear patch.
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 1.0)];
/// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
/// assert_eq!(surface.point(0.5, 0.5), DVec3::new(0.5, 0.5, 0.25));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct NurbsSurface {
    control_points: Vec<DVec3>,
    weights: Option<Vec<f64>>,
    knots_u: KnotVector,
    knots_v: KnotVector,
    /// (w x, w y, w z, w) of each control point, for evaluation.
    homogeneous: Vec<DVec4>,
    /// Two opposite corners of the control points' bounding box.
    net_box: (DVec3, DVec3),
    /// Squared lengths below which tangents count as zero.
    tangent_thresholds: TangentThresholds,
    /// Computed on first use.
    patch_nets: OnceLock<Arc<PatchNets>>,
}

/// Maximal number of Bézier control points that a surface caches (2 MiB). For larger nets,
/// recomputing them costs little compared with their use.
const MAX_CACHED_POINTS: usize = 1 << 16;

/// Surfaces are equal if their nets, weights and knots are. A net with all weights 1 differs from a
/// net without weights.
impl PartialEq for NurbsSurface {
    fn eq(&self, other: &Self) -> bool {
        self.control_points == other.control_points
            && self.weights == other.weights
            && self.knots_u == other.knots_u
            && self.knots_v == other.knots_v
    }
}

impl NurbsSurface {
    /// Builds a surface from net, weights and knots; without weights it is polynomial (all weights
    /// are 1).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{KnotVector, NurbsSurface}};
    /// let knots = KnotVector::clamped_uniform(1, 2)?;
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
    /// let weights = Some(vec![1.0, 1.0, 1.0, 3.0]);
    /// let surface = NurbsSurface::new(net, weights, knots.clone(), knots)?;
    /// // The corner with the largest weight pulls the middle to itself.
    /// assert_eq!(surface.point(0.5, 0.5), DVec3::new(4.0, 4.0, 3.0) / 6.0);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if one of these holds:
    ///
    /// - The numbers of control points and weights do not match the knots.
    /// - A control point is not finite.
    /// - A weight is not positive and finite.
    pub fn new(
        control_points: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        knots_u: KnotVector,
        knots_v: KnotVector,
    ) -> Result<Self> {
        Self::new_interruptible(control_points, weights, [knots_u, knots_v], &mut || Ok(()))
    }

    /// Builds a surface, with interrupt checks.
    pub(super) fn new_interruptible(
        control_points: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        [knots_u, knots_v]: [KnotVector; 2],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (rows, cols) = (knots_u.control_points(), knots_v.control_points());
        if control_points.len() != rows * cols {
            let got = format!(
                "{} control points were given with knots for {rows} × {cols}",
                control_points.len()
            );
            return Err(Error::Net {
                must: "have as many control points as its knots require",
                got,
            });
        }
        let name = |i: usize| format!("{:?}", (i / cols, i % cols));
        let homogeneous =
            to_homogeneous(&control_points, weights.as_deref(), name, check_interrupt)?;
        let net_box = bounds(control_points.iter().copied());
        let length = |knots: &KnotVector| knots.domain().1 - knots.domain().0;
        let size = net_box.0.distance(net_box.1);
        let tangent_thresholds = TangentThresholds::new(size, length(&knots_u), length(&knots_v));
        let patch_nets = OnceLock::new();
        Ok(Self {
            control_points,
            weights,
            knots_u,
            knots_v,
            homogeneous,
            net_box,
            tangent_thresholds,
            patch_nets,
        })
    }

    /// Returns the Bézier nets between the knots, which the surface caches.
    pub(crate) fn patch_nets(&self) -> Arc<PatchNets> {
        if let Some(nets) = self.patch_nets.get() {
            return Arc::clone(nets);
        }
        let nets = Arc::new(self.patch_nets_cut_at(&[], &[]));
        if nets.control_points() > MAX_CACHED_POINTS {
            return nets;
        }
        // Two threads may compute them at once; the first result is kept.
        Arc::clone(self.patch_nets.get_or_init(|| nets))
    }

    /// Returns the Bézier nets between the knots and these additional parameters inside the domain.
    pub(crate) fn patch_nets_cut_at(&self, u: &[f64], v: &[f64]) -> PatchNets {
        PatchNets::new(&self.homogeneous, [&self.knots_u, &self.knots_v], [u, v])
    }

    /// Builds a surface from a net in homogeneous coordinates, (w x, w y, w z, w).
    pub(super) fn from_homogeneous(
        net: Vec<DVec4>,
        rational: bool,
        knots: [KnotVector; 2],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let (points, weights) = dehomogenize(&net, rational, check_interrupt)?;
        drop(net);
        Self::new_interruptible(points, weights, knots, check_interrupt)
    }

    /// Builds a polynomial surface on `[0, 1]²` with clamped, evenly spaced knots over a net of
    /// `rows` × `cols` control points.
    ///
    /// If a side has at most `degree` control points, the degree in that direction is lowered to
    /// the highest possible one.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let net = (0..12).map(|i| DVec3::new(f64::from(i / 4), f64::from(i % 4), 0.0)).collect();
    /// let surface = NurbsSurface::clamped(net, (3, 4), 3)?;
    /// assert_eq!((surface.knots_u().degree(), surface.knots_v().degree()), (2, 3));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree is out of range or a side has fewer than 2 control
    /// points; [`Error::Net`] as [`NurbsSurface::new`].
    pub fn clamped(net: Vec<DVec3>, (rows, cols): (usize, usize), degree: usize) -> Result<Self> {
        check_degree(degree)?;
        let knots = |count: usize| {
            let possible = if count > degree { degree } else { count.saturating_sub(1) };
            KnotVector::clamped_uniform(possible, count)
        };
        Self::new(net, None, knots(rows)?, knots(cols)?)
    }

    /// The control points of the net, row by row.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// assert_eq!(plane.control_points()[1], 2.0 * DVec3::Y);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn control_points(&self) -> &[DVec3] {
        &self.control_points
    }

    /// The weights of the net, row by row; `None` if the surface is polynomial.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// assert!(plane.weights().is_none());
    /// assert!(NurbsSurface::sphere(DVec3::ZERO, 1.0)?.weights().is_some());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The knots in u, along axis 0 of the net.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert_eq!(sphere.knots_u().breaks(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn knots_u(&self) -> &KnotVector {
        &self.knots_u
    }

    /// The knots in v, along axis 1 of the net.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert_eq!(sphere.knots_v().breaks(), [0.0, 0.5, 1.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn knots_v(&self) -> &KnotVector {
        &self.knots_v
    }

    /// Rows and columns of the net.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert_eq!(sphere.shape(), (9, 5));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.knots_u.control_points(), self.knots_v.control_points())
    }

    /// Returns the smallest and largest coordinates of the control points; this box contains the
    /// surface.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// assert_eq!(plane.net_box(), (DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0)));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn net_box(&self) -> (DVec3, DVec3) {
        self.net_box
    }

    /// The size of the surface, to which tolerances are relative: the diagonal of
    /// [`NurbsSurface::net_box`], in the points' unit.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// assert_eq!(plane.size(), 5_f64.sqrt());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn size(&self) -> f64 {
        let (low, high) = self.net_box();
        low.distance(high)
    }

    /// Squared lengths below which tangents count as zero.
    pub(super) fn tangent_thresholds(&self) -> TangentThresholds {
        self.tangent_thresholds
    }

    /// Applies `f` to each control point. The surface follows exactly only if `f` is affine.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// let raised = plane.map_control_points(|p| p + DVec3::Z)?;
    /// assert_eq!(raised.point(0.5, 0.5), DVec3::new(0.5, 1.0, 1.0));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if `f` returns a point that is not finite.
    pub fn map_control_points(&self, f: impl Fn(DVec3) -> DVec3) -> Result<Self> {
        let moved = self.control_points.iter().map(|&p| f(p)).collect();
        Self::new(moved, self.weights.clone(), self.knots_u.clone(), self.knots_v.clone())
    }

    /// The net in homogeneous coordinates, row by row.
    pub(super) fn homogeneous(&self) -> &[DVec4] {
        &self.homogeneous
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(result: Result<NurbsSurface>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn error_messages_contain_both_numbers() {
        let knots = || KnotVector::clamped_uniform(1, 2).unwrap();
        let net = || vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
        let weighted = |weights| message(NurbsSurface::new(net(), Some(weights), knots(), knots()));
        assert!(weighted(vec![1.0; 3]).contains("3 weights were given for 4 points"));
        assert!(weighted(vec![1.0, 1.0, 0.0, 1.0]).contains("weight (1, 0) is 0"));
        assert!(weighted(vec![1.0, f64::NAN, 1.0, 1.0]).contains("weight (0, 1) is NaN"));
        assert!(weighted(vec![1.0, 1.0, 1.0, 5e-324]).contains("control point (1, 1) with"));
        let mut broken = net();
        broken[3].y = f64::INFINITY;
        let broken = message(NurbsSurface::new(broken, None, knots(), knots()));
        assert!(broken.contains("control point (1, 1)"));
        assert!(message(NurbsSurface::clamped(net(), (2, 2), 40)).contains("got 40"));
    }

    #[test]
    fn a_small_net_lowers_the_degree() {
        let surface = NurbsSurface::clamped(vec![DVec3::X; 12], (3, 4), 3).unwrap();
        assert_eq!((surface.knots_u().degree(), surface.knots_v().degree()), (2, 3));
    }
}
