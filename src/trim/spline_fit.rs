//! Least-squares splines in (u, v) through places, measured in the lengths of the surface.

use glam::{DMat2, DVec2, DVec3};

use super::level::Closeness;
use super::normal_matrix::NormalMatrix;
use super::settings::SplineSettings;
use crate::error::Result;
use crate::nurbs::{KnotVector, NurbsCurve, values_at};
use crate::progress::Silent;

const SETTINGS: SplineSettings = SplineSettings::STANDARD;

/// Degree of curves; straight ones have 1.
const DEGREE: usize = 3;

/// Places with parameters in [0, 1] that a curve should pass.
#[derive(Clone, Debug)]
pub(super) struct Targets<'a> {
    pub at: &'a [f64],
    pub uv: &'a [DVec2],
    pub tangents: &'a [[DVec3; 2]],
}

/// Which curves may be fitted.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// From one end to the other; ends may be given.
    Open([Option<DVec2>; 2]),
    /// Around and back to the start, moved by a shift.
    Periodic(DVec2),
}

impl Form {
    /// The numbers of control points to try.
    pub(super) fn sizes(&self) -> &'static [usize] {
        match self {
            Self::Open(_) => &OPEN_SIZES,
            Self::Periodic(_) => &PERIODIC_SIZES,
        }
    }
}

static OPEN_SIZES: [usize; 22] = SETTINGS.open_sizes;
static PERIODIC_SIZES: [usize; 24] = SETTINGS.periodic_sizes;

/// A fitted spline.
#[derive(Clone, Debug)]
pub(super) struct SplineFit {
    /// The curve, on [0, 1], with clamped knots.
    pub curve: NurbsCurve,
    /// Distinct control points.
    pub count: usize,
    /// Sum of squared distances, in space.
    pub squares: f64,
}

impl Targets<'_> {
    /// The spline with `count` control points and evenly spaced knots that is closest to the
    /// places; `None` if they do not determine it.
    ///
    /// `fairness` weighs squared third differences of control points against squared distances.
    pub(super) fn fit(&self, form: Form, count: usize, fairness: f64) -> Result<Option<SplineFit>> {
        let degree = DEGREE.min(count - 1);
        let (knots, shift) = match form {
            Form::Open(_) => (KnotVector::clamped_uniform(degree, count)?, DVec2::ZERO),
            Form::Periodic(shift) => (KnotVector::periodic_uniform(degree, count)?, shift),
        };
        let System { matrix, right } = self.system(form, &knots, count, fairness);
        let mut solved = right;
        if !matrix.solve(&mut solved) {
            return Ok(None);
        }
        let control: Vec<DVec2> = solved.chunks_exact(2).map(DVec2::from_slice).collect();
        // A straight shift is a spline whose control points lie at the Greville abscissas.
        let greville = knots.greville();
        let points = (0..knots.control_points())
            .map(|k| (control[k % count] + shift * greville[k]).extend(0.0));
        let curve = NurbsCurve::new(points.collect(), None, knots)?;
        let squares = self.distances(&curve).sum();
        let curve = match form {
            Form::Open(_) => curve,
            Form::Periodic(_) => curve.clamp(&mut Silent)?,
        };
        Ok(Some(SplineFit { curve, count, squares }))
    }

    /// The squared distances of the places from a curve's points at their parameters.
    fn distances(&self, curve: &NurbsCurve) -> impl Iterator<Item = f64> {
        self.at.iter().enumerate().map(|(k, at)| {
            let off = self.uv[k] - curve.point(*at).truncate();
            let [by_u, by_v] = self.tangents[k];
            (off.x * by_u + off.y * by_v).length_squared()
        })
    }

    /// The largest distance of a place from the curve's point at its parameter.
    pub(super) fn largest(&self, curve: &NurbsCurve) -> f64 {
        self.distances(curve).fold(0.0, f64::max).sqrt()
    }

    /// The normal equations.
    fn system(&self, form: Form, knots: &KnotVector, count: usize, fairness: f64) -> System {
        let fixed = |k: usize| match form {
            Form::Open([start, _]) if k == 0 => start,
            Form::Open([_, end]) if k + 1 == count => end,
            _ => None,
        };
        let shift = match form {
            Form::Open(_) => DVec2::ZERO,
            Form::Periodic(shift) => shift,
        };
        let mut system = System::new(count);
        let order = knots.degree() + 1;
        let mut values = [0.0; DEGREE + 1];
        let mut mean = DMat2::ZERO;
        for (k, at) in self.at.iter().enumerate() {
            let metric = metric(self.tangents[k]);
            mean += metric;
            let first = values_at(knots, *at, &mut values[..order]);
            let terms: [(usize, f64); DEGREE + 1] =
                std::array::from_fn(|i| ((first + i) % count, values[i]));
            system.add(&terms[..order], metric, self.uv[k] - shift * *at, fixed);
        }
        // Weighted by places a control point, as a share of the squared distances.
        let fair = mean * (fairness / count as f64);
        let differences = match form {
            Form::Open(_) => count.saturating_sub(3),
            Form::Periodic(_) => count,
        };
        for k in 0..differences {
            let terms = [(k, -1.0), (k + 1, 3.0), (k + 2, -3.0), (k + 3, 1.0)];
            system.add(&terms.map(|(i, value)| (i % count, value)), fair, DVec2::ZERO, fixed);
        }
        for k in [0, count - 1] {
            if let Some(end) = fixed(k) {
                system.fix(k, end);
            }
        }
        system
    }

    /// The fit with the fewest control points that cross-validation does not clearly improve on.
    /// Fits within the band come first; without one, the fit with most control points.
    ///
    /// `spacing` is the distance of places, `length` that of the whole curve, both in space.
    pub(super) fn choose(
        &self,
        form: Form,
        (spacing, length): (f64, f64),
        closeness: Closeness,
    ) -> Result<Option<SplineFit>> {
        let places = self.uv.len();
        let most = length * closeness.knots / (SETTINGS.knot_distance * spacing);
        let most = most.min(places as f64 * SETTINGS.max_share);
        let floor = places as f64 * (SETTINGS.noise_floor * spacing).powi(2);
        let mut best: Option<(f64, bool, SplineFit)> = None;
        for &count in form.sizes() {
            let extra = count as f64 - DEGREE as f64 - 1.0;
            if extra > most || count >= places {
                break;
            }
            let Some(fit) = self.fit(form, count, SETTINGS.fairness)? else { continue };
            let score = cross_validation(fit.squares + floor, count, places);
            let is_near = closeness.band == f64::INFINITY
                || self.largest(&fit.curve) <= closeness.band * spacing;
            let is_better = |(least, near, _): &(f64, bool, _)| {
                !near || (is_near && score < SETTINGS.gain * least)
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some((score, is_near, fit));
            }
        }
        Ok(best.map(|(_, _, fit)| fit))
    }
}

/// Generalized cross-validation (P. Craven and G. Wahba 1979) of a sum of squares.
pub(super) fn cross_validation(squares: f64, count: usize, places: usize) -> f64 {
    let used = SETTINGS.penalty * count as f64 / places as f64;
    squares / places as f64 / (1.0 - used.min(SETTINGS.max_used)).powi(2)
}

/// The products of tangents: lengths of steps in (u, v).
pub(super) fn metric([by_u, by_v]: [DVec3; 2]) -> DMat2 {
    let mixed = by_u.dot(by_v);
    DMat2::from_cols(
        DVec2::new(by_u.length_squared(), mixed),
        DVec2::new(mixed, by_v.length_squared()),
    )
}

/// Normal equations for control points in (u, v).
struct System {
    matrix: NormalMatrix,
    right: Vec<f64>,
}

impl System {
    fn new(count: usize) -> Self {
        Self { matrix: NormalMatrix::new(2 * count), right: vec![0.0; 2 * count] }
    }

    /// Adds the squared distance of a combination of control points from a target. Fixed control
    /// points are part of the target.
    fn add(
        &mut self,
        terms: &[(usize, f64)],
        metric: DMat2,
        target: DVec2,
        fixed: impl Fn(usize) -> Option<DVec2>,
    ) {
        let given = terms.iter().filter_map(|(k, value)| Some(fixed(*k)? * *value));
        let target = metric * (target - given.sum::<DVec2>());
        let free = || terms.iter().filter(|(k, _)| fixed(*k).is_none());
        for &(k, x) in free() {
            for d in 0..2 {
                self.right[2 * k + d] += x * target[d];
                for &(l, y) in free() {
                    for e in 0..2 {
                        let (i, j) = (2 * k + d, 2 * l + e);
                        // Each pair once; a pair of equal control points counts as it comes.
                        if j <= i {
                            self.matrix.add(i, j, x * y * metric.col(e)[d]);
                        }
                    }
                }
            }
        }
    }

    /// Makes a control point what it is given as.
    fn fix(&mut self, k: usize, point: DVec2) {
        for d in 0..2 {
            self.matrix.add(2 * k + d, 2 * k + d, 1.0);
            self.right[2 * k + d] = point[d];
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const STANDARD: Closeness = Closeness { knots: 1.0, band: f64::INFINITY };

    #[test]
    fn straight_places_give_two_control_points_and_waves_more() {
        let at: Vec<f64> = (0..80).map(|k| f64::from(k) / 79.0).collect();
        let noise = |k: usize| 0.3 * ((k * k) as f64).sin();
        let wave = |height: f64| -> Vec<DVec2> {
            let place =
                |(k, t): (usize, &f64)| DVec2::new(80.0 * t, height * (TAU * t).sin() + noise(k));
            at.iter().enumerate().map(place).collect()
        };
        let tangents = [[DVec3::X, DVec3::Y]; 80];
        let count = |uv: &[DVec2]| {
            let targets = Targets { at: &at, uv, tangents: &tangents };
            let form = Form::Open([None; 2]);
            targets.choose(form, (1.0, 80.0), STANDARD).unwrap().unwrap().count
        };
        assert_eq!(count(&wave(0.0)), 2);
        assert!((6..=10).contains(&count(&wave(5.0))));
    }

    #[test]
    fn rims_go_on_by_their_shift_and_ends_can_be_given() {
        let at: Vec<f64> = (0..60).map(|k| f64::from(k) / 60.0).collect();
        let uv: Vec<DVec2> = at.iter().map(|t| DVec2::new(3.0 * t, (TAU * t).sin())).collect();
        let tangents = [[DVec3::X, DVec3::Y]; 60];
        let targets = Targets { at: &at, uv: &uv, tangents: &tangents };
        let shift = DVec2::new(3.0, 0.0);
        let rim = targets.fit(Form::Periodic(shift), 12, 1e-3).unwrap().unwrap();
        assert!(targets.largest(&rim.curve) < 0.01);
        let ends = [0.0, 1.0].map(|at| rim.curve.point(at).truncate());
        assert!((ends[1] - ends[0]).distance(shift) < 1e-12);
        let given = [DVec2::new(-0.5, 0.2), DVec2::new(3.5, -0.2)];
        let arc = targets.fit(Form::Open(given.map(Some)), 8, 1e-3).unwrap().unwrap();
        let points = arc.curve.control_points();
        assert_eq!([points[0], points[7]], given.map(|end| end.extend(0.0)));
    }
}
