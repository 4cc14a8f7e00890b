//! Projection of points onto a curve: the globally closest point.
//!
//! A piece lies within its sag of its chord, so a piece whose chord is farther from the point than
//! the best distance so far plus the sag is skipped. The other pieces are halved; the sag falls to a
//! quarter. On each piece Newton's method looks for a closer point (The NURBS Book, section 6.1).

use glam::DVec3;

use super::bezier_curve::BezierCurve;
use super::control_net::bounds;
use super::curve::NurbsCurve;
use super::work_blocks::map_in_blocks;
use crate::error::{Error, Result};
use crate::progress::Observer;

/// Halvings of a piece between knots at most. They end the search where all points of a piece are
/// equally near, as on a circle around the point.
const MAX_HALVINGS: u32 = 16;

/// A piece whose sag is below this fraction of the curve's size is searched by Newton's method
/// alone.
const MIN_SAG: f64 = 1e-8;

/// Newton steps at most.
const MAX_STEPS: usize = 30;

/// Newton's method has converged when a step is shorter than this share of a piece.
const STEP_TOLERANCE: f64 = 1e-14;

/// The projection of a point onto a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvePoint {
    /// The parameter of the projection.
    pub u: f64,
    /// The projection.
    pub point: DVec3,
    /// The distance from the point, in the points' unit.
    pub distance: f64,
}

/// A curve prepared for closest-point searches.
///
/// ```
/// use neurbs::{DVec3, nurbs::{CurveSearch, NurbsCurve}};
/// let line = NurbsCurve::line(DVec3::ZERO, 4.0 * DVec3::X)?;
/// let projection = CurveSearch::new(&line)?.closest_point(DVec3::new(1.0, 2.0, 0.0));
/// assert_eq!((projection.u, projection.distance), (0.25, 2.0));
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CurveSearch {
    pieces: Vec<(BezierCurve, Bounds)>,
    /// The sag below which pieces are not halved.
    min_sag: f64,
}

/// What is needed to skip a piece.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec3,
    high: DVec3,
    start: DVec3,
    chord: DVec3,
    /// The largest distance of a control point from the chord.
    sag: f64,
}

impl Bounds {
    fn of(piece: &BezierCurve) -> Self {
        let (low, high) = piece.net_box();
        let (start, chord) = (piece.start(), piece.end() - piece.start());
        let mut bounds = Self { low, high, start, chord, sag: 0.0 };
        bounds.sag =
            piece.control_points().map(|p| bounds.distance_to_chord(p)).fold(0.0, f64::max);
        bounds
    }

    /// The distance of a point from the chord.
    fn distance_to_chord(&self, point: DVec3) -> f64 {
        let square = self.chord.length_squared().max(f64::MIN_POSITIVE);
        let share = ((point - self.start).dot(self.chord) / square).clamp(0.0, 1.0);
        (point - self.start).distance(share * self.chord)
    }

    /// A lower bound of the distance of a point.
    fn distance(&self, point: DVec3) -> f64 {
        let from_box = (self.low - point).max(point - self.high).max(DVec3::ZERO).length();
        from_box.max(self.distance_to_chord(point) - self.sag)
    }
}

impl CurveSearch {
    /// Prepares a curve.
    ///
    /// # Errors
    ///
    /// [`Error::Net`] if weights differ so much that a piece has no finite control points.
    pub fn new(curve: &NurbsCurve) -> Result<Self> {
        let with_bounds = |piece: BezierCurve| (piece.clone(), Bounds::of(&piece));
        let pieces = BezierCurve::of(curve)?.into_iter().map(with_bounds).collect();
        let (low, high) = bounds(curve.control_points().iter().copied());
        Ok(Self { pieces, min_sag: MIN_SAG * low.distance(high) })
    }

    /// Returns the closest point of the curve; if several are equally close, any of them.
    ///
    /// For a point that is not finite the distance is NaN.
    #[must_use]
    pub fn closest_point(&self, point: DVec3) -> CurvePoint {
        let mut best = CurvePoint { distance: f64::INFINITY, ..CurvePoint::default() };
        for (piece, _) in &self.pieces {
            better(&mut best, piece.domain().0, piece.start(), point);
            better(&mut best, piece.domain().1, piece.end(), point);
        }
        let mut order: Vec<(f64, usize)> =
            self.pieces.iter().enumerate().map(|(k, (_, b))| (b.distance(point), k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bound, k) in order {
            if bound >= best.distance {
                break;
            }
            let (piece, bounds) = &self.pieces[k];
            search((piece, bounds), point, (self.min_sag, MAX_HALVINGS), &mut best);
        }
        if point.is_finite() { best } else { CurvePoint { distance: f64::NAN, ..best } }
    }
}

/// Searches a piece for a point closer than the best so far.
fn search(
    (piece, bounds): (&BezierCurve, &Bounds),
    point: DVec3,
    (min_sag, halvings): (f64, u32),
    best: &mut CurvePoint,
) {
    let share = newton(piece, point);
    better(best, piece.parameter(share), piece.derivatives(share)[0], point);
    if bounds.sag <= min_sag || halvings == 0 {
        return;
    }
    let mut halves = piece.halves().map(|half| {
        let bounds = Bounds::of(&half);
        (bounds.distance(point), half, bounds)
    });
    halves.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (bound, half, bounds) in &halves {
        if *bound < best.distance {
            search((half, bounds), point, (min_sag, halvings - 1), best);
        }
    }
}

/// The share of a piece where Newton's method, kept inside the piece, ends.
fn newton(piece: &BezierCurve, point: DVec3) -> f64 {
    let (start, chord) = (piece.start(), piece.end() - piece.start());
    let projected = (point - start).dot(chord) / chord.length_squared().max(f64::MIN_POSITIVE);
    let mut share = projected.clamp(0.0, 1.0);
    for _ in 0..MAX_STEPS {
        let [at, velocity, bend] = piece.derivatives(share);
        let away = at - point;
        let (slope, speed) = (away.dot(velocity), velocity.length_squared());
        // Far from the projection the second derivative may be negative: a step of Gauss and Newton.
        let second = speed + away.dot(bend);
        let step = slope / if second > 0.25 * speed { second } else { speed };
        let next = (share - step).clamp(0.0, 1.0);
        if !step.is_finite() || (next - share).abs() < STEP_TOLERANCE {
            break;
        }
        share = next;
    }
    share
}

/// Replaces the best point so far by a closer one.
fn better(best: &mut CurvePoint, u: f64, place: DVec3, point: DVec3) {
    let distance = place.distance(point);
    if distance < best.distance {
        *best = CurvePoint { u, point: place, distance };
    }
}

impl NurbsCurve {
    /// Finds the closest points of many points, in parallel, in the order of the points.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsCurve, progress::Silent};
    /// let circle = NurbsCurve::arc(DVec3::ZERO, DVec3::X, DVec3::Y, std::f64::consts::TAU)?;
    /// let found = circle.closest_points(&[3.0 * DVec3::Y], &mut Silent)?;
    /// assert!(found[0].point.distance(DVec3::Y) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`] if a point is not finite, [`Error::Interrupted`] if the observer stops
    /// it.
    pub fn closest_points(
        &self,
        points: &[DVec3],
        observer: &mut dyn Observer,
    ) -> Result<Vec<CurvePoint>> {
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::NotFinite { index, point: points[index] });
        }
        let search = CurveSearch::new(self)?;
        map_in_blocks(points, observer, |point| search.closest_point(*point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn random(k: u32) -> f64 {
        f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24)
    }

    #[test]
    fn no_sample_of_the_curve_is_closer() {
        let place = |k: u32| DVec3::new(random(3 * k), random(3 * k + 1), random(3 * k + 2));
        let curve = NurbsCurve::clamped((0..12).map(place).collect(), 3).unwrap();
        let points: Vec<DVec3> = (100..300).map(|k| 2.0 * place(k) - 0.5).collect();
        let found = curve.closest_points(&points, &mut Silent).unwrap();
        let samples: Vec<DVec3> = (0..=2000).map(|k| curve.point(f64::from(k) / 2000.0)).collect();
        for (point, found) in points.iter().zip(&found) {
            let nearest = samples.iter().map(|s| s.distance(*point)).fold(f64::INFINITY, f64::min);
            assert!(found.distance <= nearest + 1e-14 && nearest < found.distance + 1e-4);
            assert!(found.point.distance(curve.point(found.u)) < 1e-13);
        }
    }

    #[test]
    fn no_sample_of_wild_rational_curves_is_closer() {
        for seed in 0..60 {
            let number = |k: u32| random(1000 * seed + k);
            let place = |k: u32| DVec3::new(number(4 * k), number(4 * k + 1), number(4 * k + 2));
            let weights = (0..7).map(|k| 10.0_f64.powf(2.0 * number(4 * k + 3) - 1.0)).collect();
            let knots = crate::nurbs::KnotVector::clamped_uniform(4, 7).unwrap();
            let curve = NurbsCurve::new((0..7).map(place).collect(), Some(weights), knots).unwrap();
            let search = CurveSearch::new(&curve).unwrap();
            for k in 20..60 {
                let point = 1.5 * place(k) - 0.25;
                let samples = (0..=500).map(|k| curve.point(f64::from(k) / 500.0).distance(point));
                let nearest = samples.fold(f64::INFINITY, f64::min);
                assert!(search.closest_point(point).distance <= nearest + 1e-14, "{seed} {k}");
            }
        }
    }

    #[test]
    fn all_points_of_a_circle_are_equally_near_to_its_center() {
        let circle =
            NurbsCurve::arc(DVec3::ZERO, DVec3::X, DVec3::Y, std::f64::consts::TAU).unwrap();
        let found = CurveSearch::new(&circle).unwrap().closest_point(DVec3::Z);
        assert!((found.distance - 2.0_f64.sqrt()).abs() < 1e-14);
    }
}
