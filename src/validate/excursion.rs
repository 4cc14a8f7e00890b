//! How far a surface leaves the neighbourhood of its points.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use super::samples::Samples;
use crate::cloud::{KdTree, Neighbor};
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// The neighbour whose distance is the spacing at a point.
const NEIGHBOR: usize = 4;

/// One of so many points has a larger spacing than the one that is taken for the largest.
const LARGER: usize = 20;

/// The neighbourhood of the points reaches this many of the largest spacings.
const REACH: f64 = 3.0;

/// How far a surface leaves the neighbourhood of its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excursion {
    /// Distance up to which a place is near a point: three times the 95th percentile of the points'
    /// distance to their fourth nearest.
    pub reach: f64,
    /// Share of the surface's area that is farther from every point. Over holes it is no harm.
    pub share: f64,
    /// Largest distance from the surface to its nearest point, in the points' unit.
    pub distance: f64,
    /// Where that is.
    pub place: DVec3,
}

impl fmt::Display for Excursion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.place;
        write!(
            f,
            "{:.1} % of the surface are farther than {:.4} from every point, at most {:.4}, at \
             ({x:.6}, {y:.6}, {z:.6})",
            100.0 * self.share,
            self.reach,
            self.distance
        )
    }
}

/// Measures how far the surface leaves the neighbourhood of the points, at four samples to a span.
///
/// ```
/// use neurbs::{DVec3, NurbsSurface, validate::excursion, progress::Silent};
/// let points: Vec<DVec3> =
///     (0..100).map(|i| DVec3::new(f64::from(i % 10), f64::from(i / 10), 0.0)).collect();
/// let net = vec![DVec3::ZERO, DVec3::Y * 9.0, DVec3::X * 18.0, DVec3::new(18.0, 9.0, 0.0)];
/// let twice_as_long = NurbsSurface::clamped(net, (2, 2), 1)?;
/// let found = excursion(&twice_as_long, &points, &mut Silent)?;
/// // From the middle of its far side to the nearest of two points beside that.
/// assert!((found.distance - 9.0_f64.hypot(0.5)).abs() < 1e-12);
/// assert!(found.share > 0.2);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn excursion(
    surface: &NurbsSurface,
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<Excursion> {
    let samples = Samples::of(surface, observer)?;
    let tree = KdTree::new(points);
    let mut spacings = tree.map(observer, |index, found| {
        tree.nearest_to(index, NEIGHBOR, found);
        found.last().map_or(0.0, Neighbor::distance)
    })?;
    spacings.sort_by(f64::total_cmp);
    let largest = spacings.len().saturating_sub(1 + spacings.len() / LARGER);
    let reach = REACH * spacings.get(largest).unwrap_or(&0.0);
    let distance = |place: &DVec3| tree.nearest(*place, 1).first().map_or(0.0, Neighbor::distance);
    let distances: Vec<f64> = samples.places.par_iter().map(distance).collect();
    let (mut area, mut away, mut farthest) = (0.0, 0.0, 0);
    for (sample, distance) in distances.iter().enumerate() {
        let own = samples.area(sample);
        area += own;
        away += if *distance > reach { own } else { 0.0 };
        farthest = if *distance > distances[farthest] { sample } else { farthest };
    }
    let share = if area > 0.0 { away / area } else { 0.0 };
    Ok(Excursion { reach, share, distance: distances[farthest], place: samples.places[farthest] })
}
