//! How far a piece of the surface can lie from the triangles that stand for it.
//!
//! Over each triangle of the parameters, what a point of the surface costs (see [`Frame::cost`]) is at
//! most what the costliest Bézier point there costs, however unevenly the parameters run along the
//! surface: no point is further from the triangles. Nor are points of the triangles further from
//! the surface: seen along a triangle's normal, the surface covers what its sides do not pass over
//! on their way to the outer edges, and they are no further from these.

use glam::{DVec2, DVec3, DVec4};

use super::bernstein::{Bernstein, Blossoms};
use super::frame::Frame;
use super::polygon::{Polygon, clip};
use super::triangle::{larger, largest};
use crate::nurbs::halve;

/// Cosine of the largest angle between neighbouring triangles of one piece that count as a sheet;
/// pieces that fold more must be small enough for a ball of the tolerance.
const SHEET: f64 = 0.5;

/// Share of the square of its longest edge under which a triangle's area counts as none.
const NO_AREA: f64 = 1e-12;

/// A vertex of a piece's outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Its place in the unit square of the piece.
    pub at: DVec2,
    pub point: DVec3,
}

/// Three corners of an outline, counter-clockwise.
pub(super) type Face = [usize; 3];

/// Memory that certifying needs.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// The net of a part in the frame of a face.
    framed: Vec<DVec4>,
    blossoms: Blossoms,
    coefficients: Vec<DVec4>,
    /// The part of the net between the ends of a segment, and the curve above it.
    part: Vec<DVec4>,
    curve: Vec<DVec4>,
    /// The normals of the faces, of those that have one.
    normals: Vec<Option<DVec3>>,
    /// The largest certified distance so far.
    most: f64,
}

/// A bound up to this multiple of the limit may be of a distance within it: then it is worth
/// looking closer.
const NEAR: f64 = 1.5;

/// How often a triangle is halved then.
const HALVINGS: usize = 2;

/// The surface over a rectangle of a piece's unit square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    pub low: DVec2,
    pub high: DVec2,
    pub net: &'a [DVec4],
}

impl Part<'_> {
    /// The place in the unit square of the part.
    fn inside(&self, at: DVec2) -> DVec2 {
        (at - self.low) / (self.high - self.low)
    }
}

/// The triangles of a piece.
pub(super) type Faces<'a> = (&'a [Corner], &'a [Face]);

/// An upper bound of the distance between the surface over the unit square of `net` and the
/// triangles, in both directions; anything above `limit` if it is above it.
pub(super) fn distance(
    bernstein: &Bernstein,
    net: &[DVec4],
    mesh: Faces<'_>,
    limit: f64,
    work: &mut Workspace,
) -> f64 {
    if !work.begin(mesh) {
        let centre = mesh.0[0].point;
        return net.iter().map(|h| h.project().distance(centre)).fold(0.0, f64::max);
    }
    work.certify(bernstein, Part { low: DVec2::ZERO, high: DVec2::ONE, net }, mesh, limit)
}

impl Workspace {
    /// Prepares for triangles, of which no part has been seen; whether they are a sheet.
    pub(super) fn begin(&mut self, (corners, faces): Faces<'_>) -> bool {
        self.most = 0.0;
        self.normals.clear();
        self.normals.extend(faces.iter().map(|face| normal(face.map(|i| corners[i].point))));
        let fold = |pair: &[Option<DVec3>]| folded(pair[0], pair[1]);
        !self.normals.windows(2).any(fold)
            && (0..faces.len()).all(|k| plane(faces, &self.normals, k).is_some())
    }

    /// The largest distance of a part, and of those before it; anything above `limit` if it is above
    /// it.
    pub(super) fn certify(
        &mut self,
        bernstein: &Bernstein,
        part: Part<'_>,
        mesh: Faces<'_>,
        limit: f64,
    ) -> f64 {
        let (corners, faces) = mesh;
        let whole = (part.low, part.high) == (DVec2::ZERO, DVec2::ONE);
        for (k, face) in faces.iter().enumerate() {
            let Some(plane) = plane(faces, &self.normals, k) else { continue };
            let mut polygon = Polygon::of(face.map(|i| corners[i].at));
            if !whole {
                polygon.clip(part.low, part.high);
                polygon.stretch(part.low, part.high);
            }
            let at = polygon.corners();
            if at.len() < 3 {
                continue;
            }
            let next = |edge| beside(faces, k, edge).and_then(|other| self.normals[other]);
            let next = edges(*face).map(next);
            let frame = Frame::new(face.map(|i| corners[i].point), plane, next);
            self.framed.clear();
            self.framed.extend(part.net.iter().map(|&h| frame.coordinates(h)));
            if !whole {
                // Points of the surface may tell that it is too far, the whole net that it is not.
                let ends = at.iter().filter_map(|&at| bernstein.end(at));
                let found = ends.map(|end| frame.cost(&self.framed[end])).fold(0.0, larger);
                if found > limit {
                    return found;
                }
                let found = self.framed.iter().map(|h| frame.cost(h)).fold(0.0, larger);
                if found <= limit {
                    self.most = larger(self.most, found);
                    continue;
                }
            }
            for i in 2..at.len() {
                let found = self.largest_over(bernstein, &frame, [at[0], at[i - 1], at[i]], limit);
                self.most = larger(self.most, found);
                if self.most > limit {
                    return self.most;
                }
            }
        }
        self.follow_sides(bernstein, part, mesh, limit);
        self.most
    }

    /// The largest cost of the points above a triangle of the square, from above.
    fn largest_over(
        &mut self,
        bernstein: &Bernstein,
        frame: &Frame,
        at: [DVec2; 3],
        limit: f64,
    ) -> f64 {
        let Self { framed, blossoms, coefficients, .. } = self;
        // The longest side opposite to the first corner: it is the one to be cut.
        let side = |k: usize| at[(k + 1) % 3].distance_squared(at[(k + 2) % 3]);
        let first = (1..3).fold(0, |first, k| if side(k) > side(first) { k } else { first });
        let at = [0, 1, 2].map(|k| at[(first + k) % 3]);
        bernstein.triangle(framed, at, blossoms, coefficients);
        let (degree, cost) = (bernstein.p + bernstein.q, |h: &DVec4| frame.cost(h));
        largest(coefficients, degree, (limit, NEAR * limit), HALVINGS, &cost)
    }

    /// Takes the distance of a part's sides from the outer edges into account.
    fn follow_sides(
        &mut self,
        bernstein: &Bernstein,
        part: Part<'_>,
        (corners, faces): Faces<'_>,
        limit: f64,
    ) {
        for (k, &face) in faces.iter().enumerate() {
            for (i, j) in edges(face) {
                if beside(faces, k, (i, j)).is_some() {
                    continue;
                }
                let (a, b) = (corners[i], corners[j]);
                let Some((from, to)) = clip((a.at, b.at), part.low, part.high) else { continue };
                let ends = (part.inside(from), part.inside(to));
                self.curve.clear();
                bernstein.segment(part.net, ends, &mut self.part, &mut self.curve);
                let mut found = away(&self.curve, a.point, b.point);
                if found > limit {
                    closer(&mut self.curve);
                    found = away(&self.curve, a.point, b.point);
                }
                self.most = larger(self.most, found);
            }
        }
    }
}

/// The face beside an edge of a face of a strip, in which neighbours follow one another.
fn beside(faces: &[Face], k: usize, (i, j): (usize, usize)) -> Option<usize> {
    let shares = |other: &usize| edges(faces[*other]).contains(&(j, i));
    let before = k.checked_sub(1).filter(shares);
    before.or_else(|| Some(k + 1).filter(|k| *k < faces.len()).filter(shares))
}

/// Whether neighbours turn away from one another too far to be a sheet.
fn folded(a: Option<DVec3>, b: Option<DVec3>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a.dot(b) < SHEET)
}

/// The directed edges of a face.
fn edges([a, b, c]: Face) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

/// The normal of a triangle, if it has one.
fn normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let longest = (b - a).length_squared().max((c - a).length_squared());
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    (length > NO_AREA * longest).then(|| cross / length)
}

/// The normal of the plane that stands for a face: of one without area (its corners lie on a pole),
/// that of a face beside it.
fn plane(faces: &[Face], normals: &[Option<DVec3>], k: usize) -> Option<DVec3> {
    normals[k]
        .or_else(|| edges(faces[k]).into_iter().find_map(|edge| normals[beside(faces, k, edge)?]))
}

/// Replaces the control points of a curve by those of its halves, which lie closer to it.
fn closer(curve: &mut Vec<DVec4>) {
    let count = curve.len();
    curve.extend_from_within(..);
    let (first, second) = curve.split_at_mut(count);
    halve(first, second, count - 1, 1, 0..1);
}

/// How far a curve leaves the segment between a and b.
fn away(curve: &[DVec4], a: DVec3, b: DVec3) -> f64 {
    let chord = b - a;
    let most = 1.0 / chord.length_squared().max(f64::MIN_POSITIVE);
    let distance = |&h: &DVec4| {
        let away = h.project() - a;
        let share = (away.dot(chord) * most).clamp(0.0, 1.0);
        (away - share * chord).length_squared()
    };
    curve.iter().map(distance).fold(0.0, larger).sqrt()
}
