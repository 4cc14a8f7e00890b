//! The circle nearest to places in a plane.

use glam::{DMat3, DVec2, DVec3};

/// Its middle and radius, of least squares in the squared distance (I. Kåsa, *A circle fitting procedure and its error
/// analysis*, 1976). Of places in a line they need not be finite.
pub(super) fn nearest_circle(places: impl Iterator<Item = DVec2>) -> (DVec2, f64) {
    let (mut squares, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for place in places {
        let row = place.extend(1.0);
        squares += DMat3::from_cols(row.x * row, row.y * row, row.z * row);
        right += place.length_squared() * row;
    }
    let found = squares.inverse() * right;
    let middle = found.truncate() / 2.0;
    (middle, (found.z + middle.length_squared()).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_on_an_arc_tell_their_circle() {
        let at = |i: u32| DVec2::new(3.0, -2.0) + 0.5 * DVec2::from_angle(0.2 * f64::from(i));
        let (middle, radius) = nearest_circle((0..9).map(at));
        assert!(middle.distance(DVec2::new(3.0, -2.0)) < 1e-9 && (radius - 0.5).abs() < 1e-9);
    }
}
