//! Duplicates merged, gross outliers set aside.
//!
//! Least squares suffer from gross outliers, and neighbourhoods from both: eight copies of a point
//! are its eight nearest neighbours, and a stray point bridges two folds. What distinguishes a
//! stray point from the sparse part of a surface is that it lies neither in the plane of its
//! neighbours nor where they bend to: scan lines, contour lines, ship tracks and densities that vary
//! tenfold stay whole.

use glam::DVec3;
use rayon::prelude::*;

use super::Bounds;
use super::kd_tree::{KdTree, Neighbor};
use super::plane::Plane;
use super::quadric::Quadric;
use crate::error::Result;
use crate::progress::{Observer, Progress, Stage, report};

/// Points nearer than this share of the typical spacing are one point measured twice, or one that
/// a file format has rounded in two ways. It is far below what could carry shape.
const SAME: f32 = 1e-4;

/// Neighbours over which the spacing at a point is averaged.
const NEIGHBORS: usize = 8;

/// Neighbours whose spacings are compared with that of a point: enough to see past a handful of
/// other strays.
const AROUND: usize = 32;

/// A point may be this many times farther from its neighbours than they are from theirs, or than is
/// usual in the cloud. Poisson scatter reaches 2.
const SPARSE: f32 = 2.5;

/// Beyond this a point is on its own even if it lies in the plane of its neighbours.
const ALONE: f32 = 6.0;

/// Distance of a point from the plane of its neighbours, or of them from it, as a share of their
/// distance: curvature and noise of a surface stay below where it is sparse, points scattered in
/// space have about 0.3. The first holds near the surface, the second where all around is stray.
const OFF_PLANE: [f64; 2] = [0.15, 0.2];

/// Neighbours whose quadric shows where a sparse end of a bent surface goes on, and the distance of
/// the point and of them from it, as a share of theirs: three fifths of such ends' points stay below, of
/// strays one in fifty.
const BENT: usize = 16;
const OFF_QUADRIC: f64 = 0.15;

/// Only points this much sparser than usual are looked at more closely.
const SUSPECT: f32 = 1.5;

/// Suspects between two reports, some ten milliseconds.
const SUSPECTS_PER_REPORT: usize = 1 << 13;

/// Outliers uncover others that they had hidden; the third round finds next to none.
const ROUNDS: usize = 3;

/// What became of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Fate {
    /// It is used.
    #[default]
    Kept,
    /// It lies where another point lies, which counts for both.
    Duplicate,
    /// It lies far from all surface that its neighbours could form.
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

/// What [`clean`] found.
#[derive(Clone, Debug, PartialEq)]
pub struct Cleaning {
    /// What became of each point.
    pub fates: Vec<Fate>,
    /// Indices of the points that were kept, ascending.
    pub kept: Vec<u32>,
    /// How many points each kept one stands for; empty if all stand for themselves.
    pub multiplicity: Vec<u32>,
    /// Median of the kept points' mean distance to their 8 nearest, in the points' unit.
    pub spacing: f64,
}

impl Cleaning {
    /// How many points had this fate.
    #[must_use]
    pub fn count(&self, fate: Fate) -> usize {
        self.fates.iter().filter(|&&of_point| of_point == fate).count()
    }
}

/// Finds duplicates and gross outliers among points that have passed [`check`](super::check).
///
/// A point is a duplicate if an earlier one lies within a ten-thousandth of the typical spacing. It
/// is an outlier if it is 2.5 times as far from its 8 nearest as is usual there (or in the whole
/// cloud), off the plane that they lie in and off where they bend to, or 6 times as far in any case.
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
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn clean(points: &[DVec3], observer: &mut dyn Observer) -> Result<Cleaning> {
    let mut fates = vec![Fate::Kept; points.len()];
    let mut multiplicity = Vec::new();
    let mut spacings = Spacings::of(points, &fates, observer)?;
    // Crowds of duplicates hide how far distinct points are apart; merging them shows it.
    while merge(points, &spacings, &mut fates, &mut multiplicity) {
        drop(spacings);
        spacings = Spacings::of(points, &fates, observer)?;
    }
    for _ in 0..ROUNDS {
        let outliers = spacings.outliers(&fates, observer)?;
        if outliers.is_empty() {
            break;
        }
        for index in outliers {
            fates[index as usize] = Fate::Outlier;
        }
        spacings.look_again(&fates, observer)?;
    }
    let kept = indices(&fates);
    if !multiplicity.is_empty() {
        multiplicity = kept.iter().map(|&index| multiplicity[index as usize]).collect();
    }
    Ok(Cleaning { fates, kept, multiplicity, spacing: f64::from(spacings.typical) / spacings.unit })
}

/// Marks points near an earlier one as its duplicates, and counts them there; whether there were
/// any.
fn merge(
    points: &[DVec3],
    spacings: &Spacings<'_>,
    fates: &mut [Fate],
    multiplicity: &mut Vec<u32>,
) -> bool {
    let same = SAME * spacings.typical;
    let crowded: Vec<u32> =
        (0..).zip(&spacings.each).filter(|(_, at)| at.nearest <= same).map(|(i, _)| i).collect();
    let radius = f64::from(same) / spacings.unit;
    let mut any = false;
    for index in crowded {
        if fates[index as usize] != Fate::Kept {
            continue;
        }
        for other in spacings.tree.within(points[index as usize], radius) {
            if other != index && fates[other as usize] == Fate::Kept {
                multiplicity.resize(points.len(), 1);
                fates[other as usize] = Fate::Duplicate;
                multiplicity[index as usize] += multiplicity[other as usize];
                any = true;
            }
        }
    }
    any
}

fn indices(fates: &[Fate]) -> Vec<u32> {
    (0..).zip(fates).filter(|(_, fate)| **fate == Fate::Kept).map(|(index, _)| index).collect()
}

/// How far points are apart, as shares of the cloud's diagonal: half the memory.
struct Spacings<'a> {
    tree: KdTree<'a>,
    unit: f64,
    each: Vec<Spacing>,
    /// The median of the means.
    typical: f32,
}

/// How far a point is from its nearest ones; not finite if it has none or is not in the tree.
#[derive(Clone, Copy)]
struct Spacing {
    nearest: f32,
    /// Over the 8 nearest.
    mean: f32,
}

impl Default for Spacing {
    fn default() -> Self {
        Self { nearest: f32::INFINITY, mean: f32::INFINITY }
    }
}

impl Spacing {
    /// From the nearest of a point, in order.
    fn of(found: &[Neighbor], unit: f64) -> Self {
        let Some(nearest) = found.first() else { return Self::default() };
        let sum: f64 = found.iter().map(Neighbor::distance).sum();
        #[expect(clippy::cast_possible_truncation, reason = "seven digits of a spacing suffice")]
        let share = |length: f64| (length * unit) as f32;
        Self { nearest: share(nearest.distance()), mean: share(sum / found.len() as f64) }
    }
}

impl<'a> Spacings<'a> {
    /// Of the points that are kept.
    fn of(points: &'a [DVec3], fates: &[Fate], observer: &mut dyn Observer) -> Result<Self> {
        let tree = KdTree::of_subset(points, indices(fates), observer)?;
        let unit = Bounds::of(points).diagonal().recip();
        let each = tree.map(observer, |index, found| {
            tree.nearest_to(index, NEIGHBORS, found);
            Spacing::of(found, unit)
        })?;
        let typical = typical(&each);
        Ok(Self { tree, unit, each, typical })
    }

    /// What was known before outliers went is known of all but suspects: what has near neighbours
    /// does not miss a far one.
    fn look_again(&mut self, fates: &[Fate], observer: &mut dyn Observer) -> Result<()> {
        self.each = self.tree.map(observer, |index, found| {
            if fates[index as usize] != Fate::Kept {
                return Spacing::default();
            }
            let before = self.each[index as usize];
            if before.mean <= SUSPECT * self.typical {
                return before;
            }
            self.nearest_kept(index, NEIGHBORS, fates, found);
            Spacing::of(found, self.unit)
        })?;
        self.typical = typical(&self.each);
        Ok(())
    }

    /// The points nearest to one of them that are kept.
    fn nearest_kept(&self, index: u32, count: usize, fates: &[Fate], found: &mut Vec<Neighbor>) {
        let place = self.tree.points()[index as usize];
        let wanted = |other: u32| other != index && fates[other as usize] == Fate::Kept;
        self.tree.nearest_where(place, count, f64::INFINITY, found, wanted);
    }

    /// Points far from all surface that their neighbours could form.
    fn outliers(&self, fates: &[Fate], observer: &mut dyn Observer) -> Result<Vec<u32>> {
        let suspects: Vec<u32> = (0..)
            .zip(&self.each)
            .filter(|(_, at)| at.mean.is_finite() && at.mean > SUSPECT * self.typical)
            .map(|(index, _)| index)
            .collect();
        let mut outliers = Vec::new();
        for slab in suspects.chunks(SUSPECTS_PER_REPORT) {
            report(observer, &Progress::of_stage(Stage::Cleaning, 0, 0, fates.len()))?;
            let stray = |index: &u32| self.is_stray(*index, fates).then_some(*index);
            outliers.par_extend(slab.par_iter().filter_map(stray));
        }
        Ok(outliers)
    }

    fn is_stray(&self, index: u32, fates: &[Fate]) -> bool {
        let (points, mut found) = (self.tree.points(), Vec::new());
        self.nearest_kept(index, AROUND, fates, &mut found);
        let mut means: Vec<f32> = found.iter().map(|n| self.each[n.index as usize].mean).collect();
        let mean = self.each[index as usize].mean;
        let (beside, usual) = (mean / median(&mut means), mean / self.typical);
        if beside > ALONE {
            return true;
        }
        if beside <= SPARSE && usual <= SPARSE {
            return false;
        }
        let near = found.iter().take(NEIGHBORS);
        let plane = Plane::of(near.map(|n| points[n.index as usize]));
        let off = plane.height(points[index as usize]).abs().max(plane.deviations[2]);
        let off = off * self.unit / f64::from(mean);
        ((beside > SPARSE && off > OFF_PLANE[0]) || (usual > SPARSE && off > OFF_PLANE[1]))
            && !self.goes_on(index, &found)
    }

    /// Whether a point lies where its nearest ones bend to.
    fn goes_on(&self, index: u32, found: &[Neighbor]) -> bool {
        let points = self.tree.points();
        let near = &found[..found.len().min(BENT)];
        let near: Vec<DVec3> = near.iter().map(|n| points[n.index as usize]).collect();
        let most = OFF_QUADRIC * f64::from(self.each[index as usize].mean) / self.unit;
        near.len() == BENT
            && Quadric::of(&near, points[index as usize])
                .is_some_and(|quadric| quadric.off.max(quadric.deviation) < most)
    }
}

/// The median of the means.
fn typical(each: &[Spacing]) -> f32 {
    let mut means: Vec<f32> = each.iter().map(|at| at.mean).filter(|m| m.is_finite()).collect();
    median(&mut means)
}

/// The upper median; infinite of nothing.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return f32::INFINITY;
    }
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn kept(points: &[DVec3]) -> usize {
        clean(points, &mut Silent).unwrap().kept.len()
    }

    fn hill(x: f64, y: f64) -> DVec3 {
        DVec3::new(x, y, 0.2 * (3.0 * x).sin() * (2.0 * y).cos())
    }

    /// Two numbers in the unit interval that fill the square evenly (R2 sequence, M. Roberts).
    fn unit(i: u32) -> (f64, f64) {
        let i = f64::from(i);
        ((i * 0.754_877_666_246_692_7).fract(), (i * 0.569_840_290_998_053_2).fract())
    }

    #[test]
    fn sparse_parts_of_surfaces_stay() {
        // Density falls a hundredfold from left to right.
        let varying: Vec<DVec3> = (0..5000)
            .map(unit)
            .map(|(a, y)| hill(-(1.0 - a * 0.99).ln() / 100.0_f64.ln(), y))
            .collect();
        assert_eq!(kept(&varying), 5000);
        let lines: Vec<DVec3> = (0..10_000)
            .map(|i| hill(f64::from(i / 400) / 25.0, f64::from(i % 400) / 400.0))
            .collect();
        assert_eq!(kept(&lines), 10_000);
        // A scan beside one ten times as fine.
        let fine = (0..4000).map(unit).map(|(x, y)| hill(0.5 * x, y));
        let coarse = (0..400).map(unit).map(|(x, y)| hill(0.5 + 0.5 * x, y));
        assert_eq!(kept(&fine.chain(coarse).collect::<Vec<_>>()), 4400);
    }

    #[test]
    fn strays_in_space_go() {
        let sheet = (0..2000).map(unit).map(|(x, y)| hill(x, y));
        let stray = (0..200).map(|i| {
            let ((x, y), (z, _)) = (unit(i), unit(7 * i + 3));
            DVec3::new(x, y, 0.4 + z)
        });
        let far = [DVec3::new(40.0, 0.0, 0.0)];
        let points: Vec<DVec3> = sheet.chain(stray).chain(far).collect();
        let cleaning = clean(&points, &mut Silent).unwrap();
        assert!(cleaning.fates[..2000].iter().all(|fate| *fate == Fate::Kept));
        assert_eq!(cleaning.fates[2200], Fate::Outlier);
        assert!(cleaning.count(Fate::Outlier) > 190, "{}", cleaning.count(Fate::Outlier));
    }

    #[test]
    fn copies_count_for_the_first() {
        let points: Vec<DVec3> = (0..600)
            .map(|i| hill(f64::from(i % 20) / 20.0, f64::from(i % 200 / 20) / 10.0))
            .collect();
        let shaken = points.iter().enumerate().map(|(i, &p)| p + DVec3::splat(1e-9 * i as f64));
        for points in [points.clone(), shaken.collect()] {
            let cleaning = clean(&points, &mut Silent).unwrap();
            assert_eq!(cleaning.kept, (0..200).collect::<Vec<_>>());
            assert_eq!(cleaning.multiplicity, [3; 200]);
            assert_eq!(cleaning.count(Fate::Duplicate), 400);
        }
    }

    #[test]
    fn few_points_are_all_kept() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        assert_eq!(kept(&corners), 4);
    }
}
