//! An upper bound of the distance of a Bézier patch, over one triangle of its parameters.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec2, DVec4};
use pulp::Simd;

use super::bezier_triangle::{Refinement, max_bound_by_halving};
use super::cell_mesh::UNIT_SQUARE;
use super::de_casteljau::quarters;
use super::distance_bound::{DistanceBound, max_bound, max_quotient, weighted_bounds};
use super::lanes::{Batch, PointBatch, larger};
use super::polygon::Polygon;
use super::triangle_conversion::{Buffers, TriangleConversion};

/// A bound above this multiple of the limit is not refined: the distance surely exceeds the limit.
const MAX_REFINED_RATIO: f64 = 1.5;

/// How often a triangle is halved to refine its bound.
const MAX_HALVINGS: usize = 2;

/// Scratch memory for bounds.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    buffers: Buffers,
    /// The Bézier points of a triangle, and of its halves.
    coefficients: Vec<PointBatch>,
    /// The coefficients over a triangle of bounds times weights, and of weights.
    quotients: Vec<[Batch; 2]>,
    /// The bounds of the control points (see [`weighted_bounds`]).
    bounds: Vec<DVec4>,
    /// A curve on a side, the quarters of a patch, or bounds over a rectangle.
    points: Vec<DVec4>,
}

impl Scratch {
    /// Makes room for patches of the degrees of a conversion.
    pub(super) fn resize(&mut self, conversion: &TriangleConversion) {
        self.quotients.resize(conversion.batches(), [Batch::default(); 2]);
        self.bounds.resize((conversion.p + 1) * (conversion.q + 1), DVec4::ZERO);
    }

    /// Memory for the control points of a curve.
    pub(super) fn curve(&mut self) -> &mut Vec<DVec4> {
        &mut self.points
    }
}

/// A patch whose distance is bounded; `frame` bounds the distance of a point.
///
/// A result above `limit` means only that the limit could not be certified.
pub(super) struct PatchBound<'a, B> {
    pub conversion: &'a TriangleConversion,
    /// The control points of the patch.
    pub net: &'a [DVec4],
    pub frame: &'a B,
    pub limit: f64,
}

impl<B: DistanceBound> PatchBound<'_, B> {
    /// The bound over the intersection of a face's triangle with the rectangle of the patch.
    ///
    /// Tries the cheaper bounds first: by the whole net, by a rectangle, by triangles.
    #[inline(always)]
    pub(super) fn over_face<S: Simd>(
        &self,
        simd: S,
        triangle: [DVec2; 3],
        (low, high): (DVec2, DVec2),
        scratch: &mut Scratch,
    ) -> f64 {
        let found = weighted_bounds(simd, self.frame, self.net, &mut scratch.bounds);
        if found <= self.limit {
            return found;
        }
        let mut polygon = Polygon::of(triangle);
        polygon.clip(low, high);
        polygon.stretch(low, high);
        if !polygon.has_area() {
            return 0.0;
        }
        let polygon = polygon.corners();
        let most = self.at_patch_corners(polygon, scratch);
        if most > self.limit {
            return most;
        }
        let found = if self.covers_patch(polygon) {
            self.by_quarters(simd, scratch)
        } else {
            self.over_polygon(simd, polygon, scratch)
        };
        larger(most, found)
    }

    /// The bound of the polygon's corners that are corners of the patch: points of the surface.
    #[inline(always)]
    fn at_patch_corners(&self, polygon: &[DVec2], scratch: &Scratch) -> f64 {
        let corners = polygon.iter().filter_map(|&at| self.conversion.corner_index(at));
        corners.fold(0.0, |most, corner| larger(most, scratch.bounds[corner].z))
    }

    /// Whether a polygon is the whole square of the patch.
    #[inline(always)]
    fn covers_patch(&self, polygon: &[DVec2]) -> bool {
        polygon.len() == UNIT_SQUARE.len()
            && polygon.iter().all(|&at| self.conversion.corner_index(at).is_some())
    }

    /// The bound of the whole patch by the control points of its quarters.
    #[inline(always)]
    fn by_quarters<S: Simd>(&self, simd: S, scratch: &mut Scratch) -> f64 {
        let degrees = (self.conversion.p, self.conversion.q);
        quarters(self.net, degrees, &mut scratch.points);
        max_bound(simd, self.frame, &scratch.points, self.limit)
    }

    /// The bound over a convex polygon of the patch's square.
    ///
    /// The bound of a mean of points is at most the mean of their bounds. So bounds are
    /// interpolated like points: first over a rectangle around the polygon, then over its
    /// triangles.
    #[inline(always)]
    fn over_polygon<S: Simd>(&self, simd: S, polygon: &[DVec2], scratch: &mut Scratch) -> f64 {
        let Self { conversion, limit, .. } = *self;
        let from = polygon.iter().copied().fold(DVec2::ONE, DVec2::min);
        let to = polygon.iter().copied().fold(DVec2::ZERO, DVec2::max);
        if (from, to) != (DVec2::ZERO, DVec2::ONE) {
            let Scratch { bounds, points, .. } = scratch;
            points.clear();
            points.extend_from_slice(bounds);
            conversion.rectangle(points, conversion.q + 1, (from.x, to.x), (from.y, to.y));
            let found = max_mean_bound(points);
            if found <= limit {
                return found;
            }
        }
        let mut most = 0.0;
        for i in 2..polygon.len() {
            let triangle = [polygon[0], polygon[i - 1], polygon[i]];
            let Scratch { buffers, quotients, bounds, .. } = scratch;
            let ordered = longest_side_first(triangle);
            conversion.triangle(simd, bounds, ordered, buffers, quotients);
            let mut found = max_quotient(simd, quotients);
            if found > limit {
                found = self.over_triangle(simd, triangle, scratch);
            }
            most = larger(most, found);
            if most > limit {
                break;
            }
        }
        most
    }

    /// The bound over a triangle of the patch's square, by its Bézier points.
    #[inline(always)]
    pub(super) fn over_triangle<S: Simd>(
        &self,
        simd: S,
        triangle: [DVec2; 3],
        Scratch { buffers, coefficients, .. }: &mut Scratch,
    ) -> f64 {
        let Self { conversion, net, frame, limit } = *self;
        let at = longest_side_first(triangle);
        let batches = conversion.batches();
        coefficients.resize((MAX_HALVINGS + 1) * batches, [Batch::default(); 4]);
        conversion.triangle(simd, net, at, buffers, coefficients);
        let max_refined = MAX_REFINED_RATIO * limit;
        let refinement = Refinement { limit, max_refined, halvings: MAX_HALVINGS };
        max_bound_by_halving(simd, coefficients, &conversion.halvings, refinement, frame)
    }
}

/// The largest bound among [`weighted_bounds`].
#[inline(always)]
fn max_mean_bound(bounds: &[DVec4]) -> f64 {
    bounds.iter().fold(0.0, |most, bound| larger(most, bound.x / bound.y))
}

/// Rotates a triangle so that its first corner is opposite to the longest side, which is cut first.
#[inline(always)]
fn longest_side_first(at: [DVec2; 3]) -> [DVec2; 3] {
    let side = |k: usize| at[(k + 1) % 3].distance_squared(at[(k + 2) % 3]);
    let first = (1..3).fold(0, |first, k| if side(k) > side(first) { k } else { first });
    [at[first], at[(first + 1) % 3], at[(first + 2) % 3]]
}
