//! A surface that folds over in a few places, turned the right way there.
//!
//! Seen along the normal that the surface has around such a place, its area is negative there. Equations that ask for
//! a little area instead, linear in the control points as far as these move little (Gauss and Newton), are solved
//! together with those of the points, and count the more the longer the fold is left: they bind one number for
//! each place, where control points that are held or drawn take the surface away from points around it.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::approximate::Approximation;
use super::correct::Foot;
use super::fitting::{Fitting, STEPS};
use super::growth::{EXACT, EndedBy, diameter};
use super::lengths::lengths;
use super::normal_equations::NormalEquations;
use super::patches::{Patches, Tangents};
use super::relaxation::{Flat, Inspect};
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::{NurbsSurface, padded};
use crate::progress::Observer;

/// Solutions at most.
const SOLUTIONS: usize = 12;

/// Where more places have flaws, these hardly ever become none.
const MOST_FLAWS: usize = 32;

/// How many times farther from its points the surface may become, if that can be seen: what turns at a few places
/// hardly goes away from them.
const FARTHEST: f64 = 1.1;

/// Places in each span along either direction that may be asked for area, and how many around a flaw are, either
/// way.
const PER_SPAN: usize = 4;
const AROUND: isize = 2;

/// How many places around, either way, say with which normal and how much area there is.
const USUAL: isize = 4;

/// Share of the usual area that is asked for, and up to how many times that it must not become less.
const LEAST_AREA: f64 = 0.1;
const NEAR_LEAST: f64 = 4.0;

/// How much an equation counts where there is a flaw for the first time, beside what the points say of a control
/// point on average, and how many times that each further time.
const FIRST: f64 = 0.01;
const STRONGER: f64 = 10.0;

/// The surface with this fairness and without any flaws, whether it had some before or none; `None` if some are left,
/// or if it went away from its points.
///
/// # Errors
///
/// Those of [`approximate`](super::approximate()), and of `inspect`.
pub(crate) fn turned(
    points: &[DVec3],
    weights: Option<&[f64]>,
    folded: &Flat<'_>,
    inspect: &mut Inspect<'_>,
    observer: &mut dyn Observer,
) -> Result<Option<Approximation>> {
    let mut fitting = folded.fitting(points, weights, Some(folded.fairness), observer);
    let found = fitting.turn(folded.surface, inspect)?;
    Ok(found.map(|(surface, feet)| fitting.end(surface, &feet, EndedBy::Grid)))
}

impl Fitting<'_> {
    fn turn(
        &mut self,
        folded: &NurbsSurface,
        inspect: &mut Inspect<'_>,
    ) -> Result<Option<(NurbsSurface, Vec<Foot>)>> {
        let knots = [folded.knots_u().clone(), folded.knots_v().clone()];
        let space = SplineSpace::new(knots, self.closed)?;
        let (energy, along_axes) = self.energy_along_axes(&space, lengths(folded));
        let mut flaws = inspect(folded, &self.uv, self.observer)?;
        let mut surface = folded.clone();
        let mut feet = self.correct(folded, STEPS);
        let limit = (FARTHEST * self.rms(&feet)).max(EXACT * diameter(self.points));
        let mut asked = Asked::of(&space);
        for _ in 0..SOLUTIONS {
            asked.ask_around(&flaws);
            let equations = self.equations(&space, &feet)?;
            let ask = |equations: &mut NormalEquations, unit| {
                asked.add_to(equations, unit, &surface);
            };
            surface = self.solve_beside(&space, equations, &energy, &along_axes, ask)?;
            self.iterations += 1;
            feet = self.correct(&surface, STEPS);
            if self.rms(&feet) > limit {
                return Ok(None);
            }
            flaws = inspect(&surface, &self.uv, self.observer)?;
            if flaws.is_empty() {
                return Ok(Some((surface, feet)));
            }
            if flaws.len() > MOST_FLAWS {
                return Ok(None);
            }
        }
        Ok(None)
    }
}

/// Places on surfaces of a space, by their numbers along u and v, and how much the area there counts.
struct Asked<'a> {
    space: &'a SplineSpace,
    /// Places along u and along v, but for the last.
    counts: [isize; 2],
    weights: BTreeMap<[isize; 2], f64>,
}

impl<'a> Asked<'a> {
    fn of(space: &'a SplineSpace) -> Self {
        let count = |d: usize| PER_SPAN * (space.knots[d].breaks().len() - 1);
        let counts = [0, 1].map(|d| count(d).cast_signed());
        Self { space, counts, weights: BTreeMap::new() }
    }

    /// Asks for area around flaws, or more strongly.
    fn ask_around(&mut self, flaws: &[DVec2]) {
        let mut around: Vec<[isize; 2]> =
            flaws.iter().flat_map(|flaw| self.near(self.nearest(*flaw), AROUND)).collect();
        around.sort_unstable();
        around.dedup();
        for place in around {
            let weight = self.weights.entry(place).or_insert(0.0);
            *weight = (STRONGER * *weight).max(FIRST);
        }
    }

    fn uv(&self, place: [isize; 2]) -> DVec2 {
        let at = |d: usize| {
            let (start, end) = self.space.knots[d].domain();
            let share = place[d] as f64 / self.counts[d] as f64;
            (start + share * (end - start)).clamp(start, end)
        };
        DVec2::new(at(0), at(1))
    }

    #[expect(clippy::cast_possible_truncation, reason = "a share of a small number")]
    fn nearest(&self, uv: DVec2) -> [isize; 2] {
        [0, 1].map(|d| {
            let (start, end) = self.space.knots[d].domain();
            ((uv[d] - start) / (end - start) * self.counts[d] as f64).round() as isize
        })
    }

    /// The places around one, around the seam where there is one.
    fn near(&self, place: [isize; 2], reach: isize) -> Vec<[isize; 2]> {
        let along = |d: usize| {
            let (count, closed) = (self.counts[d], self.space.closed[d]);
            let all = place[d] - reach..=place[d] + reach;
            let inside = all.filter(move |at| closed || (0..=count).contains(at));
            inside.map(move |at| if closed { at.rem_euclid(count) } else { at })
        };
        along(0).flat_map(|i| along(1).map(move |j| [i, j])).collect()
    }

    /// Adds an equation for each place where a surface has little area, or less than none; `unit` is what the points
    /// say on average.
    fn add_to(&self, equations: &mut NormalEquations, unit: f64, surface: &NurbsSurface) {
        let (patches, points) = (Patches::of(surface), self.space.unknown_points(surface));
        let tangents = |place| patches.at(self.uv(place));
        for (&place, &weight) in &self.weights {
            let near = self.near(place, USUAL);
            let areas = near.iter().map(|&near| tangents(near)).map(|at| at.u.cross(at.v));
            let usual = areas.sum::<DVec3>() / near.len() as f64;
            let (normal, least) = (usual.normalize_or_zero(), LEAST_AREA * usual.length());
            let Tangents { u, v, .. } = tangents(place);
            let area = u.cross(v).dot(normal);
            if area > NEAR_LEAST * least {
                continue;
            }
            let row = self.by_control_points(self.uv(place), v.cross(normal), normal.cross(u));
            let square: f64 = row.iter().map(|(_, slope)| slope.length_squared()).sum();
            if square > 0.0 {
                let now: f64 = row.iter().map(|(at, slope)| slope.dot(points[*at])).sum();
                equations.add_row(&row, weight * unit / square, now + area.max(least) - area);
            }
        }
    }

    /// How what changes so with the tangents at a place changes with the control points.
    fn by_control_points(&self, uv: DVec2, by_u: DVec3, by_v: DVec3) -> Vec<(usize, DVec3)> {
        let [u, v] = &self.space.knots;
        let (of_u, of_v) = (padded(u, uv.x), padded(v, uv.y));
        let slope = |i: usize, j: usize| {
            of_u.slopes[i] * of_v.values[j] * by_u + of_u.values[i] * of_v.slopes[j] * by_v
        };
        let place = |i: usize, j: usize| self.space.place(of_u.first + i, of_v.first + j);
        let cols = 0..=v.degree();
        (0..=u.degree())
            .flat_map(|i| cols.clone().map(move |j| (i, j)))
            .map(|(i, j)| (place(i, j), slope(i, j)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::unfolding::tests::{down, folded};
    use crate::nurbs::KnotVector;
    use crate::progress::Silent;

    #[test]
    fn asked_places_go_round_the_seam_and_end_at_borders() {
        let (surface, ..) = folded();
        let knots = [surface.knots_u().clone(), surface.knots_v().clone()];
        let open = SplineSpace::new(knots, [false; 2]).unwrap();
        let asked = Asked::of(&open);
        assert_eq!(asked.counts, [20, 20]);
        assert_eq!(asked.near([0, 10], 1), [[0, 9], [0, 10], [0, 11], [1, 9], [1, 10], [1, 11]]);
        let knots = [0, 1].map(|_| KnotVector::periodic_uniform(3, 8).unwrap());
        let closed = SplineSpace::new(knots, [true; 2]).unwrap();
        let asked = Asked::of(&closed);
        assert!(asked.near([0, 31], 1).contains(&[31, 0]));
    }

    /// A bowl whose corner, where no points are, is turned in; its points, and their parameters.
    fn bowl() -> (NurbsSurface, Vec<DVec3>, Vec<DVec2>) {
        let control = |i: u32| {
            let place = DVec2::new(f64::from(i / 8), f64::from(i % 8)) / 7.0;
            let place = if i == 0 { DVec2::splat(0.25) } else { place };
            place.extend(place.length_squared())
        };
        let surface = NurbsSurface::clamped((0..64).map(control).collect(), (8, 8), 3).unwrap();
        let uv: Vec<DVec2> = folded().2.into_iter().filter(|uv| uv.x + uv.y > 0.4).collect();
        let points = uv.iter().map(|uv| surface.point(uv.x, uv.y)).collect();
        (surface, points, uv)
    }

    fn inspect(
        surface: &NurbsSurface,
        _: &[DVec2],
        observer: &mut dyn Observer,
    ) -> Result<Vec<DVec2>> {
        down(surface, observer)
    }

    #[test]
    fn what_folds_is_turned_and_stays_near_its_points() {
        let (surface, points, uv) = bowl();
        assert!(!down(&surface, &mut Silent).unwrap().is_empty());
        let flat = Flat { surface: &surface, uv: &uv, fairness: 1e-6, closed: (false, false) };
        let found = turned(&points, None, &flat, &mut inspect, &mut Silent).unwrap().unwrap();
        assert!(down(&found.surface, &mut Silent).unwrap().is_empty());
        let farthest = found.distances.iter().copied().fold(0.0, f64::max);
        assert!(farthest < 2e-4, "{farthest}");
    }

    #[test]
    fn what_was_flattened_comes_back_to_its_points() {
        let (_, points, uv) = bowl();
        let net = (0..64).map(|i| DVec2::new(f64::from(i / 8), f64::from(i % 8)).extend(4.9) / 7.0);
        let plane = NurbsSurface::clamped(net.collect(), (8, 8), 3).unwrap();
        let flat = Flat { surface: &plane, uv: &uv, fairness: 1e-6, closed: (false, false) };
        let found = turned(&points, None, &flat, &mut inspect, &mut Silent).unwrap().unwrap();
        assert!(down(&found.surface, &mut Silent).unwrap().is_empty());
        let farthest = found.distances.iter().copied().fold(0.0, f64::max);
        assert!(farthest < 1e-2, "{farthest}");
    }

    #[test]
    fn what_folds_in_too_many_places_is_given_up_at_once() {
        let (surface, points, uv) = bowl();
        let flat = Flat { surface: &surface, uv: &uv, fairness: 1e-6, closed: (false, false) };
        let mut times = 0;
        let mut inspect = |_: &NurbsSurface, _: &[DVec2], _: &mut dyn Observer| {
            times += 1;
            Ok(vec![DVec2::ZERO; MOST_FLAWS + 1])
        };
        assert!(turned(&points, None, &flat, &mut inspect, &mut Silent).unwrap().is_none());
        assert_eq!(times, 2);
    }
}
