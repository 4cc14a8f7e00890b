//! The four sides of a flat map of the points, where it has four.

use glam::{DVec2, DVec3};

use super::region::Region;
use super::strip::{self, Sides};
use crate::cloud::{area, hull};
use crate::fit::Quadrilateral;

/// Share of the convex hull that a quadrilateral of its corners must fill for the outline to count
/// as four-sided: a rectangle fills all of it, an ellipse's largest 0.64 of it.
const FOUR_SIDED: f64 = 0.9;

/// Share of its convex hull that a region with four sides fills at least. Its border lies outside of the
/// places, so that a square of some hundreds fills 1.05 to 1.1 of it.
const FILLED: f64 = 0.95;

/// Corners of the hull that are looked at, evenly along it.
const MOST_CORNERS: usize = 64;

/// Places of a flat map in the unit square.
pub(super) struct Squared {
    pub(super) uv: Vec<DVec2>,
    /// How many times longer the map is than wide.
    pub(super) aspect: f64,
    /// Where along u it bends sharply, as a strip does.
    pub(super) creases: Vec<f64>,
}

impl Squared {
    /// Stretched so that the places fill the unit square.
    pub(super) fn filled(uv: Vec<DVec2>, aspect: f64, creases: &[f64]) -> Self {
        let (low, high) = bounds(&uv);
        let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let uv = uv.into_iter().map(|uv| (uv - low) / size).collect();
        Self { uv, aspect, creases: creases.iter().map(|at| (at - low.x) / size.x).collect() }
    }
}

/// Places of a flat map of points in the unit square.
///
/// If the outline has four sides, its corners become those of the square, bilinearly. If it is that
/// of a bent strip, which only the points tell, or none with four sides, the region that the places
/// fill becomes the square; and the rectangle around it, whose sides lie along x and y, where they
/// fill none.
pub(super) fn unit_square(places: &[DVec2], points: Option<&[DVec3]>) -> Squared {
    let hull = hull(places);
    let (low, high) = bounds(places);
    let rectangle = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    let corners = largest(&hull);
    if let Some(region) = Region::of(places) {
        // What fills little of its hull is not four-sided just because the hull is.
        if (corners.is_none() || region.area() < FILLED * area(&hull))
            && let Some(strip) = points.and_then(|points| region.strip(places, points, Sides::Bent))
        {
            return strip::straightened(&strip, places);
        }
        if corners.is_none() {
            return region.rectified(places);
        }
    }
    let quad = Quadrilateral(corners.unwrap_or(rectangle)).lengthwise();
    let uv = places.iter().map(|&place| quad.inverse(place)).collect();
    Squared::filled(uv, quad.aspect(), &[])
}

pub(super) fn bounds(places: &[DVec2]) -> (DVec2, DVec2) {
    let empty = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    places.iter().fold(empty, |(low, high), &place| (low.min(place), high.max(place)))
}

/// The corners of the largest quadrilateral in a convex polygon, if it fills most of it: for each
/// diagonal the corners farthest on either side.
fn largest(hull: &[DVec2]) -> Option<[DVec2; 4]> {
    let step = hull.len().div_ceil(MOST_CORNERS).max(1);
    let corners: Vec<DVec2> = hull.iter().copied().step_by(step).collect();
    let count = corners.len();
    let height =
        |a: usize, b: usize, c: usize| (corners[b] - corners[a]).perp_dot(corners[c] - corners[a]);
    let mut best = (0.0, [DVec2::ZERO; 4]);
    for a in 0..count {
        for c in a + 2..count {
            let farthest = |side: &mut dyn Iterator<Item = usize>| {
                let heights = side.map(|at| (height(a, c, at).abs(), at));
                heights.max_by(|x, y| x.0.total_cmp(&y.0).then(y.1.cmp(&x.1)))
            };
            let right = farthest(&mut (a + 1..c));
            let left = farthest(&mut (c + 1..count).chain(0..a));
            if let (Some(right), Some(left)) = (right, left)
                && right.0 + left.0 > best.0
            {
                let found = [a, right.1, c, left.1].map(|at| corners[at]);
                best = (right.0 + left.0, found);
            }
        }
    }
    (best.0 >= FOUR_SIDED * 2.0 * area(hull)).then_some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(corners: [DVec2; 4]) -> Vec<DVec2> {
        let [a, b, c, d] = corners;
        let share = |k: i32| f64::from(k) / 20.0;
        let place = |(u, v): (f64, f64)| a.lerp(b, u).lerp(d.lerp(c, u), v);
        (0..441).map(|k| place((share(k / 21), share(k % 21)))).collect()
    }

    /// Points in a plane.
    fn flat(places: &[DVec2]) -> Vec<DVec3> {
        places.iter().map(|place| place.extend(0.0)).collect()
    }

    #[test]
    fn what_fills_little_of_a_four_sided_hull_is_a_strip() {
        // The hull of a U is a rectangle.
        let spread = |i: usize| {
            let at = |share: f64| 3.0 * (0.5 + share * i as f64).fract();
            DVec2::new(at(0.754_877_666_246_693), at(0.569_840_290_998_053))
        };
        let is_inside = |place: &DVec2| (place.x - 1.5).abs() > 0.5 || place.y < 1.0;
        let places: Vec<DVec2> = (0..1200).map(spread).filter(is_inside).collect();
        let found = unit_square(&places, Some(&flat(&places)));
        assert_eq!(found.creases.len(), 2);
        assert!((4.0..9.0).contains(&found.aspect), "{}", found.aspect);
        let whole: Vec<DVec2> = (0..1200).map(spread).collect();
        assert!(unit_square(&whole, Some(&flat(&whole))).creases.is_empty());
    }

    #[test]
    fn a_kite_becomes_the_square() {
        let corners = [(0.0, 0.0), (4.0, -1.0), (5.0, 3.0), (-0.5, 2.0)];
        let corners = corners.map(|(x, y)| DVec2::new(x, y));
        let places = lattice(corners);
        let Squared { uv, aspect, .. } = unit_square(&places, Some(&flat(&places)));
        assert!((1.4..1.8).contains(&aspect), "{aspect}");
        let expected = lattice([DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]);
        // Up to a half turn: any of the four corners may come first.
        let turned = uv[0].distance(expected[0]) > 0.5;
        for (uv, expected) in uv.iter().zip(&expected) {
            let uv = if turned { DVec2::ONE - *uv } else { *uv };
            assert!(uv.distance(*expected) < 1e-9, "{uv} {expected}");
        }
    }

    #[test]
    fn a_disc_has_no_sides() {
        let disc: Vec<DVec2> = (0..200)
            .map(|k| f64::from(k / 20 + 1) / 10.0 * DVec2::from_angle(f64::from(k) * 0.3146))
            .collect();
        let Squared { uv, aspect, .. } = unit_square(&disc, Some(&flat(&disc)));
        assert!((aspect - 1.0).abs() < 0.05, "{aspect}");
        let middle = uv.iter().sum::<DVec2>() / 200.0;
        assert!(middle.distance(DVec2::splat(0.5)) < 0.05);
    }
}
