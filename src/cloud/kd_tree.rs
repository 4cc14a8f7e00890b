//! Nearest-neighbor search: a balanced k-d tree.
//!
//! J. Bentley, Multidimensional binary search trees used for associative searching (1975). The
//! distance to a box is updated while descending: S. Arya and D. Mount, Algorithms for fast vector
//! quantization (1993).

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::{Bounds, POINTS_PER_REPORT};
use crate::error::Result;
use crate::progress::{Observer, Progress, Silent, Stage, report};
use crate::worker_pool::install;

/// Points in a leaf, at most; leaves are searched one by one.
const LEAF_POINTS: usize = 10;

/// Points of a parallel task; in the tree's order they are neighbors.
const POINTS_PER_TASK: usize = 512;

/// A point found by a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbor {
    /// The square of its distance, in the points' unit.
    pub distance_squared: f64,
    /// Its index among the points.
    pub index: u32,
}

impl Neighbor {
    /// Its distance, in the points' unit.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance_squared.sqrt()
    }

    #[inline]
    fn is_before(&self, other: &Self) -> bool {
        let (own, others) = (self.distance_squared, other.distance_squared);
        own < others || (own == others && self.index < other.index)
    }
}

/// A search in a tree, which visits nearer boxes first.
trait Search {
    /// The square of the distance beyond which boxes are skipped.
    fn reach(&self) -> f64;

    /// Takes a visited point into account.
    fn visit_point(&mut self, near: Neighbor);
}

/// The search for the nearest points that pass a filter.
struct Nearest<'a, W> {
    count: usize,
    wanted: W,
    /// The points found so far, nearest first.
    found: &'a mut Vec<Neighbor>,
    /// Points that are not before it are ignored.
    worst: Neighbor,
}

impl<W: Fn(u32) -> bool> Search for Nearest<'_, W> {
    #[inline]
    fn reach(&self) -> f64 {
        // No point is nearer than 0, so many copies of a point end the search.
        let worst = self.worst.distance_squared;
        if worst == 0.0 { -1.0 } else { worst }
    }

    #[inline]
    fn visit_point(&mut self, near: Neighbor) {
        if !near.is_before(&self.worst) || !(self.wanted)(near.index) {
            return;
        }
        if self.found.len() == self.count {
            self.found.pop();
        }
        let place = self.found.partition_point(|found| found.is_before(&near));
        self.found.insert(place, near);
        if self.found.len() == self.count {
            self.worst = self.found[self.count - 1];
        }
    }
}

/// The search for all points within a distance.
struct Within {
    limit: f64,
    found: Vec<u32>,
}

impl Search for Within {
    fn reach(&self) -> f64 {
        self.limit
    }

    fn visit_point(&mut self, near: Neighbor) {
        if near.distance_squared <= self.limit {
            self.found.push(near.index);
        }
    }
}

/// Finds the points nearest to a place, exactly.
///
/// Among equally near points the lowest index comes first. If more points lie at the very place
/// than are searched for, any of them are found. The tree borrows the points and takes about 30
/// bytes for each. Building takes O(n log n), a search for k points O(k log n) at bounded density.
///
/// ```
/// use neurbs::{DVec3, cloud::KdTree};
/// let points: Vec<DVec3> = (0..100).map(|i| DVec3::X * f64::from(i)).collect();
/// let tree = KdTree::new(&points);
/// let found = tree.nearest(DVec3::new(7.2, 0.0, 0.0), 2);
/// assert_eq!(found.iter().map(|near| near.index).collect::<Vec<_>>(), [7, 8]);
/// ```
pub struct KdTree<'a> {
    points: &'a [DVec3],
    /// The points' indices; each node of the tree halves a range of them.
    order: Vec<u32>,
    /// The points in that order, so that neighbors are near in memory.
    places: Vec<DVec3>,
    /// The nodes, breadth first: the children of node i are 2i + 1 and 2i + 2.
    divisions: Vec<Division>,
    bounds: Bounds,
}

/// The plane between the two halves of a range.
#[derive(Clone, Copy)]
struct Division {
    axis: u32,
    /// Coordinate of the first point of the upper half.
    at: f64,
}

impl<'a> KdTree<'a> {
    /// A tree over all points, which must be finite.
    #[must_use]
    pub fn new(points: &'a [DVec3]) -> Self {
        // The silent observer never stops it.
        Self::over(points, &mut Silent).unwrap_or_else(|_| Self {
            points,
            order: vec![],
            places: vec![],
            divisions: vec![],
            bounds: Bounds::of(&[]),
        })
    }

    /// A tree over all points, which must be finite.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn over(points: &'a [DVec3], observer: &mut dyn Observer) -> Result<Self> {
        let all = 0..u32::try_from(points.len()).unwrap_or(u32::MAX);
        Self::of_subset(points, all.collect(), observer)
    }

    /// A tree over the points with these indices.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn of_subset(
        points: &'a [DVec3],
        indices: Vec<u32>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let count = indices.len();
        let entry = |index: u32| Entry { place: points[index as usize], index };
        let mut entries: Vec<Entry> = install(|| indices.into_par_iter().map(entry).collect());
        let mut divisions = Vec::new();
        let bounds = box_of(&entries);
        let levels = count.div_ceil(LEAF_POINTS).next_power_of_two().trailing_zeros();
        let mut ranges: Vec<&mut [Entry]> = vec![&mut entries];
        for level in 0..levels {
            let progress =
                Progress::of_stage(Stage::Cleaning, u64::from(level), u64::from(levels), count);
            report(observer, &progress)?;
            let halves: Vec<_> = install(|| ranges.into_par_iter().map(divide).collect());
            divisions.extend(halves.iter().map(|(division, _)| *division));
            ranges = halves.into_iter().flat_map(|(_, halves)| halves).collect();
        }
        let (order, places) = entries.into_iter().map(|entry| (entry.index, entry.place)).unzip();
        Ok(Self { points, order, places, divisions, bounds })
    }

    /// All points, also those outside the tree's subset.
    #[must_use]
    pub fn points(&self) -> &'a [DVec3] {
        self.points
    }

    /// Indices of the tree's points. Neighbors in space are near one another in this order.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The `count` points nearest to a place, nearest first; fewer if the tree has fewer.
    #[must_use]
    pub fn nearest(&self, place: DVec3, count: usize) -> Vec<Neighbor> {
        let mut found = Vec::with_capacity(count);
        self.nearest_where(place, count, f64::INFINITY, &mut found, |_| true);
        found
    }

    /// As [`KdTree::nearest`], among the points that pass the filter `wanted` and are nearer than
    /// `limit`. Writes to `found`.
    pub fn nearest_where(
        &self,
        place: DVec3,
        count: usize,
        limit: f64,
        found: &mut Vec<Neighbor>,
        wanted: impl Fn(u32) -> bool,
    ) {
        found.clear();
        if count == 0 || self.order.is_empty() {
            return;
        }
        let worst = Neighbor { distance_squared: limit * limit, index: u32::MAX };
        self.visit(place, &mut Nearest { count, wanted, found, worst });
    }

    /// The `count` points nearest to the point with this index, without itself. Writes to `found`.
    pub fn nearest_to(&self, index: u32, count: usize, found: &mut Vec<Neighbor>) {
        let place = self.points[index as usize];
        self.nearest_where(place, count, f64::INFINITY, found, |other| other != index);
    }

    /// Indices of the points at most `radius` from a place, ascending.
    #[must_use]
    pub fn within(&self, place: DVec3, radius: f64) -> Vec<u32> {
        let mut search = Within { limit: radius * radius, found: Vec::new() };
        self.visit(place, &mut search);
        search.found.sort_unstable();
        search.found
    }

    /// Calls `ask` for each of the tree's points in parallel, and returns the results by index.
    ///
    /// Points outside the tree get the default. `ask` gets a vector as scratch space.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn map<T: Clone + Default + Send>(
        &self,
        observer: &mut dyn Observer,
        ask: impl Fn(u32, &mut Vec<Neighbor>) -> T + Sync,
    ) -> Result<Vec<T>> {
        let mut answers = vec![T::default(); self.points.len()];
        let total = self.order.len();
        for (batch, indices) in self.order.chunks(POINTS_PER_REPORT).enumerate() {
            let done = (batch * POINTS_PER_REPORT) as u64;
            report(observer, &Progress::of_stage(Stage::Cleaning, done, total as u64, total))?;
            let answered = indices.par_chunks(POINTS_PER_TASK).flat_map_iter(|indices| {
                let mut found = Vec::new();
                indices.iter().map(|&index| ask(index, &mut found)).collect::<Vec<T>>()
            });
            let answered: Vec<T> = install(|| answered.collect());
            for (&index, answer) in indices.iter().zip(answered) {
                answers[index as usize] = answer;
            }
        }
        Ok(answers)
    }

    /// The distance from each place to the nearest of the tree's points; infinite without points.
    ///
    /// ```
    /// use neurbs::{DVec3, cloud::KdTree, progress::Silent};
    /// let tree_points = [DVec3::ZERO, DVec3::X];
    /// let places = [DVec3::new(0.0, 0.0, 2.0), DVec3::new(4.0, 0.0, 0.0)];
    /// let found = KdTree::new(&tree_points).distances(&places, &mut Silent)?;
    /// assert_eq!(found, [2.0, 3.0]);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`crate::Error::Interrupted`] if the observer stops it.
    pub fn distances(&self, places: &[DVec3], observer: &mut dyn Observer) -> Result<Vec<f64>> {
        let mut distances = Vec::with_capacity(places.len());
        for batch in places.chunks(POINTS_PER_REPORT) {
            let (done, total) = (distances.len() as u64, places.len());
            report(observer, &Progress::of_stage(Stage::Measuring, done, total as u64, total))?;
            let measured = batch.par_chunks(POINTS_PER_TASK).flat_map_iter(|places| {
                let mut found = Vec::with_capacity(1);
                let mut distance = |&place: &DVec3| {
                    self.nearest_where(place, 1, f64::INFINITY, &mut found, |_| true);
                    found.first().map_or(f64::INFINITY, Neighbor::distance)
                };
                places.iter().map(&mut distance).collect::<Vec<f64>>()
            });
            distances.extend(install(|| measured.collect::<Vec<f64>>()));
        }
        Ok(distances)
    }

    /// Visits the points of the whole tree, nearer boxes first.
    fn visit(&self, place: DVec3, search: &mut impl Search) {
        let offset = (self.bounds.min - place).max(place - self.bounds.max).max(DVec3::ZERO);
        self.descend(0, (0, self.order.len()), place, offset, search);
    }

    /// Visits the points of a node with this range. `offset` is the distance of the place from the
    /// node's box along each axis.
    fn descend(
        &self,
        node: usize,
        (from, to): (usize, usize),
        place: DVec3,
        offset: DVec3,
        search: &mut impl Search,
    ) {
        let Some(division) = self.divisions.get(node) else {
            for (&index, other) in self.order[from..to].iter().zip(&self.places[from..to]) {
                search.visit_point(Neighbor {
                    distance_squared: other.distance_squared(place),
                    index,
                });
            }
            return;
        };
        let (axis, middle) = (division.axis as usize, from + (to - from) / 2);
        let beyond = place[axis] - division.at;
        let (lower, upper) = ((2 * node + 1, (from, middle)), (2 * node + 2, (middle, to)));
        let (near, far) = if beyond < 0.0 { (lower, upper) } else { (upper, lower) };
        self.descend(near.0, near.1, place, offset, search);
        let mut across = offset;
        across[axis] = beyond.abs();
        if across.length_squared() <= search.reach() {
            self.descend(far.0, far.1, place, across, search);
        }
    }
}

/// A point during the construction of the tree.
#[derive(Clone, Copy)]
struct Entry {
    place: DVec3,
    index: u32,
}

/// Halves a range at the median along the longest side of its box.
fn divide(range: &mut [Entry]) -> (Division, [&mut [Entry]; 2]) {
    let bounds = box_of(range);
    let size = bounds.max - bounds.min;
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let middle = range.len() / 2;
    range.select_nth_unstable_by(middle, |a, b| {
        a.place[axis].total_cmp(&b.place[axis]).then(a.index.cmp(&b.index))
    });
    let at = range[middle].place[axis];
    let (lower, upper) = range.split_at_mut(middle);
    #[expect(clippy::cast_possible_truncation, reason = "0, 1 or 2")]
    let axis = axis as u32;
    (Division { axis, at }, [lower, upper])
}

/// The bounding box of entries.
fn box_of(entries: &[Entry]) -> Bounds {
    let empty = || Bounds { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
    let grow = |bounds: Bounds, entry: &Entry| Bounds {
        min: bounds.min.min(entry.place),
        max: bounds.max.max(entry.place),
    };
    let join = |a: Bounds, b: Bounds| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) };
    let boxes = entries.par_iter().with_min_len(1 << 14).fold(empty, grow);
    install(|| boxes.reduce(empty, join))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(points: &[DVec3], place: DVec3, count: usize) -> Vec<Neighbor> {
        let mut all: Vec<Neighbor> = (0..)
            .zip(points)
            .map(|(index, point)| Neighbor {
                distance_squared: point.distance_squared(place),
                index,
            })
            .collect();
        all.sort_by(|a, b| {
            a.distance_squared.total_cmp(&b.distance_squared).then(a.index.cmp(&b.index))
        });
        all.truncate(count);
        all
    }

    proptest! {
        #[test]
        fn the_tree_and_brute_force_find_the_same_points(
            cells in prop::collection::vec((0_u8..12, 0_u8..12, 0_u8..3), 1..300),
            count in 1_usize..12,
            place in (0.0..12.0, 0.0..12.0, 0.0..3.0),
        ) {
            // Few distinct coordinates, so that ties and duplicates are frequent.
            let place = DVec3::from(place);
            let points: Vec<DVec3> = cells
                .iter()
                .map(|&(x, y, z)| DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
                .collect();
            let tree = KdTree::new(&points);
            prop_assert_eq!(tree.nearest(place, count), brute(&points, place, count));
            let near = |near: &Neighbor| near.distance_squared <= 4.0;
            let mut wanted: Vec<u32> = brute(&points, place, points.len())
                .iter().filter(|n| near(n)).map(|n| n.index).collect();
            wanted.sort_unstable();
            prop_assert_eq!(tree.within(place, 2.0), wanted);
        }
    }

    #[test]
    fn a_search_among_many_copies_of_one_point_ends_early() {
        let points = vec![DVec3::ONE; 200_000];
        let tree = KdTree::new(&points);
        let all = tree.map(&mut Silent, |index, found| {
            tree.nearest_where(points[index as usize], 8, f64::INFINITY, found, |_| true);
            found.len()
        });
        assert!(all.unwrap().iter().all(|&found| found == 8));
    }

    #[test]
    fn an_empty_tree_finds_no_points() {
        assert!(KdTree::new(&[]).nearest(DVec3::ZERO, 3).is_empty());
        assert!(KdTree::new(&[DVec3::X]).nearest(DVec3::ZERO, 0).is_empty());
    }
}
