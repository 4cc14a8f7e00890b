//! How far a piece of the surface can lie from the triangles that stand for it.
//!
//! Over each triangle of the parameters the surface's height above the plane of the triangle is
//! at most its largest Bézier coefficient there, however unevenly the parameters run along the
//! surface. What sticks out sideways is bounded by the Bézier points of the edges' curves: beyond
//! an edge between two triangles of the same piece it costs what their planes differ there, beyond
//! any other edge it counts in full.

use glam::{DVec2, DVec3, DVec4};

use super::bernstein::{Bernstein, Blossoms};
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
    /// Heights times weights, and weights.
    heights: Vec<DVec2>,
    blossoms: Blossoms,
    coefficients: Vec<DVec2>,
    /// The part of the net between the ends of a segment, and the curve above it.
    part: Vec<DVec4>,
    curve: Vec<DVec4>,
    /// The normals of the faces, of those that have one.
    normals: Vec<Option<DVec3>>,
    /// The normals of the planes that stand for the faces.
    planes: Vec<DVec3>,
    /// The largest heights over the planes.
    overs: Vec<f64>,
}

/// A bound up to this multiple of the limit may be of a distance within it: then it is worth
/// looking closer.
const NEAR: f64 = 1.5;

/// How often a triangle is halved then.
const HALVINGS: usize = 2;

/// An upper bound of the distance between the surface over the unit square of `net` and the
/// triangles, in both directions; anything above `limit` if it is above it.
pub(super) fn distance(
    bernstein: &Bernstein,
    net: &[DVec4],
    (corners, faces): (&[Corner], &[Face]),
    limit: f64,
    work: &mut Workspace,
) -> f64 {
    work.normals.clear();
    work.normals.extend(faces.iter().map(|face| normal(face.map(|i| corners[i].point))));
    let ball = || {
        let centre = corners[0].point;
        net.iter().map(|&h| project(h).distance(centre)).fold(0.0, f64::max)
    };
    work.planes.clear();
    work.overs.clear();
    for (k, &face) in faces.iter().enumerate() {
        let Some(plane) = work.normals[k].or_else(|| borrowed(faces, &work.normals, face)) else {
            return ball();
        };
        let origin = plane.dot(corners[face[0]].point);
        work.heights.clear();
        let height = |h: &DVec4| DVec2::new(plane.dot(h.truncate()) - origin * h.w, h.w);
        work.heights.extend(net.iter().map(height));
        let over = height_over(bernstein, face.map(|i| corners[i].at), limit, work);
        if over > limit {
            return over;
        }
        work.planes.push(plane);
        work.overs.push(over);
    }
    if work.normals.windows(2).any(|pair| folded(pair[0], pair[1])) {
        return ball();
    }
    let mut most = 0.0_f64;
    for k in 0..faces.len() {
        // First the curves as they are, then, if need be, their halves.
        let mut found = beyond(bernstein, net, (corners, faces), (k, false), work);
        if found > limit {
            found = beyond(bernstein, net, (corners, faces), (k, true), work);
        }
        most = most.max(found);
        if most > limit {
            break;
        }
    }
    most
}

/// The largest distance that follows from the height over a face of the strip and from what sticks
/// out of it sideways: over another face it costs what the planes differ there, over none it is
/// added at a right angle.
fn beyond(
    bernstein: &Bernstein,
    net: &[DVec4],
    (corners, faces): (&[Corner], &[Face]),
    (k, halved): (usize, bool),
    work: &mut Workspace,
) -> f64 {
    let Workspace { normals, planes, overs, part, curve, .. } = work;
    let (mut inside, mut outside) = (0.0_f64, 0.0_f64);
    for (i, j) in edges(faces[k]) {
        let (a, b) = (corners[i], corners[j]);
        curve.clear();
        bernstein.segment(net, (a.at, b.at), part, curve);
        if halved {
            closer(curve);
        }
        let aside = sideways(curve, a.point, b.point, planes[k]);
        let shares = |other: &usize| edges(faces[*other]).contains(&(j, i));
        let beside = k.checked_sub(1).filter(shares);
        let beside = beside.or_else(|| Some(k + 1).filter(|k| *k < faces.len()).filter(shares));
        match beside.and_then(|other| normals[other]) {
            Some(other) => inside = inside.max(aside * other.distance(planes[k])),
            None => outside = outside.max(aside),
        }
    }
    right_angle(overs[k] + inside, outside)
}

/// The third side of a triangle with a right angle between these.
fn right_angle(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Whether neighbours turn away from one another too far to be a sheet.
fn folded(a: Option<DVec3>, b: Option<DVec3>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a.dot(b) < SHEET)
}

/// The largest height on a triangle of the square, from above.
fn height_over(bernstein: &Bernstein, at: [DVec2; 3], limit: f64, work: &mut Workspace) -> f64 {
    let Workspace { heights, blossoms, coefficients, .. } = work;
    // The longest side opposite to the first corner: it is the one to be cut.
    let side = |k: usize| at[(k + 1) % 3].distance_squared(at[(k + 2) % 3]);
    let first = (1..3).fold(0, |first, k| if side(k) > side(first) { k } else { first });
    let at = [0, 1, 2].map(|k| at[(first + k) % 3]);
    bernstein.triangle(heights, at, blossoms, coefficients);
    largest(coefficients, bernstein.p + bernstein.q, limit, NEAR * limit, HALVINGS)
}

/// As [`distance`], of the part of a piece that is a patch over a rectangle of the piece's square.
pub(super) fn distance_of_part(
    bernstein: &Bernstein,
    net: &[DVec4],
    (low, high): (DVec2, DVec2),
    (corners, faces): (&[Corner], &[Face]),
    limit: f64,
    work: &mut Workspace,
) -> f64 {
    let mut most = 0.0_f64;
    let mut planes: Vec<DVec3> = vec![];
    for &face in faces {
        let at = face.map(|i| corners[i].at);
        let points = face.map(|i| corners[i].point);
        if !overlap(at, low, high) {
            continue;
        }
        let Some(plane) = normal(points) else { return f64::INFINITY };
        planes.push(plane);
        let heights = net.iter().map(|&h| plane.dot(project(h) - points[0]).abs());
        let over = heights.fold(0.0, f64::max);
        if over > limit {
            return over;
        }
        let mut outside = 0.0_f64;
        for (i, j) in edges(face) {
            if faces.iter().any(|other| edges(*other).contains(&(j, i))) {
                continue;
            }
            // The part of the edge above this patch: edges of the outline run along its sides.
            let (a, b) = (corners[i], corners[j]);
            let inside = |at: DVec2| (at - low) / (high - low);
            let (from, to) = (inside(a.at), inside(b.at));
            let beside = |a: f64, b: f64| a == b && a != 0.0 && a != 1.0;
            if beside(from.x, to.x) || beside(from.y, to.y) {
                continue;
            }
            let (from, to) =
                (from.clamp(DVec2::ZERO, DVec2::ONE), to.clamp(DVec2::ZERO, DVec2::ONE));
            work.curve.clear();
            bernstein.segment(net, (from, to), &mut work.part, &mut work.curve);
            closer(&mut work.curve);
            outside = outside.max(sideways(&work.curve, a.point, b.point, plane));
        }
        most = most.max(right_angle(over, outside));
    }
    // A point above the ridge between two planes is further from it than from the planes.
    let ridge = planes.iter().map(|plane| plane.dot(planes[0])).fold(1.0, f64::min);
    if ridge < SHEET { f64::INFINITY } else { most / ridge }
}

/// Whether a triangle and a rectangle share more than a border.
fn overlap(triangle: [DVec2; 3], low: DVec2, high: DVec2) -> bool {
    let rectangle = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    let apart = |axis: DVec2| {
        let reach = |points: &[DVec2]| {
            let along = points.iter().map(|point| point.dot(axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
        };
        let (a, b) = (reach(&triangle), reach(&rectangle));
        a.1 <= b.0 || b.1 <= a.0
    };
    let sides = [0, 1, 2].map(|i| (triangle[(i + 1) % 3] - triangle[i]).perp());
    ![DVec2::X, DVec2::Y].into_iter().chain(sides).any(apart)
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

/// For a face without area (its corners lie on a pole): the normal of a face beside it.
fn borrowed(faces: &[Face], normals: &[Option<DVec3>], face: Face) -> Option<DVec3> {
    let beside = |other: &Face| edges(face).iter().any(|&(i, j)| edges(*other).contains(&(j, i)));
    let found = faces.iter().zip(normals).find(|(other, normal)| normal.is_some() && beside(other));
    found.and_then(|(_, normal)| *normal)
}

/// Replaces the control points of a curve by those of its halves, which lie closer to it.
fn closer(curve: &mut Vec<DVec4>) {
    let count = curve.len();
    curve.extend_from_within(..);
    let (first, second) = curve.split_at_mut(count);
    halve(first, second, count - 1, 1, 0..1);
}

/// How far a curve from a to b leaves the segment between them, seen along a normal.
fn sideways(curve: &[DVec4], a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let chord = b - a;
    let length = chord.length();
    let along = if length > 0.0 { chord / length } else { DVec3::ZERO };
    let across = normal.cross(along);
    let aside = |&h: &DVec4| {
        // Times the weight.
        let away = h.truncate() - h.w * a;
        let (t, s) = (away.dot(along), away.dot(across));
        let beyond = larger(larger(0.0, -t), t - h.w * length);
        let rest = if length > 0.0 { s * s } else { away.length_squared() };
        (rest + beyond * beyond) / (h.w * h.w)
    };
    curve.iter().map(aside).fold(0.0, larger).sqrt()
}

fn project(h: DVec4) -> DVec3 {
    h.truncate() / h.w
}
