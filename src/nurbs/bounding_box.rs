//! Tight axis-aligned bounding box of a surface, by branch and bound over its Bézier patches.

use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::bezier_patch::BezierPatch;
use super::parameter_region::{Cover, ParameterRegion};
use super::surface::NurbsSurface;
use super::work_blocks::interrupt_check;
use crate::error::Result;
use crate::progress::{InterruptCheck, Observer};
use crate::worker_pool;

/// Maximal distance between the box and the surface, as a fraction of the surface's size.
const BOX_TOLERANCE: f64 = 1e-10;

/// Maximal number of pieces that are halved for one side of the box. Ridges along a side require
/// many.
const MAX_PIECES: usize = 200_000;

/// A part of a surface, for its bounding box.
pub(crate) struct SurfacePart<'a> {
    pub region: &'a dyn ParameterRegion,
    /// The smallest and largest coordinates of the region's border.
    pub border: (DVec3, DVec3),
    /// The u and the v at which tangents may jump.
    pub creases: [Vec<f64>; 2],
}

/// A piece with an upper bound of its extent in the search direction.
struct Candidate {
    bound: f64,
    patch: BezierPatch,
    /// Whether a part of the piece may lie outside the region.
    is_cut: bool,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.bound == other.bound
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl NurbsSurface {
    /// Returns the smallest and largest coordinates of the surface itself.
    ///
    /// The box touches the surface on all six sides, up to 1e-10 of its size.
    /// [`NurbsSurface::net_box`] is faster but larger.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface, progress::Silent};
    /// let (low, high) = NurbsSurface::torus(DVec3::ONE, 3.0, 1.0)?.bounding_box(&mut Silent)?;
    /// assert!(low.distance(DVec3::new(-3.0, -3.0, 0.0)) < 1e-8);
    /// assert!(high.distance(DVec3::new(5.0, 5.0, 2.0)) < 1e-8);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn bounding_box(&self, observer: &mut dyn Observer) -> Result<(DVec3, DVec3)> {
        self.bounding_box_of(None, observer)
    }

    /// Returns the smallest and largest coordinates of a part of the surface; see
    /// [`Self::bounding_box`].
    pub(crate) fn bounding_box_of(
        &self,
        part: Option<&SurfacePart<'_>>,
        observer: &mut dyn Observer,
    ) -> Result<(DVec3, DVec3)> {
        let tolerance = BOX_TOLERANCE * self.size();
        let mut check_interrupt = interrupt_check(observer);
        let (patches, _) = BezierPatch::of(self, &mut check_interrupt)?;
        let mut extent = |direction: DVec3| {
            Extent { direction, tolerance, part }.farthest(&patches, &mut check_interrupt)
        };
        let high = DVec3::new(extent(DVec3::X)?, extent(DVec3::Y)?, extent(DVec3::Z)?);
        let low = DVec3::new(extent(DVec3::NEG_X)?, extent(DVec3::NEG_Y)?, extent(DVec3::NEG_Z)?);
        Ok((-low, high))
    }
}

/// The search for the largest coordinate in a direction.
struct Extent<'a> {
    direction: DVec3,
    /// How far control points may lie beyond the farthest known point.
    tolerance: f64,
    part: Option<&'a SurfacePart<'a>>,
}

impl Extent<'_> {
    /// Returns the largest coordinate.
    ///
    /// Halves the piece with the largest bound until no control point lies beyond the farthest
    /// known surface point, within the tolerance.
    fn farthest(
        &self,
        patches: &[BezierPatch],
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<f64> {
        check_interrupt()?;
        let tasks = patches.par_iter().map(|patch| self.examine(patch, self.part.is_some()));
        let found: Vec<Option<Found>> = worker_pool::install(|| tasks.collect());
        let mut reached = self.border();
        reached = found.iter().flatten().map(|found| found.reached).fold(reached, f64::max);
        // Largest bound of the patches that are not halved.
        let mut unhalved_bound = reached;
        let mut candidates = BinaryHeap::new();
        for (patch, found) in patches.iter().zip(found) {
            let Some(Found { bound, is_cut, .. }) = found else { continue };
            if bound <= reached + self.tolerance {
                unhalved_bound = unhalved_bound.max(bound);
            } else {
                candidates.push(Candidate { bound, patch: patch.clone(), is_cut });
            }
        }
        for _ in 0..MAX_PIECES {
            let Some(Candidate { bound, patch, is_cut }) = candidates.pop() else { break };
            if bound <= reached + self.tolerance {
                return Ok(unhalved_bound.max(reached).max(bound));
            }
            check_interrupt()?;
            let axis = |axis| {
                let [bend, slope] = deviations(&patch, self.direction, axis);
                // A linear bound is reached at corners, but those of a cut piece may be outside.
                if is_cut { bend + slope } else { bend }
            };
            let (first, second) =
                if axis(0) >= axis(1) { patch.halves_u() } else { patch.halves_v() };
            for half in [first, second] {
                let Some(Found { bound, reached: point, is_cut }) = self.examine(&half, is_cut)
                else {
                    continue;
                };
                reached = reached.max(point);
                candidates.push(Candidate { bound, patch: half, is_cut });
            }
        }
        let rest = candidates.peek().map_or(reached, |extent| extent.bound.max(reached));
        Ok(rest.max(unhalved_bound))
    }

    /// The largest coordinate of the border.
    fn border(&self) -> f64 {
        let of_part = |part: &SurfacePart<'_>| {
            let (low, high) = part.border;
            (low * self.direction).max(high * self.direction).element_sum()
        };
        self.part.map_or(f64::NEG_INFINITY, of_part)
    }

    /// Bounds of a piece; `None` if no point of it inside the part is farther than the border and
    /// other pieces.
    fn examine(&self, patch: &BezierPatch, may_be_cut: bool) -> Option<Found> {
        let [low, high] = patch.rectangle();
        let part = self.part.filter(|_| may_be_cut);
        let cover = part.map_or(Cover::Inside, |part| part.region.cover(low, high));
        let part = part.filter(|_| cover == Cover::Cut);
        if cover == Cover::Outside || part.is_some_and(|part| self.leads_out(patch, part)) {
            return None;
        }
        let bound = patch.points().map(|p| p.dot(self.direction)).fold(f64::NEG_INFINITY, f64::max);
        let (p, q) = patch.degrees();
        let corners = [
            (0, 0, low),
            (0, q, DVec2::new(low.x, high.y)),
            (p, 0, DVec2::new(high.x, low.y)),
            (p, q, high),
        ];
        let inside =
            |(_, _, uv): &&(usize, usize, DVec2)| part.is_none_or(|part| part.region.contains(*uv));
        let coordinates = corners.iter().filter(inside);
        let coordinates = coordinates.map(|(i, j, _)| patch.control(*i, *j).dot(self.direction));
        let reached = coordinates.fold(f64::NEG_INFINITY, f64::max);
        Some(Found { bound, reached, is_cut: part.is_some() })
    }

    /// Whether the coordinate grows all over a piece in u or v, and continues to grow behind it:
    /// then it is largest on the border or on another piece.
    fn leads_out(&self, patch: &BezierPatch, part: &SurfacePart<'_>) -> bool {
        let [low, high] = patch.rectangle();
        [0, 1].into_iter().any(|axis| match slope_sign(patch, self.direction, axis) {
            1 => !part.creases[axis].contains(&high[axis]),
            -1 => !part.creases[axis].contains(&low[axis]),
            _ => false,
        })
    }
}

/// What is known of a piece.
struct Found {
    /// An upper bound of the coordinate.
    bound: f64,
    /// The largest known coordinate of a point of the part.
    reached: f64,
    is_cut: bool,
}

/// The sign of the derivative of a coordinate along one of a patch's axes, if it is the same all
/// over the patch; else zero.
///
/// With f = g / w + c, the derivative has the sign of g' - (g / w) w', whose terms are bounded by
/// control points.
fn slope_sign(patch: &BezierPatch, direction: DVec3, axis: usize) -> i32 {
    let values = || patch.points().map(|point| point.dot(direction));
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::MIN, f64::max));
    let middle = f64::midpoint(low, high);
    let (p, q) = patch.degrees();
    let (di, dj) = if axis == 0 { (1, 0) } else { (0, 1) };
    let (mut slopes, mut weight_slope) = ((f64::INFINITY, f64::NEG_INFINITY), 0.0_f64);
    for (i, j) in (0..=p - di).flat_map(|i| (0..=q - dj).map(move |j| (i, j))) {
        let step = patch.homogeneous(i + di, j + dj) - patch.homogeneous(i, j);
        let slope = step.truncate().dot(direction) - middle * step.w;
        slopes = (slopes.0.min(slope), slopes.1.max(slope));
        weight_slope = weight_slope.max(step.w.abs());
    }
    let bend = (high - low) / 2.0 * weight_slope;
    i32::from(slopes.0 > bend) - i32::from(slopes.1 < -bend)
}

/// Largest deviation of the net from linear interpolation along one of its axes, in a direction,
/// and the largest difference between the ends.
fn deviations(patch: &BezierPatch, direction: DVec3, axis: usize) -> [f64; 2] {
    let (p, q) = patch.degrees();
    let at = |i: usize, j: usize| patch.control(i, j).dot(direction);
    let (rows, columns) = if axis == 0 { (q, p) } else { (p, q) };
    let coordinate = |row: usize, k: usize| if axis == 0 { at(k, row) } else { at(row, k) };
    let mut largest = [0.0_f64; 2];
    for row in 0..=rows {
        let (start, end) = (coordinate(row, 0), coordinate(row, columns));
        largest[1] = largest[1].max((end - start).abs());
        for k in 0..=columns {
            let deviation = coordinate(row, k) - start - (end - start) * k as f64 / columns as f64;
            largest[0] = largest[0].max(deviation.abs());
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn boxes_match_dense_samples() {
        let net: Vec<DVec3> = (0..48)
            .map(|i| DVec3::new(f64::from(i / 8), f64::from(i % 8), f64::from(i * i % 7)))
            .collect();
        let weights = (0..48).map(|i| 0.5 + f64::from(i % 4)).collect();
        let knots = |n| crate::nurbs::KnotVector::clamped_uniform(3, n).unwrap();
        let surface = NurbsSurface::new(net, Some(weights), knots(6), knots(8)).unwrap();
        let (low, high) = surface.bounding_box(&mut Silent).unwrap();
        let mut sampled = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for k in 0..=1000 * 1000 {
            let p = surface.point(f64::from(k / 1001) / 999.0, f64::from(k % 1001) / 1000.0);
            sampled = (sampled.0.min(p), sampled.1.max(p));
        }
        // A grid of this density misses an extremum by about 1e-5 at most.
        assert!(low.distance(sampled.0) < 1e-4 && high.distance(sampled.1) < 1e-4);
        assert!(
            (sampled.0 - low).min_element() >= -1e-9 && (high - sampled.1).min_element() >= -1e-9
        );
        assert_eq!(surface.net_box().1.z, 4.0);
    }
}
