//! A surface that folds, unfolded.
//!
//! Control points that lie evenly between those before and after them make no folds. Those around a
//! fold are drawn there, and the more strongly the longer it is left; the fairness, which has as large
//! a say as all else, grows with that. What this takes from the points [`relaxed`](super::relaxed())
//! gives back wherever it makes no folds again.

use glam::DVec3;

use super::approximate::Approximation;
use super::band::Band;
use super::correct::Foot;
use super::fitting::{Fitting, STEPS};
use super::growth::EndedBy;
use super::lengths::lengths;
use super::relaxation::{Flat, Inspect};
use super::space::SplineSpace;
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Solutions at most: folds that are left then move about where nothing is near the points any more.
const SOLUTIONS: usize = 12;

/// How strongly a control point is drawn between its neighbours, beside what the points say of one on
/// average, when there is a flaw around it for the first time, and how many times that each further
/// time.
const FIRST: f64 = 1.0;
const STRONGER: f64 = 10.0;

/// The surface without any flaws; `None` if some are left.
///
/// # Errors
///
/// Those of [`approximate`](super::approximate()), and of `inspect`.
pub(crate) fn unfolded(
    points: &[DVec3],
    weights: Option<&[f64]>,
    folded: &Flat<'_>,
    inspect: &mut Inspect<'_>,
    observer: &mut dyn Observer,
) -> Result<Option<Approximation>> {
    let mut fitting = folded.fitting(points, weights, Some(folded.fairness), observer);
    let found = fitting.unfold(folded.surface, inspect)?;
    Ok(found.map(|(surface, feet)| fitting.end(surface, &feet, EndedBy::Grid)))
}

impl Fitting<'_> {
    fn unfold(
        &mut self,
        folded: &NurbsSurface,
        inspect: &mut Inspect<'_>,
    ) -> Result<Option<(NurbsSurface, Vec<Foot>)>> {
        let knots = [folded.knots_u().clone(), folded.knots_v().clone()];
        let space = SplineSpace::new(knots, self.closed)?;
        let (energy, along_axes) = self.energy_along_axes(&space, lengths(folded));
        let mut flaws = inspect(folded, &self.uv, self.observer)?;
        let mut feet = self.correct(folded, STEPS);
        let mut drawn = vec![0.0_f64; space.unknowns()];
        for _ in 0..SOLUTIONS {
            for at in space.touched_by(&flaws) {
                drawn[at] = (STRONGER * drawn[at]).max(FIRST);
            }
            let mut equations = self.equations(&space, &feet)?;
            draw_between(&space, &drawn, &mut equations.matrix);
            let surface = self.solve_tangents(&space, equations, &energy, &along_axes)?;
            self.iterations += 1;
            feet = self.correct(&surface, STEPS);
            flaws = inspect(&surface, &self.uv, self.observer)?;
            if flaws.is_empty() {
                return Ok(Some((surface, feet)));
            }
        }
        Ok(None)
    }
}

/// Adds the squared distances of control points from where they would lie evenly between the one
/// before and the one after, along u and along v.
fn draw_between(space: &SplineSpace, drawn: &[f64], matrix: &mut Band) {
    let unit = matrix.trace() / (3 * space.unknowns()) as f64;
    for direction in 0..2 {
        let greville = space.knots[direction].greville();
        // In a closed direction the others are these again.
        let last = (space.shape()[direction] + 1).min(greville.len() - 1);
        for at in 1..last {
            let length = greville[at + 1] - greville[at - 1];
            let share = (greville[at] - greville[at - 1]) / length.max(f64::MIN_POSITIVE);
            let factors = [share - 1.0, 1.0, -share];
            for other in 0..space.shape()[1 - direction] {
                let places = [at - 1, at, at + 1].map(|at| match direction {
                    0 => space.place(at, other),
                    _ => space.place(other, at),
                });
                let weight = unit * drawn[places[1]];
                for (place, factor) in places.iter().zip(factors) {
                    let after = places.iter().zip(factors).filter(|(other, _)| *other <= place);
                    for (other, of_other) in after {
                        let value = weight * factor * of_other;
                        (0..3)
                            .for_each(|axis| matrix.add(3 * place + axis, 3 * other + axis, value));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::nurbs::Outside;
    use crate::progress::Silent;
    use glam::DVec2;

    /// Where normals point down.
    pub(in crate::fit) fn down(
        surface: &NurbsSurface,
        observer: &mut dyn Observer,
    ) -> Result<Vec<DVec2>> {
        let place = |i: u32| DVec2::new(f64::from(i % 25), f64::from(i / 25)) / 24.0;
        let uv: Vec<DVec2> = (0..625).map(place).collect();
        let mut normals = vec![DVec3::ZERO; uv.len()];
        surface.normals(&uv, &mut normals, Outside::Refuse, observer)?;
        Ok(uv.into_iter().zip(normals).filter(|(_, n)| n.z < 0.0).map(|(uv, _)| uv).collect())
    }

    /// A flat surface, one of whose control points lies beyond its neighbours, and points near it.
    pub(in crate::fit) fn folded() -> (NurbsSurface, Vec<DVec3>, Vec<DVec2>) {
        let control = |i: u32| {
            let place = DVec3::new(f64::from(i / 8), f64::from(i % 8), 0.0);
            if i == 27 { place + DVec3::X * 6.0 } else { place }
        };
        let surface = NurbsSurface::clamped((0..64).map(control).collect(), (8, 8), 3).unwrap();
        let place = |i: u32| DVec2::new(f64::from(i / 20), f64::from(i % 20)) / 19.0;
        let uv: Vec<DVec2> = (0..400).map(place).collect();
        (surface, uv.iter().map(|uv| 7.0 * uv.extend(0.0)).collect(), uv)
    }

    #[test]
    fn what_folds_is_unfolded() {
        let (surface, points, uv) = folded();
        assert!(!down(&surface, &mut Silent).unwrap().is_empty());
        let flat = Flat { surface: &surface, uv: &uv, fairness: 1e-3, closed: (false, false) };
        let mut inspect = |surface: &NurbsSurface, _: &[DVec2], observer: &mut dyn Observer| {
            down(surface, observer)
        };
        let found = unfolded(&points, None, &flat, &mut inspect, &mut Silent).unwrap().unwrap();
        assert!(down(&found.surface, &mut Silent).unwrap().is_empty());
    }

    #[test]
    fn what_stays_folded_is_no_answer() {
        let (surface, points, uv) = folded();
        let flat = Flat { surface: &surface, uv: &uv, fairness: 1e-3, closed: (false, false) };
        let mut inspect =
            |_: &NurbsSurface, _: &[DVec2], _: &mut dyn Observer| Ok(vec![DVec2::ZERO]);
        let found = unfolded(&points, None, &flat, &mut inspect, &mut Silent).unwrap();
        assert!(found.is_none());
    }
}
