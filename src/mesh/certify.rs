//! How far a piece of the surface can lie from the triangles that stand for it.
//!
//! Over each triangle of the parameters, what a point of the surface costs (see [`Frame::cost`]) is at
//! most what the costliest Bézier point there costs, however unevenly the parameters run along the
//! surface: no point is further from the triangles. Nor are points of the triangles further from
//! the surface: seen along a triangle's normal, the surface covers what its sides do not pass over
//! on their way to the outer edges, and they are no further from these.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::{DVec2, DVec3, DVec4};
use pulp::{Simd, WithSimd};

use super::bernstein::{Bernstein, Blossoms, quarters};
use super::chord::Chord;
use super::cost::{Eight, Octet, costliest, price, quotient};
use super::frame::Frame;
use super::net::Net;
use super::polygon::{Polygon, contains, misses};
use super::triangle::{Doubt, larger, largest};

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
    blossoms: Blossoms,
    coefficients: Vec<Octet>,
    /// What they cost at most, as numbers to be divided.
    bounds: Vec<[Eight; 2]>,
    /// The faces of which a part's net leaves doubt.
    doubtful: Vec<usize>,
    /// One of a part's patches.
    patch: Vec<DVec4>,
    /// What its points cost a face (see [`price`]).
    prices: Vec<DVec4>,
    /// The curve above a side, or the quarters of a patch.
    curve: Vec<DVec4>,
    /// The frames of the faces.
    frames: Vec<Frame>,
    normals: Vec<Option<DVec3>>,
    /// The largest certified distance so far.
    most: f64,
}

/// A bound up to this multiple of the limit may be of a distance within it: then it is worth
/// looking closer.
const NEAR: f64 = 1.5;

/// Patches of a part from which on its whole net is looked at first: that of fewer hardly ever tells more
/// than they do by themselves.
const MANY: usize = 4;

/// How often a triangle is halved then.
const HALVINGS: usize = 2;

/// The surface over a rectangle of a piece's unit square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    pub low: DVec2,
    pub high: DVec2,
    pub net: Net<'a>,
}

impl<'a> Part<'a> {
    /// All of a piece.
    pub(super) fn whole(net: Net<'a>) -> Self {
        Self { low: DVec2::ZERO, high: DVec2::ONE, net }
    }

    /// Whether it is all of the piece.
    pub(super) fn is_whole(&self) -> bool {
        (self.low, self.high) == (DVec2::ZERO, DVec2::ONE)
    }

    /// What it has of a segment on a side of the piece, in its own unit square.
    #[inline(always)]
    fn clip(&self, (a, b): (DVec2, DVec2)) -> Option<(DVec2, DVec2)> {
        let (from, to) = (a.min(b).max(self.low), a.max(b).min(self.high));
        let inside = |at: DVec2| (at - self.low) / (self.high - self.low);
        (from.cmple(to).all() && from != to).then(|| (inside(from), inside(to)))
    }
}

/// The triangles of a piece.
pub(super) type Faces<'a> = (&'a [Corner], &'a [Face]);

/// An upper bound of the distance between the surface over the unit square of `net` and triangles that
/// are no sheet, in both directions: all are in this ball around the first corner.
pub(super) fn ball(net: Net<'_>, (corners, _): Faces<'_>) -> f64 {
    let centre = corners[0].point;
    net.points.iter().map(|h| h.project().distance(centre)).fold(0.0, f64::max)
}

impl Workspace {
    /// Prepares for triangles, of which no part has been seen; whether they are a sheet.
    #[inline(always)]
    pub(super) fn begin(&mut self, (corners, faces): Faces<'_>) -> bool {
        let Self { frames, normals, most, .. } = self;
        *most = 0.0;
        frames.clear();
        normals.clear();
        for &[a, b, c] in faces {
            normals.push(normal(corners[a].point, corners[b].point, corners[c].point));
        }
        !normals.windows(2).any(|pair| folded(pair[0], pair[1]))
            && (0..faces.len()).all(|k| self.plane(k).is_some())
    }

    /// The normal of the plane that stands for a face: of one without area (its corners lie on a
    /// pole), that of a face beside it.
    #[inline(always)]
    fn plane(&self, k: usize) -> Option<DVec3> {
        let beside = || self.normals[k.saturating_sub(1)].or_else(|| *self.normals.get(k + 1)?);
        self.normals[k].or_else(beside)
    }

    /// Whether one of these points of the surface, which lie at these places in the unit square, is
    /// further than `limit` from the plane of the face that it lies over.
    pub(super) fn misses(
        &self,
        (points, places): (&[DVec4], &[DVec2]),
        (corners, faces): Faces<'_>,
        limit: f64,
    ) -> bool {
        faces.iter().zip(&self.normals).any(|(face, normal)| {
            let (Some(normal), triangle) = (normal, face.map(|corner| corners[corner])) else {
                return false;
            };
            let (origin, at) = (normal.dot(triangle[0].point), triangle.map(|corner| corner.at));
            points.iter().zip(places).any(|(point, place)| {
                (normal.extend(0.0).dot(*point) - origin).abs() > limit && contains(at, *place)
            })
        })
    }

    #[inline(always)]
    fn place_frames(&mut self, (corners, faces): Faces<'_>) {
        for (k, &face) in faces.iter().enumerate() {
            let Some(normal) = self.plane(k) else { continue };
            let points = face.map(|corner| corners[corner].point);
            let mut next = [None; 3];
            if k > 0 {
                next[LAST] = self.normals[k - 1];
            }
            if let Some(edge) = to_next(faces, k) {
                next[edge] = self.normals[k + 1];
            }
            self.frames.push(Frame::new(points, normal, next));
        }
    }

    /// What finds an upper bound of the distance between a part of the surface, and those before it,
    /// and the triangles, in both directions; anything above `limit` if it is above it.
    #[inline(always)]
    pub(super) fn certify<'a>(
        &'a mut self,
        bernstein: &'a Bernstein,
        part: Part<'a>,
        mesh: Faces<'a>,
        limit: f64,
    ) -> Certify<'a> {
        if self.frames.is_empty() {
            self.place_frames(mesh);
        }
        Certify { work: self, bernstein, part, mesh, limit }
    }
}

/// What certifying a part of a piece needs to know.
pub(super) struct Certify<'a> {
    work: &'a mut Workspace,
    bernstein: &'a Bernstein,
    part: Part<'a>,
    mesh: Faces<'a>,
    limit: f64,
}

impl Certify<'_> {
    /// Takes what the surface over each face costs into account.
    #[inline(always)]
    fn look_at_faces<S: Simd>(&mut self, simd: S) {
        if self.part.is_whole() && self.part.net.is_single() {
            self.look_at_patch(simd);
        } else {
            self.look_at_patches(simd);
        }
    }

    /// Takes into account what the only patch costs over each face.
    #[inline(always)]
    fn look_at_patch<S: Simd>(&mut self, simd: S) {
        let Self { work, bernstein, part, mesh: (corners, faces), limit } = self;
        let Workspace { blossoms, coefficients, frames, most, .. } = &mut **work;
        let (net, limit) = (part.net.points, *limit);
        for (face, frame) in faces.iter().zip(&*frames) {
            // The whole net may tell that the surface is near enough.
            let mut found = costliest(simd, frame, net, limit);
            if found > limit {
                let at = longest_first(face.map(|corner| corners[corner].at));
                let over = Over { bernstein, net, at, frame };
                found = over.costs(simd, limit, blossoms, coefficients);
            }
            *most = larger(*most, found);
            if *most > limit {
                return;
            }
        }
    }

    /// The same where there are several patches, or the only one is not all of the piece.
    #[inline(always)]
    fn look_at_patches<S: Simd>(&mut self, simd: S) {
        let Self { work, bernstein, part, mesh: (corners, faces), limit } = self;
        let Workspace {
            blossoms,
            coefficients,
            bounds,
            doubtful,
            patch,
            prices,
            curve,
            frames,
            most,
            ..
        } = &mut **work;
        let limit = *limit;
        let many = part.net.patches.0 * part.net.patches.1 >= MANY;
        doubtful.clear();
        for (k, (face, frame)) in faces.iter().zip(&*frames).enumerate() {
            if misses(face.map(|corner| corners[corner].at), part.low, part.high) {
                continue;
            }
            // The whole net may tell that the surface is near enough.
            let found =
                if many { costliest(simd, frame, part.net.points, limit) } else { f64::INFINITY };
            if found <= limit {
                *most = larger(*most, found);
            } else {
                doubtful.push(k);
            }
        }
        if doubtful.is_empty() {
            return;
        }
        bounds.resize(bernstein.octets(), [Eight::default(); 2]);
        prices.resize((bernstein.p + 1) * (bernstein.q + 1), DVec4::ZERO);
        for (at, (low, high)) in part.net.places((part.low, part.high)) {
            let net = part.net.patch(at, patch);
            for &k in &*doubtful {
                let (frame, triangle) = (&frames[k], faces[k].map(|corner| corners[corner].at));
                if misses(triangle, low, high) {
                    continue;
                }
                let found = price(simd, frame, net, prices);
                if found <= limit {
                    *most = larger(*most, found);
                    continue;
                }
                let mut polygon = Polygon::of(triangle);
                polygon.clip(low, high);
                polygon.stretch(low, high);
                let at = polygon.corners();
                if at.len() < 3 {
                    continue;
                }
                // Points of the surface may tell that it is not.
                for end in at.iter().filter_map(|&at| bernstein.end(at)) {
                    *most = larger(*most, prices[end].z);
                }
                if *most > limit {
                    return;
                }
                if at.len() == 4 && at.iter().all(|&at| bernstein.end(at).is_some()) {
                    // All of the patch lies over the face.
                    quarters(net, (bernstein.p, bernstein.q), curve);
                    *most = larger(*most, costliest(simd, frame, curve, limit));
                    if *most > limit {
                        return;
                    }
                    continue;
                }
                // A mean of points costs no more than the mean of what they cost: first those of a
                // rectangle around the polygon, then those of its triangles.
                let from = at.iter().copied().fold(DVec2::ONE, DVec2::min);
                let to = at.iter().copied().fold(DVec2::ZERO, DVec2::max);
                if (from, to) != (DVec2::ZERO, DVec2::ONE) {
                    curve.clear();
                    curve.extend_from_slice(prices);
                    bernstein.rectangle(curve, bernstein.q + 1, (from.x, to.x), (from.y, to.y));
                    let found = dearest_mean(curve);
                    if found <= limit {
                        *most = larger(*most, found);
                        continue;
                    }
                }
                for i in 2..at.len() {
                    let at = longest_first([at[0], at[i - 1], at[i]]);
                    bernstein.triangle(simd, prices, at, blossoms, bounds);
                    let mut found = quotient(simd, bounds);
                    if found > limit {
                        let over = Over { bernstein, net, at, frame };
                        found = over.costs(simd, limit, blossoms, coefficients);
                    }
                    *most = larger(*most, found);
                    if *most > limit {
                        return;
                    }
                }
            }
        }
    }

    /// Takes the distance of a part's sides from the edges of the outline into account.
    #[inline(always)]
    fn follow_sides(&mut self) {
        let Self { work, part, mesh: (corners, _), limit, .. } = self;
        let (whole, limit, mut most) = (part.is_whole(), *limit * *limit, 0.0);
        let mut a = corners[corners.len() - 1];
        for &b in *corners {
            let side = (a.at, b.at);
            if let Some(ends) = if whole { Some(side) } else { part.clip(side) } {
                let chord = Chord::new(a.point, b.point);
                most = larger(most, chord.furthest(part, ends, &mut work.curve, limit));
            }
            a = b;
        }
        work.most = larger(work.most, most.sqrt());
    }
}

/// A patch over a triangle of its square.
struct Over<'a> {
    bernstein: &'a Bernstein,
    net: &'a [DVec4],
    at: [DVec2; 3],
    frame: &'a Frame,
}

impl Over<'_> {
    /// What it costs at most, or anything above the limit if it is above it.
    #[inline(always)]
    fn costs<S: Simd>(
        &self,
        simd: S,
        limit: f64,
        blossoms: &mut Blossoms,
        coefficients: &mut Vec<Octet>,
    ) -> f64 {
        let Self { bernstein, net, at, frame } = *self;
        coefficients.resize((HALVINGS + 1) * bernstein.octets(), [Eight::default(); 4]);
        bernstein.triangle(simd, net, at, blossoms, coefficients);
        let doubt = Doubt { limit, near: NEAR * limit, halvings: HALVINGS };
        largest(simd, coefficients, &bernstein.cuts, doubt, frame)
    }
}

impl WithSimd for Certify<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> f64 {
        self.look_at_faces(simd);
        let Part { low, high, .. } = self.part;
        let inside = low.x > 0.0 && low.y > 0.0 && high.x < 1.0 && high.y < 1.0;
        if self.work.most <= self.limit && !inside {
            self.follow_sides();
        }
        self.work.most
    }
}

/// The largest of what means of points cost at most.
#[inline(always)]
fn dearest_mean(prices: &[DVec4]) -> f64 {
    prices.iter().fold(0.0, |most, price| larger(most, price.x / price.y))
}

/// The edge of a face that the one before it, among those of a [`Zip`](super::outline::Zip), shares.
const LAST: usize = 2;

/// The edge of a face that the next one shares: it begins at the first corner of that one.
#[inline(always)]
fn to_next(faces: &[Face], k: usize) -> Option<usize> {
    let next = faces.get(k + 1)?;
    Some(usize::from(next[0] != faces[k][0]))
}

/// Whether neighbours turn away from one another too far to be a sheet.
#[inline(always)]
fn folded(a: Option<DVec3>, b: Option<DVec3>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a.dot(b) < SHEET)
}

/// The normal of a triangle, if it has one.
#[inline(always)]
fn normal(a: DVec3, b: DVec3, c: DVec3) -> Option<DVec3> {
    let longest = (b - a).length_squared().max((c - a).length_squared());
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    (length > NO_AREA * longest).then(|| cross / length)
}

/// A triangle's corners in their order, the first of which is opposite to the longest side: that is
/// the one to be cut.
#[inline(always)]
fn longest_first(at: [DVec2; 3]) -> [DVec2; 3] {
    let side = |k: usize| at[(k + 1) % 3].distance_squared(at[(k + 2) % 3]);
    let first = (1..3).fold(0, |first, k| if side(k) > side(first) { k } else { first });
    [at[first], at[(first + 1) % 3], at[(first + 2) % 3]]
}
