//! No-data values: coordinates that stand for a missing measurement.

use glam::DVec3;

use super::settings::NoDataSettings;

const SETTINGS: NoDataSettings = NoDataSettings::STANDARD;

/// A value of one coordinate that stands for a missing measurement, such as -9999 among heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoData {
    /// The coordinate: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Its value.
    pub value: f64,
    /// The number of points that have it, at least two.
    pub count: usize,
}

impl NoData {
    /// Whether a point has the value.
    #[must_use]
    pub fn has(&self, point: DVec3) -> bool {
        point[self.axis] == self.value
    }
}

/// Finds a no-data value.
///
/// It is exactly the same coordinate of at least two points, but of less than half of them. It is
/// the smallest or largest value of that coordinate, and far outside the range of all others.
///
/// ```
/// use neurbs::{DVec3, cloud::no_data};
/// let height = |i: u32| if i % 9 == 4 { -9999.0 } else { f64::from(i % 7) };
/// let points: Vec<DVec3> =
///     (0..100).map(|i| DVec3::new(f64::from(i % 10), f64::from(i / 10), height(i))).collect();
/// let found = no_data(&points).unwrap();
/// assert_eq!((found.axis, found.value, found.count), (2, -9999.0, 11));
/// ```
#[must_use]
pub fn no_data(points: &[DVec3]) -> Option<NoData> {
    let along = |axis: usize| {
        let values = || points.iter().map(move |point| point[axis]);
        let (low, high) = extremes(values());
        [low, high].into_iter().find_map(|value| {
            let (start, end) = extremes(values().filter(|other| *other != value));
            let apart = (start - value).abs().min((end - value).abs());
            if !(end > start && apart > SETTINGS.min_distance_ratio * (end - start)) {
                return None;
            }
            let count = values().filter(|other| *other == value).count();
            let several = count > 1 && (count as f64) < SETTINGS.max_share * points.len() as f64;
            several.then_some(NoData { axis, value, count })
        })
    };
    (0..3).find_map(along)
}

/// The smallest and the largest value.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roof_above_the_ground_is_no_missing_value() {
        let points = |roof: f64| -> Vec<DVec3> {
            (0..100)
                .map(|i| (f64::from(i % 10), f64::from(i / 10)))
                .map(|(x, y)| DVec3::new(x, y, if x < 4.0 { 0.0 } else { roof + 0.1 * x }))
                .collect()
        };
        assert!(no_data(&points(4.0)).is_none());
        assert!(no_data(&points(1e4)).is_some());
        let one_far: Vec<DVec3> = points(4.0).into_iter().chain([DVec3::splat(1e6)]).collect();
        assert!(no_data(&one_far).is_none());
    }
}
