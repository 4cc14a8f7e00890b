//! Heights of a surface over the plane of x and y: the z of the place above or below (x, y).
//!
//! The place is a common zero of two polynomials: the distances in x and in y, multiplied by w.
//! A tree of rectangles finds the patches that may contain it. Newton's method finds the place on a
//! patch whose map to the plane is shown to be one-to-one. Other patches are halved; their parts
//! shrink to the folds and poles of the map.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use super::bezier_patch::BezierPatch;
use super::control_net::bounds;
use super::parameter_checks::check_length;
use super::plane_map::{PlaneMap, rectangle};
use super::plane_tree::{PlaneTree, Rectangle};
use super::surface::NurbsSurface;
use super::work_blocks::{MAX_POINTS_PER_TASK, for_timed_blocks, interrupt_check};
use crate::error::Result;
use crate::progress::{Observer, Silent};
use crate::worker_pool;

/// Halvings of a patch that are kept for later searches.
const KEPT_HALVINGS: usize = 10;

/// Halvings of a part during a search. At a regular place fewer reach the rounding of x and y.
const MAX_HALVINGS: usize = 120;

/// Rounding error of coordinates, as a fraction of the largest: places that much outside count as
/// on the border.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Heights are the same if they differ by less than this fraction of the surface's size: those of
/// two patches on their common side, or of all parameters of a pole.
const SAME_HEIGHT: f64 = 1e-9;

/// A part that is as small as the accuracy in x and y is a wall if it is higher than this many
/// times √(accuracy · size). Where a smooth surface becomes vertical, at a fold or at the border of
/// a dome, its parts are lower.
const MAX_RISE: f64 = 10.0;

/// A surface prepared for its heights over the plane of x and y.
///
/// The surface need not be a height field everywhere: where it has no height or several, the result
/// is NaN. A search divides the patches that it visits, and keeps the parts for later searches.
///
/// ```
/// use neurbs::{DVec3, nurbs::{HeightSearch, NurbsSurface}};
/// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 1.0)];
/// let saddle = HeightSearch::new(&NurbsSurface::clamped(net, (2, 2), 1)?)?;
/// assert_eq!(saddle.z(0.5, 0.25), 0.125);
/// assert!(saddle.z(2.0, 0.0).is_nan());
/// # Ok::<(), neurbs::Error>(())
/// ```
#[derive(Debug)]
pub struct HeightSearch {
    /// The origin of the patches' coordinates, where rounding is smallest.
    center: DVec3,
    patches: Vec<BezierPatch>,
    /// Tree over the indices of the patches.
    tree: PlaneTree<usize>,
    /// The parts of each patch, made on the first visit.
    parts: Vec<OnceLock<Parts>>,
    /// Distance in x and y below which a place counts as on the surface.
    accuracy: f64,
    /// Difference below which heights are the same.
    same: f64,
    /// Height of a part as small as the accuracy from which on it is a wall.
    max_rise: f64,
}

/// The parts of a patch.
#[derive(Debug)]
enum Parts {
    /// The patch itself.
    Whole(PlaneMap),
    Divided(PlaneTree<Part>),
}

/// A part of a patch, with its map if that is one-to-one.
#[derive(Debug)]
struct Part {
    map: Option<PlaneMap>,
    patch: BezierPatch,
}

impl HeightSearch {
    /// Prepares a surface: O(patches).
    ///
    /// # Errors
    ///
    /// [`Error::Net`](crate::Error::Net) if the surface is too large for its numbers.
    pub fn new(surface: &NurbsSurface) -> Result<Self> {
        Self::observed(surface, &mut Silent)
    }

    /// Prepares a surface and reports to an observer, which can stop it; for large nets.
    ///
    /// # Errors
    ///
    /// As [`HeightSearch::new`]; [`Error::Interrupted`](crate::Error::Interrupted) if the observer
    /// stops it.
    pub fn observed(surface: &NurbsSurface, observer: &mut dyn Observer) -> Result<Self> {
        let (low, high) = surface.net_box();
        let center = low.midpoint(high);
        let centered = surface.map_control_points(|point| point - center)?;
        let (patches, _) = BezierPatch::of(&centered, &mut interrupt_check(observer))?;
        let largest = low.truncate().abs().max(high.truncate().abs()).max_element();
        let accuracy = ROUNDING * largest;
        let rectangles = patches.iter().map(|patch| rectangle(patch, accuracy)).zip(0..);
        let tree = PlaneTree::new(rectangles.collect());
        let parts = patches.iter().map(|_| OnceLock::new()).collect();
        let same = SAME_HEIGHT * surface.size();
        let max_rise = MAX_RISE * (accuracy * surface.size()).sqrt();
        Ok(Self { center, patches, tree, parts, accuracy, same, max_rise })
    }

    /// Returns the height of the surface at (x, y), borders included.
    ///
    /// It is NaN outside, where the surface has several heights, and for x or y that are not finite.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{HeightSearch, NurbsSurface}, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 5.0)?;
    /// let dome = sphere.sub_surface((0.0, 1.0), (0.5, 1.0), &mut Silent)?;
    /// assert!((HeightSearch::new(&dome)?.z(3.0, 0.0) - 4.0).abs() < 1e-14);
    /// // The sphere has two heights.
    /// assert!(HeightSearch::new(&sphere)?.z(3.0, 0.0).is_nan());
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn z(&self, x: f64, y: f64) -> f64 {
        let place = DVec2::new(x, y) - self.center.truncate();
        let mut heights = Heights { low: f64::INFINITY, high: f64::NEG_INFINITY, same: self.same };
        for &index in self.tree.at(place) {
            let patch = &self.patches[index];
            match self.parts[index].get_or_init(|| self.parts_of(patch)) {
                Parts::Whole(map) => heights.add(map.height(patch, place, self.accuracy)),
                Parts::Divided(tree) => {
                    for part in tree.at(place) {
                        self.add_heights(part, place, MAX_HALVINGS, &mut heights);
                    }
                }
            }
            if heights.are_several() {
                break;
            }
        }
        heights.only() + self.center.z
    }

    /// Finds the heights at many places, in parallel.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{HeightSearch, NurbsSurface}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, 2.0))?;
    /// let mut z = [0.0; 2];
    /// let search = HeightSearch::new(&plane)?;
    /// search.heights(&[0.5, 0.0], &[0.25, 1.0], &mut z, &mut Silent)?;
    /// assert_eq!(z, [0.5, 2.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the lengths of `x`, `y` and `z` differ,
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn heights(
        &self,
        x: &[f64],
        y: &[f64],
        z: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<()> {
        check_length(y.len(), x.len())?;
        check_length(z.len(), x.len())?;
        for_timed_blocks(x.len(), observer, |from, to| {
            let tasks = x[from..to].iter().zip(&y[from..to]).zip(&mut z[from..to]);
            let share = (to - from) / (4 * worker_pool::num_threads());
            let share = share.min(MAX_POINTS_PER_TASK);
            worker_pool::for_each_task(tasks, share, |(): &mut (), ((x, y), z)| {
                *z = self.z(*x, *y);
            });
        })
    }

    fn parts_of(&self, patch: &BezierPatch) -> Parts {
        if let Some(map) = PlaneMap::of(patch, self.accuracy) {
            return Parts::Whole(map);
        }
        let mut parts = vec![];
        self.divide(patch.clone(), KEPT_HALVINGS, &mut parts);
        Parts::Divided(PlaneTree::new(parts))
    }

    /// Halves a part until its map is one-to-one.
    fn divide(&self, patch: BezierPatch, halvings: usize, parts: &mut Vec<(Rectangle, Part)>) {
        let map = PlaneMap::of(&patch, self.accuracy);
        if map.is_some() || halvings == 0 {
            parts.push((rectangle(&patch, self.accuracy), Part { map, patch }));
            return;
        }
        for half in halves(&patch) {
            self.divide(half, halvings - 1, parts);
        }
    }

    /// Adds the heights of a part at a place. Where its map is not one-to-one, the part is halved. A
    /// part that is as small as the accuracy has the height of its nearest corner, unless it is a
    /// wall.
    fn add_heights(&self, part: &Part, place: DVec2, halvings: usize, heights: &mut Heights) {
        let Part { map, patch } = part;
        if let Some(map) = map {
            return heights.add(map.height(patch, place, self.accuracy));
        }
        let [low, high] = rectangle(patch, self.accuracy);
        let inside = low.cmple(place).all() && place.cmple(high).all();
        if !inside || heights.are_several() {
            return;
        }
        if (high - low).max_element() <= 4.0 * self.accuracy || halvings == 0 {
            return heights.add_small(patch, place, self.max_rise);
        }
        for patch in halves(patch) {
            let map = PlaneMap::of(&patch, self.accuracy);
            self.add_heights(&Part { map, patch }, place, halvings - 1, heights);
        }
    }
}

/// The heights found at a place.
struct Heights {
    low: f64,
    high: f64,
    /// Difference below which heights are the same.
    same: f64,
}

impl Heights {
    fn add(&mut self, height: Option<f64>) {
        if let Some(height) = height {
            (self.low, self.high) = (self.low.min(height), self.high.max(height));
        }
    }

    /// Adds the height of a part that is as small as the accuracy, or all of a wall.
    fn add_small(&mut self, patch: &BezierPatch, place: DVec2, max_rise: f64) {
        let (low, high) = bounds(patch.points());
        let rise = high.z - low.z;
        if rise > max_rise {
            self.add(Some(low.z));
            return self.add(Some(high.z));
        }
        let (p, q) = patch.degrees();
        let corners = [(0, 0), (0, q), (p, 0), (p, q)].map(|(i, j)| patch.control(i, j));
        let away = |corner: &DVec3| corner.truncate().distance_squared(place);
        let nearest = corners.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        self.add(nearest.map(|corner| corner.z));
        // Small parts that meet at the place have heights that differ as much.
        self.same = self.same.max(4.0 * rise);
    }

    fn are_several(&self) -> bool {
        self.high - self.low > self.same
    }

    /// The only height; NaN if there is none or several.
    fn only(&self) -> f64 {
        let is_only = self.low <= self.high && !self.are_several();
        if is_only { f64::midpoint(self.low, self.high) } else { f64::NAN }
    }
}

/// Halves a patch along the direction in which its net is longer in the plane.
fn halves(patch: &BezierPatch) -> [BezierPatch; 2] {
    let (p, q) = patch.degrees();
    let along = |from: (usize, usize), to: (usize, usize)| {
        let [from, to] = [from, to].map(|(i, j)| patch.control(i, j).truncate());
        from.distance(to)
    };
    let u = (0..=q).map(|j| (0..p).map(|i| along((i, j), (i + 1, j))).sum::<f64>());
    let v = (0..=p).map(|i| (0..q).map(|j| along((i, j), (i, j + 1))).sum::<f64>());
    let (a, b) = if u.fold(0.0, f64::max) >= v.fold(0.0, f64::max) {
        patch.halves_u()
    } else {
        patch.halves_v()
    };
    [a, b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::KnotVector;

    /// A spline whose u and v are x and y up to a factor and offset, with these heights.
    fn height_field(side: usize, origin: DVec3, z: impl Fn(f64, f64) -> f64) -> NurbsSurface {
        let knots = KnotVector::clamped_uniform(3, side).unwrap();
        let greville: Vec<f64> = knots.as_slice()[1..]
            .windows(3)
            .take(side)
            .map(|t| t.iter().sum::<f64>() / 3.0)
            .collect();
        let net = greville.iter().flat_map(|&x| greville.iter().map(move |&y| (x, y)));
        let net = net.map(|(x, y)| origin + DVec3::new(100.0 * x, 100.0 * y, z(x, y))).collect();
        NurbsSurface::new(net, None, knots.clone(), knots).unwrap()
    }

    #[test]
    fn heights_keep_their_accuracy_in_large_coordinates() {
        let wave = |x: f64, y: f64| 20.0 * (7.0 * x).sin() * y;
        let origin = DVec3::new(500_000.0, 5_000_000.0, 100.0);
        let (near, far) = (height_field(12, DVec3::ZERO, wave), height_field(12, origin, wave));
        let [near, far] =
            [near, far].map(|surface| (HeightSearch::new(&surface).unwrap(), surface));
        for k in 0..400_u32 {
            // Eighths are exact in both.
            let (x, y) = (f64::from(k * 37 % 801) / 8.0, f64::from(k * 91 % 801) / 8.0);
            let at = near.1.point(x / 100.0, y / 100.0);
            let place = near.0.z(at.x, at.y);
            assert!((place - at.z).abs() < 1e-13, "{at} {place}");
            let offset = far.0.z(origin.x + x, origin.y + y) - origin.z - near.0.z(x, y);
            // The control points are rounded to 1e-9, on slopes below 1.5.
            assert!(offset.abs() < 1e-9, "{offset}");
        }
    }

    #[test]
    fn borders_belong_to_the_surface() {
        let surface = height_field(9, DVec3::new(3.0e5, 5.0e6, 0.0), |x, y| x - y * y);
        let search = HeightSearch::new(&surface).unwrap();
        for k in 0..=100 {
            let t = f64::from(k) / 100.0;
            for (u, v) in [(0.0, t), (1.0, t), (t, 0.0), (t, 1.0)] {
                let at = surface.point(u, v);
                assert!((search.z(at.x, at.y) - at.z).abs() < 1e-8, "{u} {v}");
            }
        }
        assert!(search.z(3.0e5 - 1e-6, 5.0e6).is_nan() && !search.z(3.0e5, 5.0e6).is_nan());
        assert!(search.z(f64::NAN, 5.0e6).is_nan() && search.z(3.0e5, f64::INFINITY).is_nan());
    }

    #[test]
    fn a_fold_has_no_height_where_it_has_two_or_none() {
        // x = 2 u - 2 u² turns back at u = 1/2, where x is 1/2.
        let net = [0.0, 1.0, 0.0].into_iter().zip([0.0, 1.0, 2.0]);
        let net = net.flat_map(|(x, z)| [DVec3::new(x, 0.0, z), DVec3::new(x, 1.0, z)]).collect();
        let fold = HeightSearch::new(&NurbsSurface::clamped(net, (3, 2), 2).unwrap()).unwrap();
        for x in [0.0, 0.3, 0.49, 0.5 - 1e-9, 0.5 + 1e-9, 0.51, 0.7] {
            assert!(fold.z(x, 0.5).is_nan(), "{x}");
        }
        // Half of it is a height field: its u is (1 - √(1 - 2 x)) / 2.
        let half = HeightSearch::new(
            &NurbsSurface::clamped(
                [(0.0, 0.0), (0.5, 0.5), (0.5, 1.0)]
                    .into_iter()
                    .flat_map(|(x, z)| [DVec3::new(x, 0.0, z), DVec3::new(x, 1.0, z)])
                    .collect(),
                (3, 2),
                2,
            )
            .unwrap(),
        )
        .unwrap();
        for x in [0.0, 0.1, 0.25, 0.49, 0.499_999] {
            let z = 1.0 - f64::sqrt(1.0 - 2.0 * x);
            assert!((half.z(x, 0.5) - z).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn walls_have_no_height_and_poles_have_one() {
        let cylinder = NurbsSurface::cylinder(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
        let cylinder = HeightSearch::new(&cylinder).unwrap();
        assert!(
            [(1.0, 0.0), (0.6, 0.8), (0.0, 0.0)].iter().all(|&(x, y)| cylinder.z(x, y).is_nan())
        );
        let cone = NurbsSurface::cone(DVec3::ZERO, 2.0 * DVec3::Z, 1.0, 0.0).unwrap();
        let cone = HeightSearch::new(&cone).unwrap();
        let sphere = NurbsSurface::sphere(DVec3::ZERO, 5.0).unwrap();
        let dome = sphere.sub_surface((0.0, 1.0), (0.5, 1.0), &mut Silent).unwrap();
        let dome = HeightSearch::new(&dome).unwrap();
        for (x, y) in [(5.0, 0.0), (-3.0, 4.0), (0.0, -5.0), (4.8, 1.4)] {
            // The surface is vertical there, so rounding of x and y has a large effect.
            assert!(dome.z(x, y).abs() < 1e-6, "{x} {y} {}", dome.z(x, y));
            assert!(dome.z(1.001 * x, 1.001 * y).is_nan());
            let z = (25.0 - (0.999_f64.powi(2) * 25.0)).sqrt();
            assert!((dome.z(0.999 * x, 0.999 * y) - z).abs() < 1e-10);
        }
        for (x, y) in [(0.0, 0.0), (1e-9, 0.0), (0.3, 0.4), (-0.6, 0.8), (0.0, -1.0)] {
            let z = 2.0 - 2.0 * f64::hypot(x, y);
            assert!((cone.z(x, y) - z).abs() < 1e-12, "{x} {y} {}", cone.z(x, y));
        }
    }
}
