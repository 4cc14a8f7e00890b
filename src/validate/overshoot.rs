//! Where a surface is farther from its points than the gaps between them explain.

use std::fmt;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::samples::{Flaw, Samples};
use crate::cloud::{Bounds, KdTree, Neighbor};
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Over a gap, a place may be as far from the nearest point as so many times the way, along the
/// surface, to the foot of one: twice, where the surface bulges over half of a circle and more.
const STEEPEST: f64 = 2.0;

/// What is no overshoot anyway, as a share of the points' diagonal.
const SLACK: f64 = 0.05;

/// Share of the points' longest chord that a place may lie outside of their convex hull, however long the way there is.
pub(crate) const OUTSIDE: f64 = 0.3;

/// Corners of the hull that are looked at, and steps among them: few places are that near to the bound.
const CORNERS: usize = 32;
const STEPS: usize = 64;

/// Cells around a sample in which a point near it is looked for, in turn.
const AROUND: [usize; 3] = [1, 3, 9];

/// Places of a surface that are farther from its points than the gaps between them explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overshoot {
    /// How many samples are.
    pub count: usize,
    /// The largest distance of one from its nearest point, in the points' unit.
    pub distance: f64,
    /// Where that is.
    pub place: DVec3,
}

impl fmt::Display for Overshoot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.place;
        write!(
            f,
            "the surface runs {:.4} away from the points at ({x:.6}, {y:.6}, {z:.6}), farther than \
             the gap between them explains; use a smaller net or more fairness",
            self.distance
        )
    }
}

/// Looks for places, four to a span, that are farther from every point than 0.05 of the diagonal of
/// the points' box and twice the way along the surface to the foot of the nearest one: its
/// parameters by those of the feet, `uv`, times the mean lengths of the surface's isocurves; or farther
/// outside of the points' convex hull than 0.3 of their longest chord. Over a hole, and beyond the border, a
/// surface without any stays within the width of the hole, and twice the width of what lies beyond, and
/// these 0.05.
///
/// ```
/// use neurbs::{DVec2, DVec3, NurbsSurface, validate::overshoot, progress::Silent};
/// // The square from 0 to 9 with a hole in the middle.
/// let places = (0..100).map(|i| DVec2::new(f64::from(i / 10), f64::from(i % 10)));
/// let places: Vec<DVec2> = places.filter(|p| p.distance(DVec2::splat(4.5)) > 3.0).collect();
/// let points: Vec<DVec3> = places.iter().map(|p| p.extend(0.0)).collect();
/// let uv: Vec<DVec2> = places.iter().map(|p| *p / 9.0).collect();
/// let bulging = |height: f64| {
///     let net = (0..49).map(|i| (i / 7, i % 7)).map(|(i, j)| {
///         DVec3::new(i as f64, j as f64, if (i, j) == (3, 3) { height } else { 0.0 }) * 1.5
///     });
///     NurbsSurface::clamped(net.collect(), (7, 7), 3)
/// };
/// let seen = |surface| overshoot(&surface, &points, &uv, (false, false), &mut Silent);
/// assert!(seen(bulging(1.0)?)?.is_none());
/// assert!(seen(bulging(20.0)?)?.is_some());
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn overshoot(
    surface: &NurbsSurface,
    points: &[DVec3],
    uv: &[DVec2],
    closed: (bool, bool),
    observer: &mut dyn Observer,
) -> Result<Option<Overshoot>> {
    let samples = Samples::of(surface, observer)?;
    Ok(Overshoot::of(&runaways(&samples, points, uv, closed, (OUTSIDE, 0.0))))
}

impl Overshoot {
    /// Of runaways.
    pub(crate) fn of(runaways: &[(f64, Flaw)]) -> Option<Self> {
        let farthest = runaways.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        farthest.map(|&(distance, Flaw { place, .. })| Self {
            count: runaways.len(),
            distance,
            place,
        })
    }
}

/// The samples that [`overshoot`] counts, and their distances from the nearest points, if the surface may lie
/// outside of the points' hull by such a share of their longest chord and so many mean spacings.
pub(crate) fn runaways(
    samples: &Samples,
    points: &[DVec3],
    uv: &[DVec2],
    closed: (bool, bool),
    (share, wanted): (f64, f64),
) -> Vec<(f64, Flaw)> {
    let slack = SLACK * Bounds::of(points).diagonal();
    let feet = Feet::of(samples, uv, closed);
    // Hardly any place is so far from a point whose foot is near, and only those are looked at.
    let near = |place: usize, point: u32| {
        samples.places[place].distance_squared(points[point as usize]) <= slack * slack
    };
    let far: Vec<usize> = feet.unsupported(near);
    if far.is_empty() {
        return Vec::new();
    }
    let tree = KdTree::new(points);
    let nearest = |place: usize| tree.nearest(samples.places[place], 1).first().copied();
    let far = far.par_iter().filter_map(|&place| Some((place, nearest(place)?)));
    let far: Vec<(usize, Neighbor)> = far.filter(|(_, near)| near.distance() > slack).collect();
    if far.is_empty() {
        return Vec::new();
    }
    let places = feet.repeated();
    let ways = KdTree::new(&places);
    let spacing = (feet.lengths.element_product() / points.len() as f64).sqrt();
    let most = share * chord(points) + wanted * spacing;
    let beyond = |&(place, near): &(usize, Neighbor)| {
        let (at, foot, found) = (samples.places[place], feet.of_sample(place), near.distance());
        let way = ways.nearest(foot, 1).first()?.distance();
        let is_outside = || found > most && outside(points, at, points[near.index as usize], most);
        let too_far = found > slack + STEEPEST * way || is_outside();
        too_far.then(|| (found, samples.flaw(place)))
    };
    far.par_iter().filter_map(beyond).collect()
}

/// Whether any of these places lies farther outside of the points' hull than a surface may.
pub(crate) fn run_out(points: &[DVec3], places: impl IntoIterator<Item = DVec3>) -> bool {
    let most = OUTSIDE * chord(points);
    points
        .first()
        .is_some_and(|&first| places.into_iter().any(|place| outside(points, place, first, most)))
}

/// How far the point that is farthest from the middle is from the one farthest from it: hardly less than the longest
/// chord, and no longer than the diagonal of any box around the points, however it is turned.
fn chord(points: &[DVec3]) -> f64 {
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let farthest = |from: DVec3| {
        let square = |point: &&DVec3| point.distance_squared(from);
        points.iter().max_by(|a, b| square(a).total_cmp(&square(b))).copied().unwrap_or(from)
    };
    let end = farthest(middle);
    end.distance(farthest(end))
}

/// Whether a place lies farther than this outside of the convex hull of points, of which one is near. The hull's
/// nearest place is sought among few of its corners by Gilbert's iteration (An iterative procedure for computing the
/// minimum of a quadratic form on a convex set, 1966), from where the farthest point towards the place is one more of
/// them: it comes near enough, or there is a plane that parts the place from the hull.
fn outside(points: &[DVec3], place: DVec3, near: DVec3, most: f64) -> bool {
    let farthest = |points: &[DVec3], away: DVec3| {
        let along = |point: &&DVec3| point.dot(away);
        points.iter().max_by(|a, b| along(a).total_cmp(&along(b))).copied()
    };
    let (mut corners, mut inside) = (vec![near], near);
    for _ in 0..CORNERS {
        for _ in 0..STEPS {
            let Some(way) = farthest(&corners, place - inside).map(|to| to - inside) else { break };
            let share = way.dot(place - inside) / way.length_squared();
            if share.is_nan() || share <= 0.0 {
                break;
            }
            inside += share.min(1.0) * way;
        }
        let away = place - inside;
        if away.length() <= most {
            return false;
        }
        match farthest(points, away) {
            Some(to) if (place - to).dot(away) <= most * away.length() => corners.push(to),
            _ => return true,
        }
    }
    true
}

/// The feet of points among the samples of a surface.
struct Feet {
    rows: usize,
    cols: usize,
    /// Mean lengths of the isocurves along u and v.
    lengths: DVec2,
    closed: [bool; 2],
    /// In the unit square.
    places: Vec<DVec2>,
}

impl Feet {
    fn of(samples: &Samples, uv: &[DVec2], closed: (bool, bool)) -> Self {
        let (low, size) = samples.domain();
        let places = uv.iter().map(|uv| (*uv - low) / size).collect();
        let (rows, cols) = (samples.rows, samples.cols);
        let at = |i: usize, j: usize| samples.places[i * cols + j];
        let along_u = (0..(rows - 1) * cols).map(|k| (k / cols, k % cols));
        let along_u: f64 = along_u.map(|(i, j)| at(i, j).distance(at(i + 1, j))).sum();
        let along_v = (0..rows * (cols - 1)).map(|k| (k / (cols - 1), k % (cols - 1)));
        let along_v: f64 = along_v.map(|(i, j)| at(i, j).distance(at(i, j + 1))).sum();
        let lengths = DVec2::new(along_u / cols as f64, along_v / rows as f64);
        Self { rows, cols, lengths, closed: closed.into(), places }
    }

    /// The sample's parameters in lengths.
    fn of_sample(&self, sample: usize) -> DVec3 {
        let (i, j) = (sample / self.cols, sample % self.cols);
        let share = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        (DVec2::new(share(i, self.rows), share(j, self.cols)) * self.lengths).extend(0.0)
    }

    /// The feet in lengths; in closed directions also a turn before and after.
    fn repeated(&self) -> Vec<DVec3> {
        let turns = |closed: bool| if closed { -1..=1 } else { 0..=0 };
        let turns = turns(self.closed[0]).flat_map(|u| {
            turns(self.closed[1]).map(move |v| DVec2::new(f64::from(u), f64::from(v)))
        });
        turns
            .flat_map(|turn| self.places.iter().map(move |&place| place + turn))
            .map(|place| (place * self.lengths).extend(0.0))
            .collect()
    }

    /// The samples that are near none of the points whose feet are in the cells around: the last of
    /// each cell is asked. Most surfaces go so little beyond their points that none is left.
    fn unsupported(&self, near: impl Fn(usize, u32) -> bool) -> Vec<usize> {
        let (rows, cols) = (self.rows, self.cols);
        let steps = DVec2::new((rows - 1) as f64, (cols - 1) as f64);
        let mut last: Vec<Option<u32>> = vec![None; rows * cols];
        for (place, point) in self.places.iter().zip(0..) {
            let cell = (*place * steps).round().clamp(DVec2::ZERO, steps);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
            let cell = [cell.x as usize, cell.y as usize];
            last[cell[0] * cols + cell[1]] = Some(point);
        }
        let supported = |&sample: &usize| {
            AROUND.into_iter().any(|reach| {
                let around =
                    |at: usize, count: usize| at.saturating_sub(reach)..(at + reach + 1).min(count);
                around(sample / cols, rows)
                    .flat_map(|i| around(sample % cols, cols).map(move |j| i * cols + j))
                    .filter_map(|cell| last[cell])
                    .any(|point| near(sample, point))
            })
        };
        (0..rows * cols).filter(|sample| !supported(sample)).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::progress::Silent;

    #[test]
    fn long_ways_excuse_no_place_far_outside() {
        let square: Vec<DVec3> =
            (0..100).map(|i| DVec3::new(f64::from(i / 10), f64::from(i % 10), 0.0) / 9.0).collect();
        let seen = |beyond: f64, wanted: f64| {
            let size = 1.0 + 2.0 * beyond;
            let place = |i: i32| f64::from(i) / 5.0 * size - beyond;
            let net = (0..36).map(|i| DVec3::new(place(i / 6), place(i % 6), 0.0));
            let surface = NurbsSurface::clamped(net.collect(), (6, 6), 1).unwrap();
            let uv: Vec<DVec2> = square.iter().map(|p| (p.truncate() + beyond) / size).collect();
            let samples = Samples::of(&surface, &mut Silent).unwrap();
            runaways(&samples, &square, &uv, (false, false), (OUTSIDE, wanted)).len()
        };
        // Three tenths of the diagonal are 0.42.
        assert_eq!(seen(0.2, 0.0), 0);
        assert!(seen(0.5, 0.0) > 0);
        assert_eq!(seen(0.5, 4.0), 0);
    }

    #[test]
    fn what_lies_outside_is_told_by_the_nearest_place_of_the_hull() {
        // Far from both ends of a rod, and near the hull between them, or beside it.
        let rod: Vec<DVec3> = [0.0, 9.0].map(|x| DVec3::X * x).to_vec();
        let beside = DVec3::new(4.0, 2.0, 0.0);
        assert!(outside(&rod, beside, rod[0], 1.99));
        assert!(!outside(&rod, beside, rod[0], 2.01));
        // The nearest point is the last of a plate's edge that leads on, askew.
        let plate = [DVec3::ZERO, DVec3::new(9.0, 3.0, 0.0), DVec3::new(9.0, -3.0, 0.0)];
        let off = DVec3::new(1.0, 2.0, 1.0);
        let distance = DVec3::new(0.5, -1.5, -1.0).length();
        assert!(outside(&plate, off, plate[0], 0.99 * distance));
        assert!(!outside(&plate, off, plate[0], 1.01 * distance));
    }

    #[test]
    fn a_chord_is_no_longer_however_points_are_turned() {
        let cube = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let corners: Vec<DVec3> = (0..8).map(cube).collect();
        assert!((chord(&corners) - 3.0_f64.sqrt()).abs() < 1e-12);
        let turn = DMat3::from_rotation_x(0.6) * DMat3::from_rotation_z(0.5);
        let turned: Vec<DVec3> = corners.iter().map(|&corner| turn * corner).collect();
        assert!((chord(&turned) - 3.0_f64.sqrt()).abs() < 1e-12);
        assert!(Bounds::of(&turned).diagonal() > 2.0);
    }
}
