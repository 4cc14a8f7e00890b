//! Alternating fit: solutions for the net in turn with parameter correction.
//!
//! The input is points with rough parameters and a spline space; output is a surface with the
//! points' projections (W. Wang, H. Pottmann, Y. Liu, 2006).

use std::borrow::Cow;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::band_matrix::BandMatrix;
use super::fairness_choice;
use super::fairness_energy::{Energy, ORDER};
use super::fit_result::{Approximation, EndedBy};
use super::isocurve_length::isocurve_lengths;
use super::normal_equations::{NormalEquations, Sample};
use super::options::ApproximateOptions;
use super::projection::{Projection, projections};
use super::settings::{
    AlternatingFitSettings, FairnessSettings, LeastSquaresSettings, ProjectionSettings,
    SideSettings,
};
use super::sizes::POINTS_PER_TASK;
use super::spline_space::SplineSpace;
use super::straight_sides::{add_margin, bounded};
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{self, Observer, Progress, Stage};

const FAIRNESS: FairnessSettings = FairnessSettings::STANDARD;
const SETTINGS: AlternatingFitSettings = AlternatingFitSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;
const PROJECTION: ProjectionSettings = ProjectionSettings::STANDARD;
const SIDES: SideSettings = SideSettings::STANDARD;

/// The state of an alternating fit.
pub(super) struct AlternatingFit<'a> {
    pub(super) points: &'a [DVec3],
    weights: Option<&'a [f64]>,
    pub(super) uv: Vec<DVec2>,
    pub(super) closed: [bool; 2],
    /// Every `stride`-th point is used.
    stride: usize,
    fixed: Option<f64>,
    /// The last result of cross-validation.
    pub(super) score: Option<fairness_choice::Score>,
    /// Weight of the fairness, which falls from solution to solution.
    pub(super) fairness_weight: f64,
    /// Share of the weight that remains after each solution. More flattens folded sheets; less, too
    /// early, follows noise.
    pub(super) fairness_decay: f64,
    pub(super) iterations: usize,
    /// Solutions with each net while the error decreases slowly.
    pub(super) limit: usize,
    /// Expected number of solutions.
    total: usize,
    /// Rms distance when it was last computed.
    error: Option<f64>,
    pub(super) observer: &'a mut dyn Observer,
    /// The matrix of an earlier solution, whose memory is reused.
    spare: Option<BandMatrix>,
}

impl<'a> AlternatingFit<'a> {
    pub(super) fn new(
        points: &'a [DVec3],
        uv: &[DVec2],
        weights: Option<&'a [f64]>,
        options: &ApproximateOptions,
        observer: &'a mut dyn Observer,
    ) -> Self {
        Self {
            points,
            weights,
            uv: uv.to_vec(),
            closed: options.closed.into(),
            stride: 1,
            fixed: options.fairness,
            score: None,
            fairness_weight: FAIRNESS.first_weight,
            fairness_decay: FAIRNESS.decay,
            iterations: 0,
            limit: options.iterations,
            total: 2 * options.iterations,
            error: None,
            observer,
            spare: None,
        }
    }

    /// Uses as many points as a net of this size needs, at equal steps in their order.
    pub(super) fn subsample_for(&mut self, space: &SplineSpace) {
        let enough =
            (SETTINGS.points_per_control_point * space.unknowns()).max(LEAST_SQUARES.enough_points);
        self.stride = (self.points.len() / enough).max(1);
    }

    /// Uses all points from now on. Returns whether it did not before.
    pub(super) fn use_all_points(&mut self, surface: &NurbsSurface) -> bool {
        let changed = self.stride > 1;
        self.stride = 1;
        if changed {
            self.correct_parameters(surface, 2 * PROJECTION.first_steps);
        }
        changed
    }

    pub(super) fn weight(&self, index: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights[index])
    }

    /// The fairness that the weight falls to. Few points get more, since cross-validation ignores
    /// the freedom of the parameters.
    pub(super) fn target_fairness(&self) -> f64 {
        let count = self.points.len() as f64;
        let least = FAIRNESS.min_weight.max(1.0 / (count * count));
        self.fixed.unwrap_or(self.score.map_or(least, |score| score.fairness.max(least)))
    }

    /// The weight of distances in the tangent plane. Few points need more to determine the net
    /// there.
    fn tangential(&self) -> f64 {
        LEAST_SQUARES.tangential_weight.max(1.0 / self.points.len() as f64)
    }

    /// The fairness energy, with the anisotropy that was found last.
    fn energy(&self, space: &SplineSpace, lengths: (f64, f64)) -> Energy {
        let [p, q] = [0, 1].map(|d| space.knots[d].degree());
        // With few points, a quadratic deviates far from their surface.
        let few = self.points.len() < 2 * space.unknowns();
        let order = if few { ORDER - 1 } else { ORDER };
        // Derivatives of an order beyond the degree vanish.
        let energy = Energy::new(lengths, order.min(p.max(q)));
        self.score.map_or(energy, |score| energy.with_anisotropy(score.anisotropy))
    }

    /// The energy's matrix, and its entries for x, y and z.
    fn energy_matrices(
        &self,
        space: &SplineSpace,
        lengths: (f64, f64),
    ) -> (BandMatrix, Vec<(usize, f64)>) {
        let energy = self.energy(space, lengths).matrix(space);
        let energy_xyz = energy.for_each_axis(&space.matrix(3));
        (energy, energy_xyz)
    }

    /// The surface that minimizes plain distances at the current parameters.
    pub(super) fn first(&mut self, space: &SplineSpace) -> Result<NurbsSurface> {
        let samples = self.samples(None);
        let energy = self.energy(space, (1.0, 1.0)).matrix(space);
        self.solve_distances(space, &samples, &energy, self.fairness_weight)
    }

    /// Samples of the points used: tangent distances at their projections, or plain distances
    /// without projections.
    fn samples(&self, projections: Option<&[Projection]>) -> Vec<Sample> {
        let across = self.tangential();
        let &Self { points, weights, ref uv, stride, .. } = self;
        let sample = |place: usize| {
            let index = place * stride;
            let (point, weight) = (points[index], weights.map_or(1.0, |weights| weights[index]));
            let Some(projection) = projections.map(|projections| projections[place]) else {
                return Sample::plain(point, uv[index], weight);
            };
            let free = !projection.border && projection.normal != DVec3::ZERO;
            let tangential = if free { across } else { 1.0 };
            Sample { point, uv: projection.uv, weight, normal: projection.normal, tangential }
        };
        let places = (0..points.len().div_ceil(stride)).into_par_iter();
        places.with_min_len(POINTS_PER_TASK).map(sample).collect()
    }

    /// A zero matrix for coupled coordinates.
    fn zero_matrix(&mut self, space: &SplineSpace) -> BandMatrix {
        space.matrix_instead(3, self.spare.take())
    }

    /// Minimizes the distances in a spline space, in turn with projection, until the error stops
    /// decreasing.
    pub(super) fn minimize(
        &mut self,
        space: &SplineSpace,
        from: NurbsSurface,
    ) -> Result<NurbsSurface> {
        // The equations, their factor, and the spare.
        space.check_memory(3, 3)?;
        let (lengths, limit) = (isocurve_lengths(&from), self.limit);
        let (mut energy, mut energy_xyz) = self.energy_matrices(space, lengths);
        let (mut surface, mut error) = (from, f64::INFINITY);
        // A surface through all points converges ever faster; the iteration continues as long as it
        // does.
        for iteration in 0..SETTINGS.extension * limit {
            let projections = self.correct_parameters(&surface, PROJECTION.steps);
            let found = self.rms(&projections);
            self.error = Some(found);
            let settled =
                self.fairness_weight <= self.target_fairness() && iteration > 2.min(limit);
            let max_ratio = if iteration < limit {
                1.0 - SETTINGS.min_decrease
            } else {
                1.0 - SETTINGS.min_extended_decrease
            };
            if (settled || iteration >= limit) && found > max_ratio * error {
                break;
            }
            error = found;
            let samples = &self.samples(Some(&projections));
            // Cross-validation again, once the net has its shape, and once the parameters have
            // followed.
            let again = iteration == 2 && self.target_fairness() > FAIRNESS.noisy_weight
                || iteration == limit / 2;
            let select_fairness = self.fixed.is_none() && (iteration == 1 || again);
            let (known, current) = (self.score, self.energy(space, lengths));
            let zero_matrix = self.zero_matrix(space);
            let (score, equations) = rayon::join(
                || select_fairness.then(|| fairness_choice::best(space, samples, current, known)),
                || {
                    NormalEquations::of_tangent_distances(space, samples, zero_matrix, &mut || {
                        Ok(())
                    })
                },
            );
            if let Some(score) = score {
                self.score = score?.or(self.score);
                if self.energy(space, lengths) != current {
                    (energy, energy_xyz) = self.energy_matrices(space, lengths);
                }
            }
            surface = self.solve_tangents(space, equations?, &energy, &energy_xyz)?;
            self.fairness_weight *= self.fairness_decay;
            self.iterations += 1;
        }
        Ok(surface)
    }

    /// Maps the parameters of the projections to the unit square, up to a margin of `border` mean
    /// spacings at open sides, and fits the surface again.
    pub(super) fn fit_on_square(
        &mut self,
        surface: &NurbsSurface,
        border: f64,
    ) -> Result<NurbsSurface> {
        let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
        let space = SplineSpace::new(knots, self.closed)?;
        let lengths = isocurve_lengths(surface);
        let spacing = (lengths.0 * lengths.1 / self.points.len() as f64).sqrt();
        self.correct_parameters(surface, PROJECTION.steps);
        self.uv = bounded(&self.uv, self.closed.into());
        for (d, length) in [lengths.0, lengths.1].into_iter().enumerate() {
            if !self.closed[d] {
                // Surfaces that extend beyond half a spacing of the control points deviate.
                let most = SIDES.max_margin / (space.shape()[d] - 1) as f64;
                add_margin(&mut self.uv, d, (border * spacing / length).min(most));
            }
        }
        let energy = self.energy(&space, lengths).matrix(&space);
        let samples = self.samples(None);
        self.fairness_weight = self.target_fairness();
        self.solve_distances(&space, &samples, &energy, self.fairness_weight)
    }

    /// The approximation by a surface.
    pub(super) fn finish(&mut self, surface: NurbsSurface, ended_by: EndedBy) -> Approximation {
        let projections = self.correct_parameters(&surface, PROJECTION.steps);
        Approximation {
            surface,
            distances: projections.iter().map(|projection| projection.offset.length()).collect(),
            fairness: self.target_fairness(),
            expected: self.score.map(|score| score.error),
            iterations: self.iterations,
            ended_by,
            uv: self.uv.clone(),
        }
    }

    /// Projects the points used, and takes over the parameters of their projections.
    pub(super) fn correct_parameters(
        &mut self,
        surface: &NurbsSurface,
        steps: usize,
    ) -> Vec<Projection> {
        let (points, uv) = (every_nth(self.points, self.stride), every_nth(&self.uv, self.stride));
        let projections = projections(surface, self.closed, &points, &uv, steps);
        drop(uv);
        let moved = self.uv.par_iter_mut().step_by(self.stride).zip(&projections);
        moved.with_min_len(POINTS_PER_TASK).for_each(|(uv, projection)| *uv = projection.uv);
        projections
    }

    /// Rms distance of the points used.
    pub(super) fn rms(&self, projections: &[Projection]) -> f64 {
        let used = (0..self.points.len()).step_by(self.stride).zip(projections);
        let (mut squares, mut weights) = (0.0, 0.0);
        for (weight, projection) in used.map(|(index, projection)| (self.weight(index), projection))
        {
            squares += weight * projection.offset.length_squared();
            weights += weight;
        }
        (squares / weights).sqrt()
    }

    fn solve_distances(
        &mut self,
        space: &SplineSpace,
        samples: &[Sample],
        energy: &BandMatrix,
        fairness: f64,
    ) -> Result<NurbsSurface> {
        let NormalEquations { mut matrix, mut right } =
            NormalEquations::of_distances(space, samples, &mut || Ok(()))?;
        matrix.add_scaled(fairness * matrix.trace() / energy.trace(), energy);
        matrix.add_ridge(LEAST_SQUARES.rounding_ridge);
        self.factor(&mut matrix, space)?;
        matrix.solve(&mut right);
        let net: Vec<DVec3> = right.into_iter().map(DVec3::from_array).collect();
        space.surface(&net)
    }

    /// Solves for tangent distances.
    fn solve_tangents(
        &mut self,
        space: &SplineSpace,
        NormalEquations { mut matrix, right }: NormalEquations,
        energy: &BandMatrix,
        energy_xyz: &[(usize, f64)],
    ) -> Result<NurbsSurface> {
        let fairness = self.fairness_weight.max(self.target_fairness());
        let point_trace = matrix.trace() / (1.0 + 2.0 * self.tangential());
        matrix.add_entries(fairness * point_trace / energy.trace(), energy_xyz);
        matrix.add_ridge(LEAST_SQUARES.rounding_ridge);
        self.factor(&mut matrix, space)?;
        let net = matrix.solved_together(&right);
        self.spare = Some(matrix);
        space.surface(&net)
    }

    fn factor(&mut self, matrix: &mut BandMatrix, space: &SplineSpace) -> Result<()> {
        let step = self.iterations.min(self.total) as u64;
        let progress = Progress {
            error: self.error,
            ..Progress::of_stage(Stage::Fitting, step, self.total as u64, self.points.len())
        };
        if matrix.factor(&mut || progress::report(self.observer, &progress))? {
            return Ok(());
        }
        let [rows, cols] = space.shape();
        let got = format!("{rows} × {cols} for {} points", self.points.len());
        Err(Error::parameter("grid", "small enough for the points to determine it", got))
    }
}

/// Every `stride`-th item.
fn every_nth<T: Copy>(items: &[T], stride: usize) -> Cow<'_, [T]> {
    if stride == 1 { items.into() } else { items.iter().step_by(stride).copied().collect() }
}
