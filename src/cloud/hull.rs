//! The convex hull of places in the plane, and the rectangle of least area around them.

use glam::DVec2;

/// A place by the axes of which the first has this direction.
pub(crate) fn turned(place: DVec2, along: DVec2) -> DVec2 {
    DVec2::new(along.dot(place), along.perp_dot(place))
}

/// The direction of the long side of the rectangle of least area around places, and its sides.
pub(crate) fn least_rectangle(places: &[DVec2]) -> (DVec2, DVec2) {
    let hull = hull(places);
    let size = |edge: DVec2| {
        let turned = hull.iter().map(|&place| turned(place, edge));
        let empty = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = turned.fold(empty, |(low, high), p| (low.min(p), high.max(p)));
        high - low
    };
    let edges = (0..hull.len()).map(|i| (hull[(i + 1) % hull.len()] - hull[i]).normalize_or_zero());
    let area = |edge: &DVec2| size(*edge).element_product();
    let best = edges.filter(|edge| *edge != DVec2::ZERO).min_by(|a, b| area(a).total_cmp(&area(b)));
    let edge = best.unwrap_or(DVec2::X);
    let extent = size(edge);
    if extent.x < extent.y { (edge.perp(), DVec2::new(extent.y, extent.x)) } else { (edge, extent) }
}

/// The area of a polygon, counter-clockwise.
pub(crate) fn area(polygon: &[DVec2]) -> f64 {
    let count = polygon.len();
    0.5 * (0..count).map(|i| polygon[i].perp_dot(polygon[(i + 1) % count])).sum::<f64>()
}

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain, of what lies outside of the eight
/// outermost places: S. G. Akl, G. T. Toussaint, *A fast convex hull algorithm*, 1978).
pub(crate) fn hull(places: &[DVec2]) -> Vec<DVec2> {
    let outermost = outermost(places);
    // Most places lie in a circle inside of these, which is a single comparison.
    let (centre, radius) = inscribed(&outermost);
    let sides = sides(&outermost);
    let is_inside = |place: &DVec2| {
        place.distance_squared(centre) < radius * radius || is_inside(&sides, *place)
    };
    let mut sorted: Vec<DVec2> = places.iter().filter(|place| !is_inside(place)).copied().collect();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |places: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for place in places {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(place - b) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(place);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut sorted.iter().copied());
    corners.extend(half(&mut sorted.iter().rev().copied()));
    corners
}

/// The outermost places in eight directions, counter-clockwise.
fn outermost(places: &[DVec2]) -> Vec<DVec2> {
    let reaches = |DVec2 { x, y }: DVec2| [x, x + y, y, y - x, -x, -x - y, -y, x - y];
    // First how far they reach, then which do: to keep both at once takes a quarter longer in all.
    let mut farthest = [f64::NEG_INFINITY; 8];
    for &place in places {
        let reaches = reaches(place);
        farthest.iter_mut().zip(reaches).for_each(|(far, reach)| *far = far.max(reach));
    }
    let mut found = [None; 8];
    for &place in places {
        let reached: [bool; 8] = std::array::from_fn(|k| reaches(place)[k] == farthest[k]);
        if reached.iter().fold(false, |any, reached| any | reached) {
            let first = found.iter_mut().zip(reached).filter(|(found, is)| *is && found.is_none());
            first.for_each(|(found, _)| *found = Some(place));
        }
    }
    let mut corners: Vec<DVec2> = found.into_iter().flatten().collect();
    corners.dedup();
    corners
}

/// A circle inside a convex polygon: about the mean of its corners, as far as its sides are.
fn inscribed(polygon: &[DVec2]) -> (DVec2, f64) {
    let centre = polygon.iter().sum::<DVec2>() / polygon.len().max(1) as f64;
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let distance = |(a, b): (&DVec2, &DVec2)| (b - a).normalize_or_zero().perp_dot(centre - a);
    (centre, sides.map(distance).fold(f64::INFINITY, f64::min).max(0.0))
}

/// Where each side of a polygon ends, and the way along it; none if it is no polygon.
fn sides(polygon: &[DVec2]) -> Vec<(DVec2, DVec2)> {
    if polygon.len() < 3 {
        return Vec::new();
    }
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    sides.filter(|(a, b)| a != b).map(|(&a, &b)| (b, b - a)).collect()
}

/// Whether a place lies inside a polygon with these sides, and not on them.
fn is_inside(sides: &[(DVec2, DVec2)], place: DVec2) -> bool {
    // All of them without a branch, which would be as often wrong as right.
    let outside = sides.iter().map(|&(end, way)| way.perp_dot(place - end) <= 0.0);
    !sides.is_empty() && !outside.fold(false, std::ops::BitOr::bitor)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn all_places_are_inside_the_hull_and_its_corners_are_some_of_them() {
        let place = |i: u32| {
            let i = f64::from(i);
            DVec2::new((i * 0.754_877_666).fract(), (i * i * 0.569_840_291).fract())
        };
        let square: Vec<DVec2> = (0..500).map(place).collect();
        let centre = DVec2::splat(0.5);
        let disc = square.iter().copied().filter(|place| place.distance(centre) < 0.5).collect();
        let line = square.iter().map(|place| DVec2::splat(place.x)).collect();
        for (places, area_of_it) in [(square.clone(), 1.0), (disc, 0.25 * PI), (line, 0.0)] {
            let corners = hull(&places);
            assert!(corners.iter().all(|corner| places.contains(corner)));
            let outside = |place: &DVec2| {
                let after = |i: usize| corners[(i + 1) % corners.len()];
                let beside = |i| (after(i) - corners[i]).perp_dot(*place - corners[i]);
                (0..corners.len()).any(|i| beside(i) < -1e-15)
            };
            assert!(!places.iter().any(outside));
            let area = area(&corners);
            assert!(area <= area_of_it && area >= 0.93 * area_of_it, "{area}");
        }
    }

    #[test]
    fn the_least_rectangle_is_the_one_that_places_fill() {
        let along = DVec2::from_angle(0.7);
        let place = |i: u32| (f64::from(i % 7), f64::from(i / 7));
        let grid: Vec<DVec2> = (0..28)
            .map(place)
            .map(|(x, y)| x * along.perp() + y * along + DVec2::new(20.0, -3.0))
            .collect();
        let (side, size) = least_rectangle(&grid);
        assert!(side.perp_dot(along.perp()).abs() < 1e-14);
        assert!(size.distance(DVec2::new(6.0, 3.0)) < 1e-13, "{size}");
    }
}
