//! The points of a surface that are closest to given points, globally.
//!
//! A tree of boxes over pieces of the surface, each of them nearly flat, gives lower bounds of the
//! distance; Newton's method with second derivatives gives feet on the pieces. A piece is left
//! aside only when it cannot hold a closer foot. Newton stays on its piece, where the surface is
//! smooth and has one valley: edges, borders and seams need no rule of their own, because the piece
//! on the other side has its own turn.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::bezier_patch::Patch;
use super::box_tree::{Inside, Node, Piece};
use super::parameter_checks::check_length;
use super::surface::NurbsSurface;
use super::work_blocks::{in_timed_blocks, listening};
use crate::error::{Error, Result};
use crate::progress::{Observer, Silent};

/// Share of the radius of curvature beyond which a piece may have several feet: small, as parts of
/// a piece may bend more than the whole.
const FOCAL_SHARE: f64 = 0.1;

/// Starts of Newton's method along each side of a piece that may have several feet.
const STARTS: usize = 3;

/// Steps of Newton's method at most; from a flat piece it needs three or four.
const MOST_STEPS: usize = 100;

/// A step shorter than this share of size and distance is the last one: the one after it would be
/// rounding.
const CONVERGED: f64 = 1e-12;

/// A slope of the squared distance below this share of size and distance, for the length of the
/// tangent, is rounding. Where a whole curve of the surface is equally near (the axis of a torus,
/// the centre of a sphere), steps along it have no reason to become short.
const STATIONARY: f64 = 1e-14;

/// Share by which rounding changes a square of a distance.
const ROUNDING: f64 = 1e-15;

/// Points that a thread takes at a time at most.
const POINTS_PER_TASK: usize = 64;

/// The foot of a point on a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClosestPoint {
    /// Its parameters.
    pub uv: DVec2,
    /// Its place.
    pub point: DVec3,
    /// Its distance from the point, in the points' unit.
    pub distance: f64,
    /// Whether Newton's method came to its end.
    pub converged: bool,
}

/// Where closest points are written: slices of one element for each point.
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

/// A surface prepared for many searches. What a search finds out about the pieces of the patches
/// that it comes to is kept for the next ones.
///
/// ```
/// use neurbs::{DVec3, nurbs::{ClosestPointSearch, NurbsSurface}};
/// let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0)?;
/// let search = ClosestPointSearch::new(&sphere)?;
/// let foot = search.closest_point(DVec3::new(0.0, 5.0, 0.0));
/// assert!(foot.point.distance(DVec3::Y * 2.0) < 1e-12 && foot.converged);
/// assert!((foot.distance - 3.0).abs() < 1e-14);
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Debug)]
pub struct ClosestPointSearch {
    patches: Vec<Patch>,
    /// Over the boxes of the patches.
    root: Node,
    /// Over the pieces of each patch, made when a search first comes there.
    trees: Vec<OnceLock<Node>>,
    size: f64,
}

impl ClosestPointSearch {
    /// Prepares a surface: O(patches).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{ClosestPointSearch, NurbsSurface}};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let foot = ClosestPointSearch::new(&sphere)?.closest_point(3.0 * DVec3::X);
    /// assert!((foot.distance - 2.0).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// None; every surface can be searched.
    pub fn new(surface: &NurbsSurface) -> Result<Self> {
        Self::observed(surface, &mut Silent)
    }

    /// The same for a net so large that one may want to stop it.
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
        let (patches, (rows, cols)) = Patch::of(surface, &mut listening(observer))?;
        let boxes = patches.iter().enumerate().map(|(index, patch)| Node::of_box(patch, index));
        let root = Node::of_rectangle(
            &mut boxes.map(Some).collect::<Vec<_>>(),
            cols,
            (0, rows),
            (0, cols),
        );
        let trees = patches.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { patches, root, trees, size: surface.size() })
    }

    /// The closest point of the surface; among several equally close ones any of them.
    ///
    /// Its parameters are clamped to the domain; in closed directions the search goes on beyond
    /// the seam. For a point that is not finite it is NaN.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{ClosestPointSearch, NurbsSurface}};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// let foot = ClosestPointSearch::new(&sphere)?.closest_point(DVec3::new(0.0, 0.0, 5.0));
    /// assert!(foot.converged && foot.point.distance(DVec3::Z) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn closest_point(&self, point: DVec3) -> ClosestPoint {
        self.search(point, &mut Vec::new())
    }

    /// The closest points of many points, in parallel.
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
    /// [`Error::NotFinite`] for a point that is not finite, [`Error::Parameter`] if an output has
    /// another length than `points`, [`Error::Interrupted`] if the observer stops it.
    pub fn closest_points(
        &self,
        points: &[DVec3],
        out: ClosestPointSlices<'_>,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let ClosestPointSlices { uv, points: feet, distances, converged } = out;
        for length in [uv.len(), feet.len(), distances.len(), converged.len()] {
            check_length(length, points.len())?;
        }
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::NotFinite { index, point: points[index] });
        }
        in_timed_blocks(points.len(), observer, |from, to| {
            let feet = uv[from..to].par_iter_mut().zip(&mut feet[from..to]);
            let rest = distances[from..to].par_iter_mut().zip(&mut converged[from..to]);
            let tasks = points[from..to].par_iter().zip(feet.zip(rest));
            let share = (to - from) / (4 * rayon::current_num_threads());
            let tasks = tasks.with_min_len(share.clamp(1, POINTS_PER_TASK));
            tasks.for_each_init(Vec::new, |stack, (&point, ((uv, foot), (distance, done)))| {
                let found = self.search(point, stack);
                (*uv, *foot) = (found.uv, found.point);
                (*distance, *done) = (found.distance, found.converged);
            });
        })
    }

    /// Parameters and distances of the closest points, as of [`Self::closest_points`].
    pub(crate) fn closest_parameters(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<(Vec<DVec2>, Vec<f64>)> {
        let count = points.len();
        let (mut uv, mut feet) = (vec![DVec2::ZERO; count], vec![DVec3::ZERO; count]);
        let (mut distances, mut converged) = (vec![0.0; count], vec![false; count]);
        let out = ClosestPointSlices {
            uv: &mut uv,
            points: &mut feet,
            distances: &mut distances,
            converged: &mut converged,
        };
        self.closest_points(points, out, observer)?;
        Ok((uv, distances))
    }

    fn search<'a>(&'a self, point: DVec3, stack: &mut Vec<(f64, &'a Node)>) -> ClosestPoint {
        let nowhere = DVec3::splat(f64::NAN);
        let mut best = ClosestPoint {
            uv: DVec2::NAN,
            point: nowhere,
            distance: f64::INFINITY,
            converged: false,
        };
        stack.clear();
        stack.push((0.0, &self.root));
        while let Some((bound, node)) = stack.pop() {
            if bound >= best.distance * best.distance {
                continue;
            }
            match &node.inside {
                Inside::Nodes(nodes) => {
                    let [a, b] = [&nodes[0], &nodes[1]].map(|node| (node.bound(point), node));
                    let (near, far) = if a.0 <= b.0 { (a, b) } else { (b, a) };
                    stack.extend([far, near]);
                }
                Inside::Patch(index) => {
                    let patch = &self.patches[*index];
                    let tree = self.trees[*index].get_or_init(|| Node::of_pieces(patch, *index));
                    stack.push((tree.bound(point), tree));
                }
                Inside::Piece(piece) => self.try_piece(piece, point, &mut best),
            }
        }
        best
    }

    fn try_piece(&self, piece: &Piece, point: DVec3, best: &mut ClosestPoint) {
        let (distance, at) = piece.nearest(point);
        if distance - piece.slack >= best.distance {
            return;
        }
        let mut start = |at: DVec2| {
            let foot = self.newton(piece, piece.middle + at * piece.half, point);
            if foot.distance < best.distance {
                *best = foot;
            }
        };
        start(at);
        if distance > FOCAL_SHARE * piece.radius {
            let step = |i: usize| 2.0 * i as f64 / (STARTS - 1) as f64 - 1.0;
            (0..STARTS * STARTS)
                .for_each(|k| start(DVec2::new(step(k / STARTS), step(k % STARTS))));
        }
    }

    /// The nearest place of a piece by Newton's method for the squared distance, with steps that
    /// are cut to the piece and halved while they lead away; where the second derivatives do not
    /// describe a minimum, by those of Gauss and Newton.
    fn newton(&self, piece: &Piece, start: DVec2, point: DVec3) -> ClosestPoint {
        let patch = &self.patches[piece.patch];
        // A step out of the piece could end in another valley, and leave this one unseen.
        let (low, high) = (piece.middle - piece.half, piece.middle + piece.half);
        let mut at = start.clamp(low, high);
        let mut frame = patch.frame(at.x, at.y);
        let mut square = frame.point.distance_squared(point);
        let mut converged = false;
        let mut steps = 0;
        while steps < MOST_STEPS && !converged {
            let away = frame.point - point;
            let gradient = DVec2::new(away.dot(frame.u), away.dot(frame.v));
            let held = |at: f64, slope: f64, low: f64, high: f64| {
                (at <= low && slope > 0.0) || (at >= high && slope < 0.0)
            };
            let free =
                [!held(at.x, gradient.x, low.x, high.x), !held(at.y, gradient.y, low.y, high.y)];
            let reach = self.size + square.sqrt();
            let still =
                |slope: f64, tangent: DVec3| slope.abs() <= STATIONARY * reach * tangent.length();
            if (!free[0] || still(gradient.x, frame.u)) && (!free[1] || still(gradient.y, frame.v))
            {
                converged = true;
                break;
            }
            let gauss = [frame.u.length_squared(), frame.u.dot(frame.v), frame.v.length_squared()];
            let bends = [away.dot(frame.uu), away.dot(frame.uv), away.dot(frame.vv)];
            let step = descent(gradient, gauss, bends, free);
            let accuracy = CONVERGED * reach;
            let mut share = 1.0;
            loop {
                steps += 1;
                let next = (at + share * step).clamp(low, high);
                let moved = next - at;
                let small = (moved.x * frame.u + moved.y * frame.v).length() <= accuracy;
                let there = patch.frame(next.x, next.y);
                let reached = there.point.distance_squared(point);
                // Near the foot the squares differ by rounding alone, and Newton knows better.
                let nearer = reached <= square * (1.0 + ROUNDING);
                if nearer || small || steps >= MOST_STEPS {
                    if nearer {
                        (at, frame, square) = (next, there, reached);
                    }
                    converged = small;
                    break;
                }
                share /= 2.0;
            }
        }
        let (u, v) = patch.parameters(at.x, at.y);
        ClosestPoint {
            uv: DVec2::new(u, v),
            point: frame.point,
            distance: square.sqrt(),
            converged,
        }
    }
}

/// The step to where a quadratic model has its minimum, in the directions that are free. The
/// matrices are [uu, uv, vv] without and with second derivatives of the surface.
fn descent(gradient: DVec2, gauss: [f64; 3], bends: [f64; 3], free: [bool; 2]) -> DVec2 {
    let alone = |slope: f64, gauss: f64, bend: f64| {
        let curvature = if gauss + bend > 0.0 { gauss + bend } else { gauss };
        if curvature > 0.0 { -slope / curvature } else { 0.0 }
    };
    let single = DVec2::new(
        if free[0] { alone(gradient.x, gauss[0], bends[0]) } else { 0.0 },
        if free[1] { alone(gradient.y, gauss[2], bends[2]) } else { 0.0 },
    );
    if free != [true, true] {
        return single;
    }
    let solve = |[a, b, c]: [f64; 3]| {
        let det = a * c - b * b;
        let clear = a > 0.0 && det > f64::EPSILON * a * c;
        let x = b * gradient.y - c * gradient.x;
        let y = b * gradient.x - a * gradient.y;
        clear.then(|| DVec2::new(x, y) / det)
    };
    let full = [gauss[0] + bends[0], gauss[1] + bends[1], gauss[2] + bends[2]];
    solve(full).or_else(|| solve(gauss)).unwrap_or(single)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_end_where_a_whole_curve_is_equally_near() {
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
