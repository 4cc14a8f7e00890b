//! Projection of points onto a surface: the globally closest point. For a local search from known
//! parameters see [`crate::fit::project`].
//!
//! A tree of bounding boxes over nearly flat pieces gives lower bounds of the distance. Newton's
//! method with second derivatives finds the projection on a piece. A piece is skipped only if it
//! cannot contain a closer point.
//!
//! Newton's method stays on its piece, where the surface is smooth. Edges and seams need no special
//! rule, because the piece on the other side is searched, too.

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};

use super::bezier_patch::BezierPatch;
use super::box_tree::{BoxNode, FlatPiece, NodeContent};
use super::parameter_checks::check_length;
use super::parameter_region::{Cover, ParameterRegion};
use super::surface::NurbsSurface;
use super::work_blocks::{MAX_POINTS_PER_TASK, for_timed_blocks, interrupt_check};
use crate::error::{Error, Result};
use crate::progress::{Observer, Silent};
use crate::worker_pool;

/// A point farther than this fraction of the radius of curvature may have several projections on a
/// piece. The fraction is small because a part of a piece may bend more than the whole.
const FOCAL_FRACTION: f64 = 0.1;

/// Starting points of Newton's method along each side of a piece with several possible projections.
const STARTS_PER_SIDE: usize = 3;

/// Maximal number of Newton steps. From a flat piece three or four are enough.
const MAX_STEPS: usize = 100;

/// Newton's method has converged when a step is shorter than this fraction of the surface's size
/// plus the distance. The next step would be rounding.
const STEP_TOLERANCE: f64 = 1e-12;

/// A slope of the squared distance is zero up to rounding if it is below this fraction of size plus
/// distance, times the length of the tangent.
///
/// This ends searches where a whole curve is equally near (a point on the axis of a torus, the
/// center of a sphere): steps along that curve do not become short.
const GRADIENT_TOLERANCE: f64 = 1e-14;

/// Relative rounding error of a squared distance.
const ROUNDING: f64 = 1e-15;

/// The projection of a point onto a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClosestPoint {
    /// The parameters of the projection.
    pub uv: DVec2,
    /// The projection.
    pub point: DVec3,
    /// The distance from the point, in the points' unit.
    pub distance: f64,
    /// Whether Newton's method converged.
    pub converged: bool,
}

/// Output slices for closest points, with one element for each point.
pub struct ClosestPointSlices<'a> {
    /// See [`ClosestPoint::uv`].
    pub uv: &'a mut [DVec2],
    /// See [`ClosestPoint::point`].
    pub points: &'a mut [DVec3],
    /// See [`ClosestPoint::distance`].
    pub distances: &'a mut [f64],
    /// See [`ClosestPoint::converged`].
    pub converged: &'a mut [bool],
}

/// A surface prepared for closest-point searches.
///
/// A search builds the pieces of the patches that it visits, and keeps them for later searches.
///
/// ```
/// use neurbs::{DVec3, nurbs::{ClosestPointSearch, NurbsSurface}};
/// let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0)?;
/// let search = ClosestPointSearch::new(&sphere)?;
/// let projection = search.closest_point(DVec3::new(0.0, 5.0, 0.0));
/// assert!(projection.point.distance(DVec3::Y * 2.0) < 1e-12 && projection.converged);
/// assert!((projection.distance - 3.0).abs() < 1e-14);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Debug)]
pub struct ClosestPointSearch {
    patches: Vec<BezierPatch>,
    /// Tree over the bounding boxes of the patches.
    root: Option<BoxNode>,
    /// Trees over the pieces of each patch, built on the first visit.
    trees: Vec<OnceLock<Option<BoxNode>>>,
    size: f64,
    /// The part of the surface that is searched; `None` for all of it.
    region: Option<Arc<dyn ParameterRegion>>,
}

impl ClosestPointSearch {
    /// Prepares a surface: O(patches).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{ClosestPointSearch, NurbsSurface}};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let projection = ClosestPointSearch::new(&sphere)?.closest_point(3.0 * DVec3::X);
    /// assert!((projection.distance - 2.0).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// None; every surface can be searched.
    pub fn new(surface: &NurbsSurface) -> Result<Self> {
        Self::observed(surface, &mut Silent)
    }

    /// Prepares a surface and reports to an observer, which can stop it; for large nets.
    ///
    /// ```
    /// use neurbs::{DVec3, Error, nurbs::{ClosestPointSearch, NurbsSurface}, progress::Progress};
    /// use std::ops::ControlFlow;
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let mut stop = |_: &Progress| ControlFlow::Break(());
    /// let search = ClosestPointSearch::observed(&sphere, &mut stop);
    /// assert!(matches!(search, Err(Error::Interrupted)));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn observed(surface: &NurbsSurface, observer: &mut dyn Observer) -> Result<Self> {
        Self::within(surface, None, observer)
    }

    /// Prepares the part of a surface in a region. Searches find the places in it where the
    /// distance is locally smallest, but not those on the region's border.
    pub(crate) fn within(
        surface: &NurbsSurface,
        region: Option<Arc<dyn ParameterRegion>>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let (patches, (rows, cols)) = BezierPatch::of(surface, &mut interrupt_check(observer))?;
        let is_outside = |patch: &BezierPatch| {
            let [low, high] = patch.rectangle();
            region.as_ref().is_some_and(|region| region.cover(low, high) == Cover::Outside)
        };
        let boxes = patches.iter().enumerate();
        let boxes =
            boxes.map(|(index, patch)| (!is_outside(patch)).then(|| BoxNode::of_box(patch, index)));
        let mut boxes: Vec<Option<BoxNode>> = boxes.collect();
        let root = BoxNode::of_rectangle(&mut boxes, cols, (0, rows), (0, cols));
        let trees = patches.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { patches, root, trees, size: surface.size(), region })
    }

    /// The smallest and largest corner of a box around the searched part.
    pub(crate) fn corners(&self) -> Option<(DVec3, DVec3)> {
        self.root.as_ref().map(BoxNode::corners)
    }

    /// Returns the closest point of the surface; if several are equally close, any of them.
    ///
    /// The parameters are inside the domain. In closed directions the search continues across the
    /// seam. For a point that is not finite the result is NaN.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{ClosestPointSearch, NurbsSurface}};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let projection = ClosestPointSearch::new(&sphere)?.closest_point(DVec3::new(0.0, 0.0, 5.0));
    /// assert!(projection.converged && projection.point.distance(DVec3::Z) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn closest_point(&self, point: DVec3) -> ClosestPoint {
        self.search(point, f64::INFINITY, &mut Vec::new())
    }

    /// Finds the closest points of many points, in parallel.
    ///
    /// ```
    /// use neurbs::nurbs::{ClosestPointSearch, ClosestPointSlices, NurbsSurface};
    /// use neurbs::{DVec2, DVec3, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let (mut uv, mut points) = ([DVec2::ZERO; 2], [DVec3::ZERO; 2]);
    /// let (mut distances, mut converged) = ([0.0; 2], [false; 2]);
    /// let out = ClosestPointSlices {
    ///     uv: &mut uv,
    ///     points: &mut points,
    ///     distances: &mut distances,
    ///     converged: &mut converged,
    /// };
    /// let search = ClosestPointSearch::new(&sphere)?;
    /// search.closest_points(&[2.0 * DVec3::X, 0.5 * DVec3::Z], out, &mut Silent)?;
    /// assert!(points[0].distance(DVec3::X) < 1e-14 && (distances[1] - 0.5).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`] if a point is not finite, [`Error::Parameter`] if the length of an
    /// output differs from that of `points`, [`Error::Interrupted`] if the observer stops it.
    pub fn closest_points(
        &self,
        points: &[DVec3],
        out: ClosestPointSlices<'_>,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let ClosestPointSlices { uv, points: projections, distances, converged } = out;
        for length in [uv.len(), projections.len(), distances.len(), converged.len()] {
            check_length(length, points.len())?;
        }
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::NotFinite { index, point: points[index] });
        }
        for_timed_blocks(points.len(), observer, |from, to| {
            let projections = uv[from..to].iter_mut().zip(&mut projections[from..to]);
            let rest = distances[from..to].iter_mut().zip(&mut converged[from..to]);
            let tasks = points[from..to].iter().zip(projections.zip(rest));
            let share = (to - from) / (4 * worker_pool::num_threads());
            worker_pool::for_each_task(
                tasks,
                share.min(MAX_POINTS_PER_TASK),
                |stack: &mut Vec<_>, (&point, ((uv, projection), (distance, done)))| {
                    let found = self.search(point, f64::INFINITY, stack);
                    (*uv, *projection) = (found.uv, found.point);
                    (*distance, *done) = (found.distance, found.converged);
                },
            );
        })
    }

    /// Returns the parameters and distances of the closest points; see [`Self::closest_points`].
    pub(crate) fn closest_parameters(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<(Vec<DVec2>, Vec<f64>)> {
        let count = points.len();
        let (mut uv, mut projections) = (vec![DVec2::ZERO; count], vec![DVec3::ZERO; count]);
        let (mut distances, mut converged) = (vec![0.0; count], vec![false; count]);
        let out = ClosestPointSlices {
            uv: &mut uv,
            points: &mut projections,
            distances: &mut distances,
            converged: &mut converged,
        };
        self.closest_points(points, out, observer)?;
        Ok((uv, distances))
    }

    /// Returns the closest point that is nearer than `limit`; `None` if there is none.
    pub(crate) fn closer_point(&self, point: DVec3, limit: f64) -> Option<ClosestPoint> {
        let found = self.search(point, limit, &mut Vec::new());
        (found.distance < limit).then_some(found)
    }

    /// Searches for a point nearer than `limit`. Without one the result is NaN at that distance.
    fn search<'a>(
        &'a self,
        point: DVec3,
        limit: f64,
        stack: &mut Vec<(f64, &'a BoxNode)>,
    ) -> ClosestPoint {
        let not_found = DVec3::splat(f64::NAN);
        let mut best =
            ClosestPoint { uv: DVec2::NAN, point: not_found, distance: limit, converged: false };
        stack.clear();
        stack.extend(self.root.as_ref().map(|root| (root.bound(point), root)));
        while let Some((bound, node)) = stack.pop() {
            if bound >= best.distance * best.distance {
                continue;
            }
            match &node.inside {
                NodeContent::Children(nodes) => {
                    let [a, b] = [&nodes[0], &nodes[1]].map(|node| (node.bound(point), node));
                    let (near, far) = if a.0 <= b.0 { (a, b) } else { (b, a) };
                    stack.extend([far, near]);
                }
                NodeContent::Patch(index) => {
                    let (patch, region) = (&self.patches[*index], self.region.as_deref());
                    let tree = self.trees[*index]
                        .get_or_init(|| BoxNode::of_pieces(patch, *index, region));
                    stack.extend(tree.as_ref().map(|tree| (tree.bound(point), tree)));
                }
                NodeContent::Piece(piece) => self.try_piece(piece, point, &mut best),
            }
        }
        best
    }

    /// Whether a place on a piece is in the searched region.
    fn contains(&self, piece: &FlatPiece, uv: DVec2) -> bool {
        !piece.is_cut || self.region.as_ref().is_none_or(|region| region.contains(uv))
    }

    fn try_piece(&self, piece: &FlatPiece, point: DVec3, best: &mut ClosestPoint) {
        let (distance, at) = piece.nearest(point);
        if distance - piece.slack >= best.distance {
            return;
        }
        let mut start = |at: DVec2| {
            let projection = self.newton(piece, piece.middle + at * piece.half, point);
            if projection.distance < best.distance && self.contains(piece, projection.uv) {
                *best = projection;
            }
        };
        start(at);
        if distance > FOCAL_FRACTION * piece.radius {
            let step = |i: usize| 2.0 * i as f64 / (STARTS_PER_SIDE - 1) as f64 - 1.0;
            (0..STARTS_PER_SIDE * STARTS_PER_SIDE).for_each(|k| {
                start(DVec2::new(step(k / STARTS_PER_SIDE), step(k % STARTS_PER_SIDE)));
            });
        }
    }

    /// Finds the closest point of a piece by Newton's method for the squared distance.
    ///
    /// Steps are clamped to the piece and halved while the distance grows. Where the Hessian is not
    /// positive definite, Gauss-Newton steps replace Newton steps.
    fn newton(&self, piece: &FlatPiece, start: DVec2, point: DVec3) -> ClosestPoint {
        let patch = &self.patches[piece.patch];
        // A step out of the piece could converge to another minimum and miss the one on this piece.
        let (low, high) = (piece.middle - piece.half, piece.middle + piece.half);
        let mut at = start.clamp(low, high);
        let mut partials = patch.partials(at.x, at.y);
        let mut square = partials.point.distance_squared(point);
        let mut converged = false;
        let mut steps = 0;
        while steps < MAX_STEPS && !converged {
            let offset = partials.point - point;
            let gradient = DVec2::new(offset.dot(partials.u), offset.dot(partials.v));
            let at_bound = |at: f64, slope: f64, low: f64, high: f64| {
                (at <= low && slope > 0.0) || (at >= high && slope < 0.0)
            };
            let free = [
                !at_bound(at.x, gradient.x, low.x, high.x),
                !at_bound(at.y, gradient.y, low.y, high.y),
            ];
            let scale = self.size + square.sqrt();
            let is_stationary = |slope: f64, tangent: DVec3| {
                slope.abs() <= GRADIENT_TOLERANCE * scale * tangent.length()
            };
            if (!free[0] || is_stationary(gradient.x, partials.u))
                && (!free[1] || is_stationary(gradient.y, partials.v))
            {
                converged = true;
                break;
            }
            let gauss = [
                partials.u.length_squared(),
                partials.u.dot(partials.v),
                partials.v.length_squared(),
            ];
            let bends = [offset.dot(partials.uu), offset.dot(partials.uv), offset.dot(partials.vv)];
            let step = newton_step(gradient, gauss, bends, free);
            let accuracy = STEP_TOLERANCE * scale;
            let mut share = 1.0;
            loop {
                steps += 1;
                let next = (at + share * step).clamp(low, high);
                let moved = next - at;
                let is_small = (moved.x * partials.u + moved.y * partials.v).length() <= accuracy;
                let next_partials = patch.partials(next.x, next.y);
                let next_square = next_partials.point.distance_squared(point);
                // Close to the projection squared distances differ only by rounding, so the Newton
                // step is accepted.
                let is_closer = next_square <= square * (1.0 + ROUNDING);
                if is_closer || is_small || steps >= MAX_STEPS {
                    if is_closer {
                        (at, partials, square) = (next, next_partials, next_square);
                    }
                    converged = is_small;
                    break;
                }
                share /= 2.0;
            }
        }
        let (u, v) = patch.parameters(at.x, at.y);
        ClosestPoint {
            uv: DVec2::new(u, v),
            point: partials.point,
            distance: square.sqrt(),
            converged,
        }
    }
}

/// Returns the step to the minimum of the quadratic model, in the free directions.
///
/// The matrices are [uu, uv, vv]: `gauss` without second derivatives of the surface, `bends` their
/// contribution.
fn newton_step(gradient: DVec2, gauss: [f64; 3], bends: [f64; 3], free: [bool; 2]) -> DVec2 {
    let along_one_axis = |slope: f64, gauss: f64, bend: f64| {
        let curvature = if gauss + bend > 0.0 { gauss + bend } else { gauss };
        if curvature > 0.0 { -slope / curvature } else { 0.0 }
    };
    let separate = DVec2::new(
        if free[0] { along_one_axis(gradient.x, gauss[0], bends[0]) } else { 0.0 },
        if free[1] { along_one_axis(gradient.y, gauss[2], bends[2]) } else { 0.0 },
    );
    if free != [true, true] {
        return separate;
    }
    let solve = |[a, b, c]: [f64; 3]| {
        let det = a * c - b * b;
        let clear = a > 0.0 && det > f64::EPSILON * a * c;
        let x = b * gradient.y - c * gradient.x;
        let y = b * gradient.x - a * gradient.y;
        clear.then(|| DVec2::new(x, y) / det)
    };
    let full = [gauss[0] + bends[0], gauss[1] + bends[1], gauss[2] + bends[2]];
    solve(full).or_else(|| solve(gauss)).unwrap_or(separate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_converge_where_a_whole_curve_is_equally_near() {
        let torus = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let search = ClosestPointSearch::new(&torus).unwrap();
        for i in 0..400 {
            let (sin, cos) = (f64::from(i) / 400.0 * std::f64::consts::TAU).sin_cos();
            let inside = search.closest_point(3.0 * DVec3::new(cos, sin, 0.0));
            assert!(inside.converged && (inside.distance - 1.0).abs() < 1e-14, "{i} {inside:?}");
            let axis = search.closest_point(DVec3::Z * (f64::from(i) / 40.0 - 5.0));
            let distance = DVec2::new(3.0, f64::from(i) / 40.0 - 5.0).length() - 1.0;
            assert!(axis.converged && (axis.distance - distance).abs() < 1e-14, "{i} {axis:?}");
        }
    }
}
