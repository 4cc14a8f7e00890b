//! Certified upper bounds of the distance between a cell's surface and its triangles.
//!
//! Over each triangle of the parameters, the bound of a surface point (see [`FaceFrame`]) is at
//! most the largest bound of the Bézier points there. So no surface point is farther from the
//! triangles, whatever the parametrization. No point of the triangles is farther from the surface,
//! either. Seen along a triangle's normal, the surface covers the triangle except where its sides
//! pass over. These sides stay within the same bound of the outer edges.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec2, DVec3, DVec4};
use pulp::{Simd, WithSimd};

use super::cell_mesh::{CellMesh, Face};
use super::chord::Chord;
use super::distance_bound::max_bound;
use super::face_frame::FaceFrame;
use super::lanes::larger;
use super::net::Net;
use super::patch_bound::{PatchBound, Scratch};
use super::polygon::{contains, disjoint};
use super::surface_part::SurfacePart;
use super::triangle_conversion::TriangleConversion;

/// Cosine of the largest angle between neighboring triangles of a cell.
///
/// The bounds hold only for flatter meshes; cells that fold more are bounded by a ball.
const MIN_FOLD_COSINE: f64 = 0.5;

/// Area of a triangle below which it has no normal, relative to the square of its longest edge.
const MIN_RELATIVE_AREA: f64 = 1e-12;

/// Patches of a part from which on its whole net is bounded first; for fewer this seldom saves
/// work.
const MIN_PATCHES_FOR_NET_BOUND: usize = 4;

/// The edge of a face that it shares with the face before it in its triangulation.
const EDGE_TO_PREVIOUS: usize = 2;

/// The frames of a cell's triangles, the distance bound so far, and scratch memory.
#[derive(Debug, Default)]
pub(super) struct Certifier {
    scratch: Scratch,
    /// The faces for which the part's whole net is not close enough.
    doubtful: Vec<usize>,
    /// The net of one patch of a part.
    patch: Vec<DVec4>,
    /// The frames of the faces.
    frames: Vec<FaceFrame>,
    /// The normals of the faces; `None` for faces without area.
    normals: Vec<Option<DVec3>>,
    /// The largest bound of the parts so far.
    bound: f64,
}

/// An upper bound of the distance between a net's surface and triangles, in both directions.
///
/// It holds for all triangles: the radius of a ball around the first corner that contains the net.
pub(super) fn ball_bound(net: Net<'_>, (corners, _): CellMesh<'_>) -> f64 {
    let center = corners[0].point;
    net.points.iter().map(|h| h.project().distance(center)).fold(0.0, f64::max)
}

impl Certifier {
    /// Starts with new triangles; returns whether they are flat enough for the bounds to hold.
    #[inline(always)]
    pub(super) fn start(&mut self, (corners, faces): CellMesh<'_>) -> bool {
        let Self { frames, normals, bound, .. } = self;
        *bound = 0.0;
        frames.clear();
        normals.clear();
        for &[a, b, c] in faces {
            normals.push(normal(corners[a].point, corners[b].point, corners[c].point));
        }
        !normals.windows(2).any(|pair| folded(pair[0], pair[1]))
            && (0..faces.len()).all(|k| self.plane_normal(k).is_some())
    }

    /// The normal of a face; of a neighbor if the face has no area (corners at the same pole).
    #[inline(always)]
    fn plane_normal(&self, k: usize) -> Option<DVec3> {
        let neighbor = || self.normals[k.saturating_sub(1)].or_else(|| *self.normals.get(k + 1)?);
        self.normals[k].or_else(neighbor)
    }

    /// Whether one of some surface points is farther than `limit` from the plane of its face.
    ///
    /// `uv` are the parameters of the points in the unit square of the cell.
    pub(super) fn exceeds(
        &self,
        (points, uv): (&[DVec4], &[DVec2]),
        (corners, faces): CellMesh<'_>,
        limit: f64,
    ) -> bool {
        faces.iter().zip(&self.normals).any(|(face, normal)| {
            let (Some(normal), triangle) = (normal, face.map(|corner| corners[corner])) else {
                return false;
            };
            let (origin, at) = (normal.dot(triangle[0].point), triangle.map(|corner| corner.at));
            points.iter().zip(uv).any(|(point, uv)| {
                (normal.extend(0.0).dot(*point) - origin).abs() > limit && contains(at, *uv)
            })
        })
    }

    #[inline(always)]
    fn set_frames(&mut self, (corners, faces): CellMesh<'_>) {
        for (k, &face) in faces.iter().enumerate() {
            let Some(normal) = self.plane_normal(k) else { continue };
            let points = face.map(|corner| corners[corner].point);
            let mut neighbors = [None; 3];
            if k > 0 {
                neighbors[EDGE_TO_PREVIOUS] = self.normals[k - 1];
            }
            if let Some(edge) = edge_to_next(faces, k) {
                neighbors[edge] = self.normals[k + 1];
            }
            self.frames.push(FaceFrame::new(points, normal, neighbors));
        }
    }

    /// The computation of the bound for a part of the surface and all parts before it.
    ///
    /// Its result is an upper bound of the distance in both directions. A result above `limit` means
    /// only that the limit could not be certified.
    #[inline(always)]
    pub(super) fn certify<'a>(
        &'a mut self,
        conversion: &'a TriangleConversion,
        part: SurfacePart<'a>,
        mesh: CellMesh<'a>,
        limit: f64,
    ) -> Certify<'a> {
        if self.frames.is_empty() {
            self.set_frames(mesh);
        }
        Certify { certifier: self, conversion, part, mesh, limit }
    }
}

/// The computation that [`Certifier::certify`] describes.
pub(super) struct Certify<'a> {
    certifier: &'a mut Certifier,
    conversion: &'a TriangleConversion,
    part: SurfacePart<'a>,
    mesh: CellMesh<'a>,
    limit: f64,
}

impl WithSimd for Certify<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> f64 {
        self.bound_over_faces(simd);
        let SurfacePart { low, high, .. } = self.part;
        let inside = low.x > 0.0 && low.y > 0.0 && high.x < 1.0 && high.y < 1.0;
        if self.certifier.bound <= self.limit && !inside {
            self.bound_on_sides();
        }
        self.certifier.bound
    }
}

impl Certify<'_> {
    /// Raises the bound to that of the surface over each face.
    #[inline(always)]
    fn bound_over_faces<S: Simd>(&mut self, simd: S) {
        if self.part.is_whole() && self.part.net.is_single() {
            self.bound_single_patch(simd);
            return;
        }
        self.find_doubtful_faces(simd);
        if !self.certifier.doubtful.is_empty() {
            self.bound_patches(simd);
        }
    }

    /// Raises the bound to that of the only patch over each face.
    #[inline(always)]
    fn bound_single_patch<S: Simd>(&mut self, simd: S) {
        let Self { certifier, conversion, part, mesh: (corners, faces), limit } = self;
        let Certifier { scratch, frames, bound, .. } = &mut **certifier;
        let (net, limit) = (part.net.points, *limit);
        for (face, frame) in faces.iter().zip(&*frames) {
            // The bound of the whole net is cheaper and often small enough.
            let mut found = max_bound(simd, frame, net, limit);
            if found > limit {
                let patch = PatchBound { conversion, net, frame, limit };
                let triangle = face.map(|corner| corners[corner].at);
                found = patch.over_triangle(simd, triangle, scratch);
            }
            *bound = larger(*bound, found);
            if *bound > limit {
                return;
            }
        }
    }

    /// Finds the faces over the part whose bound by the whole net exceeds the limit.
    #[inline(always)]
    fn find_doubtful_faces<S: Simd>(&mut self, simd: S) {
        let Self { certifier, part, mesh: (corners, faces), limit, .. } = self;
        let Certifier { doubtful, frames, bound, .. } = &mut **certifier;
        let limit = *limit;
        let many = part.net.patches.0 * part.net.patches.1 >= MIN_PATCHES_FOR_NET_BOUND;
        doubtful.clear();
        for (k, (face, frame)) in faces.iter().zip(&*frames).enumerate() {
            if disjoint(face.map(|corner| corners[corner].at), part.low, part.high) {
                continue;
            }
            let found =
                if many { max_bound(simd, frame, part.net.points, limit) } else { f64::INFINITY };
            if found <= limit {
                *bound = larger(*bound, found);
            } else {
                doubtful.push(k);
            }
        }
    }

    /// Raises the bound to that of each patch over each doubtful face.
    #[inline(always)]
    fn bound_patches<S: Simd>(&mut self, simd: S) {
        let Self { certifier, conversion, part, mesh: (corners, faces), limit } = self;
        let Certifier { scratch, doubtful, patch, frames, bound, .. } = &mut **certifier;
        scratch.resize(conversion);
        for (at, rectangle) in part.net.rectangles((part.low, part.high)) {
            let net = part.net.patch(at, patch);
            for &k in &*doubtful {
                let triangle = faces[k].map(|corner| corners[corner].at);
                if disjoint(triangle, rectangle.0, rectangle.1) {
                    continue;
                }
                let patch = PatchBound { conversion, net, frame: &frames[k], limit: *limit };
                *bound = larger(*bound, patch.over_face(simd, triangle, rectangle, scratch));
                if *bound > *limit {
                    return;
                }
            }
        }
    }

    /// Raises the bound to the distance of the part's sides from the outer edges.
    #[inline(always)]
    fn bound_on_sides(&mut self) {
        let Self { certifier, part, mesh: (corners, _), limit, .. } = self;
        let (whole, limit, mut most) = (part.is_whole(), *limit * *limit, 0.0);
        let mut a = corners[corners.len() - 1];
        for &b in *corners {
            let side = (a.at, b.at);
            if let Some(ends) = if whole { Some(side) } else { part.clip(side) } {
                let chord = Chord::new(a.point, b.point);
                let curve = certifier.scratch.curve();
                most = larger(most, chord.deviation_squared(part, ends, curve, limit));
            }
            a = b;
        }
        certifier.bound = larger(certifier.bound, most.sqrt());
    }
}

/// The edge of a face that it shares with the next one: it begins at the first corner of that one.
#[inline(always)]
fn edge_to_next(faces: &[Face], k: usize) -> Option<usize> {
    let next = faces.get(k + 1)?;
    Some(usize::from(next[0] != faces[k][0]))
}

/// Whether the angle between neighboring normals exceeds the limit.
#[inline(always)]
fn folded(a: Option<DVec3>, b: Option<DVec3>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a.dot(b) < MIN_FOLD_COSINE)
}

/// The normal of a triangle; `None` if it has no area.
#[inline(always)]
fn normal(a: DVec3, b: DVec3, c: DVec3) -> Option<DVec3> {
    let longest = (b - a).length_squared().max((c - a).length_squared());
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    (length > MIN_RELATIVE_AREA * longest).then(|| cross / length)
}
