//! Seams: where closed surfaces begin and end.

use std::sync::Arc;

use super::places::{Places, Rectangle};
use super::region::Region;
use super::triangulation::Triangulation;
use crate::error::Result;
use crate::nurbs::{Direction, NurbsSurface};
use crate::progress::Silent;

/// Share of a gap at each end in which a seam does not stay: borders move outward.
const MARGIN: f64 = 0.25;

/// The surface with each seam in the middle of a gap of the region, if there is one: a seam through
/// the region would cut it into several faces. Parameters change by whole turns.
pub(super) fn with_free_seams(
    surface: &Arc<NurbsSurface>,
    places: &Places,
    triangulation: &Triangulation,
    region: &Region,
) -> Result<Arc<NurbsSurface>> {
    let mut moved = Arc::clone(surface);
    for (d, direction) in [Direction::U, Direction::V].into_iter().enumerate() {
        if !places.rectangle.closed[d] {
            continue;
        }
        let Some((from, to)) = widest_gap(ranges(places, triangulation, region, d)) else {
            continue;
        };
        let margin = MARGIN * (to - from);
        if (from + margin..=to - margin).contains(&0.0) {
            continue;
        }
        let rectangle: &Rectangle = &places.rectangle;
        let at = rectangle.low[d] + rectangle.size()[d] * (0.5 * (from + to)).rem_euclid(1.0);
        let (before, after) = moved.split(direction, at, &mut Silent)?;
        // That the ends meet is known.
        moved = Arc::new(after.joined(direction, &before, f64::MAX, &mut Silent)?);
    }
    Ok(moved)
}

/// The ranges of u or v, in turns from the seam, of the region's triangles. They begin in [0, 1).
fn ranges(
    places: &Places,
    triangulation: &Triangulation,
    region: &Region,
    d: usize,
) -> Vec<(f64, f64)> {
    let rectangle = &places.rectangle;
    let kept = triangulation.corners.iter().zip(&region.pieces).filter(|(_, of)| of.is_some());
    let range = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|place| places.uv[place as usize]);
        let start = a[d] - rectangle.low[d];
        let ways = [b, c].map(|to| start + rectangle.way(a, to)[d]);
        let ends = ways.iter().fold((start, start), |(low, high), x| (low.min(*x), high.max(*x)));
        let (low, high) = (ends.0 / rectangle.size()[d], ends.1 / rectangle.size()[d]);
        (low - low.floor(), high - low.floor())
    };
    kept.map(|(corners, _)| range(corners)).collect()
}

/// The widest gap between ranges around a circle of length 1; it ends in [0, 1).
fn widest_gap(mut ranges: Vec<(f64, f64)>) -> Option<(f64, f64)> {
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut reach = ranges.iter().map(|range| range.1 - 1.0).fold(f64::NEG_INFINITY, f64::max);
    let mut widest: Option<(f64, f64)> = None;
    for (from, to) in ranges {
        if from > reach && widest.is_none_or(|(low, high)| from - reach > high - low) {
            widest = Some((reach, from));
        }
        reach = reach.max(to);
    }
    widest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_found_around_a_circle() {
        assert_eq!(widest_gap(vec![(0.25, 0.5), (0.125, 0.25)]), Some((-0.5, 0.125)));
        assert_eq!(widest_gap(vec![(0.75, 1.25), (0.5, 0.75)]), Some((0.25, 0.5)));
        assert_eq!(widest_gap(vec![(0.0, 0.5), (0.5, 1.0)]), None);
        assert_eq!(widest_gap(vec![(0.0, 0.25), (0.5, 1.0)]), Some((0.25, 0.5)));
    }
}
