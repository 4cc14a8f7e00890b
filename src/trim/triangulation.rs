//! The triangulation of places: Delaunay in the plane, then in the lengths of the surface.

use std::collections::{HashMap, VecDeque};

use glam::{DVec2, DVec3};
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

use super::places::Places;
use super::settings::TriangulationSettings;
use crate::numeric::index;

const SETTINGS: TriangulationSettings = TriangulationSettings::STANDARD;

/// No neighbor: the triangle is on the hull.
pub(super) const NONE: u32 = u32::MAX;

/// Triangles over places, counter-clockwise in (u, v).
#[derive(Clone, Debug)]
pub(super) struct Triangulation {
    /// Places of the corners.
    pub corners: Vec<[u32; 3]>,
    /// The triangle across the side opposite to each corner, or [`NONE`].
    pub neighbors: Vec<[u32; 3]>,
}

/// A place in the plane, with its index.
struct Site {
    position: Point2<f64>,
    index: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

impl Triangulation {
    /// The triangulation of places that is Delaunay in the lengths of the surface, as far as
    /// triangles stay convex in (u, v).
    ///
    /// First it is Delaunay after u and v were scaled by the mean lengths of their tangents, with
    /// exact predicates. Then sides are flipped (C. L. Lawson 1977).
    pub(super) fn of(places: &Places) -> Self {
        let closed = places.rectangle.closed;
        let mut made = if closed == [false, false] { plane(places) } else { wrapped(places) };
        made.flip(places);
        made
    }

    /// Flips sides that are not Delaunay in space. Returns their number.
    fn flip(&mut self, places: &Places) -> usize {
        let mut queue: VecDeque<(u32, usize)> =
            (0..self.corners.len()).flat_map(|t| (0..3).map(move |k| (index(t), k))).collect();
        let most = SETTINGS.max_flips * self.corners.len();
        let mut flips = 0;
        while let Some((t, k)) = queue.pop_front() {
            let o = self.neighbors[t as usize][k];
            if o == NONE || o == t {
                continue;
            }
            let Some(l) = self.neighbors[o as usize].iter().position(|n| *n == t) else { continue };
            let [a, b, c] = turned(self.corners[t as usize], k);
            let d = self.corners[o as usize][l];
            if a == d || !is_bad(places, [a, b, c, d]) {
                continue;
            }
            self.flip_side((t, k), (o, l));
            queue.extend([(t, 0), (t, 2), (o, 0), (o, 1)]);
            flips += 1;
            if flips == most {
                break;
            }
        }
        flips
    }

    /// Replaces triangles (a, b, c) and (d, c, b) by (a, b, d) and (a, d, c).
    fn flip_side(&mut self, (t, k): (u32, usize), (o, l): (u32, usize)) {
        let [a, b, c] = turned(self.corners[t as usize], k);
        let [_, beside_ca, beside_ab] = turned(self.neighbors[t as usize], k);
        let d = self.corners[o as usize][l];
        let [_, beside_bd, beside_dc] = turned(self.neighbors[o as usize], l);
        self.corners[t as usize] = [a, b, d];
        self.neighbors[t as usize] = [beside_bd, o, beside_ab];
        self.corners[o as usize] = [a, d, c];
        self.neighbors[o as usize] = [beside_dc, beside_ca, t];
        for (other, from, to) in [(beside_bd, o, t), (beside_ca, t, o)] {
            if other != NONE {
                let sides = &mut self.neighbors[other as usize];
                if let Some(side) = sides.iter_mut().find(|side| **side == from) {
                    *side = to;
                }
            }
        }
    }
}

/// Corners or neighbors of a triangle, beginning with the k-th.
fn turned<T: Copy>(of: [T; 3], k: usize) -> [T; 3] {
    [of[k], of[(k + 1) % 3], of[(k + 2) % 3]]
}

/// Whether side bc of triangles (a, b, c) and (d, c, b) should be flipped: the angles opposite to
/// it sum to over half a turn in space, and the triangles form a convex quadrangle in (u, v).
fn is_bad(places: &Places, [a, b, c, d]: [u32; 4]) -> bool {
    let at = |i: u32| places.points[i as usize];
    let sides = |x: u32| (at(b) - at(x), at(c) - at(x));
    let ((p, q), (r, s)) = (sides(a), sides(d));
    let sine = p.cross(q).length() * r.dot(s) + p.dot(q) * r.cross(s).length();
    let size = p.length() * q.length() * r.length() * s.length();
    if sine >= -SETTINGS.angle * size {
        return false;
    }
    let uv =
        |i: u32| places.rectangle.way(places.uv[a as usize], places.uv[i as usize]) * places.scale;
    let (b, c, d) = (uv(b), uv(c), uv(d));
    let size = b.perp_dot(c).abs() + (b - d).perp_dot(c - d).abs();
    let least = SETTINGS.convexity * size;
    b.perp_dot(d) > least && d.perp_dot(c) > least
}

/// The Delaunay triangulation in the plane of scaled parameters.
fn plane(places: &Places) -> Triangulation {
    let low = places.rectangle.low;
    let sites = places.uv.iter().enumerate();
    let sites = sites
        .map(|(k, at)| Site { position: position((at - low) * places.scale), index: index(k) });
    let triangles = triangles(sites.collect());
    let mut made = Triangulation { corners: vec![], neighbors: vec![] };
    for (corners, neighbors) in triangles {
        made.corners.push(corners);
        made.neighbors.push(neighbors);
    }
    made
}

/// A point for the triangulator, which refuses tiny coordinates.
fn position(at: DVec2) -> Point2<f64> {
    let coordinate = |x: f64| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x };
    Point2::new(coordinate(at.x), coordinate(at.y))
}

/// The corners and neighbors of the Delaunay triangles of sites.
fn triangles(sites: Vec<Site>) -> Vec<([u32; 3], [u32; 3])> {
    let Ok(made) = DelaunayTriangulation::<Site>::bulk_load(sites) else { return vec![] };
    // Inner faces are numbered from 1 on.
    let triangle =
        |face: spade::handles::FaceHandle<'_, spade::handles::PossiblyOuterTag, _, _, _, _>| {
            face.as_inner().map_or(NONE, |face| index(face.fix().index() - 1))
        };
    let face =
        |face: spade::handles::FaceHandle<'_, spade::handles::InnerTag, Site, (), (), ()>| {
            let sides = face.adjacent_edges();
            let neighbor = |k: usize| triangle(sides[k].rev().face());
            let corners = sides.map(|side| side.from().data().index);
            (corners, [neighbor(1), neighbor(2), neighbor(0)])
        };
    made.inner_faces().map(face).collect()
}

/// The Delaunay triangulation of places on a rectangle of which directions close.
///
/// A strip beside each seam is copied to the other side. The triangles whose middles lie in the
/// rectangle remain, but for those that are too large to be sure of. Places are moved by a small
/// share of their distances: of places on one circle, as grids have, the copies would be
/// triangulated in other ways.
fn wrapped(places: &Places) -> Triangulation {
    let rectangle = places.rectangle;
    let size = rectangle.size() * places.scale;
    let distance = (size.element_product() / places.len() as f64).sqrt();
    let mut sites: Vec<(DVec2, u32)> = places
        .uv
        .iter()
        .enumerate()
        .map(|(k, at)| {
            let moved = SETTINGS.jitter * distance * DVec2::from_angle(k as f64);
            ((at - rectangle.low) * places.scale + moved, index(k))
        })
        .collect();
    for d in 0..2 {
        if !rectangle.closed[d] {
            continue;
        }
        let strip = (SETTINGS.strip * distance).min(0.5 * size[d]);
        let mut axis = DVec2::ZERO;
        axis[d] = size[d];
        let copies: Vec<(DVec2, u32)> = sites
            .iter()
            .flat_map(|&(at, k)| {
                let after = (at[d] < strip).then_some((at + axis, k));
                let before = (at[d] > size[d] - strip).then_some((at - axis, k));
                [after, before]
            })
            .flatten()
            .collect();
        sites.extend(copies);
    }
    let moved: Vec<Site> = sites
        .iter()
        .enumerate()
        .map(|(k, (at, _))| Site { position: position(*at), index: index(k) })
        .collect();
    // Larger circles may reach beyond the strips, where places are missing.
    let widest = 0.5 * (SETTINGS.strip * distance).min(0.5 * closed_size(size, rectangle.closed));
    let inside = |corners: &[u32; 3]| {
        let at = corners.map(|k| sites[k as usize].0);
        let middle = at.iter().sum::<DVec2>() / 3.0;
        let own = (0..2).all(|d| !rectangle.closed[d] || (0.0..size[d]).contains(&middle[d]));
        own && circumradius(at.map(|at| at.extend(0.0))) < widest
    };
    let kept = triangles(moved).into_iter().map(|(corners, _)| corners).filter(inside);
    let corners: Vec<[u32; 3]> = kept.map(|corners| corners.map(|k| sites[k as usize].1)).collect();
    let neighbors = joined(&corners);
    Triangulation { corners, neighbors }
}

/// The smaller size of the closed directions.
fn closed_size(size: DVec2, closed: [bool; 2]) -> f64 {
    let sizes = (0..2).filter(|d| closed[*d]).map(|d| size[d]);
    sizes.fold(f64::INFINITY, f64::min)
}

/// The neighbors of triangles with these corners.
fn joined(corners: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let side = |t: usize, k: usize| {
        let [_, b, c] = turned(corners[t], k);
        (b, c)
    };
    let mut sides = HashMap::with_capacity(3 * corners.len());
    for t in 0..corners.len() {
        for k in 0..3 {
            sides.insert(side(t, k), index(t));
        }
    }
    let neighbor = |t: usize, k: usize| {
        let (b, c) = side(t, k);
        sides.get(&(c, b)).copied().unwrap_or(NONE)
    };
    (0..corners.len()).map(|t| [0, 1, 2].map(|k| neighbor(t, k))).collect()
}

/// The radius of the circle through three points; infinite if they are collinear.
pub(super) fn circumradius([a, b, c]: [DVec3; 3]) -> f64 {
    let (p, q) = (b - a, c - a);
    let radius = p.length() * q.length() * (p - q).length() / (2.0 * p.cross(q).length());
    if radius.is_finite() { radius } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::nurbs::NurbsSurface;
    use crate::progress::Silent;

    /// Scattered places on a surface.
    fn places(surface: NurbsSurface, count: u32) -> Places {
        let share = |k: u32, step: f64| (f64::from(k) * step).fract();
        let uv: Vec<DVec2> =
            (0..count).map(|k| DVec2::new(share(k, 0.754_877_7), share(k, 0.569_840_3))).collect();
        Places::of(&Arc::new(surface), &uv, &mut Silent).unwrap()
    }

    /// Neighbors know each other, and triangles are counter-clockwise in (u, v).
    fn check(made: &Triangulation, places: &Places) {
        for (t, neighbors) in made.neighbors.iter().enumerate() {
            let [a, b, c] = made.corners[t].map(|k| places.uv[k as usize]);
            let way = |to| places.rectangle.way(a, to) * places.scale;
            assert!(way(b).perp_dot(way(c)) > 0.0);
            for (k, other) in neighbors.iter().enumerate().filter(|(_, other)| **other != NONE) {
                let [_, b, c] = turned(made.corners[t], k);
                let back = made.neighbors[*other as usize].iter().position(|n| *n == index(t));
                let [_, c2, b2] = turned(made.corners[*other as usize], back.unwrap());
                assert_eq!((b, c), (b2, c2));
            }
        }
    }

    #[test]
    fn sheared_planes_are_triangulated_in_their_lengths() {
        let sheared = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::new(3.0, 1.0, 0.0));
        let places = places(sheared.unwrap(), 500);
        let mut made = plane(&places);
        check(&made, &places);
        let flips = made.flip(&places);
        check(&made, &places);
        assert!(flips > 100, "{flips}");
        // But for triangles on the hull, which would turn over in (u, v), all are Delaunay.
        assert_eq!(made.flip(&places), 0);
        let hull = made.neighbors.iter().flatten().filter(|other| **other == NONE).count();
        assert_eq!(made.corners.len() + hull + 2, 2 * places.len());
    }

    #[test]
    fn tori_have_no_hull() {
        let torus = NurbsSurface::torus(DVec3::ZERO, 1.0, 0.4).unwrap();
        let places = places(torus, 600);
        let made = Triangulation::of(&places);
        check(&made, &places);
        assert!(made.neighbors.iter().flatten().all(|other| *other != NONE));
        // Euler: V - E + F = 0 and 3 F = 2 E.
        assert_eq!(made.corners.len(), 2 * places.len());
    }

    #[test]
    fn grids_on_tubes_close() {
        let tube = NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 0.3).unwrap();
        let at = |k: i32| DVec2::new(f64::from(k % 24) / 24.0, f64::from(k / 24) / 10.0);
        let uv: Vec<DVec2> = (0..264).map(at).collect();
        let places = Places::of(&Arc::new(tube), &uv, &mut Silent).unwrap();
        let made = Triangulation::of(&places);
        check(&made, &places);
        assert_eq!(made.corners.len(), 2 * 24 * 10);
    }
}
