//! Certified upper bounds of the distance of a surface, over triangles and segments of (u, v), from
//! triangles and segments in space.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4};
use pulp::{Arch, Simd, WithSimd};

use super::bernstein::binomial;
use super::chord::Chord;
use super::distance_bound::DistanceBound;
use super::face_frame::FaceFrame;
use super::lanes::larger;
use super::patch_bound::{PatchBound, Scratch};
use super::polygon::disjoint;
use super::segment_bound::SegmentBound;
use super::triangle_conversion::TriangleConversion;
use crate::nurbs::{NurbsSurface, PatchNets, halve, in_space};

/// Area of a triangle below which it counts as a segment, relative to the square of its longest
/// side.
const MIN_RELATIVE_AREA: f64 = 1e-12;

/// How often a curve is halved to refine its bound.
const MAX_HALVINGS: u32 = 3;

/// The patches of one surface, with scratch memory.
///
/// Every result is an upper bound of a distance. A result above the given limit means only that the
/// limit could not be certified.
#[derive(Debug)]
pub(super) struct SurfaceBound {
    nets: Arc<PatchNets>,
    conversion: &'static TriangleConversion,
    arch: Arch,
    scratch: Scratch,
    /// The net of one patch.
    patch: Vec<DVec4>,
}

impl SurfaceBound {
    pub(super) fn new(surface: &NurbsSurface) -> Self {
        let nets = surface.patch_nets();
        let conversion = TriangleConversion::of(nets.degrees);
        let mut scratch = Scratch::default();
        scratch.resize(conversion);
        Self { nets, conversion, arch: Arch::new(), scratch, patch: vec![] }
    }

    /// The distance of the surface over a triangle of (u, v), counter-clockwise, from a triangle.
    pub(super) fn triangle_distance(
        &mut self,
        uv: [DVec2; 3],
        points: [DVec3; 3],
        limit: f64,
    ) -> f64 {
        let [a, b, c] = points;
        let cross = (b - a).cross(c - a);
        let length = cross.length();
        let sides = [[a, b], [b, c], [c, a]];
        let square = |[from, to]: [DVec3; 2]| from.distance_squared(to);
        let longest =
            (1..3).fold(0, |k, j| if square(sides[j]) > square(sides[k]) { j } else { k });
        if length <= MIN_RELATIVE_AREA * square(sides[longest]) {
            return self.segment_distance(uv, sides[longest], limit);
        }
        let frame = FaceFrame::new(points, cross / length, [None; 3]);
        self.over_triangle(uv, &frame, limit)
    }

    /// The distance of the surface over a triangle of (u, v), counter-clockwise, from a segment.
    pub(super) fn segment_distance(&mut self, uv: [DVec2; 3], ends: [DVec3; 2], limit: f64) -> f64 {
        self.over_triangle(uv, &SegmentBound::new(ends), limit)
    }

    fn over_triangle(&mut self, uv: [DVec2; 3], bound: &impl DistanceBound, limit: f64) -> f64 {
        self.arch.dispatch(OverTriangle { surface: self, uv, bound, limit })
    }

    /// The distance of the surface over a segment of (u, v) from a segment in space.
    pub(super) fn along(&mut self, [a, b]: [DVec2; 2], ends: [DVec3; 2], limit: f64) -> f64 {
        let mut cuts = vec![0.0, 1.0];
        for (breaks, from, to) in [(&self.nets.u, a.x, b.x), (&self.nets.v, a.y, b.y)] {
            let (low, high) = (from.min(to), from.max(to));
            let first = breaks.partition_point(|x| *x <= low);
            let inside = breaks[first..].iter().take_while(|x| **x < high);
            cuts.extend(inside.map(|x| (x - from) / (to - from)));
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let (chord, limit) = (Chord::new(ends[0], ends[1]), limit * limit);
        let mut most = 0.0;
        for pair in cuts.windows(2) {
            if pair[0] < pair[1] {
                let curve = self.curve(a.lerp(b, pair[0]), a.lerp(b, pair[1]));
                most = larger(most, squared_distance(&curve, &chord, limit, MAX_HALVINGS));
            }
            if most > limit {
                break;
            }
        }
        most.sqrt()
    }

    /// The Bézier points of the surface's curve over a segment of (u, v) inside one patch.
    fn curve(&mut self, a: DVec2, b: DVec2) -> Vec<DVec4> {
        let (p, q) = self.nets.degrees;
        let middle = 0.5 * (a + b);
        let (row, col) = (patch_of(&self.nets.u, middle.x), patch_of(&self.nets.v, middle.y));
        self.patch.clear();
        self.nets.append(row..row + 1, col..col + 1, &mut self.patch);
        let inside = |breaks: &[f64], k: usize, from: f64, to: f64| {
            let share = |x: f64| ((x - breaks[k]) / (breaks[k + 1] - breaks[k])).clamp(0.0, 1.0);
            let (from, to) = (share(from), share(to));
            (from.min(to), from.max(to))
        };
        let x = inside(&self.nets.u, row, a.x, b.x);
        let y = inside(&self.nets.v, col, a.y, b.y);
        self.conversion.rectangle(&mut self.patch, q + 1, x, y);
        // The diagonal of a patch is a curve of degree p + q.
        let opposite = (b.x - a.x) * (b.y - a.y) < 0.0;
        let mut curve = vec![DVec4::ZERO; p + q + 1];
        for i in 0..=p {
            for j in 0..=q {
                let share = binomial(p, i) * binomial(q, j) / binomial(p + q, i + j);
                let column = if opposite { q - j } else { j };
                curve[i + j] += share * self.patch[i * (q + 1) + column];
            }
        }
        curve
    }

    /// The indices of the patches whose rectangles meet an interval of the parameter.
    fn patches(breaks: &[f64], low: f64, high: f64) -> Range<usize> {
        let first = breaks.partition_point(|x| *x <= low).saturating_sub(1);
        let end = breaks.partition_point(|x| *x < high).min(breaks.len() - 1);
        first..end.max(first)
    }
}

/// The index of the patch that contains a parameter.
fn patch_of(breaks: &[f64], at: f64) -> usize {
    breaks.partition_point(|x| *x <= at).clamp(1, breaks.len() - 1) - 1
}

/// The largest squared distance of a Bézier curve from a chord, by its control points.
fn squared_distance(curve: &[DVec4], chord: &Chord, limit: f64, halvings: u32) -> f64 {
    let distance = |h: &DVec4| chord.distance_squared(in_space(*h).truncate());
    let most = curve.iter().map(distance).fold(0.0, larger);
    // The ends are on the curve.
    let exact = larger(distance(&curve[0]), distance(&curve[curve.len() - 1]));
    if most <= limit || exact > limit || halvings == 0 {
        return most;
    }
    let (mut first, mut second) = (curve.to_vec(), curve.to_vec());
    halve(&mut first, &mut second, curve.len() - 1, 1, [0]);
    let found = squared_distance(&first, chord, limit, halvings - 1);
    if found > limit {
        return found;
    }
    larger(found, squared_distance(&second, chord, limit, halvings - 1))
}

/// The computation of [`SurfaceBound::over_triangle`] for SIMD dispatch.
struct OverTriangle<'a, B> {
    surface: &'a mut SurfaceBound,
    uv: [DVec2; 3],
    bound: &'a B,
    limit: f64,
}

impl<B: DistanceBound> WithSimd for OverTriangle<'_, B> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { surface, uv, bound, limit } = self;
        let SurfaceBound { nets, conversion, scratch, patch, .. } = surface;
        let low = uv[0].min(uv[1]).min(uv[2]);
        let high = uv[0].max(uv[1]).max(uv[2]);
        let mut most = 0.0;
        for row in SurfaceBound::patches(&nets.u, low.x, high.x) {
            for col in SurfaceBound::patches(&nets.v, low.y, high.y) {
                let rectangle = (
                    DVec2::new(nets.u[row], nets.v[col]),
                    DVec2::new(nets.u[row + 1], nets.v[col + 1]),
                );
                if disjoint(uv, rectangle.0, rectangle.1) {
                    continue;
                }
                patch.clear();
                nets.append(row..row + 1, col..col + 1, patch);
                let patch = PatchBound { conversion, net: patch, frame: bound, limit };
                most = larger(most, patch.over_face(simd, uv, rectangle, scratch));
                if most > limit {
                    return most;
                }
            }
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DistanceSearch, MeshView};
    use super::*;

    #[test]
    fn bounds_are_above_the_distances_and_close_to_them() {
        let surface = NurbsSurface::torus(DVec3::ZERO, 3.0, 1.0).unwrap();
        let mut bound = SurfaceBound::new(&surface);
        let uv = [(0.2, 0.21), (0.22, 0.215), (0.205, 0.23)].map(DVec2::from);
        let points = uv.map(|at| surface.point(at.x, at.y));
        let triangle =
            MeshView { vertices: &points, triangles: &[[0, 1, 2]], normals: &[], uv: &[] };
        let search = DistanceSearch::new(triangle);
        let chord = Chord::new(points[0], points[1]);
        let along = bound.along([uv[0], uv[1]], [points[0], points[1]], f64::INFINITY);
        let (mut most, mut side) = (0.0_f64, 0.0_f64);
        for (i, j) in (0..=40).flat_map(|i| (0..=40 - i).map(move |j| (i, j))) {
            let (x, y) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
            let at = uv[0] + x * (uv[1] - uv[0]) + y * (uv[2] - uv[0]);
            let point = surface.point(at.x, at.y);
            most = most.max(search.distance(point));
            if j == 0 {
                side = side.max(chord.distance_squared(point).sqrt());
            }
        }
        let found = bound.triangle_distance(uv, points, 1.4 * most);
        assert!(most <= found && found <= 1.4 * most, "{most} {found}");
        assert!(side <= along && along < 3.0 * side, "{side} {along}");
        let fine = bound.along([uv[0], uv[1]], [points[0], points[1]], 1.2 * side);
        assert!(side <= fine && fine < 1.2 * side, "{side} {fine}");
    }
}
