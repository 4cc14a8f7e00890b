//! Likelihood of a boundary: how likely points end at a smooth curve.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::super::dense_matrix::DenseMatrix;
use super::super::sizes::POINTS_PER_TASK;
use super::settings::LikelihoodSettings;
use crate::nurbs::{Basis, KnotVector, gauss};

const SETTINGS: LikelihoodSettings = LikelihoodSettings::STANDARD;

pub(super) const DEGREE: usize = 3;

/// The basis functions at a point's x, and its y.
pub(super) struct BoundaryPoint {
    pub(super) basis: Basis<4>,
    pub(super) y: f64,
    /// Least scale of its blur.
    pub(super) least: f64,
}

impl BoundaryPoint {
    /// The height over a curve, in scales of the blur, and this scale.
    fn height_above(&self, heights: &[f64], scale: f64) -> (f64, f64) {
        let scale = scale.max(self.least);
        ((self.y - height(heights, &self.basis)) / scale, scale)
    }
}

/// The likelihood of smooth curves, y over x in [0, 1], as the lower boundary of points (x, y).
///
/// Points are a Poisson process. Its density rises across the curve from 0 below to its value above
/// like a logistic function. The logarithm of the likelihood is the sum of ln logistic((y - curve)
/// / scale), plus the density times the area under the curve. It is concave, and so is the penalty
/// on bending. A closed curve is periodic in x.
pub(super) struct Likelihood {
    pub(super) knots: KnotVector,
    /// Points that may influence a curve, lowest first.
    pub(super) places: Vec<BoundaryPoint>,
    /// The largest of the points' least scales.
    coarsest: f64,
    /// Every `stride`-th point is used, with `stride` as its weight.
    stride: usize,
    /// Derivatives of the area term by each control point: density times the area under a basis
    /// function.
    pub(super) slopes: Vec<f64>,
    count: f64,
    pub(super) closed: bool,
    /// Penalty on bending: the area, in unit squares, that weighs as much as half a squared second
    /// difference of 1.
    pub(super) penalty: f64,
    /// Least and largest height of curves.
    bounds: (f64, f64),
}

impl Likelihood {
    /// The likelihood of curves over these knots. `count` is the number of all points, including
    /// those that influence no curve; their density is uniform over the unit square.
    pub(super) fn new(
        places: impl Iterator<Item = (f64, f64)>,
        count: usize,
        knots: KnotVector,
        penalty: f64,
        bounds: (f64, f64),
    ) -> Self {
        let closed = knots.is_periodic();
        let control_points = knots.control_points() - if closed { DEGREE } else { 0 };
        let mut places: Vec<(f64, f64)> = places.collect();
        places.sort_by(|a, b| a.1.total_cmp(&b.1));
        let place = |(x, y)| BoundaryPoint { basis: Basis::at(&knots, x), y, least: 0.0 };
        let places = places.into_par_iter().with_min_len(POINTS_PER_TASK).map(place).collect();
        let count = count as f64;
        let slopes = areas(&knots, control_points).iter().map(|area| count * area).collect();
        Self { knots, places, coarsest: 0.0, stride: 1, slopes, count, closed, penalty, bounds }
    }

    /// Finds the likeliest curve, if y has noise of this size, by decreasing scales of the blur.
    /// Before each smaller scale, `update_density` may improve the density. Returns the last scale.
    pub(super) fn find(
        &mut self,
        heights: &mut Vec<f64>,
        noise: f64,
        mut update_density: impl FnMut(&mut Self, &[f64]),
    ) -> f64 {
        // The mean distance at which points touch a curve with this number of degrees of freedom.
        let mean_distance = self.slopes.len() as f64 / self.count;
        // A logistic distribution with a standard deviation of 1 has a scale of √3 / π.
        let last = (noise * 3.0_f64.sqrt() / PI).max(0.5 * mean_distance);
        let mut scale = SETTINGS.first_scale.max(last);
        loop {
            let most = if scale > last { SETTINGS.max_blurred_points } else { self.places.len() };
            self.stride = (self.places.len() / most.max(1)).max(1);
            self.maximize(heights, scale);
            if scale <= last {
                return scale;
            }
            scale = (0.5 * scale).max(last);
            update_density(self, heights);
        }
    }

    /// Raises the least blur of each point to the distance at which points of the local density
    /// touch a curve.
    pub(super) fn blur_by_density(&mut self) {
        for place in &mut self.places {
            place.least = 0.5 / height(&self.slopes, &place.basis);
        }
        self.coarsest = self.places.iter().map(|place| place.least).fold(0.0, f64::max);
    }

    /// Triples of control points whose second differences measure bending.
    fn bend_triples(&self) -> impl Iterator<Item = [usize; 3]> {
        let (count, closed) = (self.slopes.len(), self.closed);
        let middles = if closed { 0..count } else { 1..count - 1 };
        middles.map(move |i| [(i + count - 1) % count, i, (i + 1) % count])
    }

    /// Points that may influence a curve, which lies below its highest control point.
    fn influential(&self, heights: &[f64], scale: f64) -> impl Iterator<Item = &BoundaryPoint> {
        let scale = scale.max(self.coarsest);
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is_near = |place: &BoundaryPoint| place.y <= highest + SETTINGS.max_influence * scale;
        self.places[..self.places.partition_point(is_near)].iter().step_by(self.stride)
    }

    /// Newton steps to the likeliest curve at this scale. Returns the expansion there.
    pub(super) fn maximize(&self, heights: &mut Vec<f64>, scale: f64) -> LocalExpansion {
        let mut here = self.local(heights, scale);
        for _ in 0..SETTINGS.max_steps {
            let Some(step) = here.step() else { return here };
            let mut share = 1.0;
            let mut moved = 0.0;
            for _ in 0..SETTINGS.max_steps {
                let steps = heights.iter().zip(&step);
                let next: Vec<f64> = steps
                    .map(|(h, s)| (h + share * s).clamp(self.bounds.0, self.bounds.1))
                    .collect();
                let there = self.local(&next, scale);
                if there.value >= here.value {
                    let moves = next.iter().zip(heights.iter()).map(|(a, b)| (a - b).abs());
                    moved = moves.fold(0.0, f64::max);
                    (*heights, here) = (next, there);
                    break;
                }
                share *= 0.5;
            }
            if moved < SETTINGS.converged_step * scale {
                break;
            }
        }
        here
    }

    /// Standard deviations of the height at the Greville abscissa of each control point, by
    /// Laplace's approximation: the expansion's matrix is the inverse of the covariance.
    pub(super) fn standard_deviations(&self, here: &LocalExpansion) -> Vec<f64> {
        let size = self.slopes.len();
        let Some(factor) = here.matrix.cholesky() else {
            return vec![0.0; size];
        };
        let deviation = |x: f64| {
            let x = if self.closed { x.rem_euclid(1.0) } else { x.clamp(0.0, 1.0) };
            let values = sums([&Basis::at(&self.knots, x)], size);
            let variance: f64 = factor.solve(&values).iter().zip(&values).map(|(a, b)| a * b).sum();
            variance.sqrt()
        };
        self.knots.greville().into_iter().take(size).map(deviation).collect()
    }

    /// The logarithm of the evidence for this penalty, by Laplace's approximation around the
    /// likeliest curve, up to a constant.
    pub(super) fn evidence(&self, LocalExpansion { value, matrix, .. }: &LocalExpansion) -> f64 {
        let Some(factor) = matrix.cholesky() else { return f64::NEG_INFINITY };
        let bends = self.bend_triples().count() as f64;
        value + 0.5 * (bends * self.penalty.ln() - factor.ln_determinant())
    }

    /// Chooses the penalty with the largest evidence, and its likeliest curve. Returns the
    /// expansion there.
    pub(super) fn choose_penalty(
        &mut self,
        heights: &mut Vec<f64>,
        scale: f64,
        penalties: &[f64],
    ) -> LocalExpansion {
        let mut trial = heights.clone();
        let (mut most, mut best) = (f64::NEG_INFINITY, (self.penalty, None));
        for &penalty in penalties {
            self.penalty = penalty;
            let here = self.maximize(&mut trial, scale);
            let evidence = self.evidence(&here);
            if evidence > most {
                (most, best) = (evidence, (penalty, Some(here)));
                heights.clone_from(&trial);
            }
        }
        self.penalty = best.0;
        best.1.unwrap_or_else(|| self.local(heights, scale))
    }

    /// The log-likelihood of a curve, and the equations of the Newton step from it.
    pub(super) fn local(&self, heights: &[f64], scale: f64) -> LocalExpansion {
        let size = self.slopes.len();
        let mut matrix = DenseMatrix::new(size);
        let mut slopes = self.slopes.clone();
        let area: f64 = slopes.iter().zip(heights).map(|(slope, height)| slope * height).sum();
        let (mut likely, mut bending) = (0.0, 0.0);
        // A product of factors up to 2, so that one logarithm serves many points.
        let mut factors = 1.0_f64;
        for place in self.influential(heights, scale) {
            let (basis, (z, scale)) = (&place.basis, place.height_above(heights, scale));
            if z > SETTINGS.max_influence {
                continue;
            }
            let small = (-z.abs()).exp();
            likely += z.min(0.0);
            factors *= 1.0 + small;
            if factors > f64::MAX.sqrt() {
                likely -= factors.ln();
                factors = 1.0;
            }
            let share = if z > 0.0 { small } else { 1.0 } / (1.0 + small);
            let falls = self.stride as f64 * share;
            let bends = falls * (1.0 - share) / (scale * scale);
            let touched = [0, 1, 2, 3].map(|i| wrapped(basis.first + i, size));
            for (k, (i, a)) in touched.into_iter().zip(basis.values).enumerate() {
                slopes[i] -= falls / scale * a;
                for (j, b) in touched.into_iter().zip(basis.values).take(k + 1) {
                    // A factorization needs only the lower half.
                    matrix.values[i.max(j) * size + i.min(j)] += bends * a * b;
                }
            }
        }
        likely -= factors.ln();
        let stiff = self.penalty * self.count;
        for three in self.bend_triples() {
            let bent = bend(heights, three);
            bending += bent * bent;
            for (&row, a) in three.iter().zip(SECOND_DIFFERENCE) {
                slopes[row] -= stiff * bent * a;
                for (&col, b) in three.iter().zip(SECOND_DIFFERENCE) {
                    matrix.values[row * size + col] += stiff * a * b;
                }
            }
        }
        matrix.add_ridge(SETTINGS.ridge);
        let value = area + self.stride as f64 * likely - 0.5 * stiff * bending;
        LocalExpansion { value, matrix, slopes }
    }
}

/// The quadratic expansion of the log-likelihood at a curve.
pub(super) struct LocalExpansion {
    /// The logarithm of the likelihood, minus the penalty on bending.
    value: f64,
    /// The negative second derivatives.
    matrix: DenseMatrix,
    /// The derivatives by the height of each control point.
    slopes: Vec<f64>,
}

impl LocalExpansion {
    /// The Newton step to a likelier curve.
    fn step(&self) -> Option<Vec<f64>> {
        self.matrix.cholesky().map(|factor| factor.solve(&self.slopes))
    }
}

const SECOND_DIFFERENCE: [f64; 3] = [1.0, -2.0, 1.0];

fn bend(heights: &[f64], three: [usize; 3]) -> f64 {
    three.iter().zip(SECOND_DIFFERENCE).map(|(&i, share)| share * heights[i]).sum()
}

/// The curve's height at these basis functions; closed curves repeat their control points.
pub(super) fn height(heights: &[f64], basis: &Basis<4>) -> f64 {
    weighted(heights, basis.first, &basis.values)
}

/// The index of a control point after those that a closed curve repeats.
fn wrapped(index: usize, control_points: usize) -> usize {
    if index < control_points { index } else { index - control_points }
}

/// The weighted sum of heights from the first on; closed curves repeat them.
fn weighted(heights: &[f64], first: usize, weights: &[f64; 4]) -> f64 {
    let at = |i: usize| wrapped(first + i, heights.len());
    weights.iter().enumerate().map(|(i, weight)| weight * heights[at(i)]).sum()
}

/// Sums of the basis functions over points; closed curves repeat them.
pub(super) fn sums<'a>(
    bases: impl IntoIterator<Item = &'a Basis<4>>,
    control_points: usize,
) -> Vec<f64> {
    let mut sums = vec![0.0; control_points];
    for basis in bases {
        for (i, value) in basis.values.iter().enumerate() {
            sums[wrapped(basis.first + i, control_points)] += value;
        }
    }
    sums
}

/// The area under each basis function; closed curves repeat them.
fn areas(knots: &KnotVector, control_points: usize) -> Vec<f64> {
    let mut areas = vec![0.0; control_points];
    for span in knots.breaks().windows(2) {
        let length = span[1] - span[0];
        for (place, weight) in gauss::rule(DEGREE) {
            let basis = Basis::<4>::at(knots, span[0] + place * length);
            for (i, value) in basis.values.iter().enumerate() {
                areas[wrapped(basis.first + i, control_points)] += weight * length * value;
            }
        }
    }
    areas
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Points evenly over the unit square.
    pub(crate) fn even() -> impl Iterator<Item = (f64, f64)> {
        let spread = |i: usize| {
            let at = |share: f64| (0.5 + share * i as f64).fract();
            (at(0.754_877_666_246_693), at(0.569_840_290_998_053))
        };
        (0..3000).map(spread)
    }

    /// The points above a curve.
    pub(in super::super) fn above(curve: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        even().filter(|&(x, y)| y > curve(x)).collect()
    }

    /// The penalty with the largest evidence for points above a curve.
    fn likeliest_penalty(curve: impl Fn(f64) -> f64) -> f64 {
        let places = above(curve);
        let mut best = (f64::NEG_INFINITY, 0.0);
        for penalty in [100.0, 1.0, 0.01] {
            let all = places.iter().copied();
            let knots = KnotVector::periodic_uniform(DEGREE, 16).unwrap();
            let mut found = Likelihood::new(all, places.len(), knots, penalty, (-1.0, 1.0));
            let mut heights = vec![0.0; 16];
            let scale = found.find(&mut heights, 0.0, |_, _| {});
            let evidence = found.evidence(&found.local(&heights, scale));
            if evidence > best.0 {
                best = (evidence, penalty);
            }
        }
        best.1
    }

    #[test]
    fn level_curves_are_stiff_and_wavy_ones_are_not() {
        assert_eq!(likeliest_penalty(|_| 0.1), 100.0);
        assert_eq!(likeliest_penalty(|x| 0.2 + 0.1 * (18.85 * x).sin()), 0.01);
    }
}
