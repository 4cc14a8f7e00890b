//! Coarse fit: a small net fitted to a few thousand points, to compare hypotheses.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::band_matrix::BandMatrix;
use super::biweight::{MAD_TO_DEVIATION, biweight};
use super::fairness_energy::Energy;
use super::normal_equations::{NormalEquations, Sample};
use super::patches::Patches;
use super::projection::projections;
use super::settings::{CoarseSettings, FairnessSettings, LeastSquaresSettings};
use super::spline_space::SplineSpace;
use super::validation_groups::ValidationGroups;
use crate::error::{Error, Result};
use crate::numeric::{median, rms, whole};
use crate::nurbs::{KnotVector, NurbsSurface};

const FAIRNESS: FairnessSettings = FairnessSettings::STANDARD;
const LEAST_SQUARES: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Points with rough parameters.
#[derive(Clone, Copy, Debug)]
pub struct CoarseProblem<'a> {
    /// The points.
    pub points: &'a [DVec3],
    /// Their parameters in [0, 1]².
    pub uv: &'a [DVec2],
    /// Lengths of the surface along u and v.
    pub lengths: [f64; 2],
    /// Directions that close.
    pub closed: [bool; 2],
    /// Whether parameters stay as they are, as those of height fields do.
    pub fixed: bool,
    /// The noise of the points, in their unit. Smaller distances never make an outlier.
    pub noise: f64,
}

/// The result of a coarse fit.
#[derive(Clone, Debug)]
pub struct CoarseFit {
    /// The surface over [0, 1]².
    pub surface: NurbsSurface,
    /// The parameters of the points' projections.
    pub uv: Vec<DVec2>,
    /// The points' distances from the surface.
    pub distances: Vec<f64>,
    /// The weight of the fairness.
    pub fairness: f64,
    /// Rms distance of points that were left out, in turn and by blocks in space.
    pub held_out: [f64; 2],
    /// The distance of each point when it was left out in turn.
    pub left_out: Vec<f64>,
}

/// Rms distance of the points from a surface with few control points, after one solution and one
/// projection step.
///
/// # Errors
///
/// [`Error::Parameter`] if the points do not determine the net.
pub fn quick_error(problem: &CoarseProblem<'_>, settings: &CoarseSettings) -> Result<f64> {
    let mut solver = CoarseSolver::new(problem, settings, settings.quick_control_points)?;
    let surface = solver.solve(settings.first_fairness)?;
    solver.project_parameters(&surface);
    Ok(rms(solver.distances(&surface)))
}

/// The coarse fit: parameters are corrected, outliers lose their weight, and cross-validation
/// chooses the fairness.
///
/// # Errors
///
/// [`Error::Parameter`] if the points do not determine the net.
pub fn coarse(
    problem: &CoarseProblem<'_>,
    groups: &ValidationGroups,
    settings: &CoarseSettings,
) -> Result<CoarseFit> {
    let mut solver = CoarseSolver::new(problem, settings, settings.control_points.1)?;
    let mut fairness = solver.cross_validated()?.max(settings.first_fairness);
    for round in 1..settings.rounds {
        let surface = solver.solve(fairness)?;
        solver.project_parameters(&surface);
        solver.reweight(&surface, round);
    }
    fairness = solver.cross_validated()?;
    let (fairness, held_out, left_out) = solver.raise_fairness(fairness, groups)?;
    let surface = solver.solve(fairness)?;
    let distances = solver.distances(&surface);
    Ok(CoarseFit { surface, uv: solver.uv, distances, fairness, held_out, left_out })
}

/// The points of a group, and the equations of all others.
struct GroupEquations {
    points_out: Vec<usize>,
    others: NormalEquations,
}

/// The state of a coarse fit.
struct CoarseSolver<'a> {
    problem: &'a CoarseProblem<'a>,
    settings: &'a CoarseSettings,
    space: SplineSpace,
    energy: BandMatrix,
    uv: Vec<DVec2>,
    weights: Vec<f64>,
}

impl<'a> CoarseSolver<'a> {
    fn new(
        problem: &'a CoarseProblem<'a>,
        settings: &'a CoarseSettings,
        max_control_points: usize,
    ) -> Result<Self> {
        let [rows, cols] = net(problem, settings, max_control_points);
        let knots = |count, closed| {
            if closed {
                KnotVector::periodic_uniform(3, count)
            } else {
                KnotVector::clamped_uniform(3, count)
            }
        };
        let [closed_u, closed_v] = problem.closed;
        let knots = [knots(rows, closed_u)?, knots(cols, closed_v)?];
        let space = SplineSpace::new(knots, problem.closed)?;
        let [along_u, along_v] = problem.lengths;
        let energy = Energy::new((along_u, along_v), 2).matrix(&space);
        let (uv, weights) = (problem.uv.to_vec(), vec![1.0; problem.points.len()]);
        Ok(Self { problem, settings, space, energy, uv, weights })
    }

    fn samples(&self, included: impl Fn(usize) -> bool) -> Vec<Sample> {
        let sample = |i: usize| Sample::plain(self.problem.points[i], self.uv[i], self.weights[i]);
        (0..self.uv.len()).filter(|&i| included(i)).map(sample).collect()
    }

    fn equations(&self, included: impl Fn(usize) -> bool) -> Result<NormalEquations> {
        NormalEquations::of_distances(&self.space, &self.samples(included), &mut || Ok(()))
    }

    fn solve(&self, fairness: f64) -> Result<NurbsSurface> {
        let equations = self.equations(|_| true)?;
        Ok(self.solved(&equations, &equations, fairness)?.0)
    }

    /// The surface, and the factor of the matrix. The fairness is relative to the equations of all
    /// points.
    fn solved(
        &self,
        equations: &NormalEquations,
        all: &NormalEquations,
        fairness: f64,
    ) -> Result<(NurbsSurface, BandMatrix)> {
        let mut matrix = equations.matrix.clone();
        matrix.add_scaled(fairness * all.matrix.trace() / self.energy.trace(), &self.energy);
        matrix.add_ridge(LEAST_SQUARES.ridge);
        if !matrix.factor::<Error>(&mut || Ok(()))? {
            let got = format!("{} points", self.uv.len());
            return Err(Error::parameter("points", "enough for a surface", got));
        }
        let mut net = equations.right.clone();
        matrix.solve(&mut net);
        let net: Vec<DVec3> = net.into_iter().map(DVec3::from_array).collect();
        Ok((self.space.surface(&net)?, matrix))
    }

    /// The weight of the fairness with the least expected error (G. Golub, M. Heath, G. Wahba,
    /// *Generalized cross-validation as a method for choosing a good ridge parameter*, 1979).
    fn cross_validated(&self) -> Result<f64> {
        let equations = self.equations(|_| true)?;
        let count = self.weights.iter().sum::<f64>();
        let expected = |exponent: i32| -> Result<f64> {
            let fairness = 10.0_f64.powi(exponent);
            let (surface, factor) = self.solved(&equations, &equations, fairness)?;
            let freedom =
                FAIRNESS.freedom_factor * factor.inverse().inner_product(&equations.matrix);
            let squares = self.distances(&surface).into_iter().zip(&self.weights);
            let error: f64 = squares.map(|(distance, weight)| weight * distance * distance).sum();
            let left = (1.0 - freedom / count).max(FAIRNESS.freedom_factor - 1.0);
            Ok(error / (left * left))
        };
        // The error has one minimum, so the search follows it in both directions.
        let (min, max) = self.settings.fairness_exponents;
        let mut best = (expected(self.settings.first_exponent)?, self.settings.first_exponent);
        for direction in [1, -1] {
            while (min..=max).contains(&(best.1 + direction)) {
                let next = best.1 + direction;
                let found = expected(next)?;
                if found >= best.0 {
                    break;
                }
                best = (found, next);
            }
        }
        Ok(10.0_f64.powi(best.1))
    }

    /// Raises the fairness above that of generalized cross-validation while the product of both
    /// errors at left-out points falls. Returns it, the errors in turn and by blocks, and the
    /// distances in turn.
    fn raise_fairness(
        &self,
        fairness: f64,
        groups: &ValidationGroups,
    ) -> Result<(f64, [f64; 2], Vec<f64>)> {
        let all = self.equations(|_| true)?;
        let in_turn = self.group_equations(&all, &groups.in_turn)?;
        let blocks = self.group_equations(&all, &groups.blocks)?;
        let errors = |fairness: f64| -> Result<([f64; 2], Vec<f64>)> {
            let in_turn = self.group_distances(&all, &in_turn, fairness)?;
            let blocks = self.group_distances(&all, &blocks, fairness)?;
            Ok(([rms(in_turn.iter().copied()), rms(blocks)], in_turn))
        };
        let product = |found: &([f64; 2], Vec<f64>)| found.0[0] * found.0[1];
        let mut best = (fairness, errors(fairness)?);
        let limit = 10.0_f64.powi(self.settings.fairness_exponents.1);
        while best.0 < limit {
            let more = 10.0 * best.0;
            let found = errors(more)?;
            if product(&found) >= product(&best.1) {
                break;
            }
            best = (more, found);
        }
        let (fairness, (held_out, left_out)) = best;
        Ok((fairness, held_out, left_out))
    }

    /// For each group its points, and the equations of all other points.
    fn group_equations(
        &self,
        all: &NormalEquations,
        groups: &[usize],
    ) -> Result<Vec<GroupEquations>> {
        let group_of = |group: usize| -> Result<GroupEquations> {
            let points_out = (0..groups.len()).filter(|&i| groups[i] == group).collect();
            let mut others = all.clone();
            others.add_scaled(-1.0, &self.equations(|i| groups[i] == group)?);
            Ok(GroupEquations { points_out, others })
        };
        (0..FAIRNESS.groups).into_par_iter().map(group_of).collect()
    }

    /// Distances of the points of each group from the surface fitted to the others.
    fn group_distances(
        &self,
        all: &NormalEquations,
        group_equations: &[GroupEquations],
        fairness: f64,
    ) -> Result<Vec<f64>> {
        let distances =
            |GroupEquations { points_out, others }: &GroupEquations| -> Result<Vec<f64>> {
                let (surface, _) = self.solved(others, all, fairness)?;
                let points: Vec<DVec3> =
                    points_out.iter().map(|&at| self.problem.points[at]).collect();
                let uv: Vec<DVec2> = points_out.iter().map(|&at| self.uv[at]).collect();
                let projections = projections(
                    &surface,
                    self.problem.closed,
                    &points,
                    &uv,
                    self.settings.held_out_steps,
                );
                Ok(projections.iter().map(|projection| projection.offset.length()).collect())
            };
        let found = group_equations.par_iter().map(distances).collect::<Result<Vec<_>>>()?;
        let mut left_out = vec![0.0; self.uv.len()];
        for (GroupEquations { points_out, .. }, distances) in group_equations.iter().zip(found) {
            points_out.iter().zip(distances).for_each(|(&at, distance)| left_out[at] = distance);
        }
        Ok(left_out)
    }

    /// Moves the parameters by one projection step, except those of height fields.
    fn project_parameters(&mut self, surface: &NurbsSurface) {
        if !self.problem.fixed {
            let projections =
                projections(surface, self.problem.closed, self.problem.points, &self.uv, 1);
            self.uv = projections.into_iter().map(|projection| projection.uv).collect();
        }
    }

    /// Weights by Tukey's biweight, whose cutoff shrinks from round to round.
    fn reweight(&mut self, surface: &NurbsSurface, round: usize) {
        let distances = self.distances(surface);
        let median_distance =
            median(distances.iter().copied()).max(self.problem.noise / MAD_TO_DEVIATION);
        let scale = median_distance * (self.settings.rounds - round) as f64;
        self.weights =
            distances.iter().map(|d| biweight(*d, scale).max(LEAST_SQUARES.ridge)).collect();
    }

    /// Each point's distance from the surface at its parameters.
    fn distances(&self, surface: &NurbsSurface) -> Vec<f64> {
        let points = self.problem.points;
        let distance = |i: usize, place: super::patches::Tangents| points[i].distance(place.point);
        Patches::of(surface).each(points.len(), |i| self.uv[i], distance)
    }
}

/// Rows and columns of control points, without repeated ones in closed directions.
fn net(
    problem: &CoarseProblem<'_>,
    settings: &CoarseSettings,
    max_control_points: usize,
) -> [usize; 2] {
    let count = problem.points.len() / settings.points_per_control_point;
    let total = count.clamp(settings.control_points.0, max_control_points) as f64;
    let [along_u, along_v] = problem.lengths;
    let aspect = (along_u / along_v).clamp(1.0 / settings.aspect, settings.aspect);
    let (open_side, closed_side) = settings.min_side;
    let least = problem.closed.map(|closed| if closed { closed_side } else { open_side });
    let rows = whole((total * aspect).sqrt().round()).clamp(least[0], settings.max_side);
    let cols = whole((total / rows as f64).round()).clamp(least[1], settings.max_side);
    [rows, cols]
}
