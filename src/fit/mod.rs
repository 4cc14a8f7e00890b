//! Least squares: the surface closest to points whose parameters are known.
//!
//! Minimized is the weighted sum of squared distances from each point to the surface at its
//! parameters, plus fairness times the thin-plate energy (G. Greiner, *Surface construction based
//! on variational principles*, 1994). The normal equations (`normal_equations`) are sparse and
//! positive definite; no matrix has a side as long as there are points.

mod anisotropy;
mod approximate;
mod arms;
mod band;
mod border;
mod coarse;
mod correct;
mod cross_validation;
mod dense;
mod edge;
mod fairness;
mod fitting;
mod folds;
mod ground;
mod growth;
mod height;
mod joint;
mod left_out;
mod lengths;
mod likelihood;
mod line;
mod normal_equations;
mod orientation;
mod outline;
mod patches;
mod quadrilateral;
mod rational;
mod refine;
mod relaxation;
mod residuals;
mod rim;
mod robust;
mod sides;
mod space;
mod starts;
mod substitution;
mod trend;
mod trial;
mod unfolding;
mod view;

use glam::{DVec2, DVec3};

pub(crate) use self::approximate::continued;
pub use self::approximate::{ApproximateOptions, Approximation, approximate};
pub(crate) use self::arms::Arms;
use self::band::Band;
pub use self::border::bounded;
pub use self::coarse::{CoarseFit, CoarseProblem, CoarseSettings, coarse, quick_error};
pub use self::correct::project;
use self::fairness::Energy;
pub use self::folds::{FOLDS, Folds};
pub(crate) use self::ground::Base;
pub use self::ground::height_axes;
pub(crate) use self::growth::{EXACT, diameter};
pub use self::growth::{EndedBy, Growth};
pub use self::height::{HeightFit, HeightOptions, fit_heights};
pub(crate) use self::height::{cosines, fit_heights_over, fit_heights_with};
pub(crate) use self::joint::{Recovery, recovered};
pub(crate) use self::left_out::Near;
pub(crate) use self::lengths::lengths;
pub(crate) use self::line::Line;
use self::normal_equations::{NormalEquations, Sample};
pub(crate) use self::orientation::turned;
pub(crate) use self::quadrilateral::Quadrilateral;
pub use self::rational::rational;
pub(crate) use self::relaxation::{Flat, relaxed, restricted};
pub use self::robust::biweights;
pub(crate) use self::robust::{biweight, reach};
use self::space::SplineSpace;
pub(crate) use self::unfolding::unfolded;
use crate::error::{Error, Result};
use crate::nurbs::{KnotVector, NurbsSurface};
use crate::progress::{self, Listen, Observer, Stage};

/// Control points further from the centre than this many extents of the points were not held by
/// anything but rounding.
const RUNAWAY: f64 = 1e6;

/// Most control points of a net to fit: the equations of more would not fit into memory.
const MOST_CONTROL_POINTS: usize = 1 << 20;

/// Points that are gone through between two looks at the observer: a few milliseconds.
const POINTS_PER_LOOK: usize = 1 << 16;

/// Points that a thread takes at a time: enough to be worth a block of sums, few enough that a crowded cell is shared.
const POINTS_PER_TASK: usize = 2048;

/// Order of the derivatives in the thin plate's energy.
const THIN_PLATE: usize = 2;

/// What is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct FitOptions {
    /// Knots in u; the domain must hold all parameters.
    pub knots_u: KnotVector,
    /// Knots in v.
    pub knots_v: KnotVector,
    /// Directions in which the surface closes smoothly: their knots must be periodic.
    pub closed: (bool, bool),
    /// Weight of the thin-plate energy: 1 gives it as large a say (trace of the matrix) as all
    /// points together, 0 none at all. Small values, 1e-6 say, only fill what points leave open.
    pub fairness: f64,
}

impl FitOptions {
    /// Evenly spaced knots on `[0, 1]²` for a net of this shape, and a fairness of 1e-6; in closed
    /// directions the shape counts the different control points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side of the net has not more control points than its degree, or
    /// the net has more than 2^20 of them.
    pub fn new(net: (usize, usize), degree: (usize, usize), closed: (bool, bool)) -> Result<Self> {
        if net.0.saturating_mul(net.1) > MOST_CONTROL_POINTS {
            let must = format!("of at most {MOST_CONTROL_POINTS} control points");
            return Err(Error::parameter("net", must, format!("{} × {}", net.0, net.1)));
        }
        let knots = |degree, count, closed| {
            if closed {
                KnotVector::periodic_uniform(degree, count)
            } else {
                KnotVector::clamped_uniform(degree, count)
            }
        };
        let knots_u = knots(degree.0, net.0, closed.0)?;
        let knots_v = knots(degree.1, net.1, closed.1)?;
        Ok(Self { knots_u, knots_v, closed, fairness: 1e-6 })
    }
}

/// The surface closest to points at these parameters, in the sense of least squares. Each squared
/// distance counts with its weight (1 without weights; 0 leaves a point out).
///
/// O(points · degree⁴) for the normal equations; solving them takes O(unknowns^1.5) at worst.
/// The number of threads does not change a bit of the result.
///
/// ```
/// use neurbs::{DVec2, DVec3, fit::{FitOptions, fit}, progress::Silent};
/// let uv: Vec<DVec2> = (0..400)
///     .map(|i| DVec2::new(f64::from(i * 7 % 400) / 399.0, f64::from(i) / 399.0))
///     .collect();
/// let points: Vec<DVec3> = uv.iter().map(|at| DVec3::new(at.x, at.y, at.x * at.y)).collect();
/// let options = FitOptions { fairness: 0.0, ..FitOptions::new((5, 6), (3, 3), (false, false))? };
/// let surface = fit(&points, &uv, None, &options, &mut Silent)?;
/// assert!(surface.point(0.3, 0.4).distance(DVec3::new(0.3, 0.4, 0.12)) < 1e-12);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] if points, parameters and weights differ in number, a parameter lies
/// outside the domain, a weight is negative or all are 0, the fairness is negative, knots are not
/// periodic where they should be, or the points cannot hold the net; [`Error::NotFinite`] for a
/// point that is not finite; [`Error::Interrupted`] if the observer stops it.
pub fn fit(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &FitOptions,
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    let mut listen = progress::listener(observer, Stage::Fitting, points.len());
    check(points, uv, weights, options)?;
    let equations = Equations::of(points, uv, weights, options, THIN_PLATE, &mut listen)?;
    equations.solve(options.fairness, &mut listen)
}

/// The normal equations of points at their parameters, to be solved with any fairness.
struct Equations {
    space: SplineSpace,
    /// About the centroid numbers keep their digits wherever the points lie.
    centre: DVec3,
    extent: f64,
    points: usize,
    distances: NormalEquations,
    /// Of the derivatives of an order, and what that of the slopes is added to.
    order: usize,
    energy: Band,
    /// The trace of the energy without slopes, in which fairness is measured.
    scale: f64,
    /// The lengths of the domain along u and v.
    lengths: (f64, f64),
}

impl Equations {
    fn of(
        points: &[DVec3],
        uv: &[DVec2],
        weights: Option<&[f64]>,
        options: &FitOptions,
        order: usize,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let knots = [options.knots_u.clone(), options.knots_v.clone()];
        let space = SplineSpace::new(knots, options.closed.into())?;
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let extent = points.iter().map(|point| point.distance(centre)).fold(0.0, f64::max);
        let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
        let sample = |i: usize| {
            let (weight, normal) = (weight(i), DVec3::ZERO);
            Sample { point: points[i] - centre, uv: uv[i], weight, normal, tangential: 1.0 }
        };
        let mut samples = Vec::with_capacity(points.len());
        for from in (0..points.len()).step_by(POINTS_PER_LOOK) {
            listen()?;
            samples.extend((from..points.len().min(from + POINTS_PER_LOOK)).map(sample));
        }
        let distances = NormalEquations::of_distances(&space, &samples, listen)?;
        let lengths = fairness::lengths(&space, &samples, listen)?;
        drop(samples);
        listen()?;
        let energy = Energy::new(lengths, order).matrix(&space);
        let (points, scale) = (points.len(), energy.trace());
        Ok(Self { space, centre, extent, points, distances, order, energy, scale, lengths })
    }

    /// Lets slopes count as well: over gaps wider than the reach, a share of the domain's mean length, the
    /// surface becomes a membrane, whose slopes end there; over narrower ones bends decide as before.
    fn tighten(&mut self, reach: f64) {
        let bends = i32::try_from(2 * (self.order - 1)).unwrap_or(i32::MAX);
        let slopes = Energy::new(self.lengths, 1).matrix(&self.space);
        self.energy.add_scaled(reach.powi(-bends), &slopes);
    }

    fn solve(&self, fairness: f64, listen: &mut Listen<'_>) -> Result<NurbsSurface> {
        listen()?;
        let mut matrix = self.distances.matrix.clone();
        // Of degree 1 in both directions and in one span nothing bends.
        if fairness > 0.0 && self.scale > 0.0 {
            matrix.add_scaled(fairness * matrix.trace() / self.scale, &self.energy);
        }
        let mut net = self.distances.right.clone();
        let held = matrix.factor(listen)? && {
            listen()?;
            matrix.solve(&mut net);
            net.iter().all(|p| DVec3::from_array(*p).length() <= RUNAWAY * self.extent)
        };
        if !held {
            let [rows, cols] = self.space.shape();
            let got = format!("{rows} × {cols} for {} points", self.points);
            let must = "small enough for the points to hold it; or raise fairness";
            return Err(Error::parameter("net", must, got));
        }
        let place = |p: [f64; 3]| DVec3::from_array(p) + self.centre;
        let net: Vec<DVec3> = net.into_iter().map(place).collect();
        self.space.surface(&net)
    }
}

fn check(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &FitOptions,
) -> Result<()> {
    let count = points.len();
    let same = |name, length| {
        let must = format!("as many as the points, {count}");
        if length == count { Ok(()) } else { Err(Error::parameter(name, must, length)) }
    };
    if count == 0 {
        return Err(Error::parameter("points", "at least one", 0));
    }
    same("uv", uv.len())?;
    let net = (options.knots_u.control_points(), options.knots_v.control_points());
    if net.0.saturating_mul(net.1) > MOST_CONTROL_POINTS {
        let must = format!("for a net of at most {MOST_CONTROL_POINTS} control points");
        return Err(Error::parameter("knots", must, format!("{} × {}", net.0, net.1)));
    }
    if let Some(index) = points.iter().position(|point| !point.is_finite()) {
        return Err(Error::NotFinite { index, point: points[index] });
    }
    let sides = [("u", &options.knots_u), ("v", &options.knots_v)];
    for (axis, (name, knots)) in sides.into_iter().enumerate() {
        let (start, end) = knots.domain();
        if let Some(i) = uv.iter().position(|at| !(start..=end).contains(&at[axis])) {
            let must = format!("inside the domain [{start}, {end}] in {name}");
            return Err(Error::parameter("uv", must, format!("{} at index {i}", uv[i][axis])));
        }
    }
    if let Some(weights) = weights {
        same("weights", weights.len())?;
        if let Some(i) = weights.iter().position(|w| !(*w >= 0.0 && w.is_finite())) {
            let got = format!("{} at index {i}", weights[i]);
            return Err(Error::parameter("weights", "finite and at least 0", got));
        }
        if weights.iter().all(|w| *w == 0.0) {
            return Err(Error::parameter("weights", "positive for some point", "all 0"));
        }
    }
    if !(options.fairness >= 0.0 && options.fairness.is_finite()) {
        return Err(Error::parameter("fairness", "finite and at least 0", options.fairness));
    }
    Ok(())
}
