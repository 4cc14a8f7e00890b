//! Whether points are a ground and things on it, as a scan from the air shows them.

use glam::DVec3;

use super::height_field::{
    HeightField, STEEPER, Tangent, WALL_DEGREES, covers, mostly_smooth, slope, tangents,
};
use crate::cloud::{NEIGHBORS, NeighborGraph, any_of};
use crate::error::Result;
use crate::progress::Observer;

/// Points that are looked at, and how many fewer the next time where these scatter too much about a
/// surface for their distance.
const MOST: usize = 200_000;
const FEWER: usize = 4;

/// Fewer points do not show what stands on a ground.
const FEWEST: usize = 2000;

/// How high things stand, by the median over what has one above or below it, in spacings: layers nearer
/// to one another seem rough, as neighbours are taken from both.
const HIGH: f64 = 4.0;

/// Points above or below others, for each of those others: a stray point has several below it, but a tree
/// has as many points as the ground under it.
const AS_MANY: f64 = 0.85;

/// Share of what has something above or below it where both may be smooth, as at the edge of a roof. Of a
/// sheet that folds over it is more than a half, and more than this up to noise through which most of it
/// does not look smooth.
const LAYERED: f64 = 1.0 / 3.0;

/// The ground, if `all` points are one with things on it that are no part of a sheet with it: unlike the
/// folds of a sheet they are rough though they are high. Some of the points, evenly over space, tell whether
/// a closer look is worth its time.
pub(super) fn find(
    some: &[DVec3],
    graph: &NeighborGraph,
    all: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<Option<HeightField>> {
    if all.len() < FEWEST || has_walls(&tangents(some, graph)) {
        return Ok(None);
    }
    let mut most = MOST;
    loop {
        let points = any_of(all, most);
        if points.len() < FEWEST {
            return Ok(None);
        }
        let graph = NeighborGraph::of(&points, NEIGHBORS, observer)?;
        let tangents = tangents(&points, &graph);
        if mostly_smooth(&tangents) {
            return Ok(under_things(&points, &tangents));
        }
        most = points.len() / FEWER;
    }
}

/// Whether more of the points lie on smooth walls than on a ground.
fn has_walls(tangents: &[Tangent]) -> bool {
    let wall = |tangent: &&Tangent| tangent.is_smooth() && tangent.slope(DVec3::Z) > WALL_DEGREES;
    STEEPER * tangents.iter().filter(wall).count() > tangents.len()
}

/// The ground that most of the points lie on, if what is above or below it is no layer of a sheet.
fn under_things(points: &[DVec3], tangents: &[Tangent]) -> Option<HeightField> {
    let slope = slope(tangents.iter().filter(|tangent| tangent.is_smooth()), DVec3::Z);
    if slope > WALL_DEGREES {
        return None;
    }
    let (mut heights, mut layered) = (Vec::new(), 0);
    let mut above_or_below = vec![false; points.len()];
    for (index, covers) in covers(points, tangents, DVec3::Z).into_iter().enumerate() {
        let height = |&cover: &usize| (points[cover].z - points[index].z).abs();
        let Some(highest) = covers.iter().map(height).max_by(f64::total_cmp) else { continue };
        heights.push(highest);
        for &cover in &covers {
            above_or_below[cover] = true;
        }
        let smooth = |index: usize| tangents[index].is_smooth();
        layered += u32::from(smooth(index) && covers.iter().any(|&cover| smooth(cover)));
    }
    let covered = heights.len() as f64;
    let things = above_or_below.iter().filter(|is| **is).count() as f64;
    let mut spacings: Vec<f64> = tangents.iter().map(|tangent| tangent.spacing).collect();
    let fits = median(&mut heights)? >= HIGH * median(&mut spacings)?
        && things >= AS_MANY * covered
        && f64::from(layered) <= LAYERED * covered;
    fits.then_some(HeightField { up: DVec3::Z, slope, ground: true })
}

/// The upper median; `None` of nothing.
fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    /// Numbers from 0 to 1 that scatter evenly.
    fn scattered(index: u32) -> [f64; 4] {
        [2.0_f64, 3.0, 5.0, 7.0].map(|prime| (f64::from(index) * prime.sqrt()).fract())
    }

    fn found(points: &[DVec3]) -> Option<HeightField> {
        let graph = NeighborGraph::of(points, NEIGHBORS, &mut Silent).unwrap();
        find(points, &graph, points, &mut Silent).unwrap()
    }

    /// A ground of 100 by 100 with trees of radius 4 in rows and columns; what a beam meets first is a place
    /// between the bottom of a crown and its top.
    fn wood(bottom: f64, top: f64) -> Vec<DVec3> {
        let point = |index| {
            let [x, y, t, hit] = scattered(index);
            let (x, y) = (100.0 * x, 100.0 * y);
            let ground = 3.0 * (x / 30.0).sin() + 2.0 * (y / 25.0).cos();
            let from_trunk = DVec3::new(x % 20.0 - 10.0, y % 20.0 - 10.0, 0.0).length();
            let crown = from_trunk < 4.0 && hit < 0.6;
            let height = if crown { bottom + t * (top - bottom) } else { 0.0 };
            DVec3::new(x, y, ground + height)
        };
        (1..8000).map(point).collect()
    }

    #[test]
    fn trees_stand_on_a_ground() {
        let ground = found(&wood(4.0, 16.0)).unwrap();
        assert!(ground.ground && ground.up == DVec3::Z);
        assert!(ground.slope < 45.0, "{}", ground.slope);
    }

    #[test]
    fn layers_and_folds_are_no_things() {
        // Flat crowns are layers, over which a ground is no more than another.
        assert_eq!(found(&wood(8.0, 8.0)), None);
        // A sheet that folds over for a tenth of its length, from gaps in which layers seem rough to wide ones.
        for gap in [0.01, 0.02, 0.04, 0.2] {
            let point = |index| {
                let [s, y, noise, _] = scattered(index);
                let (s, noise) = (1.2 * s, 0.002 * (noise - 0.5));
                let (x, layer) = match s {
                    s if s < 0.55 => (s, 0.0),
                    s if s < 0.65 => (1.1 - s, 1.0),
                    s => (s - 0.2, 2.0),
                };
                DVec3::new(x, y, layer * gap + noise)
            };
            let sheet: Vec<DVec3> = (1..8000).map(point).collect();
            assert_eq!(found(&sheet), None, "{gap}");
            // Strays above it are no trees.
            let strays = (1..40).map(|index| {
                let [x, y, z, _] = scattered(8000 + index);
                DVec3::new(x, y, z - 0.5)
            });
            let with_strays: Vec<DVec3> = sheet.iter().copied().chain(strays).collect();
            assert_eq!(found(&with_strays), None, "{gap} and strays");
        }
    }

    #[test]
    fn what_is_mostly_rough_or_wall_is_no_ground() {
        let volume: Vec<DVec3> = (1..8000)
            .map(|index| {
                let [x, y, z, _] = scattered(index);
                DVec3::new(x, y, 0.3 * z)
            })
            .collect();
        assert_eq!(found(&volume), None);
        let standing: Vec<DVec3> =
            wood(4.0, 16.0).iter().map(|point| DVec3::new(point.x, point.z, point.y)).collect();
        assert_eq!(found(&standing), None);
    }
}
