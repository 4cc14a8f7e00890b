//! Strips that bend at corners: regions like an L, a U or a Z.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::outline::Squared;
use super::start::whole;
use crate::cloud::area;
use crate::fit::{Arms, Line};

/// Places along an outline at which corners are looked for.
pub(super) const CANDIDATES: usize = 128;

/// How far on either side an outline turns at a corner, in radii of the blur that has rounded it;
/// where its sides are straight more is looked at.
const ROUND: f64 = 3.0;
const ROUND_BETWEEN_STRAIGHT: f64 = 4.0;

/// Windows from a corner up to which a straight side is looked at, and the sine of the angle between
/// two sides from which on they meet at a corner.
const BESIDE: usize = 3;
const SLANTED: f64 = 0.5;

/// Places that tell how a place beside them lies in space.
const NEAR: usize = 32;

/// Right angles by which an outline turns at least at the inner and the outer corners of a strip,
/// which a blur has rounded.
const INNER: f64 = 0.5;
const OUTER: f64 = 0.3;

/// By this share of the least sharp outer corner of a strip its outline may turn at another place.
const DOUBTFUL: f64 = 0.9;

/// How many times wider than elsewhere a strip may be at an end or a bend.
const UNEVEN: f64 = 3.0;

/// Share of the region that the arms fill at least: a region with bent sides is no such strip.
const FILLED: f64 = 0.8;

/// The strip with an outline through these places, counter-clockwise, that turns by so much around
/// each, over so many on either side (see [`turns`]): it is cut at its bends, from each inner corner to
/// the outer one across. `None` if the outline is not that of a strip with at least one bend.
pub(super) fn within(line: &[DVec2], turns: &[f64], window: usize, sides: Sides) -> Option<Arms> {
    let corners = corners(turns, window);
    if corners.iter().all(|&i| turns[i] > 0.0) {
        return None;
    }
    let places = match sides {
        Sides::Bent => corners.iter().map(|&i| line[i]).collect(),
        Sides::Straight => sharpened(line, &corners, window),
    };
    let outer = corners.iter().map(|&i| turns[i] > 0.0);
    let corners: Vec<(DVec2, bool)> = places.into_iter().zip(outer).collect();
    let least = FILLED * area(line);
    let filled = |strip: &Arms| strip.area() > least;
    let strips = between(&corners).filter(filled);
    strips.max_by(|a, b| a.aspect().total_cmp(&b.aspect()))
}

/// The strips of even width with these corners along the outline, each with whether it is an outer
/// one.
fn between(corners: &[(DVec2, bool)]) -> impl Iterator<Item = Arms> {
    let count = corners.len();
    let at = move |i: usize| corners[i % count];
    let is_end = move |i: &usize| at(*i).1 && at(i + 1).1;
    let half = count / 2;
    // As many corners on both sides between one end and the other.
    (0..half).filter(move |start| is_end(start) && is_end(&(start + half))).filter_map(
        move |start| {
            let stations = (0..half).map(|i| [at(start + 1 + i), at(start + count - i)]);
            let stations: Vec<[(DVec2, bool); 2]> = stations.collect();
            let across = |[a, b]: &[(DVec2, bool); 2]| a.1 != b.1;
            let stands_across = stations[1..half - 1].iter().all(across);
            let stations: Vec<[DVec2; 2]> =
                stations.iter().map(|pair| pair.map(|(corner, _)| corner)).collect();
            let strip = Arms::between(&stations);
            (stands_across && is_even(&strip)).then_some(strip)
        },
    )
}

/// Whether no arm is turned over and no end or bend is much wider than another.
fn is_even(strip: &Arms) -> bool {
    let widths = strip.arms().iter().flat_map(|arm| {
        let [a, b, c, d] = arm.0;
        [a.distance(d), b.distance(c)]
    });
    let (narrowest, widest) = widths
        .fold((f64::INFINITY, 0.0_f64), |(low, high), width| (low.min(width), high.max(width)));
    widest < UNEVEN * narrowest && strip.arms().iter().all(|arm| arm.area() > 0.0)
}

/// Places in the unit square that a strip becomes.
pub(super) fn straightened(strip: &Arms, places: &[DVec2]) -> Squared {
    let uv = places.iter().map(|&place| strip.parameters(place)).collect();
    Squared::filled(uv, strip.aspect(), strip.bends())
}

/// What is known of the sides of an outline.
#[derive(Clone, Copy)]
pub(super) enum Sides {
    /// A flat map may have bent them.
    Bent,
    Straight,
}

impl Sides {
    /// The places on either side over which an outline turns at a corner that a blur of this radius, in
    /// places, has rounded.
    pub(super) fn window(self, radius: f64) -> usize {
        let round = match self {
            Self::Bent => ROUND,
            Self::Straight => ROUND_BETWEEN_STRAIGHT,
        };
        whole((round * radius).round()).max(1)
    }
}

/// By how much the closed outline of a map's places turns to the left around each of its own, over so
/// many on either side, in right angles: in space, because a flat map unbends what is bent. Each place
/// of the map is that of a point.
pub(super) fn turns(line: &[DVec2], window: usize, places: &[DVec2], points: &[DVec3]) -> Vec<f64> {
    let lifted: Vec<(DVec3, DVec3)> =
        line.par_iter().map(|&at| lifted(at, places, points)).collect();
    let count = line.len();
    let turn = |i: usize| {
        let [before, here, after] =
            [i + count - window, i, i + window].map(|k| lifted[k % count].0);
        let (from, to, normal) = (here - before, after - here, lifted[i].1);
        from.cross(to).dot(normal).atan2(from.dot(to)) / std::f64::consts::FRAC_PI_2
    };
    (0..count).map(turn).collect()
}

/// Where a place of a map lies in space, and the normal there: by the affine map that is closest for
/// the nearest of the places whose points are known.
fn lifted(at: DVec2, places: &[DVec2], points: &[DVec3]) -> (DVec3, DVec3) {
    let mut nearest: Vec<usize> = (0..places.len()).collect();
    let last = NEAR.min(nearest.len() - 1);
    let distance = |i: &usize| places[*i].distance_squared(at);
    nearest.select_nth_unstable_by(last, |a, b| distance(a).total_cmp(&distance(b)));
    let mut moments = DMat3::ZERO;
    let mut sums = [DVec3::ZERO; 3];
    for &i in &nearest[..last] {
        let affine = (places[i] - at).extend(1.0);
        moments += DMat3::from_cols(affine.x * affine, affine.y * affine, affine);
        for (sum, value) in sums.iter_mut().zip(points[i].to_array()) {
            *sum += value * affine;
        }
    }
    let inverse = moments.inverse();
    let solved = DMat3::from_cols_array_2d(&sums.map(|sum| (inverse * sum).to_array()));
    let [along, across, place] = [0, 1, 2].map(|i| solved.row(i));
    (place, along.cross(across).normalize_or_zero())
}

/// Where a closed line that turns by so much around its places has inner corners, and as many of the
/// sharpest outer ones as go with them in a strip; none if it is in doubt which.
fn corners(turns: &[f64], window: usize) -> Vec<usize> {
    let count = turns.len();
    let sharpest = |&i: &usize| {
        let turn = |k: usize| turns[k % count].abs();
        // One corner has no two peaks within the window.
        let before = (i + count - window..i + count).all(|k| turn(k) < turn(i));
        let after = (i + 1..=i + window).all(|k| turn(k) <= turn(i));
        before && after
    };
    let (mut outer, mut corners): (Vec<usize>, Vec<usize>) = (0..count)
        .filter(sharpest)
        .filter(|&i| !(-INNER..OUTER).contains(&turns[i]))
        .partition(|&i| turns[i] > 0.0);
    outer.sort_by(|&a, &b| turns[b].total_cmp(&turns[a]).then(a.cmp(&b)));
    let needed = corners.len() + 4;
    let [.., last, next] = outer[..outer.len().min(needed + 1)] else { return Vec::new() };
    if outer.len() > needed && turns[next] > DOUBTFUL * turns[last] {
        return Vec::new();
    }
    outer.truncate(needed);
    corners.extend(outer);
    corners.sort_unstable();
    corners
}

/// Where the sides of a closed line would meet at its corners, which a blur has rounded: the straight
/// lines along what lies beside a corner, but not so near that it is round.
fn sharpened(line: &[DVec2], corners: &[usize], window: usize) -> Vec<DVec2> {
    let (count, sides) = (line.len(), corners.len());
    let corner = |k: usize| {
        let here = corners[k];
        let before = (here + count - corners[(k + sides - 1) % sides]) % count;
        let after = (corners[(k + 1) % sides] + count - here) % count;
        let beside = |length: usize| window..=length.saturating_sub(window).min(BESIDE * window);
        let from = straight(beside(before).map(|i| line[(here + count - i) % count]))?;
        let to = straight(beside(after).map(|i| line[(here + i) % count]))?;
        from.meeting(to, SLANTED)
    };
    (0..sides).map(|k| corner(k).unwrap_or(line[corners[k]])).collect()
}

/// The straight line that is closest to some places.
fn straight(places: impl Iterator<Item = DVec2> + Clone) -> Option<Line> {
    let count = places.clone().count();
    if count < 2 {
        return None;
    }
    let middle = places.clone().sum::<DVec2>() / count as f64;
    let (mut spread, mut slope) = (0.0, 0.0);
    for away in places.map(|place| place - middle) {
        spread += away.x * away.x - away.y * away.y;
        slope += 2.0 * away.x * away.y;
    }
    Some(Line { at: middle, along: DVec2::from_angle(0.5 * slope.atan2(spread)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places along the outline of a polygon, and by how much it turns there.
    fn outline(polygon: &[(f64, f64)]) -> (Vec<DVec2>, Vec<f64>) {
        let corners: Vec<DVec2> = polygon.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let count = corners.len();
        let (mut line, mut turns) = (Vec::new(), Vec::new());
        for i in 0..count {
            let [before, here, after] = [i + count - 1, i, i + 1].map(|k| corners[k % count]);
            let right = (here - before).angle_to(after - here) / std::f64::consts::FRAC_PI_2;
            line.extend((0..10).map(|k| here.lerp(after, f64::from(k) / 10.0)));
            turns.extend([right].into_iter().chain([0.0; 9]));
        }
        (line, turns)
    }

    const L: [(f64, f64); 6] =
        [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];

    #[test]
    fn an_l_is_cut_from_corner_to_corner() {
        let (line, turns) = outline(&L);
        let strip = within(&line, &turns, 4, Sides::Bent).unwrap();
        assert_eq!(strip.arms().len(), 2);
        assert!((strip.area() - 4.0).abs() < 1e-12, "{}", strip.area());
        let places = [(0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (2.0, 0.5), (0.5, 3.0)];
        let places = places.map(|(x, y)| DVec2::new(x, y));
        let Squared { uv, creases, .. } = straightened(&strip, &places);
        // The arms are as long as their sides are on average: 1.5 and 2.5.
        let bend = if uv[3].x < uv[4].x { 1.5 / 4.0 } else { 2.5 / 4.0 };
        assert_eq!(creases.len(), 1);
        assert!((creases[0] - bend).abs() < 1e-12, "{creases:?}");
        assert!(uv[..3].iter().all(|uv| (uv.x - bend).abs() < 1e-9), "{uv:?}");
        assert!((uv[0].y - uv[1].y).abs() > 1.0 - 1e-9 && (uv[3].x - uv[4].x).abs() > 1.0 - 1e-9);
    }

    #[test]
    fn a_u_bends_twice_and_others_not_at_all() {
        let bends = |polygon: &[(f64, f64)]| {
            let (line, turns) = outline(polygon);
            within(&line, &turns, 4, Sides::Bent).map(|strip| strip.bends().len())
        };
        let u = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (2.0, 3.0)];
        let u = [&u[..], &[(2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]].concat();
        assert_eq!(bends(&u), Some(2));
        let t = [(1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (3.0, 2.0)];
        let t = [&t[..], &[(3.0, 3.0), (0.0, 3.0), (0.0, 2.0), (1.0, 2.0)]].concat();
        assert_eq!(bends(&t), None);
        assert_eq!(bends(&[L[0], L[1], (2.0, 3.0), L[5]]), None);
        // A notch of a square.
        let notch = [L[0], (3.0, 0.0), (3.0, 3.0), (1.6, 3.0), (1.5, 2.7), (1.4, 3.0), L[5]];
        assert_eq!(bends(&notch), None);
    }

    #[test]
    fn outlines_turn_as_they_do_in_space() {
        // A map that is half as wide as long: its right angles are none in space, where it is rolled.
        let places: Vec<DVec2> =
            (0..900).map(|i| DVec2::new(f64::from(i % 30), f64::from(i / 30)) / 30.0).collect();
        let rolled = |p: &DVec2| DVec3::new(p.x.cos(), p.x.sin(), 2.0 * p.y);
        let points: Vec<DVec3> = places.iter().map(rolled).collect();
        let line: Vec<DVec2> = [(0.2, 0.4), (0.5, 0.4), (0.5, 0.6), (0.2, 0.6)]
            .windows(2)
            .flat_map(|ends| {
                let [a, b] = [ends[0], ends[1]].map(|(x, y)| DVec2::new(x, y));
                (0..8).map(move |k| a.lerp(b, f64::from(k) / 8.0))
            })
            .collect();
        let found = turns(&line, 3, &places, &points);
        assert!(found[3..6].iter().all(|turn| turn.abs() < 0.1), "{found:?}");
        assert!([8, 16].iter().all(|&i| (found[i] - 1.0).abs() < 0.1), "{found:?}");
    }
}
