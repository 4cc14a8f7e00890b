//! Variable projection: the problem of points on a surface, with the parameters eliminated.
//!
//! To first order, distances to the tangent planes at the projections do not depend on the
//! parameters. So Gauss-Newton steps for the control points alone converge quadratically (P. Bo, R.
//! Ling, W. Wang, *A revisit to fitting parametric surfaces to point clouds*, 2012). A net that
//! slides within its surface changes these distances little. So after each step the control points
//! are solved for once more at fixed parameters.

use glam::{DVec2, DVec3};

use super::super::normal_equations::{NormalEquations, Sample};
use super::super::projection::{Projection, extended_projections};
use super::super::settings::LeastSquaresSettings;
use super::super::spline_space::SplineSpace;
use super::settings::RecoverySettings;
use crate::error::{Error, Result};
use crate::numeric::min_max;
use crate::nurbs::NurbsSurface;

const SETTINGS: RecoverySettings = RecoverySettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Points that must lie on a surface of one space.
#[derive(Clone, Copy)]
pub(super) struct Problem<'a> {
    pub(super) points: &'a [DVec3],
    pub(super) space: &'a SplineSpace,
    /// Distance of projections beyond the domain, at most, as a share of the domain.
    pub(super) beyond: f64,
    /// The points' diameter.
    pub(super) size: f64,
}

impl Problem<'_> {
    pub(super) fn is_converged(&self, error: f64) -> bool {
        error <= SETTINGS.exact_error * self.size
    }

    /// The vectors of a net, in the order of solution, evaluated at parameters.
    pub(super) fn at(&self, net: &[DVec3], uv: &[DVec2]) -> Result<Vec<DVec3>> {
        let surface = self.space.surface(net)?;
        let origin = vec![DVec3::ZERO; uv.len()];
        let projections =
            extended_projections(&surface, self.space.closed, self.beyond, &origin, uv, 0);
        Ok(projections.iter().map(|projection| -projection.offset).collect())
    }

    /// The changes of the control points that best remove the plain offsets at these projections.
    /// `None` if the points do not determine them.
    pub(super) fn plain(&self, projections: &[Projection]) -> Result<Option<Vec<DVec3>>> {
        let samples = self.samples(projections, 1.0);
        let NormalEquations { mut matrix, mut right } =
            NormalEquations::of_distances(self.space, &samples, &mut || Ok(()))?;
        matrix.add_ridge(LEAST_SQUARES.ridge);
        if !matrix.factor::<Error>(&mut || Ok(()))? {
            return Ok(None);
        }
        matrix.solve(&mut right);
        Ok(Some(right.into_iter().map(DVec3::from_array).collect()))
    }

    /// The offsets of projections as samples, with full weight along normals and `tangential`
    /// across.
    pub(super) fn samples(&self, projections: &[Projection], tangential: f64) -> Vec<Sample> {
        let sample = |&Projection { uv, offset: point, normal, border }: &Projection| {
            let tangential = if border && self.beyond == 0.0 { 1.0 } else { tangential };
            Sample { point, uv, weight: 1.0, normal, tangential }
        };
        projections.iter().map(sample).collect()
    }

    /// The equations of the offsets along the normals.
    pub(super) fn equations(&self, projections: &[Projection]) -> Result<NormalEquations> {
        let (samples, matrix) = (self.samples(projections, 0.0), self.space.matrix(3));
        NormalEquations::of_tangent_distances(self.space, &samples, matrix, &mut || Ok(()))
    }

    pub(super) fn projections(
        &self,
        surface: &NurbsSurface,
        uv: &[DVec2],
        steps: usize,
    ) -> Vec<Projection> {
        extended_projections(surface, self.space.closed, self.beyond, self.points, uv, steps)
    }

    /// The parameters of projections, scaled to the domain in open directions where some are beyond
    /// it.
    pub(super) fn scaled_to_domain(&self, projections: &[Projection]) -> Vec<DVec2> {
        let mut uv: Vec<DVec2> = projections.iter().map(|projection| projection.uv).collect();
        for d in (0..2).filter(|&d| !self.space.closed[d]) {
            let (start, end) = self.space.knots[d].domain();
            let (low, high) = min_max(uv.iter().map(|uv| uv[d]));
            let (low, high) = (low.min(start), high.max(end));
            for uv in &mut uv {
                uv[d] = start + (end - start) * (uv[d] - low) / (high - low);
            }
        }
        uv
    }
}
