//! What is found of each given point.

use glam::{DVec2, DVec3};

use super::fitted::Fitted;
use super::start::Start;
use crate::cloud::{PreparedCloud, items_at};
use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, NurbsSurface};
use crate::progress::Observer;

/// Parameters, deviations and inliers of all given points.
pub(super) struct Measured {
    pub(super) uv: Vec<DVec2>,
    pub(super) deviations: Vec<f64>,
    pub(super) inliers: Vec<bool>,
}

impl Measured {
    /// Of points on the surface in their own frame. Parameters of those that were fitted are known;
    /// others begin at those of the nearest fitted one.
    pub(super) fn of(
        given: &[DVec3],
        cloud: &PreparedCloud,
        fitted: &Fitted,
        surface: &NurbsSurface,
        closed: (bool, bool),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let known = items_at(given, &cloud.indices);
        let found = if surface.weights().is_some() {
            let (uv, distances) =
                ClosestPointSearch::new(surface)?.closest_parameters(given, observer)?;
            Start { uv, distances }
        } else {
            Start::near(given, surface, closed, &known, &fitted.uv, observer)?
        };
        let mut inliers = vec![false; given.len()];
        for (&index, weight) in cloud.indices.iter().zip(&fitted.weights) {
            inliers[index as usize] = *weight > 0.0;
        }
        for &(merged, kept) in &cloud.merged {
            inliers[merged as usize] = inliers[kept as usize];
        }
        let Start { uv, distances: deviations } = found;
        if cloud.thinned {
            // Points beyond those that were fitted count if they are as near.
            let counted = deviations.iter().zip(&inliers).filter(|(_, inlier)| **inlier);
            let limit = counted.map(|(deviation, _)| *deviation).fold(0.0, f64::max);
            for (inlier, deviation) in inliers.iter_mut().zip(&deviations) {
                *inlier |= *deviation <= limit;
            }
        }
        Ok(Self { uv, deviations, inliers })
    }

    /// Places of points that were looked at and left out: gross outliers, and points far from the
    /// surface with their duplicates. Ascending.
    pub(super) fn outliers(&self, cloud: &PreparedCloud) -> Vec<u32> {
        let merged = cloud.merged.iter().map(|(duplicate, _)| duplicate);
        let known = cloud.outliers.iter().chain(&cloud.indices).chain(merged);
        let mut found: Vec<u32> =
            known.copied().filter(|index| !self.inliers[*index as usize]).collect();
        found.sort_unstable();
        found
    }

    /// Deviations of the inliers.
    pub(super) fn counted(&self) -> Vec<f64> {
        let all = self.deviations.iter().zip(&self.inliers);
        all.filter(|(_, inlier)| **inlier).map(|(deviation, _)| *deviation).collect()
    }
}
