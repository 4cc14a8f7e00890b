//! Control points and parameters found together: points of a surface with the same net give it back.
//!
//! Where all points can lie on the surface, fairness and plain distances only hinder. What is left are
//! the distances from the tangent planes at the feet: the parameters are eliminated exactly, and
//! Gauss-Newton steps for the control points converge quadratically (W. Wang, H. Pottmann, Y. Liu,
//! *Fitting B-spline curves to point clouds by curvature-based squared distance minimization*, 2006;
//! P. Bo, R. Ling, W. Wang, *A revisit to fitting parametric surfaces to point clouds*, 2012). A net
//! that slides along its surface hardly changes it, so the equations are nearly singular: Levenberg
//! and Marquardt's damping holds it, and after each step the control points are solved for once more
//! at the parameters as they are then, which takes away what sliding along a bent surface does.
//!
//! The way leads through long, bent valleys. Steps follow their bend (M. Transtrum, J. Sethna,
//! *Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares minimization*, 2012)
//! and go on while they lead on.
//!
//! Where its knots lie on a surface is as hard to find as those of a spline curve: there are many
//! places where no step helps. So steps begin at several parametrizations, and the best go on; where these end in vain,
//! at more of them, finer graded, of which one that is near arrives in a dozen steps, and at that of the best surface,
//! moved where it is farthest from the points.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::correct::{Foot, feet, feet_beyond};
use super::edge::extremes;
use super::ground::Ground;
use super::growth::diameter;
use super::normal_equations::{NormalEquations, Sample};
use super::relaxation::Flat;
use super::residuals::correlation;
use super::space::SplineSpace;
use super::starts::Starts;
use super::trial::{DAMPING, Trial};
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{self, Observer, Progress, Stage};

/// Root mean square distances, as shares of the points' diameter: what a surface near points of the same net has at
/// most; from which on these may have been taken in a wrong order; what one through all of them has, which may be
/// rounded to the digits of single precision; and where steps end.
const ROUGH: f64 = 5e-2;
const WRONG_ORDER: f64 = 1e-2;
const THROUGH: f64 = 3e-8;
const ENOUGH: f64 = 1e-9;

/// Correlation between neighbours of the distances that are no noise, at least: noise could not vanish.
const SMOOTH: f64 = 0.1;

/// That of the distances of points without noise, which are worth another search, and the share of the error that the
/// first surface had which is so little that they are as well.
const SMOOTH_IN_VAIN: f64 = 0.5;
const HOPEFUL: f64 = 0.2;

/// Control points of a net at most: the more there are, the more places where no step helps.
const MOST_CONTROL_POINTS: usize = 400;

/// Points for each number to be found, at least, so that not any surface could pass through them;
/// and those for each control point that are looked at, at most.
const LEAST_POINTS: usize = 2;
const MOST_POINTS: usize = 32;

/// Steps after which only so many surfaces go on, the best, and none at all if the best has more than
/// this share of the error that the first one had, or this share of the error that the best had a
/// round before: that of noise stays above the first share, and where no step helps above the other.
/// The last steps end there.
type Round = (usize, usize, f64, f64);

/// Those of a search from few starts.
const ROUNDS: [Round; 8] = [
    (3, 6, 0.85, 1.0),
    (6, 4, 0.75, 1.0),
    (12, 3, 0.6, 1.0),
    (24, 2, 0.5, 0.95),
    (48, 2, 0.4, 0.9),
    (96, 1, 0.2, 0.9),
    (192, 1, 0.1, 0.9),
    (384, 1, 0.05, 0.9),
];

/// Those of a search from many, of which a near one falls fast.
const QUICK_ROUNDS: [Round; 6] = [
    (3, 32, 1.0, 1.0),
    (6, 24, 0.2, 1.0),
    (12, 18, 0.05, 1.0),
    (24, 2, 0.02, 0.9),
    (48, 1, 0.01, 0.9),
    (96, 1, 0.005, 0.9),
];

/// Other searches, where the first one ends in vain.
#[derive(Clone, Copy)]
enum Again {
    /// From parametrizations that are evenly distributed, and from graded ones.
    Ranked,
    Graded,
    /// From that of the best surface, moved where it is farthest from the points, and graded.
    Moved,
    GradedAnew,
}

/// All of them, in turn.
const AGAIN: [Again; 4] = [Again::Ranked, Again::Graded, Again::Moved, Again::GradedAnew];

/// What a parametrization that was moved leaves of the error at most for it to be moved again, and how often it is.
const GAIN: f64 = 0.9;
const MOST_MOVES: usize = 3;

/// Steps after which those that go on do so in two ways, as they are and trimmed.
const TRIMMED_AFTER: usize = 24;

/// How far beyond the domain's ends feet may lie on the way, as a share of it: held at the ends they
/// would hold the net.
const BEYOND: f64 = 0.15;

/// Steps to the feet, from where they were and at first.
pub(super) const STEPS: usize = 2;
const FIRST_STEPS: usize = 8;

/// What is added where parameters are known, to hold control points that no point holds.
const RIDGE: f64 = 1e-9;

/// Steps that follow: the distances vanish before the net has come to rest, on which it depends where
/// the surface ends.
const LAST_STEPS: usize = 6;

/// Steps that draw a surface to where points end; four to sixteen did.
const HELD_STEPS: usize = 24;

/// Mean gaps between points that may lie between them and an end of the domain.
const GAPS: f64 = 10.0;

/// What comes of a search for the net of points.
pub(crate) enum Recovery {
    Found(Box<NurbsSurface>),
    /// From another parametrization, or by longer searches, there may be more to find.
    InVain,
    /// The points are noisy or too few, or lie on no surface with this net.
    Hopeless,
}

/// A surface through the points that count, as many as are looked at, with the net of another one near them. It ends
/// where those do that lie on it of all whose `given` weight is not zero. Searches are long where they are `thorough`.
///
/// # Errors
///
/// [`Error::Interrupted`] if the observer stops it.
pub(crate) fn recovered(
    points: &[DVec3],
    weights: Option<&[f64]>,
    given: Option<&[f64]>,
    &Flat { surface: near, uv, closed, .. }: &Flat<'_>,
    thorough: bool,
    observer: &mut dyn Observer,
) -> Result<Recovery> {
    let knots = [near.knots_u().clone(), near.knots_v().clone()];
    let space = SplineSpace::new(knots, closed.into())?;
    let given = |i: usize| given.map_or(1.0, |given| given[i]);
    let weight = |i: usize| weights.map_or_else(|| given(i), |weights| weights[i]);
    let (counted, left_out): (Vec<usize>, Vec<usize>) =
        (0..points.len()).filter(|&i| given(i) > 0.0).partition(|&i| weight(i) > 0.0);
    let unknowns = space.unknowns();
    if unknowns > MOST_CONTROL_POINTS || counted.len() < LEAST_POINTS * 3 * unknowns {
        return Ok(Recovery::Hopeless);
    }
    let all: Vec<DVec3> = counted.iter().map(|&i| points[i]).collect();
    let size = diameter(&all);
    let of = |indices: &[usize], step: usize| {
        let seen = || indices.iter().step_by(step).copied();
        let points = seen().map(|i| points[i]).collect();
        let weight = |i| if weight(i) > 0.0 { weight(i) } else { given(i) };
        let (weights, uv) = (seen().map(weight).collect(), seen().map(|i| uv[i]).collect());
        Joint { points, weights, uv, space: space.clone(), enough: ENOUGH * size, beyond: BEYOND }
    };
    let few = of(&counted, (counted.len() / (MOST_POINTS * unknowns)).max(1));
    let feet = few.feet_inside(near, &few.uv);
    let first = few.rms(&feet);
    let ordered = thorough || first < WRONG_ORDER * size;
    let hopeless = if ordered { Recovery::Hopeless } else { Recovery::InVain };
    if !(few.enough..ROUGH * size).contains(&first) || !are_smooth(&feet, SMOOTH) {
        return Ok(hopeless);
    }
    let through = |trial: &Trial| trial.error <= THROUGH * size;
    let found = match few.found(first, through, thorough, observer)? {
        Some(found) if through(&found) => found,
        Some(found) if few.promises(&found, first) => return Ok(Recovery::InVain),
        _ => return Ok(hopeless),
    };
    // Where the surface ends, all points say that lie on it, or on what goes on beyond its border.
    let mut counted = counted;
    if !left_out.is_empty()
        && let Some(there) = of(&left_out, 1).like(&found, &few)?
    {
        let on_it = left_out.iter().zip(&there.feet);
        let on_it = on_it.filter(|(_, foot)| foot.offset.length() <= THROUGH * size);
        counted.extend(on_it.map(|(i, _)| *i));
    }
    let joint = of(&counted, 1);
    let Some(found) = joint.like(&found, &few)? else { return Ok(Recovery::InVain) };
    let trimmed = joint.trimmed(&found)?;
    let mut tried: Vec<Trial> = trimmed.into_iter().chain([found]).collect();
    for _ in 0..LAST_STEPS {
        tried.par_iter_mut().try_for_each(|trial| trial.advance(&joint))?;
    }
    let stretched = tried.iter().map(|trial| joint.stretched(trial)).collect::<Result<Vec<_>>>()?;
    tried.extend(stretched.into_iter().flatten());
    let ends_there = |trial: &Trial| {
        joint.rms(&joint.feet_inside(&trial.surface, &trial.uv())) <= THROUGH * size
    };
    if let Some(found) = tried.iter().find(|trial| ends_there(trial)) {
        return Ok(Recovery::Found(Box::new(found.surface.clone())));
    }
    for trial in &tried {
        let held = joint.held(trial, observer)?;
        if ends_there(&held) {
            return Ok(Recovery::Found(Box::new(held.surface)));
        }
    }
    Ok(Recovery::InVain)
}

/// Points that shall all lie on a surface of one space.
#[derive(Clone)]
pub(super) struct Joint {
    points: Vec<DVec3>,
    weights: Vec<f64>,
    /// Their parameters on the surface near them.
    uv: Vec<DVec2>,
    pub(super) space: SplineSpace,
    /// The error at which steps end.
    pub(super) enough: f64,
    /// How far beyond the domain's ends feet may lie, as a share of it.
    beyond: f64,
}

impl Joint {
    /// The surface that comes nearest, of all that searches find until one comes near enough or no more is to be
    /// expected, or of the first search alone. One near the points has this `first` error.
    fn found(
        &self,
        first: f64,
        through: impl Fn(&Trial) -> bool,
        thorough: bool,
        observer: &mut dyn Observer,
    ) -> Result<Option<Trial>> {
        let starts = Starts { space: &self.space, uv: &self.uv };
        let mut found = self.best(&starts.first(), first, &ROUNDS, observer)?;
        for again in AGAIN.into_iter().filter(|_| thorough) {
            let Some(last) = found.as_ref().filter(|last| !through(last)) else { break };
            let hopeful = last.error <= HOPEFUL * first;
            if !self.promises(last, first) {
                break;
            }
            let mut quick =
                |starts: &[Vec<DVec2>]| self.best(starts, first, &QUICK_ROUNDS, observer);
            let other = match again {
                Again::Ranked => quick(&starts.ranked())?,
                Again::Graded => quick(&starts.graded())?,
                Again::Moved if hopeful => self.moved(last, first, observer)?,
                Again::GradedAnew if hopeful => {
                    quick(&Starts { uv: &self.within(last), ..starts }.graded())?
                }
                Again::Moved | Again::GradedAnew => break,
            };
            found = other.filter(|other| other.error < last.error).or(found);
        }
        Ok(found)
    }

    /// Whether there may be more to find than a search has that ended with this surface.
    fn promises(&self, last: &Trial, first: f64) -> bool {
        let near = last.error <= HOPEFUL * first || are_smooth(&last.feet, SMOOTH_IN_VAIN);
        near && self.space.closed != [true, true]
    }

    /// The surface that comes nearest when parameters are moved where this one is farthest from the points, and
    /// again, as long as that brings it nearer; `None` if it never does.
    fn moved(
        &self,
        trial: &Trial,
        first: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Trial>> {
        let mut found = None;
        for _ in 0..MOST_MOVES {
            let last = found.as_ref().unwrap_or(trial);
            let uv = self.within(last);
            let squares = last.feet.iter().map(|foot| foot.offset.length_squared());
            let sum: f64 = squares.clone().sum();
            let place = uv.iter().zip(squares).map(|(uv, square)| square / sum * *uv).sum();
            let starts = Starts { space: &self.space, uv: &uv }.moved_around(place);
            let next = self.best(&starts, first, &QUICK_ROUNDS, observer)?;
            let Some(next) = next.filter(|next| next.error <= GAIN * last.error) else { break };
            let arrived = next.error <= self.enough;
            found = Some(next);
            if arrived {
                break;
            }
        }
        Ok(found)
    }

    /// The surface that another one comes to with feet that do not leave the domain, whose ends then draw it to where
    /// points end: distances along normals hardly tell how far it slides along itself.
    fn held(&self, trial: &Trial, observer: &mut dyn Observer) -> Result<Trial> {
        let held = Self { beyond: 0.0, ..self.clone() };
        let (surface, damping) = (trial.surface.clone(), DAMPING);
        let feet = held.feet(&surface, &self.within(trial), FIRST_STEPS);
        let mut trial = Trial { error: held.rms(&feet), surface, feet, damping, equations: None };
        for step in 0..HELD_STEPS {
            if trial.error <= self.enough {
                break;
            }
            let (step, total) = (step as u64, HELD_STEPS as u64);
            let progress = Progress::of_stage(Stage::Fitting, step, total, self.points.len());
            progress::report(observer, &progress)?;
            trial.advance(&held)?;
        }
        Ok(trial)
    }

    /// The surface that comes nearest of those from these parametrizations, when it has arrived at the
    /// points or no more is to be expected.
    fn best(
        &self,
        starts: &[Vec<DVec2>],
        first: f64,
        rounds: &[Round],
        observer: &mut dyn Observer,
    ) -> Result<Option<Trial>> {
        let trials = starts.par_iter().map(|uv| self.trial(uv)).collect::<Result<Vec<_>>>()?;
        let mut trials: Vec<Trial> = trials.into_iter().flatten().collect();
        let total = rounds[rounds.len() - 1].0 as u64;
        let on_the_way = |trials: &[Trial]| trials.iter().all(|trial| trial.error > self.enough);
        let (mut step, mut before) = (0, f64::INFINITY);
        for &(end, left, share, fall) in rounds {
            while step < end && on_the_way(&trials) {
                let count = self.points.len();
                let progress = Progress::of_stage(Stage::Fitting, step as u64, total, count);
                progress::report(observer, &progress)?;
                trials.par_iter_mut().try_for_each(|trial| trial.advance(self))?;
                step += 1;
            }
            trials.sort_by(|a, b| a.error.total_cmp(&b.error));
            trials.truncate(left);
            let Some(best) = trials.first() else { return Ok(None) };
            if best.error > self.enough && best.error > (share * first).min(fall * before) {
                break;
            }
            before = best.error;
            if step == TRIMMED_AFTER {
                let trimmed = trials.par_iter().map(|trial| self.trimmed(trial));
                let trimmed = trimmed.collect::<Result<Vec<_>>>()?;
                trials.extend(trimmed.into_iter().flatten());
            }
        }
        Ok(trials.into_iter().next())
    }

    /// The surface that was found for others of the points.
    fn like(&self, trial: &Trial, others: &Self) -> Result<Option<Trial>> {
        let size = DVec2::from(self.space.knots.each_ref().map(|knots| {
            let (start, end) = knots.domain();
            end - start
        }));
        let moved = |(&uv, foot): (&DVec2, &Foot)| {
            let mut by = foot.uv - uv;
            for d in (0..2).filter(|&d| self.space.closed[d]) {
                by[d] -= size[d] * (by[d] / size[d]).round();
            }
            Foot { uv, offset: by.extend(0.0), ..*foot }
        };
        let moved: Vec<Foot> = others.uv.iter().zip(&trial.feet).map(moved).collect();
        let Some(net) = others.plain(&moved)? else { return Ok(None) };
        let moved = self.places(&net, &self.uv)?;
        let uv: Vec<DVec2> =
            self.uv.iter().zip(&moved).map(|(uv, by)| *uv + by.truncate()).collect();
        let (surface, damping) = (trial.surface.clone(), trial.damping);
        let feet = self.feet(&surface, &uv, FIRST_STEPS);
        Ok(Some(Trial { error: self.rms(&feet), surface, feet, damping, equations: None }))
    }

    /// Where the surface of these control points, in the order of solution, has these parameters.
    pub(super) fn places(&self, net: &[DVec3], uv: &[DVec2]) -> Result<Vec<DVec3>> {
        let surface = self.space.surface(net)?;
        let origin = vec![DVec3::ZERO; uv.len()];
        let feet = feet_beyond(&surface, self.space.closed, BEYOND, &origin, uv, 0);
        Ok(feet.iter().map(|foot| -foot.offset).collect())
    }

    /// A surface that ends where the points do, from one that does not. Where one is straight and even
    /// along a parameter, any stretch of it has the same net; another may have gone astray.
    fn trimmed(&self, trial: &Trial) -> Result<Option<Trial>> {
        let (mut uv, mut trimmed) = (trial.uv(), false);
        let places: Vec<DVec3> = uv.iter().map(|uv| uv.extend(0.0)).collect();
        let ground = Ground::around(&places, |_| true)?;
        for d in (0..2).filter(|&d| !self.space.closed[d]) {
            let (start, end) = self.space.knots[d].domain();
            let (low, high) = extremes(uv.iter().map(|uv| uv[d]));
            let gaps = 0.0..=GAPS / uv.len() as f64 * (end - start);
            if !(gaps.contains(&(low - start)) && gaps.contains(&(end - high))) {
                let parameter = |place: &DVec3| ground.parameters(place.truncate())[d];
                let moved = places.iter().map(|place| start + (end - start) * parameter(place));
                uv.iter_mut().zip(moved).for_each(|(uv, moved)| uv[d] = moved);
                trimmed = true;
            }
        }
        if trimmed { self.trial(&uv) } else { Ok(None) }
    }

    /// A surface that ends no earlier than the points do, from one that may by rounding: where it ends is
    /// known to fewer digits than where it lies.
    fn stretched(&self, trial: &Trial) -> Result<Option<Trial>> {
        self.trial(&self.within(trial))
    }

    /// The parameters of the points' feet, drawn together in open directions where some are beyond the domain.
    fn within(&self, trial: &Trial) -> Vec<DVec2> {
        let mut uv = trial.uv();
        for d in (0..2).filter(|&d| !self.space.closed[d]) {
            let (start, end) = self.space.knots[d].domain();
            let (low, high) = extremes(uv.iter().map(|uv| uv[d]));
            let (low, high) = (low.min(start), high.max(end));
            for uv in &mut uv {
                uv[d] = start + (end - start) * (uv[d] - low) / (high - low);
            }
        }
        uv
    }

    /// The surface nearest in plain distances at these parameters.
    fn trial(&self, uv: &[DVec2]) -> Result<Option<Trial>> {
        let place = |(&uv, &offset): (&DVec2, &DVec3)| Foot { uv, offset, ..Foot::default() };
        let places: Vec<Foot> = uv.iter().zip(&self.points).map(place).collect();
        let Some(net) = self.plain(&places)? else { return Ok(None) };
        let surface = self.space.surface(&net)?;
        let feet = self.feet(&surface, uv, FIRST_STEPS);
        Ok(Some(Trial { error: self.rms(&feet), surface, feet, damping: DAMPING, equations: None }))
    }

    /// The changes of the control points by which plain distances from these places vanish.
    pub(super) fn plain(&self, places: &[Foot]) -> Result<Option<Vec<DVec3>>> {
        let NormalEquations { mut matrix, mut right } =
            NormalEquations::of_distances(&self.space, &self.samples(places, 1.0), &mut || Ok(()))?;
        matrix.add_ridge(RIDGE);
        if !matrix.factor::<Error>(&mut || Ok(()))? {
            return Ok(None);
        }
        matrix.solve(&mut right);
        Ok(Some(right.into_iter().map(DVec3::from_array).collect()))
    }

    /// What is left between points and places, in full along normals, as far as `tangential` across.
    pub(super) fn samples(&self, places: &[Foot], tangential: f64) -> Vec<Sample> {
        let sample = |(place, &weight): (&Foot, &f64)| {
            let &Foot { uv, offset: point, normal, border } = place;
            let tangential = if border && self.beyond == 0.0 { 1.0 } else { tangential };
            Sample { point, uv, weight, normal, tangential }
        };
        places.iter().zip(&self.weights).map(sample).collect()
    }

    /// The equations of the distances from places along their normals.
    pub(super) fn equations(&self, places: &[Foot]) -> Result<NormalEquations> {
        let (samples, matrix) = (self.samples(places, 0.0), self.space.matrix(3));
        NormalEquations::of_tangent_distances(&self.space, &samples, matrix, &mut || Ok(()))
    }

    pub(super) fn feet(&self, surface: &NurbsSurface, uv: &[DVec2], steps: usize) -> Vec<Foot> {
        feet_beyond(surface, self.space.closed, self.beyond, &self.points, uv, steps)
    }

    fn feet_inside(&self, surface: &NurbsSurface, uv: &[DVec2]) -> Vec<Foot> {
        feet(surface, self.space.closed, &self.points, uv, STEPS)
    }

    /// Root of the mean square of the distances.
    pub(super) fn rms(&self, feet: &[Foot]) -> f64 {
        let square = |(foot, weight): (&Foot, &f64)| weight * foot.offset.length_squared();
        let squares: f64 = feet.iter().zip(&self.weights).map(square).sum();
        (squares / self.weights.iter().sum::<f64>()).sqrt()
    }
}

/// Whether distances are correlated between neighbours at least so much.
fn are_smooth(feet: &[Foot], least: f64) -> bool {
    let distances: Vec<f64> = feet.iter().map(|foot| foot.offset.dot(foot.normal)).collect();
    let uv: Vec<DVec2> = feet.iter().map(|foot| foot.uv).collect();
    correlation(&uv, &distances) >= least
}
