//! Adaptive refinement: a net grows until a tolerance holds, or until more control points would
//! follow noise.

use glam::{DVec2, DVec3};

use super::alternating_fit::AlternatingFit;
use super::fit_result::{Approximation, EndedBy};
use super::isocurve_length::isocurve_lengths;
use super::options::Growth;
use super::projection::Projection;
use super::residual_correlation::are_noise;
use super::settings::{ProjectionSettings, RefinementSettings};
use super::span_division;
use super::spline_space::SplineSpace;
use crate::error::Result;
use crate::nurbs::NurbsSurface;

const PROJECTION: ProjectionSettings = ProjectionSettings::STANDARD;
const SETTINGS: RefinementSettings = RefinementSettings::STANDARD;

/// Rms error below which a fit is exact, in diameters of the points.
pub(crate) const EXACT_ERROR: f64 = SETTINGS.exact_error;

/// Decides whether a finer surface, with these parameters of the points, may replace the one
/// before.
pub(crate) type Accept<'a> = &'a dyn Fn(&NurbsSurface, &[DVec2]) -> Result<bool>;

/// The results of a refinement.
pub(crate) struct RefinementResult {
    /// The surface with the most control points.
    pub(crate) finest: Approximation,
    /// The surface before the first that was not accepted; `None` if all were accepted.
    pub(crate) accepted: Option<Approximation>,
}

impl AlternatingFit<'_> {
    /// The approximation by this surface, or by its refinement if growth is allowed.
    pub(super) fn refined_fit(
        mut self,
        surface: NurbsSurface,
        growth: Option<Growth>,
        accept: Accept<'_>,
    ) -> Result<RefinementResult> {
        let mut accepted = None;
        let (surface, ended_by) = match growth {
            Some(growth) => self.refine(surface, growth, accept, &mut accepted)?,
            None => (surface, EndedBy::Grid),
        };
        let finest = self.finish(surface, ended_by);
        Ok(RefinementResult { finest, accepted })
    }

    /// Divides spans and solves again until the tolerance holds or a limit is reached.
    ///
    /// With a tolerance, the growth ends at the first surface that is not accepted. Without one, it
    /// continues and keeps the surface before.
    fn refine(
        &mut self,
        mut surface: NurbsSurface,
        growth: Growth,
        accept: Accept<'_>,
        accepted: &mut Option<Approximation>,
    ) -> Result<(NurbsSurface, EndedBy)> {
        let used = (0..self.points.len()).filter(|&i| self.weight(i) > 0.0).count();
        let max_supported =
            (used / SETTINGS.points_per_control_point).max(used.min(SETTINGS.few_points));
        let exact = EXACT_ERROR * diameter(self.points);
        // The fairness weight of a finer net starts at the last one.
        self.fairness_decay = 1.0;
        self.limit = self.limit.div_ceil(2) - 1;
        loop {
            let projections = self.correct_parameters(&surface, PROJECTION.steps);
            let exceeds = |projection: &Projection| {
                growth.tolerance.is_none_or(|most| projection.offset.length() > most)
            };
            let used_point = |i: usize| self.weight(i) > 0.0;
            let within = projections
                .iter()
                .enumerate()
                .all(|(i, projection)| !(exceeds(projection) && used_point(i)));
            if within {
                return Ok((surface, EndedBy::Tolerance));
            }
            if growth.tolerance.is_none() && self.rms(&projections) <= exact {
                return Ok((surface, EndedBy::Exact));
            }
            if growth.tolerance.is_none() && self.are_noise(&projections) {
                return Ok((surface, EndedBy::Noise));
            }
            let error = |projection: &Projection| {
                if exceeds(projection) { projection.offset.length_squared() } else { 0.0 }
            };
            let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
            let space = SplineSpace::new(knots, self.closed)?;
            let lengths = isocurve_lengths(&surface);
            let refined =
                |share| span_division::refined(&space, &projections, error, lengths, share);
            let limit = growth.most.min(max_supported);
            let (finer, share) = span_division::refined_within(limit, refined)?;
            let ended_by = match share < SETTINGS.divided_error {
                true if max_supported < growth.most => EndedBy::Points,
                true => EndedBy::MaxControlPoints,
                false => EndedBy::Noise,
            };
            let Some(finer) = finer else {
                let smallest = ended_by == EndedBy::Noise;
                return Ok((surface, if smallest { EndedBy::Points } else { ended_by }));
            };
            let before = (self.score, self.uv.clone());
            let next = self.minimize(&finer, surface.clone())?;
            if growth.tolerance.is_none()
                && let (Some(old), Some(new)) = (before.0, self.score)
                && (new.error > SETTINGS.max_error_ratio * old.error
                    || new.error_of_blocks > old.error_of_blocks)
            {
                (self.score, self.uv) = before;
                return Ok((surface, ended_by));
            }
            if accepted.is_none() && !accept(&next, &self.uv)? {
                let after = (self.score, std::mem::take(&mut self.uv));
                (self.score, self.uv) = before;
                if growth.tolerance.is_some() {
                    return Ok((surface, EndedBy::Defects));
                }
                *accepted = Some(self.finish(surface, EndedBy::Defects));
                (self.score, self.uv) = after;
            }
            surface = next;
            if share < SETTINGS.divided_error {
                return Ok((surface, ended_by));
            }
        }
    }
}

impl AlternatingFit<'_> {
    /// Whether the distances of the used points are noise, which a finer net would follow.
    fn are_noise(&self, projections: &[Projection]) -> bool {
        let used = projections.iter().enumerate().filter(|(i, _)| self.weight(*i) > 0.0);
        let (uv, distances): (Vec<DVec2>, Vec<f64>) = used
            .map(|(_, projection)| (projection.uv, projection.offset.dot(projection.normal)))
            .unzip();
        are_noise(&uv, &distances)
    }
}

/// Twice the distance of the farthest point from the centroid. Unlike the diagonal of a bounding
/// box, it does not change under rotation.
pub(crate) fn diameter(points: &[DVec3]) -> f64 {
    let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    2.0 * points.iter().map(|point| point.distance(mean)).fold(0.0, f64::max)
}
