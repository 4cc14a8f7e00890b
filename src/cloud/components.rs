//! The connected components of a cloud.

use glam::DVec3;
use rayon::prelude::*;

use super::kd_tree::{KdTree, Neighbor};
use super::plane::Plane;
use super::sampling::{even_sample, items_at};
use super::set_links::NO_SET;
use super::settings::ComponentSettings;
use crate::disjoint_sets::DisjointSets;
use crate::error::Result;
use crate::numeric::whole;
use crate::progress::Observer;
use crate::worker_pool;

const SETTINGS: ComponentSettings = ComponentSettings::STANDARD;

/// The connected components of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    /// For each point the number of its component, the largest being 0. [`Components::STRAY`] if it
    /// belongs to none.
    pub labels: Vec<u32>,
    /// The number of points of each component, descending.
    pub sizes: Vec<usize>,
    /// The smallest distance between two components, in the points' unit; infinite if there is one.
    pub gap: f64,
}

impl Components {
    /// The label of a point in a group too small for a component.
    pub const STRAY: u32 = NO_SET;

    /// Indices of the points of a component, ascending.
    #[must_use]
    pub fn indices(&self, component: u32) -> Vec<u32> {
        let own = (0..).zip(&self.labels).filter(|(_, label)| **label == component);
        own.map(|(index, _)| index).collect()
    }
}

/// Finds the connected components of a cloud.
///
/// Each point is joined to the points of its neighborhood. Neighborhoods grow until they are
/// two-dimensional: neither a line, as along a scan line, nor thick, as where noise exceeds the
/// spacing. Scan lines, ship tracks and clouds of any density are therefore one component, and
/// layers three spacings apart are several. O(n log n).
///
/// ```
/// use neurbs::{DVec3, cloud::components, progress::Silent};
/// let grid = |i: u32| DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0);
/// let points: Vec<DVec3> =
///     (0..400).map(grid).chain((0..100).map(|i| grid(i) + DVec3::Z * 9.0)).collect();
/// let found = components(&points, &mut Silent)?;
/// assert_eq!((found.sizes.as_slice(), found.gap), (&[400, 100][..], 9.0));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn components(points: &[DVec3], observer: &mut dyn Observer) -> Result<Components> {
    worker_pool::run_observed(points.len(), observer, |observer| found(points, observer))
}

fn found(points: &[DVec3], observer: &mut dyn Observer) -> Result<Components> {
    let sample = items_at(points, &even_sample(points, SETTINGS.max_sample));
    let tree = KdTree::over(&sample, observer)?;
    let roots = grow(&tree, observer)?;
    let (labels, sizes) = numbered(&roots);
    let gap = gap(&sample, &labels, sizes.len());
    if sample.len() == points.len() {
        return Ok(Components { labels, sizes, gap });
    }
    let labels = KdTree::over(points, observer)?.map(observer, |index, found| {
        tree.nearest_where(points[index as usize], 1, f64::INFINITY, found, |_| true);
        found.first().map_or(NO_SET, |near| labels[near.index as usize])
    })?;
    let mut sizes = vec![0; sizes.len()];
    labels.iter().filter(|label| **label != NO_SET).for_each(|&label| sizes[label as usize] += 1);
    Ok(Components { labels, sizes, gap })
}

/// The smallest distance between two components.
fn gap(points: &[DVec3], labels: &[u32], count: usize) -> f64 {
    let mut members = vec![Vec::new(); count];
    let labeled = labels.iter().zip(points).filter(|(label, _)| **label != NO_SET);
    labeled.for_each(|(&label, &point)| members[label as usize].push(point));
    let nearest = |component: usize| {
        let (tree, mut found) = (KdTree::new(&members[component]), Vec::new());
        let mut nearest = f64::INFINITY;
        for &place in members[..component].iter().flatten() {
            tree.nearest_where(place, 1, nearest, &mut found, |_| true);
            nearest = found.first().map_or(nearest, Neighbor::distance);
        }
        nearest
    };
    (0..count).into_par_iter().map(nearest).reduce(|| f64::INFINITY, f64::min)
}

/// Joins points to their neighborhoods. Returns for each point the first one of its component.
///
/// In each round, neighbors are taken from a sparser sample, so that neighborhoods grow. A part is
/// closed once most of its points have a two-dimensional neighborhood. Two closed parts are not
/// joined, because neighborhoods of boundary points may reach into another layer.
fn grow(tree: &KdTree<'_>, observer: &mut dyn Observer) -> Result<Vec<u32>> {
    let points = tree.points();
    let mut parts = DisjointSets::new(points.len());
    let pairs = tree.map(observer, |own, found| {
        tree.nearest_to(own, SETTINGS.k_nearest, found);
        found.iter().map(|near| near.index).collect::<Vec<u32>>()
    })?;
    (0..).zip(&pairs).for_each(|(own, near)| near.iter().for_each(|&to| parts.unite(own, to)));
    let mut is_closed = vec![false; points.len()];
    let mut is_flat = vec![false; points.len()];
    let mut growing: Vec<u32> = (0..).take(points.len()).collect();
    let mut few = growing.clone();
    while few.len() > 2 * SETTINGS.k_neighbors && !growing.is_empty() {
        let found = flat_neighborhoods(points, &few, &growing, observer)?;
        for (&own, around) in growing.iter().zip(found) {
            is_flat[own as usize] = !around.is_empty();
            for other in around {
                let ends = [own, other].map(|end| parts.root(end));
                let closed = ends.map(|end| is_closed[end as usize]);
                if closed != [true; 2] {
                    parts.unite(own, other);
                    is_closed[parts.root(own) as usize] = closed != [false; 2];
                }
            }
        }
        let roots = parts.roots();
        // For each part, the numbers of points with a flat neighborhood and of others.
        let mut counts = vec![[0; 2]; points.len()];
        for (&root, &flat) in roots.iter().zip(&is_flat) {
            counts[root as usize][usize::from(!flat)] += 1;
        }
        // A few neighboring points may be flat by chance.
        is_closed =
            counts.iter().map(|[flat, others]| *flat > others + SETTINGS.k_neighbors).collect();
        growing.retain(|&at| !is_flat[at as usize] && !is_closed[roots[at as usize] as usize]);
        let kept = even_sample(&items_at(points, &few), few.len() / 2);
        few = kept.into_iter().map(|at| few[at as usize]).collect();
    }
    // Points without a flat neighborhood are joined to their nearest neighbors.
    let mut found = Vec::new();
    for own in growing {
        tree.nearest_to(own, SETTINGS.k_neighbors, &mut found);
        for near in &found {
            parts.unite(own, near.index);
        }
    }
    Ok(parts.roots())
}

/// Finds for each growing point its neighbors in the sparse sample `few`.
///
/// The list is empty unless these neighbors are flat and most of them have flat neighborhoods, too.
fn flat_neighborhoods(
    points: &[DVec3],
    few: &[u32],
    growing: &[u32],
    observer: &mut dyn Observer,
) -> Result<Vec<Vec<u32>>> {
    let tree = KdTree::of_subset(points, few.to_vec(), observer)?;
    let look = |own: u32, found: &mut Vec<Neighbor>| {
        tree.nearest_to(own, SETTINGS.k_neighbors, found);
        let around: Vec<u32> = found.iter().map(|near| near.index).collect();
        let plane = Plane::of(around.iter().chain([&own]).map(|&at| points[at as usize]));
        (around, plane.is_flat())
    };
    // Growing points outside the sample have no neighbors yet.
    let of_few = tree.map(observer, look)?;
    let others = growing.iter().copied().filter(|&own| of_few[own as usize].0.is_empty());
    let of_others = KdTree::of_subset(points, others.collect(), observer)?.map(observer, look)?;
    let flat = |&own: &u32| {
        let known = &of_few[own as usize];
        let (around, is_flat) = if known.0.is_empty() { &of_others[own as usize] } else { known };
        let flat = around.iter().filter(|&&near| of_few[near as usize].1).count();
        if *is_flat && 2 * flat > around.len() { around.clone() } else { Vec::new() }
    };
    Ok(growing.par_iter().map(flat).collect())
}

/// Numbers the components by size, the earlier one first among equals. Returns labels and sizes.
fn numbered(roots: &[u32]) -> (Vec<u32>, Vec<usize>) {
    let mut counts = vec![0; roots.len()];
    for &root in roots {
        counts[root as usize] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0);
    let fewest = whole(SETTINGS.min_share * roots.len() as f64);
    let fewest = fewest.max(SETTINGS.min_points).min(most);
    let mut order: Vec<usize> =
        (0..roots.len()).filter(|&root| counts[root] >= fewest.max(1)).collect();
    order.sort_by_key(|&root| std::cmp::Reverse(counts[root]));
    let mut numbers = vec![NO_SET; roots.len()];
    (0..).zip(&order).for_each(|(number, &root)| numbers[root] = number);
    let labels = roots.iter().map(|&root| numbers[root as usize]).collect();
    (labels, order.iter().map(|&root| counts[root]).collect())
}

#[cfg(test)]
mod tests {
    use super::super::test_points::{cube, hill, random, square};
    use super::*;
    use crate::progress::Silent;

    fn sizes(points: &[DVec3]) -> Vec<usize> {
        components(points, &mut Silent).unwrap().sizes
    }

    fn above(points: &[DVec3], height: f64) -> Vec<DVec3> {
        points.iter().map(|&point| point + height * DVec3::Z).collect()
    }

    /// A hilly sheet with noise of this size in its heights.
    fn noisy(count: u32, noise: f64, seed: u32) -> Vec<DVec3> {
        let height = |i: u32| (0..6).map(|k| random(i, 40 + 6 * seed + k) - 0.5).sum::<f64>();
        let points = (0..).zip(square(count, seed));
        points.map(|(i, point)| hill(point) + noise * height(i) * DVec3::Z).collect()
    }

    /// Scan lines on a hilly sheet: points, points a line, lines a unit width, and noise.
    fn lines(points: u32, per_line: u32, width: f64, jitter: f64) -> Vec<DVec3> {
        let point = |i: u32| {
            let noise = [0, 1, 2].map(|axis| jitter * (random(i, axis) - 0.5));
            let x = f64::from(i / per_line) / width;
            hill(DVec3::new(x, random(i, 3), 0.0)) + DVec3::from_array(noise)
        };
        (0..points).map(point).collect()
    }

    #[test]
    fn a_sheet_of_varying_density_is_one_component() {
        let fall = |a: f64| -(1.0 - a * 0.99).ln() / 100.0_f64.ln();
        let points = square(5000, 3).into_iter().map(|p| hill(DVec3::new(fall(p.x), p.y, 0.0)));
        assert_eq!(sizes(&points.collect::<Vec<_>>()), [5000]);
        let dense = square(1500, 1).into_iter().map(|p| p * DVec3::new(0.3, 1.0, 0.0));
        let sparse = square(30, 2).into_iter().map(|p| DVec3::new(0.3 + 0.7 * p.x, p.y, 0.0));
        assert_eq!(sizes(&dense.chain(sparse).map(hill).collect::<Vec<_>>()), [1530]);
        assert_eq!(sizes(&square(7, 3)), [7]);
    }

    #[test]
    fn layers_three_spacings_apart_are_components() {
        for (count, gap) in [(300, 5.0), (3000, 3.0)] {
            let gap = gap / f64::from(count).sqrt();
            let layer = |k: u32| above(&noisy(count, 0.0, k), gap * f64::from(k));
            let layers: Vec<DVec3> = (0..3).flat_map(layer).collect();
            assert_eq!(sizes(&layers), [count as usize; 3]);
        }
    }

    #[test]
    fn noisy_sheets_are_neither_split_nor_joined() {
        for noise in [0.02, 0.04, 0.1] {
            let sheets = [0.0, 20.0 * noise].map(|z| above(&noisy(3000, noise, 5), z));
            assert_eq!(sizes(&sheets[0]), [3000]);
            assert_eq!(sizes(&sheets.concat()), [3000; 2]);
        }
        let cubes = [cube(1500, 1), above(&cube(1500, 2), 4.0)];
        assert_eq!(sizes(&cubes.concat()), [1500; 2]);
    }

    #[test]
    fn scan_lines_are_one_component_with_and_without_noise() {
        for jitter in [0.0, 0.005, 0.02] {
            let sheet = lines(5000, 200, 25.0, jitter);
            assert_eq!(sizes(&[sheet.clone(), above(&sheet, 1.0)].concat()), [5000; 2]);
            assert_eq!(sizes(&lines(12_000, 1000, 12.0, jitter)), [12_000]);
        }
    }

    #[test]
    fn a_sheet_with_a_crease_is_one_component() {
        let folded = |p: DVec3| {
            let along = 6.0 * p.x;
            DVec3::new(along.min(3.0), p.y, (along - 3.0).max(0.0))
        };
        assert_eq!(sizes(&square(4000, 1).into_iter().map(folded).collect::<Vec<_>>()), [4000]);
    }

    #[test]
    fn a_large_cloud_is_labeled_by_its_sample() {
        let sheet = square(30_000, 1);
        let found = components(&[sheet.clone(), above(&sheet, 0.4)].concat(), &mut Silent).unwrap();
        assert_eq!(found.sizes, [30_000, 30_000]);
        assert!((found.gap - 0.4).abs() < 1e-3);
        assert_eq!(found.indices(found.labels[0]).len(), 30_000);
    }
}
