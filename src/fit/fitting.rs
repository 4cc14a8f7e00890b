//! A fit in progress: solutions for the net in turns with corrections of the parameters.

use std::borrow::Cow;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::POINTS_PER_TASK;
use super::approximate::{ApproximateOptions, Approximation};
use super::band::Band;
use super::border::conformed;
use super::correct::{Foot, feet};
use super::cross_validation;
use super::fairness::Energy;
use super::growth::{EndedBy, Growth};
use super::lengths::lengths;
use super::normal_equations::{NormalEquations, Sample};
use super::outline::Outline;
use super::patches::Patches;
use super::rim::Rim;
use super::space::SplineSpace;
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{self, Observer, Progress, Stage};

/// Order of the derivatives whose energy is kept small. Third derivatives leave quadratics free,
/// which bend as most surfaces do.
const ORDER: usize = 3;

/// Order for so few points that a quadratic through them would be far from their surface, and how
/// few they are for each control point.
const ORDER_OF_FEW: usize = 2;
const FEW: usize = 2;

/// Weight of distances across the normal. Less lets the net slide away, more is plain distance,
/// which converges slowly.
const TANGENTIAL: f64 = 0.01;

/// That of noisy points on a domain that was bent: the fairness that smooths them would draw the net
/// along the surface, off the border that was found.
const TANGENTIAL_OF_NOISE: f64 = 0.03;

/// That of few points, which do not hold a net where they are not: it would slide away.
const TANGENTIAL_OF_FEW: f64 = 0.1;

/// Points whose surface wants this weight of the fairness are noisy.
const FAIRNESS_OF_NOISE: f64 = 0.1;

/// Weight of the fairness at the first solution. Without it the first iterations, whose parameters
/// are rough, run away.
const FIRST_FAIRNESS: f64 = 1.0;

/// Least weight of the fairness: enough to hold control points that no point holds; and that of few
/// points, and of others that cannot tell: cross-validation does not know of the freedom that parameters
/// have, and with few points that is much of all.
pub(super) const LEAST_FAIRNESS: f64 = 1e-4;
const FAIRNESS_OF_FEW: f64 = 0.01;

/// Fewer points are few.
const FEW_POINTS: usize = 100;

/// Least weight of the fairness at the first solution on a domain that was bent.
const FAIRNESS_OF_BENT: f64 = 1e-3;

/// Steps towards the foot between two solutions, and from parameters that were left behind.
pub(super) const STEPS: usize = 2;
const STEPS_OF_STRAGGLERS: usize = 8;

/// Points for each control point that are looked at while a surface takes shape, and how many at
/// least: more would not change the shape, but the noise in it.
const ENOUGH: usize = 16;
const LEAST_SEEN: usize = 2000;

/// Iterations end when the error falls by less than this share; and by which on a domain that is bent thereafter,
/// with which they go on.
const CONVERGED: f64 = 0.06;
const CONVERGED_FOR_NOW: f64 = 0.15;

/// Iterations go on beyond their limit, up to so many times, while the error falls under this share
/// of what it was: where a surface passes through all points they converge ever faster.
const CONVERGING: f64 = 0.7;
const MOST_TIMES: usize = 4;

/// Solutions with each net at least.
const LEAST_ITERATIONS: usize = 3;

/// Iterations at which cross-validation is asked: when the net has taken shape, and when the
/// parameters have followed; and of noise, once more on a domain that ends where points do: a surface
/// without it tells better how smooth it is in which direction.
const ASKED: [usize; 2] = [1, 4];
const ASKED_OF_NOISE: usize = 2;

/// A share of the mean diagonal entry that is added to all: what rounding could make negative.
const RIDGE: f64 = 1e-14;

/// How solutions with a net follow one another.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    /// Solutions at most, while the error falls slowly.
    pub(super) limit: usize,
    /// The share of the fairness that is left after each: with much of it, folded sheets are drawn
    /// flat.
    pub(super) left_of_fairness: f64,
}

/// A fit in progress.
pub(super) struct Fitting<'a> {
    pub(super) points: &'a [DVec3],
    weights: Option<&'a [f64]>,
    pub(super) uv: Vec<DVec2>,
    pub(super) closed: [bool; 2],
    /// Only each so manieth point is looked at.
    stride: usize,
    fixed: Option<f64>,
    /// What cross-validation has found last.
    pub(super) score: Option<cross_validation::Score>,
    /// The weight that falls from solution to solution.
    pub(super) falling: f64,
    /// Whether the domain was bent to where the points end.
    pub(super) bent: bool,
    pub(super) iterations: usize,
    total: usize,
    /// Root of the mean square of the distances, when they were found last.
    error: Option<f64>,
    pub(super) observer: &'a mut dyn Observer,
    pub(super) rim: Option<Rim>,
    /// The matrix of an earlier solution, whose memory is used again.
    spare: Option<Band>,
}

impl<'a> Fitting<'a> {
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
            falling: FIRST_FAIRNESS,
            bent: false,
            iterations: 0,
            total: 2 * options.iterations,
            error: None,
            observer,
            rim: None,
            spare: None,
        }
    }

    /// Looks at no more points than a net of this size needs, at equal steps in their order.
    pub(super) fn look_at_enough_for(&mut self, space: &SplineSpace) {
        let enough = (ENOUGH * space.unknowns()).max(LEAST_SEEN);
        self.stride = (self.points.len() / enough).max(1);
    }

    /// Looks at all points from now on; says whether it did not before.
    pub(super) fn look_at_all(&mut self, surface: &NurbsSurface) -> bool {
        let news = self.stride > 1;
        self.stride = 1;
        if news {
            self.correct(surface, STEPS_OF_STRAGGLERS);
        }
        news
    }

    pub(super) fn weight(&self, index: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights[index])
    }

    /// The weight of the fairness that is aimed at.
    fn aim(&self) -> f64 {
        let least = if self.few() { FAIRNESS_OF_FEW } else { LEAST_FAIRNESS };
        self.fixed.unwrap_or(self.score.map_or(least, |score| score.fairness.max(least)))
    }

    fn few(&self) -> bool {
        self.points.len() < FEW_POINTS
    }

    /// Whether the points are so noisy that fairness has a say.
    fn noisy(&self) -> bool {
        self.aim() >= FAIRNESS_OF_NOISE
    }

    /// Whether the domain ends where points do, or nowhere.
    fn ends_are_known(&self) -> bool {
        self.bent || self.closed == [true, true]
    }

    /// The first step of cross-validation, if it is asked at this iteration.
    fn asked(&self, iteration: usize) -> Option<f64> {
        if self.fixed.is_some() {
            return None;
        }
        if iteration == ASKED_OF_NOISE && self.noisy() && self.ends_are_known() {
            return Some(cross_validation::FROM_NEAR);
        }
        ASKED.contains(&iteration).then_some(cross_validation::FROM_KNOWN)
    }

    /// The weight of distances across the normal.
    fn tangential(&self) -> f64 {
        match self.bent && self.noisy() {
            _ if self.few() => TANGENTIAL_OF_FEW,
            true => TANGENTIAL_OF_NOISE,
            false => TANGENTIAL,
        }
    }

    /// The energy that is kept small, with the anisotropy that was found last.
    fn energy(&self, space: &SplineSpace, lengths: (f64, f64)) -> Energy {
        let [p, q] = [0, 1].map(|d| space.knots[d].degree());
        let few = self.points.len() < FEW * space.unknowns();
        let order = if few { ORDER_OF_FEW } else { ORDER };
        // Derivatives beyond the degree vanish.
        let energy = Energy::new(lengths, order.min(p.max(q)));
        self.score.map_or(energy, |score| energy.with_anisotropy(score.anisotropy))
    }

    /// Its matrix, and the entries of that for x, y and z.
    pub(super) fn energy_along_axes(
        &self,
        space: &SplineSpace,
        lengths: (f64, f64),
    ) -> (Band, Vec<(usize, f64)>) {
        let energy = self.energy(space, lengths).matrix(space);
        let along_axes = energy.for_each_axis(&space.matrix(3));
        (energy, along_axes)
    }

    /// The surface by plain distances at the parameters as they are.
    pub(super) fn first(&mut self, space: &SplineSpace) -> Result<NurbsSurface> {
        let samples = self.samples(None);
        let energy = self.energy(space, (1.0, 1.0)).matrix(space);
        self.solve_distances(space, &samples, &energy, self.falling)
    }

    /// The points looked at, at their feet or, without, for plain distances at their parameters.
    pub(super) fn samples(&self, feet: Option<&[Foot]>) -> Vec<Sample> {
        let across = self.tangential();
        let &Self { points, weights, ref uv, stride, .. } = self;
        let sample = |place: usize| {
            let index = place * stride;
            let (point, weight) = (points[index], weights.map_or(1.0, |weights| weights[index]));
            let Some(foot) = feet.map(|feet| feet[place]) else {
                let (uv, normal) = (uv[index], DVec3::ZERO);
                return Sample { point, uv, weight, normal, tangential: 1.0 };
            };
            let free = !foot.border && foot.normal != DVec3::ZERO;
            let tangential = if free { across } else { 1.0 };
            Sample { point, uv: foot.uv, weight, normal: foot.normal, tangential }
        };
        let places = (0..points.len().div_ceil(stride)).into_par_iter();
        places.with_min_len(POINTS_PER_TASK).map(sample).collect()
    }

    /// The equations of the points' tangent distances at their feet.
    pub(super) fn equations(
        &mut self,
        space: &SplineSpace,
        feet: &[Foot],
    ) -> Result<NormalEquations> {
        let (samples, blank) = (self.samples(Some(feet)), self.blank(space));
        NormalEquations::of_tangent_distances(space, &samples, blank, &mut || Ok(()))
    }

    /// A matrix of zeros for coupled coordinates.
    fn blank(&mut self, space: &SplineSpace) -> Band {
        space.matrix_instead(3, self.spare.take())
    }

    /// Samples of the rim, beside those of so many points.
    fn rim(&self, points: usize) -> impl Iterator<Item = Sample> {
        let fairness = self.falling.max(self.aim());
        self.rim.iter().flat_map(move |rim| rim.beside(points, fairness))
    }

    /// Solves with a net of its own, in turns with the feet, until the error stops falling.
    pub(super) fn descend(
        &mut self,
        space: &SplineSpace,
        from: NurbsSurface,
        Pace { limit, left_of_fairness }: Pace,
    ) -> Result<NurbsSurface> {
        let lengths = lengths(&from);
        let (mut energy, mut along_axes) = self.energy_along_axes(space, lengths);
        let mut surface = from;
        let mut error = f64::INFINITY;
        let falls = if self.ends_are_known() { CONVERGED } else { CONVERGED_FOR_NOW };
        for iteration in 0..MOST_TIMES * limit {
            let feet = self.correct(&surface, STEPS);
            let found = self.rms(&feet);
            self.error = Some(found);
            let settled = self.falling <= self.aim() && iteration >= LEAST_ITERATIONS.min(limit);
            let most = if iteration < limit { 1.0 - falls } else { CONVERGING };
            if settled && found > most * error || iteration >= limit && found > CONVERGING * error {
                break;
            }
            error = found;
            let mut held = self.samples(Some(&feet));
            let points = held.len();
            held.extend(self.rim(points));
            let samples = &held[..points];
            let asked = self.asked(iteration);
            let (known, wanted) = (self.score, self.energy(space, lengths));
            let blank = self.blank(space);
            let (score, equations) = rayon::join(
                || asked.map(|step| cross_validation::best(space, samples, wanted, (known, step))),
                || NormalEquations::of_tangent_distances(space, &held, blank, &mut || Ok(())),
            );
            if let Some(score) = score {
                self.believe(score?);
                if self.energy(space, lengths) != wanted {
                    (energy, along_axes) = self.energy_along_axes(space, lengths);
                }
            }
            surface = self.solve_tangents(space, equations?, &energy, &along_axes)?;
            self.falling *= left_of_fairness;
            self.iterations += 1;
        }
        Ok(surface)
    }

    /// Aims at the fairness that cross-validation has found.
    fn believe(&mut self, found: Option<cross_validation::Score>) {
        match found {
            Some(score) => self.score = Some(score),
            // So few points cannot tell.
            None => self.falling = self.falling.max(FAIRNESS_OF_FEW),
        }
    }

    /// Bends the domain so that it ends where the points end, and goes on by this many of their mean
    /// spacings, at open borders; says whether one has a notch.
    pub(super) fn conform(
        &mut self,
        surface: NurbsSurface,
        border: f64,
    ) -> Result<(NurbsSurface, bool)> {
        if self.closed == [true, true] {
            return Ok((surface, false));
        }
        let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
        let space = SplineSpace::new(knots, self.closed)?;
        let (length_u, length_v) = lengths(&surface);
        let spacing = (length_u * length_v / self.points.len() as f64).sqrt();
        let feet = self.correct(&surface, STEPS);
        let size = DVec2::new(length_u, length_v);
        let noise = self.rms(&feet);
        let outline = if self.closed == [false, false] {
            Outline::around(&self.uv, &surface, size, noise, border)?
        } else {
            None
        };
        self.rim =
            outline.as_ref().map(|outline| Rim::through(&Patches::of(&surface), outline.rim()));
        let notched;
        (self.uv, notched) = match outline {
            Some(outline) => (outline.squared(&self.uv), false),
            None => conformed(&self.uv, &space, noise / size, border, spacing / size)?,
        };
        let energy = self.energy(&space, (length_u, length_v)).matrix(&space);
        let samples = self.samples(None);
        self.bent = true;
        self.falling = self.aim().max(FAIRNESS_OF_BENT);
        Ok((self.solve_distances(&space, &samples, &energy, self.falling)?, notched))
    }

    /// The approximation by this surface, or by what it grows to.
    pub(super) fn grown(
        mut self,
        surface: NurbsSurface,
        growth: Option<Growth>,
    ) -> Result<Approximation> {
        let (surface, ended_by) = match growth {
            Some(growth) => self.grow(surface, growth)?,
            None => (surface, EndedBy::Grid),
        };
        let feet = self.correct(&surface, STEPS);
        Ok(self.end(surface, &feet, ended_by))
    }

    /// The approximation by a surface on which the points have these feet.
    pub(super) fn end(
        self,
        surface: NurbsSurface,
        feet: &[Foot],
        ended_by: EndedBy,
    ) -> Approximation {
        Approximation {
            surface,
            distances: feet.iter().map(|foot| foot.offset.length()).collect(),
            fairness: self.aim(),
            expected: self.score.map(|score| score.error),
            iterations: self.iterations,
            ended_by,
            uv: self.uv,
        }
    }

    /// Moves the parameters of the points looked at to their feet.
    pub(super) fn correct(&mut self, surface: &NurbsSurface, steps: usize) -> Vec<Foot> {
        let (points, uv) = (every(self.points, self.stride), every(&self.uv, self.stride));
        let feet = feet(surface, self.closed, &points, &uv, steps);
        drop(uv);
        let moved = self.uv.par_iter_mut().step_by(self.stride).zip(&feet);
        moved.with_min_len(POINTS_PER_TASK).for_each(|(uv, foot)| *uv = foot.uv);
        feet
    }

    /// Root of the mean square of the distances.
    pub(super) fn rms(&self, feet: &[Foot]) -> f64 {
        let seen = (0..self.points.len()).step_by(self.stride).zip(feet);
        let (mut squares, mut weights) = (0.0, 0.0);
        for (weight, foot) in seen.map(|(index, foot)| (self.weight(index), foot)) {
            squares += weight * foot.offset.length_squared();
            weights += weight;
        }
        (squares / weights).sqrt()
    }

    fn solve_distances(
        &mut self,
        space: &SplineSpace,
        samples: &[Sample],
        energy: &Band,
        fairness: f64,
    ) -> Result<NurbsSurface> {
        let NormalEquations { mut matrix, mut right } =
            NormalEquations::of_distances(space, samples, &mut || Ok(()))?;
        matrix.add_scaled(fairness * matrix.trace() / energy.trace(), energy);
        matrix.add_ridge(RIDGE);
        self.factor(&mut matrix, space)?;
        matrix.solve(&mut right);
        let net: Vec<DVec3> = right.into_iter().map(DVec3::from_array).collect();
        space.surface(&net)
    }

    /// Solves for tangent distances.
    pub(super) fn solve_tangents(
        &mut self,
        space: &SplineSpace,
        equations: NormalEquations,
        energy: &Band,
        along_axes: &[(usize, f64)],
    ) -> Result<NurbsSurface> {
        self.solve_beside(space, equations, energy, along_axes, |_, _| {})
    }

    /// Solves for tangent distances together with what is added beside them, which is told what the points say of a
    /// control point's coordinate on average.
    pub(super) fn solve_beside(
        &mut self,
        space: &SplineSpace,
        mut equations: NormalEquations,
        energy: &Band,
        along_axes: &[(usize, f64)],
        beside: impl FnOnce(&mut NormalEquations, f64),
    ) -> Result<NurbsSurface> {
        let fairness = self.falling.max(self.aim());
        let matrix = &mut equations.matrix;
        let (said, size) = (matrix.trace() / (1.0 + 2.0 * self.tangential()), 3 * space.unknowns());
        matrix.add_entries(fairness * said / energy.trace(), along_axes);
        matrix.add_ridge(RIDGE);
        beside(&mut equations, said / size as f64);
        let NormalEquations { mut matrix, right } = equations;
        self.factor(&mut matrix, space)?;
        let net = matrix.solved_together(&right);
        self.spare = Some(matrix);
        space.surface(&net)
    }

    fn factor(&mut self, matrix: &mut Band, space: &SplineSpace) -> Result<()> {
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
        Err(Error::parameter("grid", "small enough for the points to hold it", got))
    }
}

/// Each so manieth of some items.
fn every<T: Copy>(items: &[T], stride: usize) -> Cow<'_, [T]> {
    if stride == 1 { items.into() } else { items.iter().step_by(stride).copied().collect() }
}
