//! Parameters, deviation and inlier flag of each given point on the final surface.

use glam::{DVec2, DVec3};

use super::projection::Projection;
use super::surface_fit::SurfaceFit;
use crate::cloud::{PreparedCloud, items_at};
use crate::error::Result;
use crate::nurbs::{ClosestPointSearch, NurbsSurface};
use crate::progress::Observer;

/// Results for all given points, in their order.
pub(super) struct PointDeviations {
    pub(super) uv: Vec<DVec2>,
    pub(super) deviations: Vec<f64>,
    pub(super) inliers: Vec<bool>,
}

impl PointDeviations {
    /// Projects all given points onto the surface in their own frame. The fitted points are the
    /// known ones from which the projection starts.
    pub(super) fn of(
        given: &[DVec3],
        cloud: &PreparedCloud,
        fit: &SurfaceFit,
        surface: &NurbsSurface,
        closed: (bool, bool),
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let known = items_at(given, &cloud.indices);
        let found = if surface.weights().is_some() {
            let (uv, distances) =
                ClosestPointSearch::new(surface)?.closest_parameters(given, observer)?;
            Projection { uv, distances }
        } else {
            Projection::from_nearest(given, surface, closed, &known, &fit.uv, observer)?
        };
        let mut inliers = vec![false; given.len()];
        for (&index, weight) in cloud.indices.iter().zip(&fit.weights) {
            inliers[index as usize] = *weight > 0.0;
        }
        for &(merged, kept) in &cloud.merged {
            inliers[merged as usize] = inliers[kept as usize];
        }
        let Projection { uv, distances: deviations } = found;
        if cloud.thinned {
            // A point outside the fitted sample is an inlier if it is as near as those of the
            // sample.
            let used = deviations.iter().zip(&inliers).filter(|(_, inlier)| **inlier);
            let limit = used.map(|(deviation, _)| *deviation).fold(0.0, f64::max);
            for (inlier, deviation) in inliers.iter_mut().zip(&deviations) {
                *inlier |= *deviation <= limit;
            }
        }
        Ok(Self { uv, deviations, inliers })
    }

    /// Indices of the outliers, ascending: gross outliers, and points far from the surface with
    /// their duplicates.
    pub(super) fn outliers(&self, cloud: &PreparedCloud) -> Vec<u32> {
        let merged = cloud.merged.iter().map(|(duplicate, _)| duplicate);
        let known = cloud.outliers.iter().chain(&cloud.indices).chain(merged);
        let mut found: Vec<u32> =
            known.copied().filter(|index| !self.inliers[*index as usize]).collect();
        found.sort_unstable();
        found
    }

    /// Parameters of the inliers.
    pub(super) fn inlier_parameters(&self) -> Vec<DVec2> {
        let all = self.uv.iter().zip(&self.inliers);
        all.filter(|(_, inlier)| **inlier).map(|(uv, _)| *uv).collect()
    }

    /// Deviations of the inliers.
    pub(super) fn inlier_deviations(&self) -> Vec<f64> {
        let all = self.deviations.iter().zip(&self.inliers);
        all.filter(|(_, inlier)| **inlier).map(|(deviation, _)| *deviation).collect()
    }
}

/// The number of deviations above a tolerance.
pub(super) fn count_missed(deviations: &[f64], tolerance: f64) -> usize {
    deviations.iter().filter(|deviation| **deviation > tolerance).count()
}
