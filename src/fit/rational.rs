//! Weights of the control points as well: rational surfaces, for what is round.
//!
//! Spheres and cylinders are rational surfaces and no polynomial ones, so fewer control points do
//! when their weights are free. Multiplied by its denominator, the distance from a point p to the
//! surface is linear in the homogeneous net (W. Ma and J.-P. Kruth, *NURBS curve and surface fitting
//! for reverse engineering*, 1998); dividing by the denominator of the step before makes it the
//! distance itself.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::dense::Dense;
use crate::error::{Error, Result};
use crate::nurbs::{ClosestPointSearch, KnotVector, NurbsSurface, padded};
use crate::progress::{Observer, Progress, Stage, report};

/// Nets with more different control points are left as they are: the equations are dense.
const MOST_UNKNOWNS: usize = 900;

/// Weights are kept between these, so that no part of the surface hangs on one control point.
const WEIGHTS: (f64, f64) = (0.1, 10.0);

/// How strongly weights are drawn to 1, as a share of what the points say of them.
const PULL: f64 = 1e-9;

/// A share of the diagonal that is added to it, so that control points that no point holds stay near
/// the middle and do not run away.
const RIDGE: f64 = 1e-12;

/// Steps at most; each finds new feet, a net and weights.
const MOST_STEPS: usize = 12;

/// Shares of a step that are tried, the longest first.
const SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.03];

/// Steps end when the mean squared distance falls by less than this share.
const ENOUGH: f64 = 0.01;

/// A rational surface must be better than the polynomial one by this share of the mean squared
/// distance to be worth its weights.
const WORTH: f64 = 0.05;

/// Frees the weights of a surface near points: the same knots and as many control points, moved and
/// weighted so that the mean of the squared distances (each with its weight, 1 without) falls.
///
/// It is never worse: what does not gain a twentieth of that mean comes back as it was, and so do
/// surfaces that are rational already or have more than 900 control points.
///
/// ```
/// use neurbs::{DVec2, DVec3, NurbsSurface, fit::{FitOptions, fit, rational}, progress::Silent};
/// // A quarter of a cylinder, by a net of 3 × 2.
/// let uv: Vec<DVec2> =
///     (0..400).map(|i| DVec2::new(f64::from(i % 20), f64::from(i / 20)) / 19.0).collect();
/// let points: Vec<DVec3> = uv.iter().map(|at| DVec2::from_angle(1.5 * at.x).extend(at.y)).collect();
/// let polynomial = fit(&points, &uv, None, &FitOptions::new((3, 2), (2, 1), (false, false))?)?;
/// let rational = rational(&polynomial, &points, None, &mut Silent)?;
/// let error = |s: &NurbsSurface| (s.point(0.3, 0.5).truncate().length() - 1.0).abs();
/// assert!(error(&polynomial) > 1e-3 && error(&rational) < 1e-6);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] if there are not as many weights as points; [`Error::Interrupted`] if the
/// observer stops it.
pub fn rational(
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
    if surface.weights().is_some() || unknowns.count() > MOST_UNKNOWNS || points.is_empty() {
        return Ok(surface.clone());
    }
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let (mut uv, first) = feet(surface, points, &weight)?;
    let (mut best, mut error) = (surface.clone(), first);
    let mut of_net = vec![1.0; unknowns.count()];
    for step in 0..MOST_STEPS {
        let (step, total) = (step as u64, MOST_STEPS as u64);
        report(observer, &Progress::of_stage(Stage::Fitting, step, total, points.len()))?;
        let Some(wanted) = unknowns.weights(&best, points, &uv, &weight) else { break };
        let tried = SHARES.iter().find_map(|share| {
            let between =
                |(old, new): (&f64, &f64)| (old + share * (new - old)).clamp(WEIGHTS.0, WEIGHTS.1);
            let tried: Vec<f64> = of_net.iter().zip(&wanted).map(between).collect();
            let surface = unknowns.net(&best, points, &uv, &weight, &tried)?;
            let (uv, squared) = feet(&surface, points, &weight).ok()?;
            (squared < error).then_some((surface, uv, squared, tried))
        });
        let Some((surface, feet, squared, tried)) = tried else { break };
        let gained = 1.0 - squared / error;
        (best, uv, error, of_net) = (surface, feet, squared, tried);
        if gained < ENOUGH {
            break;
        }
    }
    Ok(if error < (1.0 - WORTH) * first { best } else { surface.clone() })
}

/// The points' feet, and the sum of the squared distances to them.
fn feet(
    surface: &NurbsSurface,
    points: &[DVec3],
    weight: &(impl Fn(usize) -> f64 + Sync),
) -> Result<(Vec<DVec2>, f64)> {
    let search = ClosestPointSearch::new(surface)?;
    let found: Vec<_> = points.par_iter().map(|&point| search.closest_point(point)).collect();
    let squared = found.iter().enumerate().map(|(i, foot)| weight(i) * foot.distance.powi(2));
    let sum = squared.sum();
    Ok((found.iter().map(|foot| foot.uv).collect(), sum))
}

/// The control points that differ: those that a closed direction repeats are folded together.
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
        let (rows, cols) = (padded(u, uv.x), padded(v, uv.y));
        let mut functions = Vec::with_capacity((u.degree() + 1) * (v.degree() + 1));
        for (i, row) in rows.values.iter().take(u.degree() + 1).enumerate() {
            for (j, col) in cols.values.iter().take(v.degree() + 1).enumerate() {
                functions.push((self.index(rows.first + i, cols.first + j), row * col));
            }
        }
        functions
    }

    /// The surface's weights at a point of which these are the functions.
    fn denominator(functions: &[(usize, f64)], weights: &[f64]) -> f64 {
        functions.iter().map(|&(k, value)| value * weights[k]).sum()
    }

    fn own_weights(&self, surface: &NurbsSurface) -> Vec<f64> {
        let mut own = vec![1.0; self.count()];
        for (at, &weight) in surface.weights().unwrap_or_default().iter().enumerate() {
            own[self.index(at / self.shape.1, at % self.shape.1)] = weight;
        }
        own
    }

    /// The weights that, with the best control points for them, bring the surface nearest to the
    /// points at these parameters: the net is eliminated from the equations, the mean is kept at 1.
    fn weights(
        &self,
        surface: &NurbsSurface,
        points: &[DVec3],
        uv: &[DVec2],
        weight: &impl Fn(usize) -> f64,
    ) -> Option<Vec<f64>> {
        let size = self.count();
        let own = self.own_weights(surface);
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        // Unknown are Q, a net times its weights, and 1 + d, the weights: Σ |B Q - p B (1 + d)|².
        let mut net = Dense::new(size);
        let mut mixed = [(); 3].map(|()| Dense::new(size));
        let mut squares = Dense::new(size);
        for (i, (&point, &at)) in points.iter().zip(uv).enumerate() {
            let point = point - centre;
            let functions = self.functions(surface, at);
            let factor = weight(i) / Self::denominator(&functions, &own).powi(2);
            for &(a, left) in &functions {
                for &(b, right) in &functions {
                    let product = factor * left * right;
                    net.values[a * size + b] += product;
                    squares.values[a * size + b] += product * point.length_squared();
                    for (mixed, along) in mixed.iter_mut().zip(point.to_array()) {
                        mixed.values[a * size + b] += product * along;
                    }
                }
            }
        }
        net.add_ridge(RIDGE);
        let factor = net.cholesky()?;
        let pull = PULL * squares.trace() / size as f64;
        let mut reduced = squares;
        for mixed in &mixed {
            // L⁻¹ M, whose square is Mᵀ N⁻¹ M.
            let half = factor.forward(mixed);
            reduced.subtract_square(&half);
        }
        let right: Vec<f64> = (0..size)
            .map(|a| -(0..size).map(|b| reduced.values[a * size + b]).sum::<f64>())
            .collect();
        (0..size).for_each(|a| reduced.values[a * size + a] += pull);
        let change = reduced.cholesky()?.solve(&right);
        let wanted: Vec<f64> = change.iter().map(|change| 1.0 + change).collect();
        let mean = wanted.iter().sum::<f64>() / size as f64;
        let fine = mean > 0.0 && wanted.iter().all(|weight| weight.is_finite());
        fine.then(|| wanted.iter().map(|weight| weight / mean).collect())
    }

    /// The surface with these weights that is nearest to the points at these parameters.
    fn net(
        &self,
        surface: &NurbsSurface,
        points: &[DVec3],
        uv: &[DVec2],
        weight: &impl Fn(usize) -> f64,
        weights: &[f64],
    ) -> Option<NurbsSurface> {
        let size = self.count();
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let mut matrix = Dense::new(size);
        let mut right = [(); 3].map(|()| vec![0.0; size]);
        for (i, (&point, &at)) in points.iter().zip(uv).enumerate() {
            let functions = self.functions(surface, at);
            let denominator = Self::denominator(&functions, weights);
            let value = |k: usize, value: f64| value * weights[k] / denominator;
            for &(a, left) in &functions {
                let left = weight(i) * value(a, left);
                for (right, along) in right.iter_mut().zip((point - centre).to_array()) {
                    right[a] += left * along;
                }
                for &(b, other) in &functions {
                    matrix.values[a * size + b] += left * value(b, other);
                }
            }
        }
        matrix.add_ridge(RIDGE);
        let factor = matrix.cholesky()?;
        let [x, y, z] = right.map(|right| factor.solve(&right));
        let (rows, cols) = self.shape;
        let unknown = |at: usize| self.index(at / cols, at % cols);
        let point = |k: usize| centre + DVec3::new(x[k], y[k], z[k]);
        let net = (0..rows * cols).map(|at| point(unknown(at))).collect();
        let weights = (0..rows * cols).map(|at| weights[unknown(at)]).collect();
        let (knots_u, knots_v) = (surface.knots_u().clone(), surface.knots_v().clone());
        NurbsSurface::new(net, Some(weights), knots_u, knots_v).ok()
    }
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
        (feet(surface, points, &|_| 1.0).unwrap().1 / points.len() as f64).sqrt()
    }

    #[test]
    fn a_sphere_s_octant_is_met_by_a_small_net() {
        let uv: Vec<DVec2> = grid(25).collect();
        let place = |at: &DVec2| {
            let (longitude, latitude) = (1.2 * at.x, 1.2 * at.y - 0.6);
            (latitude.cos() * DVec2::from_angle(longitude)).extend(latitude.sin()) + 40.0
        };
        let points: Vec<DVec3> = uv.iter().map(place).collect();
        let options = FitOptions::new((3, 3), (2, 2), (false, false)).unwrap();
        let polynomial = fit(&points, &uv, None, &options).unwrap();
        let found = rational(&polynomial, &points, None, &mut Silent).unwrap();
        let (before, after) = (rms(&polynomial, &points), rms(&found, &points));
        assert!(before > 3e-4 && after < 1e-6, "{before:e} {after:e}");
    }

    #[test]
    fn a_closed_tube_stays_closed() {
        let uv: Vec<DVec2> = grid(24).map(|at| DVec2::new(at.x * 23.0 / 24.0, at.y)).collect();
        let points: Vec<DVec3> =
            uv.iter().map(|at| DVec2::from_angle(TAU * at.x).extend(2.0 * at.y)).collect();
        let options = FitOptions::new((5, 2), (2, 1), (true, false)).unwrap();
        let polynomial = fit(&points, &uv, None, &options).unwrap();
        let found = rational(&polynomial, &points, None, &mut Silent).unwrap();
        assert!(rms(&found, &points) <= rms(&polynomial, &points));
        assert!(found.point(0.0, 0.4).distance(found.point(1.0, 0.4)) < 1e-12);
    }

    #[test]
    fn what_is_not_round_comes_back_as_it_was() {
        let uv: Vec<DVec2> = grid(30).collect();
        let points: Vec<DVec3> = uv.iter().map(|at| at.extend(at.x * at.y)).collect();
        let options = FitOptions::new((4, 4), (3, 3), (false, false)).unwrap();
        let polynomial = fit(&points, &uv, None, &options).unwrap();
        let found = rational(&polynomial, &points, None, &mut Silent).unwrap();
        assert!(rms(&found, &points) <= rms(&polynomial, &points));
    }
}
