//! Polygons: the borders that always hold.

use glam::DVec2;

use super::arc::straight;
use super::border::Border;
use crate::error::Result;
use crate::nurbs::NurbsCurve;

/// The straight curves through all places of a border that are farther than a tolerance from the
/// straight line between those that remain (D. H. Douglas and T. K. Peucker 1973).
pub(super) fn polygon(border: &Border, tolerance: f64) -> Result<Vec<NurbsCurve>> {
    let kept = simplified(border, tolerance);
    let at = |k: usize| border.uv[k % border.len()] + border.shift * (k / border.len()) as f64;
    let corners: Vec<DVec2> = kept.iter().map(|k| at(*k)).collect();
    corners.windows(2).map(|pair| straight(pair[0], pair[1])).collect()
}

/// The places that remain, from the first one once around to it.
fn simplified(border: &Border, tolerance: f64) -> Vec<usize> {
    let count = border.len();
    let point = |k: usize| border.points[k % count];
    // The farthest place is on every good polygon.
    let far = (1..count)
        .max_by(|a, b| point(*a).distance(point(0)).total_cmp(&point(*b).distance(point(0))));
    let mut kept = vec![0];
    let mut left: Vec<(usize, usize)> = match far {
        Some(far) => vec![(far, count), (0, far)],
        None => vec![(0, count)],
    };
    while let Some((from, to)) = left.pop() {
        let (a, b) = (point(from), point(to));
        let along = (b - a).normalize_or_zero();
        let off = |k: usize| {
            let way = point(k) - a;
            let at = way.dot(along).clamp(0.0, a.distance(b));
            (way - along * at).length()
        };
        let farthest = (from + 1..to).max_by(|x, y| off(*x).total_cmp(&off(*y)));
        match farthest.filter(|k| off(*k) > tolerance) {
            Some(k) => left.extend([(k, to), (from, k)]),
            None => kept.push(to),
        }
    }
    kept
}
