//! Least squares at known parameters.

use glam::{DVec2, DVec3};

use super::band_matrix::BandMatrix;
use super::fairness_energy::{Energy, LengthSums};
use super::normal_equations::{NormalEquations, Sample};
use super::options::{FitOptions, check_fairness, check_weights};
use super::settings::LeastSquaresSettings;
use super::sizes::{MAX_CONTROL_POINTS, POINTS_PER_CALL};
use super::spline_space::SplineSpace;
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::{self, InterruptCheck, Observer, Stage};
use crate::worker_pool;

const SETTINGS: LeastSquaresSettings = LeastSquaresSettings::STANDARD;

/// Order of the derivatives in the thin plate's energy.
pub(super) const THIN_PLATE: usize = 2;

/// The least-squares surface of points at these parameters. Each squared distance is multiplied by
/// its weight, 1 without weights. A weight of 0 leaves a point out.
///
/// The normal equations take O(points · degree⁴), their solution at worst O(unknowns^1.5). The
/// result is the same to the last bit with any number of threads.
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
/// - [`Error::Parameter`] if points, parameters and weights differ in number, or a parameter lies
///   outside the domain.
/// - [`Error::Parameter`] if a weight is negative, all weights are 0, or the fairness is negative.
/// - [`Error::Parameter`] if knots are not periodic where they should be, or the points do not
///   determine the net.
/// - [`Error::NotFinite`] for a point that is not finite.
/// - [`Error::Interrupted`] if the observer stops it.
pub fn fit(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &FitOptions,
    observer: &mut dyn Observer,
) -> Result<NurbsSurface> {
    check(points, uv, weights, options)?;
    // Relative to the centroid, coordinates keep their digits wherever the points lie.
    let center = points.iter().sum::<DVec3>() / points.len() as f64;
    worker_pool::run_observed(points.len(), observer, |observer| {
        let mut check_interrupt = progress::interrupt_check(observer, Stage::Fitting, points.len());
        let sums = PointSums::of(points, uv, weights, center, options, &mut check_interrupt)?;
        Equations::of(sums, THIN_PLATE, 1.0).solve(options.fairness, &mut check_interrupt)
    })
}

/// The sums over points at known parameters, as band matrices.
#[derive(Clone)]
pub(super) struct PointSums {
    pub(super) space: SplineSpace,
    pub(super) origin: DVec3,
    /// Largest distance of a point from the origin.
    pub(super) extent: f64,
    pub(super) count: u64,
    pub(super) equations: NormalEquations,
    pub(super) lengths: LengthSums,
}

impl PointSums {
    /// The sums over points, each with its weight, 1 without weights. Coordinates keep most digits
    /// relative to an `origin` near the points.
    pub(super) fn of(
        points: &[DVec3],
        uv: &[DVec2],
        weights: Option<&[f64]>,
        origin: DVec3,
        options: &FitOptions,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let space = SplineSpace::of(options)?;
        // The equations, the energy, their sum and its factor, and the inverse.
        space.check_memory(1, 5)?;
        let extent = points.iter().map(|point| point.distance(origin)).fold(0.0, f64::max);
        let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
        let sample = |i: usize| Sample::plain(points[i] - origin, uv[i], weight(i));
        let mut samples = Vec::with_capacity(points.len());
        for from in (0..points.len()).step_by(POINTS_PER_CALL) {
            check_interrupt()?;
            samples.extend((from..points.len().min(from + POINTS_PER_CALL)).map(sample));
        }
        let equations = NormalEquations::of_distances(&space, &samples, check_interrupt)?;
        let lengths = LengthSums::of(&space, &samples, check_interrupt)?;
        Ok(Self { space, origin, extent, count: points.len() as u64, equations, lengths })
    }

    /// The same sums over a domain of known lengths in space.
    pub(super) fn with_lengths(self, lengths: (f64, f64)) -> Self {
        Self { lengths: LengthSums::known(lengths), ..self }
    }
}

/// Sums over points with an energy, to be solved for any fairness.
pub(super) struct Equations {
    sums: PointSums,
    /// Order of the derivatives in the energy.
    order: usize,
    pub(super) energy: BandMatrix,
    /// The trace of the energy without slopes, to which the fairness is relative.
    scale: f64,
}

impl Equations {
    pub(super) fn of(sums: PointSums, order: usize, anisotropy: f64) -> Self {
        let energy = Energy::new(sums.lengths.lengths(), order).with_anisotropy(anisotropy);
        Self::with_energy(sums, energy)
    }

    /// The sums with an energy of their domain.
    pub(super) fn with_energy(sums: PointSums, energy: Energy) -> Self {
        let order = energy.order;
        let energy = energy.matrix(&sums.space);
        let scale = energy.trace();
        Self { sums, order, energy, scale }
    }

    /// The same equations, with derivatives along u multiplied by the anisotropy, and those along v
    /// divided by it.
    pub(super) fn with_anisotropy(&self, anisotropy: f64) -> Self {
        Self::of(self.sums.clone(), self.order, anisotropy)
    }

    /// Penalizes slopes as well. Over gaps wider than the reach, a share of the domain's mean
    /// length, the surface becomes a membrane; over narrower ones the energy is as before.
    pub(super) fn tighten(&mut self, reach: f64) {
        let bends = i32::try_from(2 * (self.order - 1)).unwrap_or(i32::MAX);
        let slopes = Energy::new(self.sums.lengths.lengths(), 1).matrix(&self.sums.space);
        self.energy.add_scaled(reach.powi(-bends), &slopes);
    }

    pub(super) fn space(&self) -> &SplineSpace {
        &self.sums.space
    }

    /// The equations of the points without the energy.
    pub(super) fn of_points(&self) -> &NormalEquations {
        &self.sums.equations
    }

    /// The factor of the energy's matrix for a weight of the fairness.
    pub(super) fn times(&self, fairness: f64) -> f64 {
        // With degree 1 and one span in both directions, the energy is zero.
        let bends = fairness > 0.0 && self.scale > 0.0;
        if bends { fairness * self.of_points().matrix.trace() / self.scale } else { 0.0 }
    }

    pub(super) fn solve(
        &self,
        fairness: f64,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<NurbsSurface> {
        check_interrupt()?;
        let PointSums { space, origin, extent, equations, .. } = &self.sums;
        let mut matrix = equations.matrix.clone();
        matrix.add_scaled(self.times(fairness), &self.energy);
        let mut net = equations.right.clone();
        let determined = matrix.factor(check_interrupt)? && {
            check_interrupt()?;
            matrix.solve(&mut net);
            net.iter().all(|p| {
                DVec3::from_array(*p).length() <= SETTINGS.max_control_point_distance * extent
            })
        };
        if !determined {
            return Err(self.undetermined());
        }
        let place = |p: [f64; 3]| DVec3::from_array(p) + *origin;
        let net: Vec<DVec3> = net.into_iter().map(place).collect();
        space.surface(&net)
    }

    /// The error for a net that the points do not determine. Where points leave gaps, it says so.
    fn undetermined(&self) -> Error {
        let PointSums { space, count, equations, .. } = &self.sums;
        let ([rows, cols], matrix) = (space.shape(), &equations.matrix);
        let without = (0..matrix.size()).filter(|&i| matrix.entry(i, i) <= 0.0).count();
        let gaps = match without {
            0 => String::new(),
            without => format!(", with none near {without} of the {} control points", rows * cols),
        };
        let must = "small enough for the points to determine it; or raise fairness";
        Error::parameter("net", must, format!("{rows} × {cols} for {count} points{gaps}"))
    }
}

pub(super) fn check(
    points: &[DVec3],
    uv: &[DVec2],
    weights: Option<&[f64]>,
    options: &FitOptions,
) -> Result<()> {
    let count = points.len();
    if count == 0 {
        return Err(Error::parameter("points", "at least one", 0));
    }
    if uv.len() != count {
        let must = format!("as many as the points, {count}");
        return Err(Error::parameter("uv", must, uv.len()));
    }
    let net = (options.knots_u.control_points(), options.knots_v.control_points());
    if net.0.saturating_mul(net.1) > MAX_CONTROL_POINTS {
        let must = format!("for a net of at most {MAX_CONTROL_POINTS} control points");
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
        check_weights(weights, points.len())?;
    }
    check_fairness(options.fairness)
}
