//! The convex hull of points in the plane, and their bounding rectangle of least area.

use glam::DVec2;

/// The coordinates of a place in perpendicular axes, of which the first has the unit direction
/// `along`.
pub(crate) fn in_axes(place: DVec2, along: DVec2) -> DVec2 {
    DVec2::new(along.dot(place), along.perp_dot(place))
}

/// The bounding rectangle of least area: the direction of its long side, and both lengths.
pub(crate) fn min_area_rectangle(places: &[DVec2]) -> (DVec2, DVec2) {
    let hull = convex_hull(places);
    let size = |edge: DVec2| {
        let turned = hull.iter().map(|&place| in_axes(place, edge));
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

/// The area of a polygon with counterclockwise corners.
pub(crate) fn polygon_area(polygon: &[DVec2]) -> f64 {
    let count = polygon.len();
    0.5 * (0..count).map(|i| polygon[i].perp_dot(polygon[(i + 1) % count])).sum::<f64>()
}

/// The corners of the convex hull, counterclockwise (A. Andrew's monotone chain, 1979).
pub(crate) fn convex_hull(places: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = places.to_vec();
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

/// Whether a convex polygon with counterclockwise corners contains a place.
pub(crate) fn is_in_hull(hull: &[DVec2], place: DVec2) -> bool {
    let after = |i: usize| hull[(i + 1) % hull.len()];
    (0..hull.len()).all(|i| (after(i) - hull[i]).perp_dot(place - hull[i]) >= 0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn the_hull_contains_all_places_and_has_some_as_corners() {
        let place = |i: u32| {
            let i = f64::from(i);
            DVec2::new((i * 0.754_877_666).fract(), (i * i * 0.569_840_291).fract())
        };
        let square: Vec<DVec2> = (0..500).map(place).collect();
        let center = DVec2::splat(0.5);
        let disc = square.iter().copied().filter(|place| place.distance(center) < 0.5).collect();
        let line = square.iter().map(|place| DVec2::splat(place.x)).collect();
        for (places, area_of_it) in [(square.clone(), 1.0), (disc, 0.25 * PI), (line, 0.0)] {
            let corners = convex_hull(&places);
            assert!(corners.iter().all(|corner| places.contains(corner)));
            let outside = |place: &DVec2| {
                let after = |i: usize| corners[(i + 1) % corners.len()];
                let beside = |i| (after(i) - corners[i]).perp_dot(*place - corners[i]);
                (0..corners.len()).any(|i| beside(i) < -1e-15)
            };
            assert!(!places.iter().any(outside));
            let area = polygon_area(&corners);
            assert!(area <= area_of_it && area >= 0.93 * area_of_it, "{area}");
        }
    }

    #[test]
    fn the_min_area_rectangle_of_a_rotated_grid_is_the_grid() {
        let along = DVec2::from_angle(0.7);
        let place = |i: u32| (f64::from(i % 7), f64::from(i / 7));
        let grid: Vec<DVec2> = (0..28)
            .map(place)
            .map(|(x, y)| x * along.perp() + y * along + DVec2::new(20.0, -3.0))
            .collect();
        let (side, size) = min_area_rectangle(&grid);
        assert!(side.perp_dot(along.perp()).abs() < 1e-14);
        assert!(size.distance(DVec2::new(6.0, 3.0)) < 1e-13, "{size}");
    }
}
