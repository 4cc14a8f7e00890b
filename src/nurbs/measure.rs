//! What a surface measures: its box and its area.

use std::collections::BinaryHeap;

use glam::DVec3;
use rayon::prelude::*;

use super::bezier::Patch;
use super::gauss;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};

/// A box is tight when no side lies further outside than this share of the size.
const TIGHT: f64 = 1e-10;

/// Pieces that are looked at for one side of a box at most; ridges that run along a side need
/// many.
const MOST_PIECES: usize = 200_000;

/// Points of the quadrature along each side of a piece.
const NODES: usize = 8;

/// Halvings of a patch at most when its area is measured: where the surface is singular, the
/// pieces are negligible by then.
const MOST_HALVINGS: usize = 12;

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
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let (low, high) = NurbsSurface::torus(DVec3::ONE, 3.0, 1.0)?.bounding_box()?;
    /// assert!(low.distance(DVec3::new(-3.0, -3.0, 0.0)) < 1e-8);
    /// assert!(high.distance(DVec3::new(5.0, 5.0, 2.0)) < 1e-8);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// None; every surface has a box.
    pub fn bounding_box(&self) -> Result<(DVec3, DVec3)> {
        let (patches, _) = Patch::of(self)?;
        let tolerance = TIGHT * self.size();
        let sides = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
        let reaches: Vec<f64> =
            sides.par_iter().map(|side| farthest(&patches, *side, tolerance)).collect();
        let [x, y, z, left, front, below] = reaches[..] else { unreachable!("six sides") };
        Ok((-DVec3::new(left, front, below), DVec3::new(x, y, z)))
    }

    /// The area, in the square of the points' unit, to a share of `accuracy` (for instance 1e-9):
    /// Gauss-Legendre quadrature on each patch, which is halved until it agrees with itself.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let area = NurbsSurface::sphere(DVec3::ZERO, 1.0)?.area(1e-12)?;
    /// assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the accuracy is not between 1e-14 and 1.
    pub fn area(&self, accuracy: f64) -> Result<f64> {
        if !(1e-14..=1.0).contains(&accuracy) {
            return Err(Error::parameter("accuracy", "between 1e-14 and 1", accuracy));
        }
        let (patches, _) = Patch::of(self)?;
        let rule = gauss::rule(NODES);
        let first: Vec<f64> = patches.par_iter().map(|patch| quadrature(patch, &rule)).collect();
        let enough = accuracy * first.iter().sum::<f64>() / patches.len() as f64;
        let refined = patches.par_iter().zip(&first);
        let areas: Vec<f64> = refined
            .map(|(patch, area)| refine(patch, *area, enough, &rule, MOST_HALVINGS))
            .collect();
        Ok(areas.iter().sum())
    }
}

/// The largest coordinate in a direction: the piece that may reach farthest is halved until no
/// control point lies further out than the farthest point that is known.
fn farthest(patches: &[Patch], side: DVec3, tolerance: f64) -> f64 {
    let bound =
        |patch: &Patch| patch.points().map(|p| p.dot(side)).fold(f64::NEG_INFINITY, f64::max);
    let corners = |patch: &Patch| {
        let (p, q) = patch.degrees();
        let corners = [(0, 0), (0, q), (p, 0), (p, q)];
        corners
            .map(|(i, j)| patch.control(i, j).dot(side))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let mut known = patches.iter().map(corners).fold(f64::NEG_INFINITY, f64::max);
    let reach = |patch: &Patch| Reach { bound: bound(patch), patch: patch.clone() };
    let mut open: BinaryHeap<Reach> = patches.iter().map(reach).collect();
    for _ in 0..MOST_PIECES {
        let Some(Reach { bound, patch }) = open.pop() else { break };
        if bound <= known + tolerance {
            return known.max(bound);
        }
        let halves = if bend(&patch, side, 0) >= bend(&patch, side, 1) {
            patch.halves_u()
        } else {
            patch.halves_v()
        };
        for half in [halves.0, halves.1] {
            known = known.max(corners(&half));
            open.push(reach(&half));
        }
    }
    open.peek().map_or(known, |reach| reach.bound.max(known))
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

fn quadrature(patch: &Patch, rule: &[(f64, f64)]) -> f64 {
    let places = rule.iter().flat_map(|s| rule.iter().map(move |t| (s, t)));
    let part = |((s, a), (t, b)): (&(f64, f64), &(f64, f64))| {
        let frame = patch.frame(*s, *t);
        a * b * frame.u.cross(frame.v).length()
    };
    places.map(part).sum()
}

fn refine(patch: &Patch, area: f64, enough: f64, rule: &[(f64, f64)], halvings: usize) -> f64 {
    let (first, second) = patch.halves_u();
    let ((a, b), (c, d)) = (first.halves_v(), second.halves_v());
    let quarters = [a, b, c, d].map(|quarter| (quadrature(&quarter, rule), quarter));
    let sum = quarters.iter().map(|(area, _)| area).sum::<f64>();
    if (sum - area).abs() <= enough || halvings == 0 {
        return sum;
    }
    let parts = quarters.iter();
    parts.map(|(area, part)| refine(part, *area, enough / 2.0, rule, halvings - 1)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_those_of_dense_samples() {
        let net: Vec<DVec3> = (0..48)
            .map(|i| DVec3::new(f64::from(i / 8), f64::from(i % 8), f64::from(i * i % 7)))
            .collect();
        let weights = (0..48).map(|i| 0.5 + f64::from(i % 4)).collect();
        let knots = |n| crate::nurbs::KnotVector::clamped_uniform(3, n).unwrap();
        let surface = NurbsSurface::new(net, Some(weights), knots(6), knots(8)).unwrap();
        let (low, high) = surface.bounding_box().unwrap();
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

    #[test]
    fn areas_are_those_of_closed_forms() {
        use std::f64::consts::PI;
        let area = |surface: Result<NurbsSurface>| surface.unwrap().area(1e-12).unwrap();
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-11, "{a} {b}");
        close(area(NurbsSurface::torus(DVec3::ONE, 3.0, 1.0)), 12.0 * PI * PI);
        close(area(NurbsSurface::cone(DVec3::ONE, DVec3::X * 4.0, 3.0, 0.0)), 15.0 * PI);
        close(
            area(NurbsSurface::plane(DVec3::ONE, DVec3::X * 2.0, DVec3::new(5.0, 3.0, 0.0))),
            6.0,
        );
    }
}
