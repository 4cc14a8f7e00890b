//! Values that stand for no data.

use std::fmt;

use glam::DVec3;

/// A value that stands for no data is so many times farther from all others than these are from one another.
const FAR: f64 = 10.0;

/// A value of one coordinate that many points have and that lies far from all others, as -9999 below heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoData {
    /// Which coordinate.
    pub axis: usize,
    /// Its value.
    pub value: f64,
    /// How many points have it: two at least.
    pub count: usize,
}

impl NoData {
    /// Whether a point has the value.
    #[must_use]
    pub fn has(&self, point: DVec3) -> bool {
        point[self.axis] == self.value
    }
}

impl fmt::Display for NoData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, value, count } = self;
        write!(
            f,
            "{count} points have {} = {value}, far from all others, as if that stood for no data: they \
             are left out; clean=False keeps them",
            ["x", "y", "z"][*axis]
        )
    }
}

/// Looks for a value that less than half of the points, but several, have as a coordinate, exactly, and that
/// is ten times farther from the values of all others than these extend.
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
            if !(end > start && apart > FAR * (end - start)) {
                return None;
            }
            let count = values().filter(|other| *other == value).count();
            let several = count > 1 && (count as f64) < 0.5 * points.len() as f64;
            several.then_some(NoData { axis, value, count })
        })
    };
    (0..3).find_map(along)
}

fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_and_roofs_are_data() {
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
