//! Multistart: the search from several parametrizations, all derived from one.
//!
//! The given one is about proportional to lengths. That of the net may be faster or slower at the
//! ends of the domain than in the middle, and differ between both ends.

use glam::DVec2;
use rayon::prelude::*;

use super::super::spline_space::SplineSpace;
use super::lm_iterate::Trial;
use super::settings::RecoverySettings;
use super::varpro::Problem;
use crate::error::Result;
use crate::nurbs::{KnotVector, MAX_ORDER, padded};
use crate::progress::{self, Observer, Progress, Stage};

const SETTINGS: RecoverySettings = RecoverySettings::STANDARD;

/// The trial with the least error from these parametrizations. `None` if the points determine no
/// net.
pub(super) fn search(
    problem: &Problem<'_>,
    starts: &[Vec<DVec2>],
    observer: &mut dyn Observer,
) -> Result<Option<Trial>> {
    let trials = starts
        .par_iter()
        .map(|uv| Trial::from_parameters(problem, uv))
        .collect::<Result<Vec<_>>>()?;
    let mut trials: Vec<Trial> = trials.into_iter().flatten().collect();
    let (mut end, mut before) = (SETTINGS.first_round_steps, f64::INFINITY);
    for step in 0..SETTINGS.max_steps {
        let progress = Progress::of_stage(
            Stage::Fitting,
            step as u64,
            SETTINGS.max_steps as u64,
            problem.points.len(),
        );
        progress::report(observer, &progress)?;
        if trials.iter().any(|trial| problem.is_converged(trial.error)) {
            break;
        }
        trials.par_iter_mut().try_for_each(|trial| trial.advance(problem))?;
        if step + 1 == end {
            end *= 2;
            trials.sort_by(|a, b| a.error.total_cmp(&b.error));
            trials.truncate((trials.len() / 2).clamp(1, SETTINGS.max_trials));
            let Some(best) = trials.first() else { return Ok(None) };
            // While there are several trials, the best one may stall for a while.
            if trials.len() == 1 && best.error > SETTINGS.stalled_ratio * before {
                break;
            }
            before = best.error;
        }
    }
    Ok(trials.into_iter().min_by(|a, b| a.error.total_cmp(&b.error)))
}

/// A change of the parameters in one direction.
#[derive(Clone, Copy, PartialEq)]
enum Warp {
    /// Shift by this number of spans, in a closed direction.
    Turn(f64),
    /// Interpolation towards the parameters of a net with evenly spaced control points, which are
    /// three times as fast at both ends. Then `skew` is the speed at the start, and its inverse
    /// that at the end.
    Stretch { evenness: f64, skew: f64 },
}

/// Parameters of points on a surface of a space, from which starts are derived.
pub(super) struct StartParameters<'a> {
    pub(super) space: &'a SplineSpace,
    pub(super) uv: &'a [DVec2],
}

impl StartParameters<'_> {
    /// Starts with the same speed at both ends.
    pub(super) fn even(&self) -> Vec<Vec<DVec2>> {
        let stretch = |k: i32| Warp::Stretch { evenness: 0.25 * f64::from(k), skew: 1.0 };
        self.warped_by(&(-1..=4).map(stretch).collect::<Vec<_>>())
    }

    /// Starts with up to eight times the speed at one end of that at the other.
    pub(super) fn graded(&self) -> Vec<Vec<DVec2>> {
        let stretch = |evenness| {
            (-3..=3)
                .map(move |k| Warp::Stretch { evenness, skew: 2.0_f64.powf(0.5 * f64::from(k)) })
        };
        self.warped_by(&[0.5, 1.0].into_iter().flat_map(stretch).collect::<Vec<_>>())
    }

    /// Starts by all pairs of changes. In open directions the evenness is the same along u and v.
    fn warped_by(&self, stretches: &[Warp]) -> Vec<Vec<DVec2>> {
        let ([rows, cols], closed) = (self.space.shape(), self.space.closed);
        let turns = [0, 1, 2].map(|third| Warp::Turn(f64::from(third) / 3.0));
        let choices = closed.map(|closed| if closed { &turns[..] } else { stretches });
        let pairs = choices[0].iter().flat_map(|u| choices[1].iter().map(move |v| [*u, *v]));
        let alike = |pair: &[Warp; 2]| match *pair {
            [Warp::Stretch { evenness: u, .. }, Warp::Stretch { evenness: v, .. }] => u == v,
            _ => true,
        };
        let pairs: Vec<[Warp; 2]> = pairs.filter(alike).collect();
        // The points do not show along which direction the larger side of the net lies.
        let swapped: Vec<DVec2> = self.uv.iter().map(|uv| DVec2::new(uv.y, uv.x)).collect();
        let both = [self.uv, &swapped];
        let ways = if closed[0] == closed[1] && rows != cols { &both[..] } else { &both[..1] };
        let moved = |uv: &&[DVec2]| {
            let even = uv.par_iter().map(|uv| self.even_at(*uv)).collect::<Vec<_>>();
            let moved = |by: &[Warp; 2]| {
                let place = |(uv, even): (&DVec2, &DVec2)| {
                    DVec2::from([0, 1].map(|d| self.place(d, uv[d], even[d], by[d])))
                };
                uv.iter().zip(&even).map(place).collect()
            };
            pairs.iter().map(moved).collect::<Vec<Vec<DVec2>>>()
        };
        ways.iter().flat_map(moved).collect()
    }

    fn place(&self, d: usize, at: f64, even: f64, by: Warp) -> f64 {
        match by {
            Warp::Turn(by) => (at + by / self.space.shape()[d] as f64).rem_euclid(1.0),
            Warp::Stretch { evenness, skew } => {
                let share = at + evenness * (even - at);
                skew * share / (1.0 + (skew - 1.0) * share)
            }
        }
    }

    /// The parameters at which nets with evenly spaced control points reach these shares of their
    /// sides.
    fn even_at(&self, uv: DVec2) -> DVec2 {
        let parameter = |d: usize| {
            let knots = &self.space.knots[d];
            let (mut low, mut high) = (0.0, 1.0);
            if !self.space.closed[d] {
                for _ in 0..f64::MANTISSA_DIGITS {
                    let middle = 0.5 * (low + high);
                    let end = if even_place(knots, middle) < uv[d] { &mut low } else { &mut high };
                    *end = middle;
                }
            }
            low
        };
        DVec2::new(parameter(0), parameter(1))
    }
}

/// The position at a parameter, as a share of a line with evenly spaced control points.
fn even_place(knots: &KnotVector, at: f64) -> f64 {
    let basis = padded::<MAX_ORDER>(knots, at);
    let numbers = basis.values.iter().zip(basis.first..);
    let place: f64 = numbers.map(|(value, number)| value * number as f64).sum();
    place / (knots.control_points() - 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_differ_keep_the_order_and_span_the_domain() {
        let knots = [6, 7].map(|count| KnotVector::clamped_uniform(3, count).unwrap());
        let space = SplineSpace::new(knots, [false; 2]).unwrap();
        let at = |i: i32| f64::from(i) / 20.0;
        let uv: Vec<DVec2> = (0..=20).map(|i| DVec2::new(at(i), at(i) * at(i))).collect();
        let starts = StartParameters { space: &space, uv: &uv };
        let (even, graded) = (starts.even(), starts.graded());
        assert_eq!((even.len(), graded.len()), (2 * 6, 2 * 2 * 49));
        for starts in [even, graded] {
            for (i, start) in starts.iter().enumerate() {
                assert!(start.windows(2).all(|pair| pair[0].cmplt(pair[1]).all()));
                assert!(start[0].length() < 1e-12 && start[20].distance(DVec2::ONE) < 1e-12);
                for other in &starts[..i] {
                    assert!(start.iter().zip(other).any(|(a, b)| a.distance(*b) > 0.01));
                }
            }
        }
    }
}
