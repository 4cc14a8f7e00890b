//! What is found of each point of the cloud, in the places of the cloud.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::counted::{Counted, every, of};
use super::feet::{feet, heights};
use crate::cloud::{KdTree, Neighbor};
use crate::error::Result;
use crate::fit::project;
use crate::nurbs::NurbsSurface;
use crate::progress::{self, Observer, Progress, Stage};

/// Points whose feet are looked for at a time: tens of milliseconds, and little memory.
pub(super) const PORTION: usize = 1 << 16;

/// Points from whose feet those of others are looked for: the nearest of so many is not far.
const BESIDE: usize = 1 << 16;

/// Where on the surface the points have their feet, how far away these are, and which points count.
pub(super) struct Measured {
    pub(super) uv: Vec<DVec2>,
    pub(super) distances: Vec<f64>,
    pub(super) inliers: Vec<bool>,
}

/// Where feet are looked for.
#[derive(Clone, Copy)]
pub(super) struct Feet {
    /// Which directions of the surface are closed.
    pub(super) closed: (bool, bool),
    /// Straight below: ways along x and y are none beside heights in another unit.
    pub(super) straight: bool,
}

impl Measured {
    /// What was found of the points that were fitted.
    pub(super) fn of_fitted(
        counted: &Counted,
        cloud: usize,
        uv: &[DVec2],
        distances: &[f64],
        counts: &[bool],
    ) -> Self {
        let mut all = Self {
            uv: vec![DVec2::NAN; cloud],
            distances: vec![f64::NAN; cloud],
            inliers: vec![false; cloud],
        };
        all.set(&counted.indices, uv, distances, |i| counts[i]);
        all
    }

    /// Adds what is found of the others: their feet are looked for from those of the points beside
    /// them, and all over the surface where that does not lead as near as the fitted points lie. Of
    /// more points than a surface is fitted to, those count that lie as near. Of heights over x and y
    /// in other units they are straight below.
    pub(super) fn add_others(
        &mut self,
        cloud: &[DVec3],
        counted: &Counted,
        surface: &NurbsSurface,
        Feet { closed, straight }: Feet,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let others = counted.others(cloud.len());
        let inliers = counted.indices.iter().filter(|&&index| self.inliers[index as usize]);
        let limit = inliers.map(|&index| self.distances[index as usize]).fold(0.0, f64::max);
        let counts = |distance: f64| counted.thinned && distance <= limit;
        if straight {
            let (uv, distances) = heights(surface, &of(cloud, &others));
            self.set(&others, &uv, &distances, |i| counts(distances[i]));
            return Ok(());
        }
        let mut far = Vec::new();
        if surface.weights().is_some() {
            far = others;
        } else if !others.is_empty() {
            let beside: Vec<u32> = every(&counted.indices, BESIDE).copied().collect();
            let (places, known) = (of(cloud, &beside), of(&self.uv, &beside));
            let tree = KdTree::new(&places);
            let start = |found: &mut Vec<Neighbor>, point: &DVec3| {
                tree.nearest_where(*point, 1, f64::INFINITY, found, |_| true);
                found.first().map_or(DVec2::ZERO, |near| known[near.index as usize])
            };
            for (number, portion) in others.chunks(PORTION).enumerate() {
                let (step, total) = ((number * PORTION) as u64, others.len() as u64);
                let progress = Progress::of_stage(Stage::Measuring, step, total, cloud.len());
                progress::report(observer, &progress)?;
                let points = of(cloud, portion);
                let starts: Vec<DVec2> = points.par_iter().map_init(Vec::new, start).collect();
                let (uv, distances) = project(surface, closed, &points, &starts);
                self.set(portion, &uv, &distances, |i| counts(distances[i]));
                far.extend(
                    portion.iter().zip(&distances).filter(|(_, d)| **d > limit).map(|(&i, _)| i),
                );
            }
        }
        for portion in far.chunks(PORTION) {
            let (uv, distances) = feet(surface, &of(cloud, portion), observer)?;
            self.set(portion, &uv, &distances, |i| counts(distances[i]));
        }
        Ok(())
    }

    fn set(
        &mut self,
        indices: &[u32],
        uv: &[DVec2],
        distances: &[f64],
        counts: impl Fn(usize) -> bool,
    ) {
        for (i, &index) in indices.iter().enumerate() {
            let index = index as usize;
            (self.uv[index], self.distances[index]) = (uv[i], distances[i]);
            self.inliers[index] = counts(i);
        }
    }

    /// The distances of the points that count.
    pub(super) fn near(&self) -> Vec<f64> {
        let all = self.distances.iter().zip(&self.inliers);
        all.filter(|(_, inlier)| **inlier).map(|(distance, _)| *distance).collect()
    }
}
