//! What curves and surfaces measure: lengths and boxes.

use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;

use super::bezier_patch::Patch;
use super::surface::NurbsSurface;
use super::work_blocks::listening;
use crate::error::Result;
use crate::progress::{Listen, Observer};

/// A box is tight when no side lies further outside than this share of the size.
const TIGHT: f64 = 1e-10;

/// Pieces that are looked at for one side of a box at most; ridges that run along a side need
/// many.
const MOST_PIECES: usize = 200_000;

/// A piece and how far it may reach in the direction that is looked at.
struct Reach {
    bound: f64,
    patch: Patch,
}

impl PartialEq for Reach {
    fn eq(&self, other: &Self) -> bool {
        self.bound == other.bound
    }
}

impl Eq for Reach {}

impl PartialOrd for Reach {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Reach {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl NurbsSurface {
    /// Smallest and largest coordinates of the surface itself: a box that it touches on all six
    /// sides, up to 1e-10 of its size. [`NurbsSurface::net_box`] costs less and is larger.
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
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn bounding_box(&self, observer: &mut dyn Observer) -> Result<(DVec3, DVec3)> {
        let tolerance = TIGHT * self.size();
        let mut listen = listening(observer);
        let (patches, _) = Patch::of(self, &mut listen)?;
        let mut reach = |side: DVec3| farthest(&patches, side, tolerance, &mut listen);
        let high = DVec3::new(reach(DVec3::X)?, reach(DVec3::Y)?, reach(DVec3::Z)?);
        let low = DVec3::new(reach(DVec3::NEG_X)?, reach(DVec3::NEG_Y)?, reach(DVec3::NEG_Z)?);
        Ok((-low, high))
    }
}

/// The largest coordinate in a direction: the piece that may reach farthest is halved until no
/// control point lies further out than the farthest point that is known.
fn farthest(
    patches: &[Patch],
    side: DVec3,
    tolerance: f64,
    listen: &mut Listen<'_>,
) -> Result<f64> {
    let corners = |patch: &Patch| {
        let (p, q) = patch.degrees();
        let corners = [(0, 0), (0, q), (p, 0), (p, q)];
        corners
            .map(|(i, j)| patch.control(i, j).dot(side))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max)
    };
    listen()?;
    let mut known = patches.par_iter().map(corners).reduce(|| f64::NEG_INFINITY, f64::max);
    let bounds: Vec<f64> = patches.par_iter().map(|patch| bound(patch, side)).collect();
    // What patches that are not looked into may reach.
    let mut settled = known;
    let mut open = BinaryHeap::new();
    for (patch, bound) in patches.iter().zip(bounds) {
        if bound <= known + tolerance {
            settled = settled.max(bound);
        } else {
            open.push(Reach { bound, patch: patch.clone() });
        }
    }
    for _ in 0..MOST_PIECES {
        let Some(Reach { bound, patch }) = open.pop() else { break };
        if bound <= known + tolerance {
            return Ok(settled.max(known).max(bound));
        }
        listen()?;
        let halves = if bend(&patch, side, 0) >= bend(&patch, side, 1) {
            patch.halves_u()
        } else {
            patch.halves_v()
        };
        for half in [halves.0, halves.1] {
            known = known.max(corners(&half));
            open.push(Reach { bound: self::bound(&half, side), patch: half });
        }
    }
    Ok(open.peek().map_or(known, |reach| reach.bound.max(known)).max(settled))
}

/// The farthest that a patch may reach in a direction.
fn bound(patch: &Patch, side: DVec3) -> f64 {
    patch.points().map(|p| p.dot(side)).fold(f64::NEG_INFINITY, f64::max)
}

/// How far a net is from linear along one of its axes, in a direction.
fn bend(patch: &Patch, side: DVec3, axis: usize) -> f64 {
    let (p, q) = patch.degrees();
    let at = |i: usize, j: usize| patch.control(i, j).dot(side);
    let (rows, columns) = if axis == 0 { (q, p) } else { (p, q) };
    let place = |row: usize, k: usize| if axis == 0 { at(k, row) } else { at(row, k) };
    let line = |row: usize, k: usize| {
        let (start, end) = (place(row, 0), place(row, columns));
        place(row, k) - start - (end - start) * k as f64 / columns as f64
    };
    let bends = (0..=rows).flat_map(|row| (0..=columns).map(move |k| line(row, k).abs()));
    bends.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn boxes_are_those_of_dense_samples() {
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
        // A grid of a thousand misses an extremum by some 1e-5 at most.
        assert!(low.distance(sampled.0) < 1e-4 && high.distance(sampled.1) < 1e-4);
        assert!(
            (sampled.0 - low).min_element() >= -1e-9 && (high - sampled.1).min_element() >= -1e-9
        );
        assert_eq!(surface.net_box().1.z, 4.0);
    }
}
