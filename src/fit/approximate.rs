//! The surface near points whose parameters are known roughly: least squares, coarse to fine, with
//! fairness and parameter correction by tangent distance.
//!
//! Tangent distance (W. Wang, H. Pottmann, Y. Liu, *Fitting B-spline curves to point clouds by
//! curvature-based squared distance minimization*, 2006) counts how far a point is from the tangent
//! plane at its foot, and hardly where in the plane it is: the net may slide along the surface
//! towards the parameters that suit it, which plain distances hinder.

use glam::{DVec2, DVec3};

use super::band::Band;
use super::border::bounded;
use super::correct::{Foot, Tangents, feet};
use super::cross_validation;
use super::fairness;
use super::normal_equations::{NormalEquations, Sample};
use super::refine;
use super::space::SplineSpace;
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsSurface};
use crate::progress::{self, Observer, Progress, Stage};

/// How to approximate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ApproximateOptions {
    /// Rows and columns of the control net; in closed directions the different ones.
    pub net: (usize, usize),
    /// Degrees in u and v.
    pub degree: (usize, usize),
    /// Directions in which the surface closes smoothly.
    pub closed: (bool, bool),
    /// Weight of the fairness, the energy of third derivatives: 1 gives it as large a say as all
    /// points together. `None`: by generalized cross-validation.
    pub fairness: Option<f64>,
    /// How far the surface goes on beyond the points at open borders, in mean spacings of the
    /// points.
    pub border: f64,
    /// Solutions with the whole net at most.
    pub iterations: usize,
    /// Whether and how far the net grows.
    pub growth: Option<Growth>,
}

/// How far a net grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Until all points lie as near, in their unit; `None`: until cross-validation expects nothing
    /// from more control points.
    pub tolerance: Option<f64>,
    /// Control points at most.
    pub most: usize,
}

/// What ended the growth of a net.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndedBy {
    /// All points lie within the tolerance.
    Tolerance,
    /// A larger net would follow the noise of the points, says cross-validation.
    Noise,
    /// The error is so small that a larger net would not be seen.
    Exact,
    /// The size of the net was given.
    Grid,
    /// The points cannot hold more control points.
    Points,
    /// As many control points as were allowed.
    MaxControlPoints,
}

impl EndedBy {
    /// The name, as Python and reports spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tolerance => "tolerance",
            Self::Noise => "noise",
            Self::Exact => "exact",
            Self::Grid => "grid",
            Self::Points => "points",
            Self::MaxControlPoints => "max_control_points",
        }
    }
}

/// A surface near points.
#[derive(Clone, Debug, PartialEq)]
pub struct Approximation {
    /// The surface.
    pub surface: NurbsSurface,
    /// Where on it each point has its foot.
    pub uv: Vec<DVec2>,
    /// Each point's distance from its foot, in the points' unit.
    pub distances: Vec<f64>,
    /// The weight of the fairness that was used.
    pub fairness: f64,
    /// Mean square of the error that cross-validation expects at a point that was left out, in the
    /// points' unit squared; `None` if it was not asked.
    pub expected: Option<f64>,
    /// Solutions made after the coarse net.
    pub iterations: usize,
    /// What ended the growth of the net.
    pub ended_by: EndedBy,
}

/// Order of the derivatives whose energy is kept small. Third derivatives leave quadratics free,
/// which bend as most surfaces do.
const ORDER: usize = 3;

/// The same for surfaces of this degree, whose higher derivatives vanish.
fn order(space: &SplineSpace) -> usize {
    let [p, q] = [0, 1].map(|d| space.knots[d].degree());
    ORDER.min(p.max(q))
}

/// Weight of distances across the normal. Less lets the net slide away, more is plain distance,
/// which converges slowly.
const TANGENTIAL: f64 = 0.01;

/// Weight of the fairness at the first solution; half as much at each after it. Without it the
/// first iterations, whose parameters are rough, run away; with much more, folded sheets are drawn
/// flat.
const FIRST_FAIRNESS: f64 = 1.0;

/// Least weight of the fairness: enough to hold control points that no point holds.
const LEAST_FAIRNESS: f64 = 1e-4;

/// Steps towards the foot between two solutions.
const STEPS: usize = 3;

/// Solutions with the coarse net, as a share of those with the whole.
const COARSE_SHARE: f64 = 0.5;

/// Iterations end when the error falls by less than this share.
const CONVERGED: f64 = 0.02;

/// Solutions with the whole net at least.
const LEAST_ITERATIONS: usize = 4;

/// A share of the diagonal that is added to it: what rounding could make negative.
const RIDGE: f64 = 1e-14;

/// Solutions with a net that has grown, at most.
const GROWTH_ITERATIONS: usize = 6;

/// Share of its error that cross-validation must expect after growing at most, for the growth to
/// go on.
const LEAST_GAIN: f64 = 0.95;

/// Least number of points for each control point of a net that grows.
const POINTS_PER_CONTROL_POINT: usize = 4;

/// Root mean square error, as a share of the diagonal of the points' box, below which nobody sees
/// what more control points would do.
const EXACT: f64 = 1e-5;

/// Samples of each isocurve that lengths are measured on.
const LENGTH_SAMPLES: usize = 24;

/// The surface near `points`, from rough parameters in [0, 1]² (a closed direction has the period
/// 1). Each squared distance counts with its weight (1 without weights).
///
/// Half the net is fitted first, then the whole. O(points · degree⁴) and one band solution of three
/// times the unknowns for each iteration. The number of threads does not change a bit.
///
/// ```
/// use neurbs::{DVec2, DVec3, fit::{ApproximateOptions, approximate}, progress::Silent};
/// let points: Vec<DVec3> = (0..400)
///     .map(|i| {
///         let (x, y) = (f64::from(i * 7 % 400) / 399.0, f64::from(i) / 399.0);
///         DVec3::new(x, y, 0.3 * (2.0 * x).sin() * y)
///     })
///     .collect();
/// let uv: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
/// let options = ApproximateOptions { net: (6, 6), ..ApproximateOptions::default() };
/// let found = approximate(&points, &uv, None, &options, &mut Silent)?;
/// assert!(found.distances.iter().all(|distance| *distance < 1e-3));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] if the net is too small for the degree, or nothing holds it;
/// [`Error::Interrupted`] if the observer stops it.
pub fn approximate(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &ApproximateOptions,
    observer: &mut dyn Observer,
) -> Result<Approximation> {
    let mut fitting = Fitting::new(points, uv, weights, options, observer);
    let coarse = coarser(options);
    let share = |count: usize| ((count as f64 * COARSE_SHARE) as usize).max(2);
    let first = fitting.first(&uniform(coarse, options)?)?;
    let surface = if coarse == options.net {
        first
    } else {
        fitting.descend(&uniform(coarse, options)?, first, share(options.iterations))?
    };
    let surface = fitting.descend(&uniform(options.net, options)?, surface, options.iterations)?;
    let surface = fitting.widen(surface, options.border)?;
    let (surface, ended_by) = match options.growth {
        Some(growth) => fitting.grow(surface, growth)?,
        None => (surface, EndedBy::Grid),
    };
    Ok(fitting.finish(surface, ended_by))
}

impl Default for ApproximateOptions {
    fn default() -> Self {
        Self {
            net: (12, 12),
            degree: (3, 3),
            closed: (false, false),
            fairness: None,
            border: 0.5,
            iterations: 12,
            growth: None,
        }
    }
}

/// Half the net in both directions, as far as the degree allows.
fn coarser(options: &ApproximateOptions) -> (usize, usize) {
    let half = |count: usize, degree: usize, closed| {
        let least = degree + if closed { 2 } else { 1 };
        (count / 2).max(least).min(count)
    };
    (
        half(options.net.0, options.degree.0, options.closed.0),
        half(options.net.1, options.degree.1, options.closed.1),
    )
}

/// Evenly spaced knots for a net.
fn uniform(net: (usize, usize), options: &ApproximateOptions) -> Result<SplineSpace> {
    let knots = |degree, count, closed| {
        if closed {
            KnotVector::periodic_uniform(degree, count)
        } else {
            KnotVector::clamped_uniform(degree, count)
        }
    };
    let u = knots(options.degree.0, net.0, options.closed.0)?;
    let v = knots(options.degree.1, net.1, options.closed.1)?;
    SplineSpace::new([u, v], options.closed.into())
}

/// A fit in progress.
struct Fitting<'a> {
    points: &'a [DVec3],
    weights: Option<&'a [f64]>,
    uv: Vec<DVec2>,
    closed: [bool; 2],
    fixed: Option<f64>,
    /// What cross-validation has found last.
    score: Option<cross_validation::Score>,
    /// The weight that falls from solution to solution.
    falling: f64,
    iterations: usize,
    total: usize,
    observer: &'a mut dyn Observer,
}

impl<'a> Fitting<'a> {
    fn new(
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
            fixed: options.fairness,
            score: None,
            falling: FIRST_FAIRNESS,
            iterations: 0,
            total: options.iterations + (options.iterations as f64 * COARSE_SHARE) as usize + 2,
            observer,
        }
    }

    fn weight(&self, index: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights[index])
    }

    /// The weight of the fairness that is aimed at.
    fn aim(&self) -> f64 {
        let found = self.score.map_or(LEAST_FAIRNESS, |score| score.fairness);
        self.fixed.unwrap_or(found.max(LEAST_FAIRNESS))
    }

    /// The surface by plain distances at the parameters as they are.
    fn first(&mut self, space: &SplineSpace) -> Result<NurbsSurface> {
        let lengths = fairness::lengths(self.points, &self.uv, &space.knots);
        let samples = self.samples(None);
        let energy = fairness::energy(space, lengths, order(space));
        self.solve_distances(space, &samples, &energy, self.falling)
    }

    fn samples(&self, feet: Option<&[Foot]>) -> Vec<Sample> {
        let sample = |(index, &point): (usize, &DVec3)| {
            let weight = self.weight(index);
            match feet.map(|feet| feet[index]) {
                Some(foot) => {
                    let free = !foot.border && foot.normal != DVec3::ZERO;
                    let tangential = if free { TANGENTIAL } else { 1.0 };
                    Sample { point, uv: foot.uv, weight, normal: foot.normal, tangential }
                }
                None => {
                    let (uv, normal) = (self.uv[index], DVec3::ZERO);
                    Sample { point, uv, weight, normal, tangential: 1.0 }
                }
            }
        };
        self.points.iter().enumerate().map(sample).collect()
    }

    /// Solves with a net of its own, in turns with the feet, until the error stops falling.
    fn descend(
        &mut self,
        space: &SplineSpace,
        from: NurbsSurface,
        iterations: usize,
    ) -> Result<NurbsSurface> {
        let energy = fairness::energy(space, lengths(&from), order(space));
        let mut surface = from;
        let mut error = f64::INFINITY;
        for iteration in 0..iterations {
            let feet = self.correct(&surface);
            let found = self.rms(&feet);
            let settled = self.falling <= self.aim() && iteration >= LEAST_ITERATIONS;
            if settled && found > (1.0 - CONVERGED) * error {
                break;
            }
            error = found;
            let samples = self.samples(Some(&feet));
            if self.fixed.is_none() && matches!(iteration, 1 | 3 | 6) {
                let near = self.score.map(|score| score.fairness);
                self.score = cross_validation::best(space, &samples, &energy, near)?.or(self.score);
            }
            surface = self.solve_tangents(space, &samples, &energy)?;
            self.falling /= 2.0;
            self.iterations += 1;
        }
        Ok(surface)
    }

    /// Goes on beyond the points by this many of their mean spacings, at open borders.
    fn widen(&mut self, surface: NurbsSurface, border: f64) -> Result<NurbsSurface> {
        if border <= 0.0 || self.closed == [true, true] {
            return Ok(surface);
        }
        let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
        let space = SplineSpace::new(knots, self.closed)?;
        let (length_u, length_v) = lengths(&surface);
        let margin = border * (length_u * length_v / self.points.len() as f64).sqrt();
        self.correct(&surface);
        self.uv = bounded(&self.uv, self.closed.into());
        for (d, length) in [length_u, length_v].into_iter().enumerate() {
            if !self.closed[d] {
                let place = |at: f64| (at * length + margin) / (length + 2.0 * margin);
                self.uv.iter_mut().for_each(|uv| uv[d] = place(uv[d]));
            }
        }
        let energy = fairness::energy(&space, (length_u, length_v), order(&space));
        let samples = self.samples(None);
        let surface = self.solve_distances(&space, &samples, &energy, self.aim().max(1e-3))?;
        let feet = self.correct(&surface);
        self.solve_tangents(&space, &self.samples(Some(&feet)), &energy)
    }

    /// Divides spans and solves again until the tolerance holds or something forbids more.
    fn grow(
        &mut self,
        mut surface: NurbsSurface,
        growth: Growth,
    ) -> Result<(NurbsSurface, EndedBy)> {
        let counted = (0..self.points.len()).filter(|&i| self.weight(i) > 0.0).count();
        let held = counted / POINTS_PER_CONTROL_POINT;
        let exact = EXACT * extent(self.points);
        loop {
            let feet = self.correct(&surface);
            let far = |foot: &Foot| growth.tolerance.is_none_or(|most| foot.offset.length() > most);
            let counts = |i: usize| self.weight(i) > 0.0;
            let within = feet.iter().enumerate().all(|(i, foot)| !(far(foot) && counts(i)));
            if within {
                return Ok((surface, EndedBy::Tolerance));
            }
            if growth.tolerance.is_none() && self.rms(&feet) <= exact {
                return Ok((surface, EndedBy::Exact));
            }
            let error = |foot: &Foot| if far(foot) { foot.offset.length_squared() } else { 0.0 };
            let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
            let space = SplineSpace::new(knots, self.closed)?;
            let Some(finer) = refine::refined(&space, &feet, error, lengths(&surface))? else {
                return Ok((surface, EndedBy::Points));
            };
            if finer.unknowns() > growth.most.min(held) {
                let few = held < growth.most;
                let by = if few { EndedBy::Points } else { EndedBy::MaxControlPoints };
                return Ok((surface, by));
            }
            let before = (self.score, self.uv.clone());
            let next = self.descend(&finer, surface.clone(), GROWTH_ITERATIONS)?;
            if let (Some(old), Some(new)) = (before.0, self.score)
                && new.error > LEAST_GAIN * old.error
            {
                (self.score, self.uv) = before;
                return Ok((surface, EndedBy::Noise));
            }
            surface = next;
        }
    }

    fn finish(mut self, surface: NurbsSurface, ended_by: EndedBy) -> Approximation {
        let feet = self.correct(&surface);
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

    /// Moves the parameters to the feet.
    fn correct(&mut self, surface: &NurbsSurface) -> Vec<Foot> {
        let feet = feet(surface, self.closed, self.points, &self.uv, STEPS);
        self.uv.iter_mut().zip(&feet).for_each(|(uv, foot)| *uv = foot.uv);
        feet
    }

    /// Root of the mean square of the distances.
    fn rms(&self, feet: &[Foot]) -> f64 {
        let squares = feet.iter().enumerate();
        let squares = squares.map(|(i, foot)| self.weight(i) * foot.offset.length_squared());
        let weights: f64 = (0..feet.len()).map(|i| self.weight(i)).sum();
        (squares.sum::<f64>() / weights).sqrt()
    }

    fn solve_distances(
        &mut self,
        space: &SplineSpace,
        samples: &[Sample],
        energy: &Band,
        fairness: f64,
    ) -> Result<NurbsSurface> {
        let NormalEquations { mut matrix, mut right } =
            NormalEquations::of_distances(space, samples);
        let (said, size) = (matrix.trace(), space.unknowns());
        matrix.add_scaled(fairness * said / energy.trace(), energy);
        (0..size).for_each(|i| matrix.add(i, i, RIDGE * said / size as f64));
        self.factor(&mut matrix, space)?;
        matrix.solve(&mut right);
        let net: Vec<DVec3> = right.into_iter().map(DVec3::from_array).collect();
        space.surface(&net)
    }

    fn solve_tangents(
        &mut self,
        space: &SplineSpace,
        samples: &[Sample],
        energy: &Band,
    ) -> Result<NurbsSurface> {
        let NormalEquations { mut matrix, right } =
            NormalEquations::of_tangent_distances(space, samples);
        let fairness = self.falling.max(self.aim());
        let (said, size) = (matrix.trace() / (1.0 + 2.0 * TANGENTIAL), 3 * space.unknowns());
        matrix.add_for_each_axis(fairness * said / energy.trace(), energy);
        (0..size).for_each(|i| matrix.add(i, i, RIDGE * said / size as f64));
        self.factor(&mut matrix, space)?;
        let mut net: Vec<[f64; 1]> = right.as_flattened().iter().map(|&value| [value]).collect();
        matrix.solve(&mut net);
        let net: Vec<DVec3> =
            net.chunks(3).map(|p| DVec3::new(p[0][0], p[1][0], p[2][0])).collect();
        space.surface(&net)
    }

    fn factor(&mut self, matrix: &mut Band, space: &SplineSpace) -> Result<()> {
        let step = self.iterations.min(self.total) as u64;
        let progress =
            Progress::of_stage(Stage::Fitting, step, self.total as u64, self.points.len());
        if matrix.factor(&mut || progress::report(self.observer, &progress))? {
            return Ok(());
        }
        let [rows, cols] = space.shape();
        let got = format!("{rows} × {cols} for {} points", self.points.len());
        Err(Error::parameter("grid", "small enough for the points to hold it", got))
    }
}

/// The diagonal of the points' box.
fn extent(points: &[DVec3]) -> f64 {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let grow = |(low, high): (DVec3, DVec3), point: &DVec3| (low.min(*point), high.max(*point));
    let (low, high) = points.iter().fold(empty, grow);
    high.distance(low)
}

/// Mean lengths of the isocurves along u and along v, in the unit of the net.
fn lengths(surface: &NurbsSurface) -> (f64, f64) {
    let count = LENGTH_SAMPLES;
    let place = |knots: &KnotVector, i: usize| {
        let (start, end) = knots.domain();
        start + (end - start) * i as f64 / (count - 1) as f64
    };
    let at = |i: usize, j: usize| {
        let uv = DVec2::new(place(surface.knots_u(), i), place(surface.knots_v(), j));
        Tangents::at(surface, uv).point
    };
    let points: Vec<DVec3> = (0..count * count).map(|k| at(k / count, k % count)).collect();
    let length = |from: usize, to: usize| points[from].distance(points[to]);
    let (mut along_u, mut along_v) = (0.0, 0.0);
    for i in 1..count {
        for j in 0..count {
            along_u += length((i - 1) * count + j, i * count + j);
            along_v += length(j * count + i - 1, j * count + i);
        }
    }
    (along_u / count as f64, along_v / count as f64)
}
