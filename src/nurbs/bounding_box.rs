//! Tight axis-aligned bounding box of a surface, by branch and bound over its Bézier patches.

use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;

use super::bezier_patch::BezierPatch;
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

/// A piece with an upper bound of its extent in the search direction.
struct Candidate {
    bound: f64,
    patch: BezierPatch,
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
        let tolerance = BOX_TOLERANCE * self.size();
        let mut check_interrupt = interrupt_check(observer);
        let (patches, _) = BezierPatch::of(self, &mut check_interrupt)?;
        let mut extent =
            |direction: DVec3| farthest(&patches, direction, tolerance, &mut check_interrupt);
        let high = DVec3::new(extent(DVec3::X)?, extent(DVec3::Y)?, extent(DVec3::Z)?);
        let low = DVec3::new(extent(DVec3::NEG_X)?, extent(DVec3::NEG_Y)?, extent(DVec3::NEG_Z)?);
        Ok((-low, high))
    }
}

/// Returns the largest coordinate in a direction.
///
/// Halves the piece with the largest bound until no control point lies beyond the farthest known
/// surface point, within `tolerance`.
fn farthest(
    patches: &[BezierPatch],
    direction: DVec3,
    tolerance: f64,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<f64> {
    let corners = |patch: &BezierPatch| {
        let (p, q) = patch.degrees();
        let corners = [(0, 0), (0, q), (p, 0), (p, q)];
        corners
            .map(|(i, j)| patch.control(i, j).dot(direction))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max)
    };
    check_interrupt()?;
    let (mut reached, bounds) = worker_pool::install(|| {
        let reached = patches.par_iter().map(corners).reduce(|| f64::NEG_INFINITY, f64::max);
        let bounds = patches.par_iter().map(|patch| bound(patch, direction));
        (reached, bounds.collect::<Vec<f64>>())
    });
    // Largest bound of the patches that are not halved.
    let mut unhalved_bound = reached;
    let mut candidates = BinaryHeap::new();
    for (patch, bound) in patches.iter().zip(bounds) {
        if bound <= reached + tolerance {
            unhalved_bound = unhalved_bound.max(bound);
        } else {
            candidates.push(Candidate { bound, patch: patch.clone() });
        }
    }
    for _ in 0..MAX_PIECES {
        let Some(Candidate { bound, patch }) = candidates.pop() else { break };
        if bound <= reached + tolerance {
            return Ok(unhalved_bound.max(reached).max(bound));
        }
        check_interrupt()?;
        let halves = if nonlinearity(&patch, direction, 0) >= nonlinearity(&patch, direction, 1) {
            patch.halves_u()
        } else {
            patch.halves_v()
        };
        for half in [halves.0, halves.1] {
            reached = reached.max(corners(&half));
            candidates.push(Candidate { bound: self::bound(&half, direction), patch: half });
        }
    }
    Ok(candidates.peek().map_or(reached, |extent| extent.bound.max(reached)).max(unhalved_bound))
}

/// An upper bound of the patch's coordinate in a direction.
fn bound(patch: &BezierPatch, direction: DVec3) -> f64 {
    patch.points().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}

/// Largest deviation of the net from linear interpolation along one of its axes, in a direction.
fn nonlinearity(patch: &BezierPatch, direction: DVec3, axis: usize) -> f64 {
    let (p, q) = patch.degrees();
    let at = |i: usize, j: usize| patch.control(i, j).dot(direction);
    let (rows, columns) = if axis == 0 { (q, p) } else { (p, q) };
    let coordinate = |row: usize, k: usize| if axis == 0 { at(k, row) } else { at(row, k) };
    let deviation_at = |row: usize, k: usize| {
        let (start, end) = (coordinate(row, 0), coordinate(row, columns));
        coordinate(row, k) - start - (end - start) * k as f64 / columns as f64
    };
    let deviations =
        (0..=rows).flat_map(|row| (0..=columns).map(move |k| deviation_at(row, k).abs()));
    deviations.fold(0.0, f64::max)
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
