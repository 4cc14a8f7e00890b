//! Straight sides: the quadrilateral around parameters, mapped to the unit square.

use glam::DVec2;
use rayon::prelude::*;

use super::settings::SideSettings;
use super::sizes::POINTS_PER_TASK;
use crate::numeric::min_max;

const SETTINGS: SideSettings = SideSettings::STANDARD;

/// Maps parameters to the unit square. In each open direction, two straight lines that enclose all
/// parameters with the least area between become sides of the square, level ones across a closed
/// direction. Closed directions stay as they are.
///
/// ```
/// use neurbs::{DVec2, fit::bounded};
/// let leaning = [(0.0, 0.0), (2.0, 1.0), (0.5, 2.0), (2.5, 3.0)].map(|(u, v)| DVec2::new(u, v));
/// let uv = bounded(&leaning, (false, false));
/// assert!(uv[0].distance(DVec2::ZERO) < 1e-12 && uv[3].distance(DVec2::ONE) < 1e-12);
/// ```
#[must_use]
pub fn bounded(uv: &[DVec2], closed: (bool, bool)) -> Vec<DVec2> {
    let mut uv = uv.to_vec();
    // The sides of one direction depend on those of the other.
    for _ in 0..2 {
        for (d, closed, across) in [(0, closed.0, closed.1), (1, closed.1, closed.0)] {
            if !closed {
                bound_direction(&mut uv, d, across);
            }
        }
    }
    uv
}

/// Gives direction d, from 0 to 1, a margin at both ends.
pub(super) fn add_margin(uv: &mut [DVec2], d: usize, margin: f64) {
    change_each(uv, |uv| uv[d] = (uv[d] + margin) / (1.0 + 2.0 * margin));
}

/// Applies a change to each parameter.
fn change_each(uv: &mut [DVec2], change: impl Fn(&mut DVec2) + Sync + Send) {
    uv.par_iter_mut().with_min_len(POINTS_PER_TASK).for_each(change);
}

/// Maps direction d to [0, 1]. Lines across a closed direction are level: they end where they begin.
fn bound_direction(uv: &mut [DVec2], d: usize, closed_across: bool) {
    let across = |uv: &DVec2| uv[1 - d];
    let low = StraightLine::below(uv.iter().map(|uv| (across(uv), uv[d])));
    let high = StraightLine::below(uv.iter().map(|uv| (across(uv), -uv[d]))).negated();
    let (start, end) = min_max(uv.iter().map(across));
    let width = |at: f64| high.at(at) - low.at(at);
    let mean = width(0.5 * (start + end));
    let slopes = !closed_across && width(start).min(width(end)) >= SETTINGS.min_width * mean;
    let (low, high) = if slopes {
        (low, high)
    } else {
        let (least, most) = min_max(uv.iter().map(|uv| uv[d]));
        (StraightLine::level(least), StraightLine::level(most))
    };
    change_each(uv, |uv| {
        let at = uv[1 - d];
        let size = high.at(at) - low.at(at);
        uv[d] = if size > 0.0 { ((uv[d] - low.at(at)) / size).clamp(0.0, 1.0) } else { 0.5 };
    });
}

/// A straight line, y over x.
#[derive(Clone, Copy)]
struct StraightLine {
    height: f64,
    slope: f64,
}

impl StraightLine {
    fn level(height: f64) -> Self {
        Self { height, slope: 0.0 }
    }

    fn at(self, x: f64) -> f64 {
        self.height + self.slope * x
    }

    fn negated(self) -> Self {
        Self { height: -self.height, slope: -self.slope }
    }

    /// The line below all points (x, y) with the least area between: it extends the edge of their
    /// lower convex hull that lies below the middle.
    fn below(places: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let mut places: Vec<_> =
            lowest_in_strips(places, SETTINGS.hull_strips).into_iter().flatten().collect();
        places.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let middle = 0.5 * (places[0].0 + places[places.len() - 1].0);
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for place in places {
            while let [.., a, b] = chain[..] {
                if (b.0 - a.0) * (place.1 - a.1) - (b.1 - a.1) * (place.0 - a.0) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(place);
        }
        let spans = |edge: &&[(f64, f64)]| edge[0].0 <= middle && middle <= edge[1].0;
        match chain.windows(2).find(spans) {
            Some(&[a, b]) if b.0 > a.0 => {
                let slope = (b.1 - a.1) / (b.0 - a.0);
                Self { height: a.1 - slope * a.0, slope }
            }
            _ => Self::level(chain.iter().map(|place| place.1).fold(f64::INFINITY, f64::min)),
        }
    }
}

/// The lowest point (x, y) in each strip of x; one more strip contains the largest x.
fn lowest_in_strips(
    places: impl Iterator<Item = (f64, f64)> + Clone,
    strips: usize,
) -> Vec<Option<(f64, f64)>> {
    let (start, end) = min_max(places.clone().map(|place| place.0));
    let scale = strips as f64 / (end - start).max(f64::MIN_POSITIVE);
    let mut found: Vec<Option<(f64, f64)>> = vec![None; strips + 1];
    for place in places {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let strip = &mut found[(((place.0 - start) * scale) as usize).min(strips)];
        if strip.is_none_or(|lowest| place.1 < lowest.1) {
            *strip = Some(place);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_fill_the_square_and_touch_every_side() {
        let uv: Vec<DVec2> = (0..400)
            .map(|i| {
                let (x, y) = (f64::from(i * 7 % 400) / 400.0, f64::from(i) / 400.0);
                DVec2::new(3.0 * x + 0.4 * y, 2.0 * y - 0.3 * x + 5.0)
            })
            .collect();
        let found = bounded(&uv, (false, false));
        for d in 0..2 {
            let (low, high) = min_max(found.iter().map(|uv| uv[d]));
            assert!((low, high) == (0.0, 1.0), "{low} {high}");
            let touching = |end: f64| found.iter().filter(|uv| (uv[d] - end).abs() < 1e-9).count();
            assert!(touching(0.0) >= 2 && touching(1.0) >= 2);
        }
    }

    #[test]
    fn round_boundaries_get_level_sides() {
        let uv: Vec<DVec2> = (0..60)
            .map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 60.0))
            .collect();
        let found = bounded(&uv, (false, false));
        assert!(found[0].distance(DVec2::new(1.0, 0.5)) < 0.05, "{}", found[0]);
    }
}
