//! Base of a height field: the plane across the heights, and the rectangle that the surface covers.

use glam::{DVec2, DVec3};

use super::settings::HeightSettings;
use crate::error::{Error, Result};

const SETTINGS: HeightSettings = HeightSettings::STANDARD;

/// The plane across the heights.
#[derive(Clone, Debug)]
pub(crate) struct BasePlane {
    /// Unit vectors of the plane's axes.
    pub(crate) axes: [DVec3; 2],
    /// Unit vector of the heights.
    pub(crate) up: DVec3,
}

impl BasePlane {
    /// The plane across `up`, with the axes of [`height_axes`].
    pub(crate) fn over(points: &[DVec3], up: DVec3) -> Self {
        Self { axes: height_axes(points, up), up }
    }
}

/// The plane's axes for a direction of heights: x and y for z, otherwise the principal axes of the
/// points' places in the plane, the one of largest variance first.
#[must_use]
pub fn height_axes(points: &[DVec3], up: DVec3) -> [DVec3; 2] {
    if up == DVec3::Z {
        return [DVec3::X, DVec3::Y];
    }
    let (first, second) = up.any_orthonormal_pair();
    let count = points.len().max(1) as f64;
    let place = |p: &DVec3| DVec2::new(first.dot(*p), second.dot(*p));
    let center = points.iter().map(place).sum::<DVec2>() / count;
    let moments = points
        .iter()
        .map(|p| place(p) - center)
        .fold(DVec3::ZERO, |sum, p| sum + DVec3::new(p.x * p.x, p.x * p.y, p.y * p.y));
    let along = DVec2::from_angle(0.5 * (2.0 * moments.y).atan2(moments.x - moments.z));
    let u = along.x * first + along.y * second;
    [u, up.cross(u)]
}

/// A rectangle in the base plane, along its axes.
#[derive(Clone, Debug)]
pub(super) struct BaseDomain {
    low: DVec2,
    size: DVec2,
}

impl BaseDomain {
    /// The rectangle around the first two coordinates of points. At sides where the used points are
    /// scattered, it extends to where they most likely end.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if it has no area.
    pub(super) fn around(points: &[DVec3], is_used: impl Fn(usize) -> bool) -> Result<Self> {
        let places = || points.iter().map(|point| point.truncate());
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = high - low;
        if !(size.x > 0.0 && size.y > 0.0) {
            let got = format!("{} × {}", size.x, size.y);
            return Err(Error::parameter(
                "points",
                "extended across the direction of heights",
                got,
            ));
        }
        let (mut on_low, mut on_high, mut used) = ([0; 2], [0; 2], 0.0);
        for (_, place) in places().enumerate().filter(|(i, _)| is_used(*i)) {
            used += 1.0;
            for axis in 0..2 {
                on_low[axis] +=
                    usize::from(place[axis] - low[axis] <= SETTINGS.side_tolerance * size[axis]);
                on_high[axis] +=
                    usize::from(high[axis] - place[axis] <= SETTINGS.side_tolerance * size[axis]);
            }
        }
        // The outermost of n points lies on average 1 / n of a side from its end, exponentially
        // distributed. Six of seven gaps are shorter than twice that. Rows of a grid end on the
        // side.
        let extension = (2.0 / f64::max(used, 1.0)).min(SETTINGS.max_extension);
        let beyond =
            |on: [usize; 2]| DVec2::from(on.map(|on| if on <= 2 { extension } else { 0.0 })) * size;
        let (low, high) = (low - beyond(on_low), high + beyond(on_high));
        Ok(Self { low, size: high - low })
    }

    /// The parameters of a place, in the unit square.
    pub(super) fn parameters(&self, place: DVec2) -> DVec2 {
        ((place - self.low) / self.size).clamp(DVec2::ZERO, DVec2::ONE)
    }

    /// The lengths of the sides.
    pub(super) fn size(&self) -> DVec2 {
        self.size
    }

    /// The place at these parameters.
    pub(super) fn place(&self, uv: DVec2) -> DVec2 {
        self.low + uv * self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points scattered over a rectangle of 3 × 2.
    fn scattered(count: u32) -> Vec<DVec3> {
        let place = |i: u32| {
            let at = f64::from(i) + 0.5;
            let x = (at * 0.754_877_666_246_692_7).fract();
            DVec3::new(3.0 * x, 2.0 * (at * 0.569_840_290_998_053_2).fract(), x)
        };
        (0..count).map(place).collect()
    }

    fn ends(points: &[DVec3]) -> (DVec2, DVec2) {
        let ground = BaseDomain::around(points, |_| true).unwrap();
        (ground.place(DVec2::ZERO), ground.place(DVec2::ONE))
    }

    #[test]
    fn the_base_extends_two_gaps_beyond_scattered_points() {
        let points = scattered(400);
        let box_low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p)).truncate();
        let box_high = points.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p)).truncate();
        let extension = 2.0 / 400.0 * (box_high - box_low);
        let (low, high) = ends(&points);
        assert!(low.distance(box_low - extension) < 1e-14);
        assert!(high.distance(box_high + extension) < 1e-14);
        // Unused points do not increase the density.
        let ground = BaseDomain::around(&points, |i| i < 200).unwrap();
        assert!(ground.place(DVec2::ONE).distance(box_high + 2.0 * extension) < 1e-14);
    }

    #[test]
    fn sides_with_rows_of_points_stay_where_they_are() {
        let mut points = scattered(400);
        points.extend([0.1, 0.5, 0.7].map(|t| DVec3::new(3.0 * t, -1.0, 0.0)));
        let (low, high) = ends(&points);
        assert!(low.y == -1.0 && low.x < 0.0 && high.y > 2.0, "{low} {high}");
    }

    #[test]
    fn the_base_extends_little_beyond_few_points() {
        for count in [4, 6, 20, 100] {
            let points = scattered(count);
            let (low, high) = ends(&points);
            let (first, last) = (points[0].truncate(), points[1].truncate());
            assert!(low.cmplt(first.min(last)).all() && high.cmpgt(first.max(last)).all());
            assert!(
                (high - low)
                    .cmple((1.0 + 2.0 * SETTINGS.max_extension) * DVec2::new(3.0, 2.0))
                    .all()
            );
        }
    }

    #[test]
    fn parameters_and_places_are_inverse() {
        let points = scattered(50);
        let ground = BaseDomain::around(&points, |_| true).unwrap();
        for place in points.iter().map(|point| point.truncate()) {
            assert!(ground.place(ground.parameters(place)).distance(place) < 1e-14);
        }
    }
}
