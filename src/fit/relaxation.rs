//! Less fairness for a surface that has more of it than its points want, as far as nothing goes
//! wrong.
//!
//! The fairness falls step by step. Where a step makes flaws, it is taken anew from where it began,
//! while the control points around them are held to their places: the surface stays there what it
//! was, and comes nearer the points elsewhere.

use glam::{DVec2, DVec3};

use super::approximate::{ApproximateOptions, Approximation};
use super::band::Band;
use super::correct::Foot;
use super::fitting::{Fitting, LEAST_FAIRNESS, STEPS};
use super::growth::EndedBy;
use super::lengths::lengths;
use super::normal_equations::NormalEquations;
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// A surface near points, all of it with the same fairness.
pub(crate) struct Flat<'a> {
    pub(crate) surface: &'a NurbsSurface,
    /// Where on it each point has its foot.
    pub(crate) uv: &'a [DVec2],
    pub(crate) fairness: f64,
    pub(crate) closed: (bool, bool),
}

impl Flat<'_> {
    /// What goes on from it, down to this fairness, or without, that of cross-validation.
    pub(super) fn fitting<'b>(
        &self,
        points: &'b [DVec3],
        weights: Option<&'b [f64]>,
        aim: Option<f64>,
        observer: &'b mut dyn Observer,
    ) -> Fitting<'b> {
        let options = ApproximateOptions {
            closed: self.closed,
            fairness: aim,
            ..ApproximateOptions::default()
        };
        let mut fitting = Fitting::new(points, self.uv, weights, &options, observer);
        fitting.falling = self.fairness;
        fitting
    }
}

/// Asks for the flaws of a surface on which the points have their feet there: where on it they are.
pub(crate) type Inspect<'a> =
    dyn FnMut(&NurbsSurface, &[DVec2], &mut dyn Observer) -> Result<Vec<DVec2>> + 'a;

/// Share of the fairness that a step, one solution, leaves. With less of it flaws come in one step
/// where several would have gone round them.
const LEFT_OF_FAIRNESS: f64 = 0.5;

/// Steps at most, and those at most that fail one after the other: where more are needed, hardly
/// anything is left that could move.
const STEPS_TAKEN: usize = 48;
const FAILURES: usize = 6;

/// How strongly all control points are held to their last places, beside what the points say of one on
/// average: they go on from there.
const ANCHOR: f64 = 0.001;

/// How strongly a control point is held there when there is a flaw around it for the first time, and how
/// many times that each further time.
const FIRST_HOLD: f64 = 0.1;
const TIGHTER: f64 = 10.0;

/// Share of what the points say of a control point on average, below which they do not hold it: it is held to
/// where the flat surface had it, as it would run away beyond the border.
const UNHELD: f64 = 0.01;

/// With the least fairness steps end when one leaves more than this share of the error.
const SETTLED: f64 = 0.99;

/// The surface with less fairness, down to `aim` or what holds control points, that has no more
/// flaws, but where it is held: how far it may be from its points there depends on its size.
///
/// # Errors
///
/// Those of [`approximate`](super::approximate()), and of `inspect`.
pub(crate) fn relaxed(
    points: &[DVec3],
    weights: Option<&[f64]>,
    flat: &Flat<'_>,
    aim: f64,
    inspect: &mut Inspect<'_>,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    let aim = aim.max(LEAST_FAIRNESS);
    let mut fitting = flat.fitting(points, weights, Some(aim), observer);
    let (surface, feet) = fitting.relax(flat.surface.clone(), aim, inspect)?;
    let fairness = fitting.falling;
    Ok(Approximation { fairness, ..fitting.end(surface, &feet, EndedBy::Grid) })
}

/// The surface on the domain that ends where the points end, and goes on by this many of their mean
/// spacings.
///
/// # Errors
///
/// Those of [`approximate`](super::approximate()).
pub(crate) fn restricted(
    points: &[DVec3],
    weights: Option<&[f64]>,
    flat: &Flat<'_>,
    border: f64,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    let mut fitting = flat.fitting(points, weights, Some(flat.fairness), observer);
    let (surface, _) = fitting.conform(flat.surface.clone(), border)?;
    let fairness = fitting.falling;
    let feet = fitting.correct(&surface, STEPS);
    Ok(Approximation { fairness, ..fitting.end(surface, &feet, EndedBy::Grid) })
}

impl Fitting<'_> {
    fn relax(
        &mut self,
        mut surface: NurbsSurface,
        aim: f64,
        inspect: &mut Inspect<'_>,
    ) -> Result<(NurbsSurface, Vec<Foot>)> {
        let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
        let space = SplineSpace::new(knots, self.closed)?;
        let (energy, along_axes) = self.energy_along_axes(&space, lengths(&surface));
        let mut feet = self.correct(&surface, STEPS);
        let mut fewest = inspect(&surface, &self.uv, self.observer)?.len();
        let mut error = self.rms(&feet);
        let mut places = space.unknown_points(&surface);
        let mut holds = vec![ANCHOR; space.unknowns()];
        let loose = unheld(&self.equations(&space, &feet)?.matrix, space.unknowns());
        hold(&loose, &mut holds);
        let (mut reached, mut failures) = (self.falling, 0);
        for _ in 0..STEPS_TAKEN {
            let before = self.falling;
            self.falling = (LEFT_OF_FAIRNESS * before).max(aim);
            let equations = self.equations(&space, &feet)?;
            let beside = |equations: &mut NormalEquations, unit| {
                hold_to(&places, &holds, unit, equations);
            };
            let next = self.solve_beside(&space, equations, &energy, &along_axes, beside)?;
            self.iterations += 1;
            let next_feet = self.correct(&next, STEPS);
            let found = self.rms(&next_feet);
            let flaws = inspect(&next, &self.uv, self.observer)?;
            if flaws.len() <= fewest && found <= error {
                let settled = before <= aim && found > SETTLED * error;
                (surface, feet, error) = (next, next_feet, found);
                let last = space.unknown_points(&surface).into_iter().enumerate();
                last.filter(|(at, _)| loose.binary_search(at).is_err())
                    .for_each(|(at, place)| places[at] = place);
                fewest = fewest.min(flaws.len());
                (reached, failures) = (self.falling, 0);
                if settled {
                    break;
                }
                continue;
            }
            self.uv.iter_mut().zip(&feet).for_each(|(uv, foot)| *uv = foot.uv);
            failures += 1;
            if failures > FAILURES || flaws.is_empty() && before <= aim {
                break;
            }
            // Without flaws it is the fairness, new to a surface of heights, that moves it away.
            if !flaws.is_empty() {
                self.falling = before;
                hold(&space.touched_by(&flaws), &mut holds);
            }
        }
        self.falling = reached;
        Ok((surface, feet))
    }
}

/// Of control points with this matrix of the points' equations those that hardly any point holds, ascending.
fn unheld(matrix: &Band, unknowns: usize) -> Vec<usize> {
    let usual = matrix.trace() / unknowns as f64;
    let said = |at: usize| (3 * at..3 * at + 3).map(|i| matrix.entry(i, i)).sum::<f64>();
    (0..unknowns).filter(|&at| said(at) < UNHELD * usual).collect()
}

/// Holds these control points, or holds them tighter.
fn hold(control_points: &[usize], holds: &mut [f64]) {
    for &at in control_points {
        holds[at] = (TIGHTER * holds[at]).max(FIRST_HOLD);
    }
}

/// Adds the squared distances of control points from places, in the order of solution, as strongly as they are held;
/// `unit` is what the points say on average.
fn hold_to(places: &[DVec3], holds: &[f64], unit: f64, equations: &mut NormalEquations) {
    let NormalEquations { matrix, right } = equations;
    for (at, (place, hold)) in places.iter().zip(holds).enumerate() {
        for (axis, value) in place.to_array().into_iter().enumerate() {
            matrix.add(3 * at + axis, 3 * at + axis, hold * unit);
            right[at][axis] += hold * unit * value;
        }
    }
}
