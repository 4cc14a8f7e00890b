//! The points of a surface that are closest to given points, globally.
//!
//! A tree of boxes over pieces of the surface, each of them nearly flat, gives lower bounds of the
//! distance; Newton's method with second derivatives gives feet on the pieces. A piece is left
//! aside only when it cannot hold a closer foot. Newton stays on its piece, where the surface is
//! smooth and has one valley: edges, borders and seams need no rule of their own, because the piece
//! on the other side has its own turn.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::batch::{check_length, in_blocks};
use super::bezier::Patch;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::Observer;

/// A piece is flat when its control points lie this near to a parallelogram, as a share of its
/// diagonal. Smaller means more pieces; larger means more of them tried for each point.
const FLATNESS: f64 = 0.05;

/// Halvings of a patch at most: a piece that is not flat by then is small.
const MOST_HALVINGS: usize = 14;

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

/// Points that a thread takes at a time.
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

/// A surface prepared for many searches; preparing costs about as much as a thousand of them.
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
    root: Node,
    size: f64,
}

/// A box around pieces of the surface.
#[derive(Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    inside: Inside,
}

#[derive(Debug)]
enum Inside {
    Nodes(Box<[Node; 2]>),
    Piece(Box<Piece>),
}

/// A nearly flat piece of a patch: no point of it lies further than `slack` from the
/// parallelogram `centre + α a + β b`, α and β from -1 to 1.
#[derive(Debug)]
struct Piece {
    patch: usize,
    /// Its middle and half its extent in shares of the patch's sides.
    middle: DVec2,
    half: DVec2,
    centre: DVec3,
    a: DVec3,
    b: DVec3,
    slack: f64,
    /// An estimate of the radius of curvature.
    radius: f64,
}

impl ClosestPointSearch {
    /// Prepares a surface: O(patches).
    ///
    /// # Errors
    ///
    /// None; every surface can be searched.
    pub fn new(surface: &NurbsSurface) -> Result<Self> {
        let (patches, (rows, cols)) = Patch::of(surface)?;
        let trees: Vec<Node> = patches
            .par_iter()
            .enumerate()
            .map(|(index, patch)| Node::of_patch(patch, patch, index, MOST_HALVINGS))
            .collect();
        let mut trees: Vec<Option<Node>> = trees.into_iter().map(Some).collect();
        let root = Node::of_patches(&mut trees, cols, (0, rows), (0, cols));
        Ok(Self { patches, root, size: surface.size() })
    }

    /// The closest point of the surface; among several equally close ones any of them.
    ///
    /// Its parameters are clamped to the domain; in closed directions the search goes on beyond
    /// the seam. For a point that is not finite it is NaN.
    #[must_use]
    pub fn closest_point(&self, point: DVec3) -> ClosestPoint {
        self.search(point, &mut Vec::new())
    }

    /// The closest points of many points, in parallel.
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
        in_blocks(points.len(), observer, |from, to| {
            let feet = uv[from..to].par_iter_mut().zip(&mut feet[from..to]);
            let rest = distances[from..to].par_iter_mut().zip(&mut converged[from..to]);
            let tasks = points[from..to].par_iter().zip(feet.zip(rest));
            let tasks = tasks.with_min_len(POINTS_PER_TASK);
            tasks.for_each_init(Vec::new, |stack, (&point, ((uv, foot), (distance, done)))| {
                let found = self.search(point, stack);
                (*uv, *foot) = (found.uv, found.point);
                (*distance, *done) = (found.distance, found.converged);
            });
        })
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

impl Node {
    /// Square of a lower bound of the distance from a point to what is inside.
    fn bound(&self, point: DVec3) -> f64 {
        let outside = (self.low - point).max(point - self.high).max(DVec3::ZERO);
        outside.length_squared()
    }

    fn around(nodes: [Self; 2]) -> Self {
        let [a, b] = &nodes;
        let (low, high) = (a.low.min(b.low), a.high.max(b.high));
        Self { low, high, inside: Inside::Nodes(Box::new(nodes)) }
    }

    /// The tree over a rectangle of patches in rows of `cols`.
    fn of_patches(
        trees: &mut [Option<Self>],
        cols: usize,
        rows: (usize, usize),
        columns: (usize, usize),
    ) -> Self {
        let half = |(from, to): (usize, usize)| {
            let middle = usize::midpoint(from, to);
            [(from, middle), (middle, to)]
        };
        let (height, width) = (rows.1 - rows.0, columns.1 - columns.0);
        if height * width == 1 {
            let tree = trees[rows.0 * cols + columns.0].take();
            return tree.expect("rectangles do not overlap");
        }
        let halves = if height >= width {
            half(rows).map(|rows| Self::of_patches(trees, cols, rows, columns))
        } else {
            half(columns).map(|columns| Self::of_patches(trees, cols, rows, columns))
        };
        Self::around(halves)
    }

    /// The tree over a piece of a patch, halved until flat.
    fn of_patch(whole: &Patch, part: &Patch, index: usize, halvings: usize) -> Self {
        let (p, q) = part.degrees();
        let corners = [(0, 0), (0, q), (p, 0), (p, q)].map(|(i, j)| part.control(i, j));
        let [c00, c01, c10, c11] = corners;
        let (a, b) = ((c10 + c11 - c00 - c01) / 4.0, (c01 + c11 - c00 - c10) / 4.0);
        let centre = (c00 + c01 + c10 + c11) / 4.0;
        let share = |t: f64, (from, to): (f64, f64)| (t - from) / (to - from);
        let from = DVec2::new(share(part.u.0, whole.u), share(part.v.0, whole.v));
        let to = DVec2::new(share(part.u.1, whole.u), share(part.v.1, whole.v));
        let (middle, half) = (from.midpoint(to), (to - from) / 2.0);
        let (slack, radius) = (0.0, 0.0);
        let mut piece = Piece { patch: index, middle, half, centre, a, b, slack, radius };
        let distances = part.points().map(|point| piece.nearest(point).0);
        piece.slack = distances.fold(0.0, f64::max);
        let diagonal = (a + b).length().max((a - b).length());
        piece.radius = diagonal * diagonal / (2.0 * piece.slack).max(f64::MIN_POSITIVE);
        if piece.slack <= FLATNESS * diagonal || halvings == 0 {
            let first = corners[0];
            let grow = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
            let (low, high) = part.points().fold((first, first), grow);
            return Self { low, high, inside: Inside::Piece(Box::new(piece)) };
        }
        // The net's length along u against that along v: the longer way is halved.
        let along = |di: usize, dj: usize| {
            let steps = (0..=p - di).flat_map(|i| (0..=q - dj).map(move |j| (i, j)));
            let lengths =
                steps.map(|(i, j)| part.control(i + di, j + dj).distance(part.control(i, j)));
            lengths.sum::<f64>() / ((p + 1 - di) * (q + 1 - dj)) as f64
        };
        let (along_u, along_v) = (along(1, 0) * p as f64, along(0, 1) * q as f64);
        let (first, second) = if along_u >= along_v { part.halves_u() } else { part.halves_v() };
        Self::around([first, second].map(|part| Self::of_patch(whole, &part, index, halvings - 1)))
    }
}

impl Piece {
    /// The distance from a point to the parallelogram, and where on it the nearest place is.
    fn nearest(&self, point: DVec3) -> (f64, DVec2) {
        let (to, a, b) = (point - self.centre, self.a, self.b);
        let (aa, ab, bb) = (a.length_squared(), a.dot(b), b.length_squared());
        let (ta, tb) = (to.dot(a), to.dot(b));
        let det = aa * bb - ab * ab;
        let measure = |at: DVec2| ((to - at.x * a - at.y * b).length(), at);
        if det > f64::EPSILON * aa * bb {
            let at = DVec2::new(bb * ta - ab * tb, aa * tb - ab * ta) / det;
            if at.abs().max_element() <= 1.0 {
                return measure(at);
            }
        }
        let place = |along: f64, square: f64| {
            if square > 0.0 { (along / square).clamp(-1.0, 1.0) } else { 0.0 }
        };
        let sides = [-1.0, 1.0].map(|side| {
            let on_a = DVec2::new(side, place(tb - side * ab, bb));
            let on_b = DVec2::new(place(ta - side * ab, aa), side);
            [measure(on_a), measure(on_b)]
        });
        let [[first, second], [third, fourth]] = sides;
        [second, third, fourth].into_iter().fold(first, |a, b| if b.0 < a.0 { b } else { a })
    }
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
