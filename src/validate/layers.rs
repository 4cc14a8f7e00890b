//! Two layers of points that lie closer together than the points of each.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use crate::cloud::{Bounds, KdTree, Neighbor, Plane, even_sample};
use crate::error::Result;
use crate::progress::{self, Observer, Progress, Stage};

/// Points among which the layers are looked for, evenly over space.
const MOST: usize = 20_000;

/// Places that are looked at, evenly over space: so many tell a share of them to a hundredth.
const PLACES: usize = 400;

/// Points around each that show the layers there: those that are closer than the spacing, and those that
/// are up to three times as far apart, which may be told from one another.
const AROUND: usize = 16;
const AROUND_MORE: usize = 32;

/// Share of the points that show layers twice as far apart, and how many are enough.
const FEWER: usize = 4;
const ENOUGH: usize = 200;

/// Share of the distance of such layers by which a surface that follows them is off the points at most.
const FOLLOWED: f64 = 0.1;

/// Points that a layer has of these at least.
const FEWEST: usize = 5;

/// The gap between layers, as a multiple of the deviation of each. Of 16 normally scattered heights
/// one in thousands shows such a gap.
const CLEAR: f64 = 4.0;

/// Share of the layers' distance that points are off a bent sheet, from which on they are no rows of a
/// grid on one; 16 points of two layers are off by 0.4 of it.
const BENT: f64 = 0.2;

/// Share of the square of a polynomial's values that is rounding.
const ROUNDING: f64 = 1e-12;

/// Share of the points around which there are two layers, from which on it is no accident.
const NO_ACCIDENT: f64 = 0.02;

/// Two layers of points that lie closer together than the points of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleLayer {
    /// Share of the points around which both are seen.
    pub share: f64,
    /// Their distance, at the median, in the points' unit.
    pub separation: f64,
    /// A place where both are.
    pub place: DVec3,
}

impl fmt::Display for DoubleLayer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.place;
        write!(
            f,
            "two layers {:.4} apart, closer than the spacing of their points: check the fold near \
             ({x:.6}, {y:.6}, {z:.6})",
            self.separation
        )
    }
}

/// Looks for places where the points lie in two layers closer together than their spacing: a fold
/// pressed flat, both sides of a plate, two scans that do not match. No map can tell such layers
/// apart.
///
/// ```
/// use neurbs::{DVec3, validate::double_layer, progress::Silent};
/// let grid = |z: f64| (0..400).map(move |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), z));
/// let points: Vec<DVec3> = grid(0.0).chain(grid(0.4)).collect();
/// let found = double_layer(&points, &mut Silent)?.unwrap();
/// assert!((found.separation - 0.4).abs() < 0.02);
/// assert!(double_layer(&points[..400], &mut Silent)?.is_none());
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn double_layer(points: &[DVec3], observer: &mut dyn Observer) -> Result<Option<DoubleLayer>> {
    among(points, (MOST, AROUND), observer)
}

/// What is to be said of two layers, if points lie in such, that a map may tell apart, but that a surface
/// which is so far off the points, by root mean square, does not follow.
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub(crate) fn not_followed(
    points: &[DVec3],
    off: f64,
    observer: &mut dyn Observer,
) -> Result<Option<String>> {
    let spacing = Bounds::of(points).diagonal() / (points.len() as f64).sqrt();
    let mut count = points.len().min(MOST);
    while off > FOLLOWED * spacing && count >= ENOUGH {
        let found = among(points, (count, AROUND_MORE), observer)?;
        if let Some(DoubleLayer { separation, place, .. }) = found
            && off > FOLLOWED * separation
        {
            let DVec3 { x, y, z } = place;
            return Ok(Some(format!(
                "two layers {separation:.4} apart, between which the surface passes near \
                 ({x:.6}, {y:.6}, {z:.6}): leave one of them out"
            )));
        }
        count /= FEWER;
    }
    Ok(None)
}

/// Two layers that show themselves in a sample of so many points, among so many neighbours of some.
fn among(
    points: &[DVec3],
    (count, around): (usize, usize),
    observer: &mut dyn Observer,
) -> Result<Option<DoubleLayer>> {
    let points = even_sample(points, count);
    let tree = KdTree::new(&points);
    let places = even_sample(&points, PLACES);
    progress::report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, points.len()))?;
    let gap = |found: &mut Vec<Neighbor>, place: &DVec3| {
        tree.nearest_where(*place, 1 + around, f64::INFINITY, found, |_| true);
        // The first is the point itself.
        let beside = found.iter().skip(1).map(|n| points[n.index as usize]);
        let plane = Plane::of(beside.clone());
        let local: Vec<DVec3> = beside.map(|point| plane.local(point)).collect();
        let mut heights: Vec<f64> = local.iter().map(|point| point.z).collect();
        heights.sort_by(f64::total_cmp);
        separation(&heights).filter(|apart| off_bent_sheet(&local) > BENT * apart)
    };
    let gaps: Vec<Option<f64>> = places.par_iter().map_init(Vec::new, gap).collect();
    let double: Vec<usize> = (0..gaps.len()).filter(|&i| gaps[i].is_some()).collect();
    let share = double.len() as f64 / places.len() as f64;
    let mut separations: Vec<f64> = gaps.iter().copied().flatten().collect();
    separations.sort_by(f64::total_cmp);
    let place = double.get(double.len() / 2).map(|&index| places[index]);
    let found = place.map(|place| DoubleLayer {
        share,
        separation: separations[separations.len() / 2],
        place,
    });
    Ok(found.filter(|_| share >= NO_ACCIDENT))
}

/// Root of the mean square distance from the bent sheet nearest to points along z: a polynomial of
/// degree 2 in x and y.
fn off_bent_sheet(points: &[DVec3]) -> f64 {
    let mut heights: Vec<f64> = points.iter().map(|p| p.z).collect();
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let polynomials: [fn(&DVec3) -> f64; 6] =
        [|_| 1.0, |p| p.x, |p| p.y, |p| p.x * p.x, |p| p.x * p.y, |p| p.y * p.y];
    for polynomial in polynomials {
        // Gram and Schmidt: each has nothing in common with those before.
        let mut shape: Vec<f64> = points.iter().map(polynomial).collect();
        let whole = dot(&shape, &shape);
        for before in &shapes {
            let common = dot(&shape, before);
            shape.iter_mut().zip(before).for_each(|(own, before)| *own -= common * before);
        }
        let own = dot(&shape, &shape);
        if own > ROUNDING * whole {
            for value in &mut shape {
                *value /= own.sqrt();
            }
            let share = dot(&heights, &shape);
            heights.iter_mut().zip(&shape).for_each(|(height, shape)| *height -= share * shape);
            shapes.push(shape);
        }
    }
    (dot(&heights, &heights) / points.len() as f64).sqrt()
}

/// The distance between the two groups that ascending heights fall into, if they do.
fn separation(heights: &[f64]) -> Option<f64> {
    let last = heights.len().checked_sub(FEWEST)?;
    let widest = (FEWEST..=last)
        .max_by(|&a, &b| (heights[a] - heights[a - 1]).total_cmp(&(heights[b] - heights[b - 1])))?;
    let (low, high) = heights.split_at(widest);
    let mean = |heights: &[f64]| heights.iter().sum::<f64>() / heights.len() as f64;
    let deviation = |heights: &[f64]| {
        let mean = mean(heights);
        let squared: f64 = heights.iter().map(|height| (height - mean).powi(2)).sum();
        (squared / heights.len() as f64).sqrt()
    };
    let gap = heights[widest] - heights[widest - 1];
    let clear = gap > CLEAR * deviation(low).max(deviation(high)) && gap > 0.0;
    clear.then(|| mean(high) - mean(low))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn rows_of_a_grid_that_is_bent_are_no_layers() {
        let rolled = |radius: f64| {
            (0..3000).map(move |i| {
                let (along, y) = (f64::from(i / 50) / 50.0, f64::from(i % 50) / 50.0);
                let (sin, cos) = (along / radius).sin_cos();
                DVec3::new(radius * cos, y, radius * sin)
            })
        };
        for radius in [0.3, 0.5, 1.0, 2.0] {
            let points: Vec<DVec3> = rolled(radius).collect();
            assert_eq!(double_layer(&points, &mut Silent).unwrap(), None, "{radius}");
        }
        let twice: Vec<DVec3> = rolled(2.0).chain(rolled(2.005)).collect();
        let found = double_layer(&twice, &mut Silent).unwrap().unwrap();
        assert!((found.separation - 0.005).abs() < 5e-4, "{}", found.separation);
        assert!(found.share > 0.5, "{}", found.share);
    }

    #[test]
    fn noise_is_no_second_layer() {
        let noisy: Vec<DVec3> = (0..5000)
            .map(f64::from)
            .map(|i| {
                let z: f64 = (1..9).map(|k| (i * 0.618 * f64::from(k * k)).fract() - 0.5).sum();
                DVec3::new((i * 0.754_877_666).fract(), (i * 0.569_840_29).fract(), 0.02 * z)
            })
            .collect();
        assert!(double_layer(&noisy, &mut Silent).unwrap().is_none());
    }
}
