//! Cleaning of a cloud: duplicates are merged, gross outliers are left out.
//!
//! Copies of a point would be its nearest neighbors, and outliers would join separate layers. An
//! outlier is farther from its neighbors than these are from theirs, and off the surface that they
//! form. Sparse regions, scan lines, contour lines and ship tracks therefore stay.

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::POINTS_PER_REPORT;
use super::kd_tree::{KdTree, Neighbor};
use super::plane::Plane;
use super::settings::CleanSettings;
use crate::error::Result;
use crate::numeric::{index, median, quantile};
use crate::progress::{Observer, Progress, Stage, report};
use crate::worker_pool;

const SETTINGS: CleanSettings = CleanSettings::STANDARD;

/// The result of cleaning for one point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Fate {
    /// The point is used.
    #[default]
    Kept,
    /// The point lies at a kept point, which stands for both.
    Duplicate,
    /// The point lies far from any surface that its neighbors may form.
    Outlier,
}

impl Fate {
    /// The fate's name, as Python spells it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Duplicate => "duplicate",
            Self::Outlier => "outlier",
        }
    }
}

/// The result of [`clean`].
#[derive(Clone, Debug, PartialEq)]
pub struct Cleaning {
    /// The fate of each point. Duplicates of an outlier are outliers.
    pub fates: Vec<Fate>,
    /// Indices of the points that were kept, ascending.
    pub kept: Vec<u32>,
    /// How many points each kept point stands for; empty if there are no duplicates.
    pub multiplicity: Vec<u32>,
    /// Each duplicate with the kept point that stands for it, ascending.
    pub merged: Vec<(u32, u32)>,
    /// Median spacing of the kept points, in the points' unit.
    pub spacing: f64,
}

impl Cleaning {
    /// The number of points with this fate.
    #[must_use]
    pub fn count(&self, fate: Fate) -> usize {
        self.fates.iter().filter(|&&own| own == fate).count()
    }
}

/// Finds duplicates and gross outliers among points that have passed [`check`](super::check).
///
/// The spacing at a point is the distance to one of its nearest neighbors. A point is a duplicate
/// if an earlier one lies within a tiny share of the typical spacing. There are three kinds of
/// outliers:
///
/// - One has a larger spacing than its surroundings and lies steeply above their plane.
/// - One has a far larger spacing than usual and fills a volume with its neighbors.
/// - One has a spacing of several radii of the cloud. In a small cloud, only these are outliers.
///
/// O(n log n); needs about 60 bytes a point.
///
/// ```
/// use neurbs::{DVec3, cloud::{Fate, clean}, progress::Silent};
/// let grid = |i: u32| DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0);
/// let mut points: Vec<DVec3> = (0..400).map(grid).collect();
/// points.push(DVec3::new(9.0, 9.0, 8.0));
/// points.push(points[7]);
/// let cleaning = clean(&points, &mut Silent)?;
/// assert_eq!(cleaning.fates[400..], [Fate::Outlier, Fate::Duplicate]);
/// assert_eq!((cleaning.kept.len(), cleaning.multiplicity[7]), (400, 2));
/// assert_eq!(cleaning.merged, [(401, 7)]);
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn clean(points: &[DVec3], observer: &mut dyn Observer) -> Result<Cleaning> {
    worker_pool::run_observed(points.len(), observer, |observer| cleaned(points, observer))
}

fn cleaned(points: &[DVec3], observer: &mut dyn Observer) -> Result<Cleaning> {
    let mut fates = vec![Fate::Kept; points.len()];
    let mut keepers: Vec<u32> = (0..).take(points.len()).collect();
    let mut spacings = Spacings::of(points, &fates, observer)?;
    // Many copies of a point hide the spacing of distinct points, so merging is repeated.
    while merge(&spacings, &mut fates, &mut keepers) {
        spacings = Spacings::of(points, &fates, observer)?;
    }
    for _ in 0..SETTINGS.max_rounds {
        let outliers = spacings.outliers(&fates, observer)?;
        if outliers.is_empty() {
            break;
        }
        for index in outliers {
            fates[index as usize] = Fate::Outlier;
        }
        spacings = Spacings::of(points, &fates, observer)?;
    }
    let mut merged = Vec::new();
    for duplicate in (0..points.len()).filter(|&i| fates[i] == Fate::Duplicate) {
        let mut keeper = keepers[duplicate];
        while keepers[keeper as usize] != keeper {
            keeper = keepers[keeper as usize];
        }
        merged.push((index(duplicate), keeper));
    }
    let mut counts = vec![1; points.len()];
    for &(duplicate, keeper) in &merged {
        counts[keeper as usize] += 1;
        if fates[keeper as usize] == Fate::Outlier {
            fates[duplicate as usize] = Fate::Outlier;
        }
    }
    merged.retain(|&(duplicate, _)| fates[duplicate as usize] == Fate::Duplicate);
    let kept = indices(&fates);
    let multiplicity = kept.iter().map(|&index| counts[index as usize]);
    let multiplicity = if merged.is_empty() { vec![] } else { multiplicity.collect() };
    Ok(Cleaning { fates, kept, multiplicity, merged, spacing: spacings.typical })
}

/// Marks points near an earlier one as its duplicates. Returns whether there were any.
fn merge(spacings: &Spacings<'_>, fates: &mut [Fate], keepers: &mut [u32]) -> bool {
    let same = SETTINGS.max_duplicate_distance * spacings.typical;
    let (tree, mut any) = (&spacings.tree, false);
    for own in (0..tree.points().len()).filter(|&i| spacings.nearest[i] <= same) {
        if fates[own] != Fate::Kept {
            continue;
        }
        for other in tree.within(tree.points()[own], same) {
            let other = other as usize;
            if other != own && fates[other] == Fate::Kept {
                (fates[other], keepers[other]) = (Fate::Duplicate, index(own));
                any = true;
            }
        }
    }
    any
}

/// Indices of the kept points, ascending.
fn indices(fates: &[Fate]) -> Vec<u32> {
    (0..).zip(fates).filter(|(_, fate)| **fate == Fate::Kept).map(|(index, _)| index).collect()
}

/// Spacings of the kept points; infinite at others.
struct Spacings<'a> {
    tree: KdTree<'a>,
    /// Distance to the nearest neighbor.
    nearest: Vec<f64>,
    /// Distance to the neighbor whose rank the settings give.
    each: Vec<f64>,
    /// Median of the finite ones.
    typical: f64,
}

impl<'a> Spacings<'a> {
    fn of(points: &'a [DVec3], fates: &[Fate], observer: &mut dyn Observer) -> Result<Self> {
        let kept = indices(fates);
        // In a small cloud, the rank is at most half of the other points.
        let rank = SETTINGS.spacing_rank.min(kept.len().saturating_sub(1) / 2).max(1);
        let tree = KdTree::of_subset(points, kept, observer)?;
        let pairs = tree.map(observer, |index, found| {
            tree.nearest_to(index, rank, found);
            let distances = [found.first(), found.last()];
            Some(distances.map(|near| near.map_or(f64::INFINITY, Neighbor::distance)))
        })?;
        let of =
            |k: usize| pairs.iter().map(move |pair| pair.map_or(f64::INFINITY, |pair| pair[k]));
        let (nearest, each) = (of(0).collect(), of(1).collect());
        let typical = median(of(1).filter(|spacing| spacing.is_finite()));
        Ok(Self { tree, nearest, each, typical })
    }

    /// Indices of the outliers among the kept points.
    fn outliers(&self, fates: &[Fate], observer: &mut dyn Observer) -> Result<Vec<u32>> {
        let (points, kept) = (self.tree.points(), indices(fates));
        let radius = radius(points, &kept);
        let wide =
            |&index: &u32| self.each[index as usize] > SETTINGS.min_suspect_spacing * self.typical;
        let suspects: Vec<u32> = kept.iter().copied().filter(wide).collect();
        let mut outliers = Vec::new();
        for batch in suspects.chunks(POINTS_PER_REPORT) {
            report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, fates.len()))?;
            let is_outlier = |&&index: &&u32| {
                self.each[index as usize] > SETTINGS.max_isolation * radius
                    || kept.len() > SETTINGS.k_neighbors && self.is_off(index)
            };
            outliers.par_extend(batch.par_iter().filter(is_outlier));
        }
        Ok(outliers)
    }

    /// Whether a point is off the surface of its surroundings, or fills a volume with its
    /// neighbors.
    fn is_off(&self, index: u32) -> bool {
        let (points, mut found) = (self.tree.points(), Vec::new());
        self.tree.nearest_to(index, SETTINGS.k_neighbors, &mut found);
        let (own, spacing) = (points[index as usize], self.each[index as usize]);
        let around = found.iter().map(|near| points[near.index as usize]);
        let nearest = around.clone().take(SETTINGS.k_volume_neighbors);
        if spacing > SETTINGS.min_sparse_spacing * self.typical
            && Plane::of(nearest.chain([own])).is_thick()
        {
            return true;
        }
        let usual = median(found.iter().map(|near| self.each[near.index as usize]));
        let plane = Plane::of(around);
        let height = plane.height(own).abs();
        // Sparse parts of a surface are less steep, or their surroundings bend as much.
        spacing > SETTINGS.min_local_spacing * usual
            && height > SETTINGS.min_slope * spacing
            && height > SETTINGS.min_height * plane.deviations[2]
    }
}

/// Radius about the median of each coordinate that includes most of the kept points.
fn radius(points: &[DVec3], kept: &[u32]) -> f64 {
    let kept = kept.iter().map(|&index| points[index as usize]);
    let center = [0, 1, 2].map(|axis| median(kept.clone().map(|point| point[axis])));
    quantile(kept.map(|point| point.distance(DVec3::from_array(center))), SETTINGS.radius_share)
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::super::test_points::{cube, hill, random, square, tube};
    use super::*;
    use crate::progress::Silent;

    fn cleaned(points: &[DVec3]) -> Cleaning {
        clean(points, &mut Silent).unwrap()
    }

    fn kept(points: &[DVec3]) -> usize {
        cleaned(points).kept.len()
    }

    #[test]
    fn sparse_parts_of_surfaces_are_kept() {
        let wave = |p: DVec3| DVec3::new(p.x, p.y, 0.3 * (3.0 * p.x).sin() * (2.0 * p.y).cos());
        for seed in 0..6 {
            let dense = square(1500, 2 * seed).into_iter().map(|p| p * DVec3::new(0.3, 1.0, 0.0));
            let sparse = square(30, 2 * seed + 1).into_iter();
            let sparse = sparse.map(|p| DVec3::new(0.3 + 0.7 * p.x, p.y, 0.0));
            assert_eq!(kept(&dense.chain(sparse).map(wave).collect::<Vec<_>>()), 1530);
        }
        // Density falls a hundredfold from left to right.
        let fall = |a: f64| -(1.0 - a * 0.99).ln() / 100.0_f64.ln();
        let varying = square(5000, 1).into_iter().map(|p| hill(DVec3::new(fall(p.x), p.y, 0.0)));
        assert_eq!(kept(&varying.collect::<Vec<_>>()), 5000);
    }

    #[test]
    fn scan_lines_and_grids_are_kept() {
        // The lines are twenty spacings apart.
        let lines = |jitter: f64| -> Vec<DVec3> {
            let point = |i: u32| {
                let noise = [0, 1].map(|salt| jitter * (random(i, salt) - 0.5));
                let place = DVec3::new(f64::from(i / 400) / 25.0, f64::from(i % 400) / 500.0, 0.0);
                hill(place + DVec3::new(noise[0], noise[1], 0.0)) + DVec3::Z * noise[0]
            };
            (0..10_000).map(point).collect()
        };
        for jitter in [0.0, 0.002, 0.01] {
            assert_eq!(kept(&lines(jitter)), 10_000);
        }
        let grid = |i: u32| DVec3::new(f64::from(i % 30), f64::from(i / 30), 0.0);
        assert_eq!(kept(&(0..900).map(grid).collect::<Vec<_>>()), 900);
    }

    #[test]
    fn points_far_from_the_surface_are_outliers() {
        for (surface, percent) in [(hill as fn(DVec3) -> DVec3, 5), (tube, 10), (hill, 20)] {
            let good: Vec<DVec3> = square(3000, 5).into_iter().map(surface).collect();
            let bounds = Bounds::of(&good);
            let place = |p: DVec3| bounds.center() + 1.4 * (p - 0.5) * (bounds.max - bounds.min);
            let bad: Vec<DVec3> = cube(30 * percent, 7).into_iter().map(place).collect();
            let found = cleaned(&[good.clone(), bad.clone()].concat());
            let (of_good, of_bad) = found.fates.split_at(3000);
            let lost = of_good.iter().filter(|fate| **fate != Fate::Kept).count();
            assert!(lost <= 3, "{lost}");
            let tree = KdTree::new(&good);
            let distance = 3.0 * bounds.diagonal() / 3000_f64.sqrt();
            let is_far = |p: &DVec3| tree.nearest(*p, 1)[0].distance() > distance;
            let far: Vec<Fate> =
                bad.iter().zip(of_bad).filter(|(p, _)| is_far(p)).map(|(_, fate)| *fate).collect();
            let left = far.iter().filter(|fate| **fate == Fate::Kept).count();
            assert!(left * 10 < far.len(), "{left} of {}", far.len());
        }
    }

    #[test]
    fn groups_of_far_points_in_corners_are_outliers() {
        let point = |k: u32| {
            let (i, j) = (f64::from(k / 9), f64::from(k % 9));
            let is_spike = (i - 4.0).abs() + (j - 4.0).abs() >= 7.0;
            let z = if is_spike { 130.0 + 0.1 * ((i + 2.0 * j) % 5.0) } else { 0.05 * i * j / 8.0 };
            DVec3::new(10.0 * i, 10.0 * j, z)
        };
        assert_eq!(kept(&(0..81).map(point).collect::<Vec<_>>()), 69);
    }

    #[test]
    fn copies_are_merged_into_the_first() {
        let grid = |i: u32| hill(DVec3::new(f64::from(i % 20), f64::from(i / 20 % 10), 0.0) / 20.0);
        let points: Vec<DVec3> = (0..600).map(grid).collect();
        let shaken = points.iter().enumerate().map(|(i, &p)| p + DVec3::splat(1e-9 * i as f64));
        for points in [points.clone(), shaken.collect()] {
            let cleaning = cleaned(&points);
            assert_eq!(cleaning.kept, (0..200).collect::<Vec<_>>());
            assert_eq!(cleaning.multiplicity, [3; 200]);
            assert_eq!(cleaning.count(Fate::Duplicate), 400);
            assert_eq!(cleaning.merged, (200..600).map(|i| (i, i % 200)).collect::<Vec<_>>());
        }
    }

    #[test]
    fn in_a_small_cloud_only_far_points_are_outliers() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 2.0)];
        assert_eq!(kept(&corners), 4);
        let mut few = square(12, 3);
        assert_eq!(kept(&few), 12);
        few.push(DVec3::X * 40.0);
        assert_eq!(cleaned(&few).fates[12], Fate::Outlier);
    }
}
