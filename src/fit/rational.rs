//! Rational fit: weights of the control points, for round surfaces.
//!
//! Spheres and cylinders are rational surfaces, so with free weights a smaller net suffices.
//! Gauss-Newton steps change control points and weights together. They minimize the distances to
//! the tangent planes at the points' projections, which are recomputed after each step (W. Wang, H.
//! Pottmann, Y. Liu, 2006, for control points alone).

use glam::{DVec2, DVec3, DVec4};
use rayon::prelude::*;

use super::dense_matrix::DenseMatrix;
use super::settings::{LeastSquaresSettings, RationalSettings};
use crate::error::{Error, Result};
use crate::nurbs::{ClosestPointSearch, KnotVector, MAX_ORDER, NurbsSurface, padded};
use crate::progress::{Observer, Progress, Stage, report};
use crate::worker_pool;

const SETTINGS: RationalSettings = RationalSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Fits the weights of a surface to points. Knots and the number of control points stay. Control
/// points and weights change so that the weighted mean squared distance falls.
///
/// The result is never worse. The surface is returned unchanged in these cases:
///
/// - the mean falls by less than a twentieth;
/// - the surface is rational already;
/// - it has more than 256 control points.
///
/// ```
/// use neurbs::{DVec2, DVec3, NurbsSurface, fit::{FitOptions, fit, fit_weights}, progress::Silent};
/// // A quarter of a cylinder, by a net of 3 × 2.
/// let uv: Vec<DVec2> =
///     (0..400).map(|i| DVec2::new(f64::from(i % 20), f64::from(i / 20)) / 19.0).collect();
/// let points: Vec<DVec3> = uv.iter().map(|at| DVec2::from_angle(1.5 * at.x).extend(at.y)).collect();
/// let polynomial = fit(&points, &uv, None, &FitOptions::new((3, 2), (2, 1), (false, false))?, &mut Silent)?;
/// let rational = fit_weights(&polynomial, &points, None, &mut Silent)?;
/// let error = |s: &NurbsSurface| (s.point(0.3, 0.5).truncate().length() - 1.0).abs();
/// assert!(error(&polynomial) > 1e-3 && error(&rational) < 1e-5);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] if there are not as many weights as points; [`Error::Interrupted`] if the
/// observer stops it.
pub fn fit_weights(
    surface: &NurbsSurface,
    points: &[DVec3],
    weights: Option<&[f64]>,
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    if let Some(weights) = weights.filter(|weights| weights.len() != points.len()) {
        let must = format!("as many as the points, {}", points.len());
        return Err(Error::parameter("weights", must, weights.len()));
    }
    let unknowns = Unknowns::of(surface);
    if surface.weights().is_some()
        || unknowns.count() > SETTINGS.max_control_points
        || points.is_empty()
    {
        return Ok(surface.clone());
    }
    worker_pool::run_observed(points.len(), observer, |observer| {
        optimized(surface, &unknowns, points, weights, observer)
    })
}

/// Minimizes over control points and weights.
fn optimized(
    surface: &NurbsSurface,
    unknowns: &Unknowns,
    points: &[DVec3],
    weights: Option<&[f64]>,
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let (mut uv, first) = projections(surface, points, &weight)?;
    let (mut best, mut error) = (surface.clone(), first);
    let center = points.iter().sum::<DVec3>() / points.len() as f64;
    for step in 0..SETTINGS.max_steps {
        let (step, total) = (step as u64, SETTINGS.max_steps as u64);
        report(observer, &Progress::of_stage(Stage::Fitting, step, total, points.len()))?;
        let Some(change) = unknowns.step(&best, points, &uv, &weight, center) else { break };
        let tried = (0..=SETTINGS.max_halvings).find_map(|halvings| {
            let surface = unknowns.moved(&best, &change, 0.5_f64.powi(halvings), center)?;
            let (uv, squared) = projections(&surface, points, &weight).ok()?;
            (squared < error).then_some((surface, uv, squared))
        });
        let Some((surface, projections, squared)) = tried else { break };
        let gained = 1.0 - squared / error;
        (best, uv, error) = (surface, projections, squared);
        if gained < SETTINGS.min_step_decrease {
            break;
        }
    }
    Ok(if error < (1.0 - SETTINGS.min_decrease) * first { best } else { surface.clone() })
}

/// The parameters of the points' projections, and the weighted sum of the squared distances.
fn projections(
    surface: &NurbsSurface,
    points: &[DVec3],
    weight: &(impl Fn(usize) -> f64 + Sync),
) -> Result<(Vec<DVec2>, f64)> {
    let search = ClosestPointSearch::new(surface)?;
    let found: Vec<_> = points.par_iter().map(|&point| search.closest_point(point)).collect();
    let squared =
        found.iter().enumerate().map(|(i, projection)| weight(i) * projection.distance.powi(2));
    let sum = squared.sum();
    Ok((found.iter().map(|projection| projection.uv).collect(), sum))
}

/// The different control points: those that a closed direction repeats are one unknown.
struct Unknowns {
    shape: (usize, usize),
    different: (usize, usize),
}

impl Unknowns {
    fn of(surface: &NurbsSurface) -> Self {
        let (rows, cols) = surface.shape();
        let net = surface.control_points();
        let repeats = |knots: &KnotVector, same: &dyn Fn(usize) -> bool| {
            let degree = knots.degree();
            let closed = knots.is_periodic() && !knots.is_clamped() && (0..degree).all(same);
            if closed { degree } else { 0 }
        };
        let last_row = |i: usize| {
            let last = rows - surface.knots_u().degree() + i;
            (0..cols).all(|j| net[i * cols + j] == net[last * cols + j])
        };
        let last_col = |j: usize| {
            let last = cols - surface.knots_v().degree() + j;
            (0..rows).all(|i| net[i * cols + j] == net[i * cols + last])
        };
        let different = (
            rows - repeats(surface.knots_u(), &last_row),
            cols - repeats(surface.knots_v(), &last_col),
        );
        Self { shape: (rows, cols), different }
    }

    fn count(&self) -> usize {
        self.different.0 * self.different.1
    }

    fn index(&self, i: usize, j: usize) -> usize {
        (i % self.different.0) * self.different.1 + j % self.different.1
    }

    /// Basis functions that differ from zero at a point: unknowns and values.
    fn functions(&self, surface: &NurbsSurface, uv: DVec2) -> Vec<(usize, f64)> {
        let (u, v) = (surface.knots_u(), surface.knots_v());
        let (rows, cols) = (padded::<MAX_ORDER>(u, uv.x), padded::<MAX_ORDER>(v, uv.y));
        let mut functions = Vec::with_capacity((u.degree() + 1) * (v.degree() + 1));
        for (i, row) in rows.values.iter().take(u.degree() + 1).enumerate() {
            for (j, col) in cols.values.iter().take(v.degree() + 1).enumerate() {
                functions.push((self.index(rows.first + i, cols.first + j), row * col));
            }
        }
        functions
    }

    /// A Gauss-Newton step for control points and weights together: the change of the homogeneous
    /// net relative to a center. It minimizes the distances to the tangent planes at the
    /// projections, plus a little of those within the planes.
    fn step(
        &self,
        surface: &NurbsSurface,
        points: &[DVec3],
        uv: &[DVec2],
        weight: &impl Fn(usize) -> f64,
        center: DVec3,
    ) -> Option<Vec<DVec4>> {
        let size = 4 * self.count();
        let own: Vec<f64> = self.homogeneous(surface, center).iter().map(|h| h.w).collect();
        let (mut matrix, mut right) = (DenseMatrix::new(size), vec![0.0; size]);
        for (i, (&point, &at)) in points.iter().zip(uv).enumerate() {
            let functions = self.functions(surface, at);
            let denominator: f64 = functions.iter().map(|&(k, value)| value * own[k]).sum();
            let projection = surface.point(at.x, at.y);
            let normal = surface.normal(at.x, at.y);
            let across =
                if is_on_border(surface, at) { 1.0 } else { LEAST_SQUARES.tangential_weight };
            let seen = |v: DVec3| across * v + (1.0 - across) * normal.dot(v) * normal;
            // The motion of the foot point when x, y, z or the weight of a control point grows.
            let moves =
                [DVec3::X, DVec3::Y, DVec3::Z, center - projection].map(|v| v / denominator);
            let images = moves.map(|v| weight(i) * seen(v));
            let block = moves.map(|v| images.map(|image| v.dot(image)));
            for &(k, left) in &functions {
                for (a, row) in block.iter().enumerate() {
                    right[4 * k + a] += left * images[a].dot(point - projection);
                    let line = &mut matrix.values[(4 * k + a) * size..][..size];
                    for &(l, other) in &functions {
                        for (sum, value) in line[4 * l..4 * l + 4].iter_mut().zip(row) {
                            *sum += left * other * value;
                        }
                    }
                }
            }
        }
        // A common factor of all weights changes nothing, so the matrix needs a ridge.
        matrix.add_ridge(LEAST_SQUARES.ridge);
        let change = matrix.cholesky()?.solve(&right);
        let change: Vec<DVec4> = change.chunks(4).map(DVec4::from_slice).collect();
        change.iter().all(|change| change.is_finite()).then_some(change)
    }

    /// The different control points relative to a center, in homogeneous coordinates.
    fn homogeneous(&self, surface: &NurbsSurface, center: DVec3) -> Vec<DVec4> {
        let mut net = vec![DVec4::ZERO; self.count()];
        for (at, &point) in surface.control_points().iter().enumerate() {
            let weight = surface.weights().map_or(1.0, |weights| weights[at]);
            let own = self.index(at / self.shape.1, at % self.shape.1);
            net[own] = ((point - center) * weight).extend(weight);
        }
        net
    }

    /// The surface after a share of a step. `None` if a weight exceeds its bounds.
    fn moved(
        &self,
        surface: &NurbsSurface,
        change: &[DVec4],
        share: f64,
        center: DVec3,
    ) -> Option<NurbsSurface> {
        let own = self.homogeneous(surface, center);
        let net: Vec<DVec4> = own.iter().zip(change).map(|(h, d)| *h + share * *d).collect();
        let mean = net.iter().map(|h| h.w).sum::<f64>() / net.len() as f64;
        let (least, most) = SETTINGS.weights;
        if !net.iter().all(|h| (least * mean..=most * mean).contains(&h.w)) {
            return None;
        }
        let (rows, cols) = self.shape;
        let at = |at: usize| net[self.index(at / cols, at % cols)];
        let points = (0..rows * cols).map(|i| center + at(i).truncate() / at(i).w).collect();
        let weights = (0..rows * cols).map(|i| at(i).w / mean).collect();
        let (knots_u, knots_v) = (surface.knots_u().clone(), surface.knots_v().clone());
        NurbsSurface::new(points, Some(weights), knots_u, knots_v).ok()
    }
}

/// Whether a foot point lies on an open border, where the point may be beyond the surface.
fn is_on_border(surface: &NurbsSurface, uv: DVec2) -> bool {
    let ends = |knots: &KnotVector, at: f64| {
        let (start, end) = knots.domain();
        knots.is_clamped() && (at <= start || at >= end)
    };
    ends(surface.knots_u(), uv.x) || ends(surface.knots_v(), uv.y)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::fit::{FitOptions, fit};
    use crate::progress::Silent;

    fn grid(count: u32) -> impl Iterator<Item = DVec2> {
        let side = f64::from(count - 1);
        (0..count * count)
            .map(move |i| DVec2::new(f64::from(i % count), f64::from(i / count)) / side)
    }

    fn rms(surface: &NurbsSurface, points: &[DVec3]) -> f64 {
        (projections(surface, points, &|_| 1.0).unwrap().1 / points.len() as f64).sqrt()
    }

    #[test]
    fn a_small_rational_net_fits_part_of_a_sphere() {
        let uv: Vec<DVec2> = grid(25).collect();
        let place = |at: &DVec2| {
            let (longitude, latitude) = (1.2 * at.x, 1.2 * at.y - 0.6);
            (latitude.cos() * DVec2::from_angle(longitude)).extend(latitude.sin()) + 40.0
        };
        let points: Vec<DVec3> = uv.iter().map(place).collect();
        let options = FitOptions::new((3, 3), (2, 2), (false, false)).unwrap();
        let polynomial = fit(&points, &uv, None, &options, &mut Silent).unwrap();
        let found = fit_weights(&polynomial, &points, None, &mut Silent).unwrap();
        let (before, after) = (rms(&polynomial, &points), rms(&found, &points));
        assert!(after < 1e-3 * before, "{before:e} {after:e}");
    }

    #[test]
    fn a_closed_tube_stays_closed() {
        let uv: Vec<DVec2> = grid(24).map(|at| DVec2::new(at.x * 23.0 / 24.0, at.y)).collect();
        let points: Vec<DVec3> =
            uv.iter().map(|at| DVec2::from_angle(TAU * at.x).extend(2.0 * at.y)).collect();
        let options = FitOptions::new((5, 2), (2, 1), (true, false)).unwrap();
        let polynomial = fit(&points, &uv, None, &options, &mut Silent).unwrap();
        let found = fit_weights(&polynomial, &points, None, &mut Silent).unwrap();
        assert!(rms(&found, &points) <= rms(&polynomial, &points));
        assert!(found.point(0.0, 0.4).distance(found.point(1.0, 0.4)) < 1e-12);
    }

    #[test]
    fn a_surface_that_is_not_round_does_not_get_worse() {
        let uv: Vec<DVec2> = grid(30).collect();
        let points: Vec<DVec3> = uv.iter().map(|at| at.extend(at.x * at.y)).collect();
        let options = FitOptions::new((4, 4), (3, 3), (false, false)).unwrap();
        let polynomial = fit(&points, &uv, None, &options, &mut Silent).unwrap();
        let found = fit_weights(&polynomial, &points, None, &mut Silent).unwrap();
        assert!(rms(&found, &points) <= rms(&polynomial, &points));
    }
}
