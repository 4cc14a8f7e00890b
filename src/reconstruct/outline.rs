//! The four sides of a flat map of the points, where it has four.

use glam::DVec2;

use super::region::Region;
use crate::som;

/// Share of the convex hull that a quadrilateral of its corners must fill for the outline to count
/// as four-sided: a rectangle fills all of it, an ellipse's largest 0.64 of it.
const FOUR_SIDED: f64 = 0.9;

/// Corners of the hull that are looked at, evenly along it.
const MOST_CORNERS: usize = 64;

/// Steps of Newton's method for a place in a quadrilateral; it is nearly a parallelogram.
const STEPS: usize = 8;

/// Places in the unit square, and how many times longer the outline is than wide.
///
/// If the outline has four sides, its corners become those of the square, bilinearly; else the
/// rectangle around it, whose sides lie along x and y, does.
pub(super) fn unit_square(places: &[DVec2]) -> (Vec<DVec2>, f64) {
    let hull = som::hull(places);
    let (low, high) = bounds(places);
    let rectangle = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    let corners = largest(&hull);
    if corners.is_none()
        && let Some(region) = Region::of(places)
    {
        let (uv, aspect) = region.rectified(places);
        return (filled(uv), aspect);
    }
    let quad = Quadrilateral(corners.unwrap_or(rectangle)).lengthwise();
    (filled(places.iter().map(|&place| quad.inverse(place)).collect()), quad.aspect())
}

/// The places stretched so that they fill the unit square.
fn filled(uv: Vec<DVec2>) -> Vec<DVec2> {
    let (low, high) = bounds(&uv);
    let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
    uv.into_iter().map(|uv| (uv - low) / size).collect()
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

pub(super) fn area(polygon: &[DVec2]) -> f64 {
    let count = polygon.len();
    0.5 * (0..count).map(|i| polygon[i].perp_dot(polygon[(i + 1) % count])).sum::<f64>()
}

/// Four corners, counter-clockwise; the first becomes the origin, the second (1, 0).
struct Quadrilateral([DVec2; 4]);

impl Quadrilateral {
    /// Mean lengths of the sides along x and along y.
    fn lengths(&self) -> (f64, f64) {
        let [a, b, c, d] = self.0;
        (0.5 * (a.distance(b) + d.distance(c)), 0.5 * (a.distance(d) + b.distance(c)))
    }

    fn aspect(&self) -> f64 {
        let (along, across) = self.lengths();
        along / across
    }

    /// The same with its long sides along x.
    fn lengthwise(self) -> Self {
        let [a, b, c, d] = self.0;
        if self.aspect() < 1.0 { Self([b, c, d, a]) } else { self }
    }

    /// The place in the unit square that the bilinear map brings here.
    fn inverse(&self, place: DVec2) -> DVec2 {
        let [a, b, c, d] = self.0;
        let (along, across, twist) = (b - a, d - a, a - b + c - d);
        let mut uv = DVec2::splat(0.5);
        for _ in 0..STEPS {
            let rest = place - (a + uv.x * along + uv.y * across + uv.x * uv.y * twist);
            let (du, dv) = (along + uv.y * twist, across + uv.x * twist);
            let det = du.perp_dot(dv);
            if det == 0.0 {
                break;
            }
            uv += DVec2::new(rest.perp_dot(dv), du.perp_dot(rest)) / det;
        }
        uv
    }
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

    #[test]
    fn a_kite_becomes_the_square() {
        let corners = [(0.0, 0.0), (4.0, -1.0), (5.0, 3.0), (-0.5, 2.0)];
        let corners = corners.map(|(x, y)| DVec2::new(x, y));
        let (uv, aspect) = unit_square(&lattice(corners));
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
        let (uv, aspect) = unit_square(&disc);
        assert!((aspect - 1.0).abs() < 0.05, "{aspect}");
        let middle = uv.iter().sum::<DVec2>() / 200.0;
        assert!(middle.distance(DVec2::splat(0.5)) < 0.05);
    }
}
