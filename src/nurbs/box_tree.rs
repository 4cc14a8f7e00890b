//! Binary tree of bounding boxes over nearly flat pieces of a surface.

use glam::{DVec2, DVec3};

use super::bezier_patch::BezierPatch;
use super::control_net::bounds;
use super::parameter_region::{Cover, ParameterRegion};

/// A piece is flat if its control points lie this close to a parallelogram, as a fraction of its
/// diagonal. Smaller values make more pieces; larger values make more of them be searched for each
/// point.
const FLATNESS: f64 = 0.05;

/// Maximal number of halvings of a patch. A piece that is not flat by then is small.
const MAX_HALVINGS: usize = 14;

/// A bounding box with the part of the surface inside it.
#[derive(Debug)]
pub(super) struct BoxNode {
    low: DVec3,
    high: DVec3,
    pub inside: NodeContent,
}

/// The contents of a node.
#[derive(Debug)]
pub(super) enum NodeContent {
    Children(Box<[BoxNode; 2]>),
    /// The index of a patch that is not yet divided into pieces.
    Patch(usize),
    Piece(Box<FlatPiece>),
}

/// A nearly flat piece of a patch. Every point of it lies within `slack` of the parallelogram
/// `center + α a + β b`, with α and β from -1 to 1.
#[derive(Debug)]
pub(super) struct FlatPiece {
    pub patch: usize,
    /// The center and half of the extent, in the patch's unit square.
    pub middle: DVec2,
    pub half: DVec2,
    center: DVec3,
    a: DVec3,
    b: DVec3,
    pub slack: f64,
    /// An estimate of the radius of curvature.
    pub radius: f64,
    /// Whether a part of it may lie outside the region of the search.
    pub is_cut: bool,
}

impl BoxNode {
    /// Returns a lower bound of the squared distance from a point to the contents.
    pub(super) fn bound(&self, point: DVec3) -> f64 {
        let outside = (self.low - point).max(point - self.high).max(DVec3::ZERO);
        outside.length_squared()
    }

    fn around(nodes: [Self; 2]) -> Self {
        let [a, b] = &nodes;
        let (low, high) = (a.low.min(b.low), a.high.max(b.high));
        Self { low, high, inside: NodeContent::Children(Box::new(nodes)) }
    }

    /// Returns the bounding box of a patch's net.
    pub(super) fn of_box(patch: &BezierPatch, index: usize) -> Self {
        let (low, high) = bounds(patch.points());
        Self { low, high, inside: NodeContent::Patch(index) }
    }

    /// The smallest and largest corner.
    pub(super) fn corners(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }

    /// Builds a tree over a rectangle of nodes; `cols` is the number of nodes in a row. Some nodes
    /// may be missing; without any there is no tree.
    pub(super) fn of_rectangle(
        trees: &mut [Option<Self>],
        cols: usize,
        rows: (usize, usize),
        columns: (usize, usize),
    ) -> Option<Self> {
        let half = |(from, to): (usize, usize)| {
            let middle = usize::midpoint(from, to);
            [(from, middle), (middle, to)]
        };
        let (height, width) = (rows.1 - rows.0, columns.1 - columns.0);
        if height * width == 1 {
            return trees[rows.0 * cols + columns.0].take();
        }
        let halves = if height >= width {
            half(rows).map(|rows| Self::of_rectangle(trees, cols, rows, columns))
        } else {
            half(columns).map(|columns| Self::of_rectangle(trees, cols, rows, columns))
        };
        Self::around_any(halves)
    }

    /// The node around those of two nodes that exist.
    fn around_any(nodes: [Option<Self>; 2]) -> Option<Self> {
        match nodes {
            [Some(a), Some(b)] => Some(Self::around([a, b])),
            [a, b] => a.or(b),
        }
    }

    /// Builds the tree over the flat pieces of a patch, without those outside a region.
    pub(super) fn of_pieces(
        patch: &BezierPatch,
        index: usize,
        region: Option<&dyn ParameterRegion>,
    ) -> Option<Self> {
        Self::of_part((patch, index), patch, region, MAX_HALVINGS)
    }

    /// Builds the tree over a part of a patch, halving it until it is flat.
    fn of_part(
        (whole, index): (&BezierPatch, usize),
        part: &BezierPatch,
        region: Option<&dyn ParameterRegion>,
        halvings: usize,
    ) -> Option<Self> {
        let [low, high] = part.rectangle();
        let cover = region.map_or(Cover::Inside, |region| region.cover(low, high));
        if cover == Cover::Outside {
            return None;
        }
        // Parts of a rectangle inside need no further test.
        let region = region.filter(|_| cover == Cover::Cut);
        let piece = FlatPiece::new(whole, part, index, region.is_some());
        if piece.slack <= FLATNESS * piece.diagonal() || halvings == 0 {
            let (low, high) = bounds(part.points());
            return Some(Self { low, high, inside: NodeContent::Piece(Box::new(piece)) });
        }
        let (along_u, along_v) = lengths(part);
        let (first, second) = if along_u >= along_v { part.halves_u() } else { part.halves_v() };
        let half = |half: BezierPatch| Self::of_part((whole, index), &half, region, halvings - 1);
        Self::around_any([first, second].map(half))
    }
}

/// The lengths of the net in both directions, as means over its polygons.
fn lengths(part: &BezierPatch) -> (f64, f64) {
    let (p, q) = part.degrees();
    let along = |di: usize, dj: usize| {
        let steps = (0..=p - di).flat_map(|i| (0..=q - dj).map(move |j| (i, j)));
        let lengths = steps.map(|(i, j)| part.control(i + di, j + dj).distance(part.control(i, j)));
        lengths.sum::<f64>() / ((p + 1 - di) * (q + 1 - dj)) as f64
    };
    (along(1, 0) * p as f64, along(0, 1) * q as f64)
}

impl FlatPiece {
    /// The parallelogram of the corners of a part of a patch.
    fn new(whole: &BezierPatch, part: &BezierPatch, index: usize, is_cut: bool) -> Self {
        let (p, q) = part.degrees();
        let corners = [(0, 0), (0, q), (p, 0), (p, q)].map(|(i, j)| part.control(i, j));
        let [c00, c01, c10, c11] = corners;
        let (a, b) = ((c10 + c11 - c00 - c01) / 4.0, (c01 + c11 - c00 - c10) / 4.0);
        let center = (c00 + c01 + c10 + c11) / 4.0;
        let share = |t: f64, (from, to): (f64, f64)| (t - from) / (to - from);
        let from = DVec2::new(share(part.u.0, whole.u), share(part.v.0, whole.v));
        let to = DVec2::new(share(part.u.1, whole.u), share(part.v.1, whole.v));
        let (middle, half) = (from.midpoint(to), (to - from) / 2.0);
        let (slack, radius) = (0.0, 0.0);
        let mut piece = Self { patch: index, middle, half, center, a, b, slack, radius, is_cut };
        let distances = part.points().map(|point| piece.nearest(point).0);
        piece.slack = distances.fold(0.0, f64::max);
        let diagonal = piece.diagonal();
        piece.radius = diagonal * diagonal / (2.0 * piece.slack).max(f64::MIN_POSITIVE);
        piece
    }

    /// The longer diagonal of the parallelogram.
    fn diagonal(&self) -> f64 {
        (self.a + self.b).length().max((self.a - self.b).length())
    }

    /// Returns the distance from a point to the parallelogram, and the closest (α, β).
    pub(super) fn nearest(&self, point: DVec3) -> (f64, DVec2) {
        let (to, a, b) = (point - self.center, self.a, self.b);
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
