//! The least-squares problem of a height field: places in the unit square, heights over a
//! regression plane.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::base_domain::{BaseDomain, BasePlane};
use super::dense_matrix::DenseMatrix;
use super::fairness_energy::ORDER;
use super::fit_result::HeightFit;
use super::least_squares::{Equations, PointSums, check};
use super::options::{FitOptions, HeightOptions};
use super::patches::Patches;
use super::plane_trend::PlaneTrend;
use super::settings::{HeightSettings, LeastSquaresSettings};
use crate::error::{Error, Result};
use crate::numeric::min_max;
use crate::nurbs::NurbsSurface;
use crate::progress::InterruptCheck;

const SETTINGS: HeightSettings = HeightSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Points as parameters in the base rectangle and heights over a regression plane.
pub(super) struct HeightField<'a> {
    axes: [DVec3; 3],
    pub(super) ground: BaseDomain,
    /// The points in the plane's axes; their heights are over the regression plane.
    pub(super) local: Vec<DVec3>,
    trend: PlaneTrend,
    pub(super) uv: Vec<DVec2>,
    weights: Option<&'a [f64]>,
    options: FitOptions,
    /// Order of the derivatives in the fairness energy.
    order: usize,
}

impl<'a> HeightField<'a> {
    pub(super) fn of(
        points: &[DVec3],
        weights: Option<&'a [f64]>,
        base: &BasePlane,
        options: &HeightOptions,
    ) -> Result<Self> {
        if !base.up.is_normalized() {
            return Err(Error::parameter("up", "a vector of length 1", base.up));
        }
        let BasePlane { axes: [along, across], up } = base;
        let turned = |p: &DVec3| DVec3::new(along.dot(*p), across.dot(*p), up.dot(*p));
        let mut local: Vec<DVec3> = points.par_iter().map(turned).collect();
        let is_used = |i: usize| weights.is_none_or(|weights| weights.get(i) != Some(&0.0));
        let options = options.with_possible_degree();
        let ground = BaseDomain::around(&local, is_used)?;
        let uv: Vec<DVec2> =
            local.par_iter().map(|point| ground.parameters(point.truncate())).collect();
        let mut fitting = FitOptions::new(options.net, options.degree, (false, false))?;
        fitting.fairness = options.fairness.unwrap_or(fitting.fairness);
        check(&local, &uv, weights, &fitting)?;
        let trend = PlaneTrend::of(&local, weights);
        local.par_iter_mut().for_each(|point| point.z -= trend.height(point.truncate()));
        let few = points.len() < SETTINGS.min_points_for_third_order || on_conic(&uv);
        let order = if few { ORDER - 1 } else { ORDER };
        let order = order.min(options.degree.0.max(options.degree.1));
        let axes = [*along, *across, *up];
        Ok(Self { axes, ground, local, trend, uv, weights, options: fitting, order })
    }

    /// The normal equations of the heights, with the fairness energy.
    pub(super) fn equations(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Equations> {
        let Self { local, uv, weights, options, order, ground, .. } = self;
        let sums = PointSums::of(local, uv, *weights, DVec3::ZERO, options, check_interrupt)?;
        Ok(Equations::of(sums.with_lengths(ground.size().into()), *order, 1.0))
    }

    /// The surface with this fairness. Slopes are penalized from a known reach on, or as far as
    /// needed to prevent overshoot.
    pub(super) fn fitted(
        self,
        equations: Equations,
        fairness: f64,
        reach: Option<f64>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<HeightFit> {
        let (heights, reach) = self.tightened(equations, fairness, reach, check_interrupt)?;
        let Self { axes: [along, across, up], ground, local, trend, uv, .. } = self;
        check_interrupt()?;
        let residuals = residuals(&heights, &local, &uv);
        let (rows, cols) = (heights.knots_u().greville(), heights.knots_v().greville());
        let net = heights.control_points().iter().enumerate().map(|(i, point)| {
            let place = ground.place(DVec2::new(rows[i / cols.len()], cols[i % cols.len()]));
            place.x * along + place.y * across + (point.z + trend.height(place)) * up
        });
        let (knots_u, knots_v) = (heights.knots_u().clone(), heights.knots_v().clone());
        let surface = NurbsSurface::new(net.collect(), None, knots_u, knots_v)?;
        let (expected, expected_in_gaps) = (f64::INFINITY, f64::INFINITY);
        Ok(HeightFit {
            surface,
            uv,
            residuals,
            fairness,
            anisotropy: 1.0,
            reach,
            expected,
            expected_in_gaps,
        })
    }

    /// The surface over the regression plane, tightened until it does not overshoot, and the reach
    /// for it, which never exceeds the known one.
    fn tightened(
        &self,
        mut equations: Equations,
        fairness: f64,
        known: Option<f64>,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<(NurbsSurface, Option<f64>)> {
        if let Some(reach) = known {
            equations.tighten(reach);
        }
        let (low, high) = min_max(self.local.iter().map(|point| point.z));
        let beyond = SETTINGS.max_overshoot * (high - low);
        let (mut heights, mut reach) = (equations.solve(fairness, check_interrupt)?, known);
        while fairness > 0.0 && reach.is_none_or(|reach| reach > SETTINGS.min_reach) {
            let (lowest, highest) = min_max(self::heights(&heights));
            if low - beyond <= lowest && highest <= high + beyond {
                break;
            }
            let shorter = SETTINGS.reach_factor * reach.unwrap_or(1.0);
            equations.tighten(shorter);
            (heights, reach) = (equations.solve(fairness, check_interrupt)?, Some(shorter));
        }
        Ok((heights, reach))
    }

    pub(super) fn weight(&self, i: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights[i])
    }
}

/// Whether a quadratic vanishes on all places. Then one of its terms is a linear combination of
/// those before it.
fn on_conic(uv: &[DVec2]) -> bool {
    let terms = |place: DVec2| {
        let DVec2 { x, y } = 2.0 * place - 1.0;
        [1.0, x, y, x * x, x * y, y * y]
    };
    let count = terms(DVec2::ZERO).len();
    let mut moments = DenseMatrix::new(count);
    for place in uv.iter().step_by(uv.len().div_ceil(LEAST_SQUARES.max_samples).max(1)) {
        let terms = terms(*place);
        for (i, a) in terms.iter().enumerate() {
            terms.iter().enumerate().for_each(|(j, b)| moments.values[i * count + j] += a * b);
        }
    }
    let Some(lower) = moments.cholesky() else { return true };
    (0..count * count)
        .step_by(count + 1)
        .any(|at| lower.values[at].powi(2) < SETTINGS.min_conic_share * moments.values[at])
}

/// Heights of a surface, evenly over its domain.
pub(super) fn heights(surface: &NurbsSurface) -> impl Iterator<Item = f64> {
    let (u, v) = (surface.knots_u(), surface.knots_v());
    let [rows, cols] = [u, v].map(|knots| 2 * (knots.control_points() - knots.degree()));
    let place = |i: usize| {
        DVec2::new((i / (cols + 1)) as f64 / rows as f64, (i % (cols + 1)) as f64 / cols as f64)
    };
    Patches::of(surface).each((rows + 1) * (cols + 1), place, |_, place| place.point.z).into_iter()
}

/// Heights of points over a surface.
fn residuals(surface: &NurbsSurface, local: &[DVec3], uv: &[DVec2]) -> Vec<f64> {
    Patches::of(surface).each(uv.len(), |i| uv[i], |i, place| local[i].z - place.point.z)
}
