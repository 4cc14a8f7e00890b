//! Where the straight sides of a strip lie most likely, given places scattered over it.

use glam::DVec2;

use super::arms::Arms;
use super::likelihood::{DEGREE, Likelihood, height};
use super::line::Line;
use crate::nurbs::{Basis, KnotVector};

/// How deep the ground behind a side is looked at, in spacings of the places, but no deeper than this
/// share of the side's length; and how far beyond it places may lie.
const DEPTH: f64 = 8.0;
const DEEPEST: f64 = 0.7;
const BEYOND: f64 = 2.0;

/// How much of a side is left out at either end, in spacings: near a corner places may belong to
/// another side.
const ENDS: f64 = 2.0;

/// Places that tell where a side is, at least.
const LEAST: usize = 16;

/// Stiffness of a straight line, and of curves that it must not be less likely than by this factor's
/// logarithm.
const STRAIGHT: f64 = 1e6;
const BENT: [f64; 3] = [100.0, 10.0, 1.0];
const CLEARLY: f64 = 3.0;

/// Scale of the blur that the search begins with, as a share of the depth.
const FIRST_SCALE: f64 = 0.1;

/// How many standard deviations beyond the likeliest line a side is put.
const MARGIN: f64 = 1.2;

/// How many times the noise places may lie beyond a side, but for so many spacings at either end.
const NOISE: f64 = 3.0;
const LAST: f64 = 0.3;

/// The sine of the angle between two sides from which on they meet at a corner.
const SLANTED: f64 = 0.3;

/// A straight line through two places.
#[derive(Clone, Copy)]
struct Side(DVec2, DVec2);

impl Side {
    fn line(self) -> Line {
        Line { at: self.0, along: self.1 - self.0 }
    }

    /// Moved out until no place between its corners lies beyond, but for noise of this size.
    fn enclosing(
        self,
        places: &[DVec2],
        (from, to): (DVec2, DVec2),
        spacing: f64,
        noise: f64,
    ) -> Self {
        let along = (to - from).normalize();
        let between = LAST * spacing..=from.distance(to) - LAST * spacing;
        let near = |away: &DVec2| between.contains(&away.dot(along));
        let beyond = |away: DVec2| -along.perp_dot(away);
        let outside = places.iter().map(|place| *place - from).filter(near).map(beyond);
        let farthest = outside.filter(|far| *far < BEYOND * spacing).fold(0.0, f64::max);
        let out = (farthest - NOISE * noise).max(0.0) * -along.perp();
        Self(self.0 + out, self.1 + out)
    }

    /// The side near a line from corner to corner at which places end most likely, if they are blurred
    /// by noise of this size; `None` if they end at a curve, which is more likely by a factor with this
    /// logarithm.
    fn of(
        places: &[DVec2],
        (from, to): (DVec2, DVec2),
        spacing: f64,
        noise: f64,
        clearly: f64,
    ) -> Option<Self> {
        let length = from.distance(to);
        let depth = (DEPTH * spacing).min(DEEPEST * length);
        let along = (to - from) / length;
        let left_out = ENDS * spacing;
        let looked_at = length - 2.0 * left_out;
        let inside = |place: &DVec2| {
            let away = *place - from;
            ((away.dot(along) - left_out) / looked_at, along.perp_dot(away) / depth)
        };
        let near = places.iter().map(inside);
        let beyond = -BEYOND * spacing / depth;
        let near: Vec<(f64, f64)> =
            near.filter(|(x, y)| (0.0..=1.0).contains(x) && (beyond..=1.0).contains(y)).collect();
        if looked_at <= 0.0 || near.len() < LEAST {
            return None;
        }
        let knots = KnotVector::clamped_uniform(DEGREE, DEGREE + 1).ok()?;
        let ends = [0.0, 1.0].map(|x| Basis::at(&knots, x));
        let count = near.len();
        let bounds = (beyond, 0.5);
        let mut likelihood = Likelihood::new(near.iter().copied(), count, knots, STRAIGHT, bounds);
        let lowest = near.iter().map(|place| place.1).fold(f64::INFINITY, f64::min);
        let mut line = vec![lowest; DEGREE + 1];
        let scale = likelihood.find(&mut line, FIRST_SCALE, noise / depth, |_, _| {});
        let here = likelihood.local(&line, scale);
        let (evidence, deviations) = (likelihood.evidence(&here), likelihood.deviations(&here));
        for stiffness in BENT {
            let mut curve = line.clone();
            likelihood.stiffness = stiffness;
            let here = likelihood.climb(&mut curve, scale);
            if likelihood.evidence(&here) > evidence + clearly {
                return None;
            }
        }
        let [start, end] = ends.map(|basis| height(&line, &basis));
        let (start, end) = (start - MARGIN * deviations[0], end - MARGIN * deviations[DEGREE]);
        let place = |x: f64, y: f64| from + along.rotate(DVec2::new(x, depth * y));
        Some(Self(place(left_out, start), place(length - left_out, end)))
    }
}

impl Arms {
    /// The strip like this one whose straight sides places end at most likely, and a little beyond, if
    /// they are blurred by noise of this size. `None` if they rather end at curves.
    pub(crate) fn around(&self, places: &[DVec2], noise: f64) -> Option<Self> {
        // Whether sides are straight is seen once it is known where they end.
        self.drawn(places, noise, f64::INFINITY)?.drawn(places, noise, CLEARLY)
    }

    fn drawn(&self, places: &[DVec2], noise: f64, clearly: f64) -> Option<Self> {
        let outline = self.outline();
        let count = outline.len();
        let spacing = (self.area() / places.len() as f64).sqrt();
        let side = |k: usize| {
            let ends = (outline[k], outline[(k + 1) % count]);
            Side::of(places, ends, spacing, noise, clearly)
        };
        let sides: Vec<Side> = (0..count).map(side).collect::<Option<_>>()?;
        let corners = self::corners(&sides)?;
        let enclosing = |(k, side): (usize, Side)| {
            side.enclosing(places, (corners[k], corners[(k + 1) % count]), spacing, noise)
        };
        let sides: Vec<Side> = sides.into_iter().enumerate().map(enclosing).collect();
        let found = Self::within(&self::corners(&sides)?);
        found.arms().iter().all(|arm| arm.area() > 0.0).then_some(found)
    }
}

/// Where each of the sides around a strip meets the one before.
fn corners(sides: &[Side]) -> Option<Vec<DVec2>> {
    let before = |k: usize| sides[(k + sides.len() - 1) % sides.len()];
    (0..sides.len()).map(|k| before(k).line().meeting(sides[k].line(), SLANTED)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::likelihood::tests::even;
    use super::*;

    /// The corners of an L in the unit square, counter-clockwise from one on its right side.
    const L: [(f64, f64); 6] =
        [(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5), (0.5, 1.0)];

    fn corners() -> impl Iterator<Item = DVec2> {
        L.into_iter().map(DVec2::from)
    }

    /// Like the L, but found only roughly.
    fn rough() -> Arms {
        let off = |(i, at): (usize, DVec2)| at + 0.02 * DVec2::from_angle(2.0 * i as f64);
        Arms::within(&corners().enumerate().map(off).collect::<Vec<_>>())
    }

    fn farthest(found: &Arms) -> f64 {
        found.outline().into_iter().zip(corners()).map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
    }

    #[test]
    fn straight_sides_are_found_with_their_corners() {
        let in_l = |place: &DVec2| place.min_element() < 0.5;
        let places: Vec<DVec2> = even().map(DVec2::from).filter(in_l).collect();
        let found = rough().around(&places, 0.0).unwrap();
        assert!(farthest(&rough()) > 0.015 && farthest(&found) < 0.006, "{}", farthest(&found));
        // No place is left out.
        let parameters = places.iter().map(|&place| found.parameters(place));
        let beyond = parameters.map(|uv| (uv - 0.5).abs().max_element() - 0.5);
        assert!(beyond.fold(f64::NEG_INFINITY, f64::max) < 1e-3);
    }

    #[test]
    fn noise_does_not_push_sides_out() {
        let in_l = |place: &DVec2| place.min_element() < 0.5;
        let noise = |i: usize| {
            let wave = |k: usize| (1.7 * (i * i * k % 9973) as f64).sin();
            0.02 * 2.0_f64.sqrt() * DVec2::new(wave(1), wave(3))
        };
        let places = even().map(DVec2::from).filter(in_l).enumerate();
        let places: Vec<DVec2> = places.map(|(i, place)| place + noise(i)).collect();
        let around = |noise| rough().around(&places, noise).unwrap();
        let (told, untold) = (around(0.02), around(0.0));
        assert!(told.area() < 0.5 * (0.75 + untold.area()), "{} {}", told.area(), untold.area());
        assert!(farthest(&told) < 0.03, "{}", farthest(&told));
    }

    #[test]
    fn sides_that_bend_are_not_straight() {
        // One side is drawn in by a spacing or two in the middle.
        let hollow = |x: f64| 0.05 * (std::f64::consts::PI * x).sin();
        let in_it = |at: &DVec2| at.min_element() < 0.5 && at.y > hollow(at.x);
        let places: Vec<DVec2> = even().map(DVec2::from).filter(in_it).collect();
        assert!(rough().around(&places, 0.0).is_none());
    }
}
