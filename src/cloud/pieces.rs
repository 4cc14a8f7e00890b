//! The pieces that a cloud falls into.

use glam::DVec3;
use rayon::prelude::*;

use super::even_sample::even_sample;
use super::kd_tree::{KdTree, Neighbor};
use super::lines::{across_lines, are_ropes};
use super::neighborhoods::{NEIGHBORS, Neighborhoods};
use super::plane::Plane;
use crate::error::Result;
use crate::progress::Observer;

/// Points that are looked at; of more, as many evenly over space, the others follow the nearest.
const MOST: usize = 40_000;

/// Two points belong together when they are at most this many spacings apart: first those of the
/// denser place, so that nothing is joined by a stray point; then those of the sparser one. The
/// eighth neighbour of a random scatter is 1.5 spacings away, seldom 2.5.
const REACH: [f64; 2] = [2.5, 2.0];

/// Share of the second principal deviation of neighbours in the third below which they lie in a plane.
const FLAT: f64 = 0.3;

/// How often planes are made to agree with those near them: what lies in lines first gets one.
const SMOOTHINGS: usize = 2;

/// A way leaves the planes at its ends at more than this product of sines, 24 degrees at both: one from
/// layer to layer that is not that steep is two and a half times as long as the layers are apart.
const STEEP: f64 = 0.16;

/// Points by which it is told how far groups are apart.
const TELLING: usize = 1000;

/// Lines of points belong together when they are at most this many times as far apart as lines
/// usually are in the cloud.
const LINE_REACH: f64 = 3.0;

/// The pieces that a cloud falls into.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieces {
    /// For each point the number of its piece; 0 is the one with most points.
    pub labels: Vec<u32>,
    /// How many points each piece has, descending.
    pub sizes: Vec<usize>,
    /// The smallest distance between two pieces, in the points' unit; infinite if there is one.
    pub gap: f64,
}

impl Pieces {
    /// Indices of the points of a piece, ascending.
    #[must_use]
    pub fn indices(&self, piece: u32) -> Vec<u32> {
        (0..).zip(&self.labels).filter(|(_, label)| **label == piece).map(|(i, _)| i).collect()
    }

    /// The normal of the plane nearest to the largest piece of these points.
    pub(crate) fn normal_of_largest(&self, points: &[DVec3]) -> DVec3 {
        let of_largest = self.labels.iter().zip(points).filter(|(label, _)| **label == 0);
        Plane::of(of_largest.map(|(_, point)| *point)).normal()
    }

    /// What a user should know; `None` if all hang together.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let advice = "one surface spans the gaps between them; choose a piece, or fit each";
        Some(format!("{}: {advice}", self.told()?))
    }

    /// How many there are, how large and how far apart; `None` if all hang together.
    pub(crate) fn told(&self) -> Option<String> {
        const SHOWN: usize = 5;
        if self.sizes.len() < 2 {
            return None;
        }
        let mut sizes: Vec<String> = self.sizes.iter().take(SHOWN).map(usize::to_string).collect();
        if self.sizes.len() > SHOWN {
            sizes.push("…".into());
        }
        Some(format!(
            "the points are in {} pieces ({} points), the nearest two {:.4} apart",
            self.sizes.len(),
            sizes.join(", "),
            self.gap
        ))
    }
}

/// Finds the pieces of a cloud whose density may vary: points belong together when they are near
/// one another as compared with the spacing there, and one does not lie above the other, as layers do,
/// seen from either. Points in lines (scan lines, contour lines, ship tracks) belong to one piece
/// although the lines are far apart, also where noise makes ropes of them.
///
/// O(n log n) for n points.
///
/// ```
/// use neurbs::{DVec3, cloud::pieces, progress::Silent};
/// let grid = |i: u32| DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0);
/// let points: Vec<DVec3> =
///     (0..400).map(grid).chain((0..100).map(|i| grid(i) + DVec3::Z * 9.0)).collect();
/// let pieces = pieces(&points, &mut Silent)?;
/// assert_eq!((pieces.sizes.as_slice(), pieces.gap), (&[400, 100][..], 9.0));
/// # Ok::<(), neurbs::Error>(())
/// ```
///
/// # Errors
///
/// [`crate::Error::Interrupted`] if the observer stops it.
pub fn pieces(points: &[DVec3], observer: &mut dyn Observer) -> Result<Pieces> {
    Ok(pieces_across(points, observer)?.0)
}

/// The pieces, and of points in ropes, which are pieces at first sight, those that show that they are not.
pub(crate) fn pieces_across(
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<(Pieces, Option<Vec<DVec3>>)> {
    let looked_at = even_sample(points, MOST);
    let (mut groups, _) = Groups::joined(&looked_at, observer)?;
    let across = groups.joined_across(observer)?;
    let gap =
        groups.gaps(|_, _, _| true).iter().map(|gap| gap.length).fold(f64::INFINITY, f64::min);
    let roots = groups.roots();
    let labels = if looked_at.len() == points.len() {
        roots
    } else {
        let all = KdTree::new(points);
        all.map(observer, |index, found| {
            groups.tree.nearest_where(points[index as usize], 1, f64::INFINITY, found, |_| true);
            found.first().map_or(0, |near| roots[near.index as usize])
        })?
    };
    Ok((numbered(&labels, looked_at.len(), gap), across))
}

/// Whether points hang together, and not only because they are in ropes; and what is near each, by which that is told.
pub(crate) fn hang_together(
    points: &[DVec3],
    observer: &mut dyn Observer,
) -> Result<(bool, Neighborhoods)> {
    let (mut groups, near) = Groups::joined(points, observer)?;
    let in_ropes = groups.joined_across(observer)?.is_some();
    let roots = groups.roots();
    Ok((!in_ropes && roots.iter().all(|root| *root == roots[0]), near))
}

/// Pieces numbered by size, the earlier one first among equals.
fn numbered(labels: &[u32], most: usize, gap: f64) -> Pieces {
    let mut counts = vec![0; most];
    for &label in labels {
        counts[label as usize] += 1;
    }
    let mut order: Vec<usize> = (0..most).filter(|&label| counts[label] > 0).collect();
    order.sort_by_key(|&label| std::cmp::Reverse(counts[label]));
    let mut number = vec![0; most];
    (0..).zip(&order).for_each(|(i, &label)| number[label] = i);
    Pieces {
        labels: labels.iter().map(|&label| number[label as usize]).collect(),
        sizes: order.iter().map(|&label| counts[label]).collect(),
        gap,
    }
}

/// Points in groups that grow together (union by the lower index).
pub(super) struct Groups<'a> {
    points: &'a [DVec3],
    tree: KdTree<'a>,
    parents: Vec<u32>,
    /// Mean distance from each point to its nearest.
    spacing: Vec<f64>,
    around: Vec<Around>,
}

/// How a point's nearest lie about it.
#[derive(Clone, Copy, Default, PartialEq)]
enum Around {
    #[default]
    Anyhow,
    InLine,
    /// In a plane with this normal.
    Flat(DVec3),
}

impl Around {
    fn of(plane: &Plane) -> Self {
        let [_, second, third] = plane.deviations;
        if plane.is_line() {
            Self::InLine
        } else if third < FLAT * second {
            Self::Flat(plane.normal())
        } else {
            Self::Anyhow
        }
    }

    fn normal(self) -> Option<DVec3> {
        match self {
            Self::Flat(normal) => Some(normal),
            _ => None,
        }
    }
}

/// The shortest way from a group to another.
#[derive(Clone, Copy)]
struct Gap {
    length: f64,
    from: u32,
    to: u32,
}

impl<'a> Groups<'a> {
    /// Groups of points that hang together, and what is near each of these.
    fn joined(points: &'a [DVec3], observer: &mut dyn Observer) -> Result<(Self, Neighborhoods)> {
        let tree = KdTree::new(points);
        let near = Neighborhoods::of(&tree, NEIGHBORS, observer)?;
        let mut groups = Self::of(tree, &near);
        groups.join(REACH[1]);
        Ok((groups, near))
    }

    /// Groups of points that are near one another even by the denser one's spacing.
    fn of(tree: KdTree<'a>, Neighborhoods { near, planes }: &Neighborhoods) -> Self {
        let spacing = |near: &Vec<Neighbor>| {
            near.iter().map(Neighbor::distance).sum::<f64>() / near.len() as f64
        };
        let spacing = near.iter().map(spacing).collect();
        let around = planes.iter().map(Around::of).collect();
        let points = tree.points();
        let parents = (0..).take(points.len()).collect();
        let mut groups = Self { points, tree, parents, spacing, around };
        for _ in 0..SMOOTHINGS {
            groups.smooth(near);
        }
        for (from, near) in near.iter().enumerate() {
            for neighbor in near {
                let to = neighbor.index as usize;
                let spacing = groups.spacing[from].min(groups.spacing[to]);
                if neighbor.distance() <= REACH[0] * spacing && groups.beside(from, to) {
                    groups.unite(from, to);
                }
            }
        }
        groups
    }

    /// Joins ropes that lie beside one another on a surface, and answers with the points that show it.
    fn joined_across(&mut self, observer: &mut dyn Observer) -> Result<Option<Vec<DVec3>>> {
        if !are_ropes(self.points, &self.roots()) {
            return Ok(None);
        }
        let across = across_lines(self.points, None, Some(self.usual_distance()));
        if let Some(few) = &across {
            self.join_as(&mut Groups::joined(few, observer)?.0);
        }
        Ok(across)
    }

    /// Makes each plane the one, of those at a point and at its nearest, that agrees best with the others:
    /// layers, and rims, come near few points only.
    fn smooth(&mut self, near: &[Vec<Neighbor>]) {
        let known = &self.around;
        let smoothed = |normals: &mut Vec<DVec3>, (point, near): (usize, &Vec<Neighbor>)| {
            let near = near.iter().map(|near| near.index as usize);
            normals.clear();
            normals.extend(std::iter::once(point).chain(near).filter_map(|at| known[at].normal()));
            let agreement = |a: &DVec3| normals.iter().map(|b| a.dot(*b).abs()).sum::<f64>();
            let agreeing = normals.iter().map(|normal| (agreement(normal), *normal));
            let best = agreeing.max_by(|a, b| a.0.total_cmp(&b.0));
            let best = best.filter(|_| 2 * normals.len() > NEIGHBORS);
            best.map_or(known[point], |(_, normal)| Around::Flat(normal))
        };
        self.around = near.par_iter().enumerate().map_init(Vec::new, smoothed).collect();
    }

    /// Whether two points may lie beside one another on a surface: not where the way between them
    /// leaves the planes at both.
    fn beside(&self, a: usize, b: usize) -> bool {
        let way = self.points[b] - self.points[a];
        let [Some(at_a), Some(at_b)] = [a, b].map(|end| self.around[end].normal()) else {
            return true;
        };
        (at_a.dot(way) * at_b.dot(way)).abs() <= STEEP * way.length_squared()
    }

    /// For each point the first of its group.
    pub(super) fn roots(&mut self) -> Vec<u32> {
        (0..self.points.len()).map(|point| self.root(point)).collect()
    }

    fn root(&mut self, point: usize) -> u32 {
        let (mut point, mut parent) = (point, self.parents[point]);
        while self.parents[parent as usize] != parent {
            // Ways to the root are halved.
            parent = self.parents[parent as usize];
            self.parents[point] = parent;
            point = parent as usize;
        }
        parent
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Joins what is nearest to points of one group of others.
    fn join_as(&mut self, others: &mut Groups<'_>) {
        let roots = others.roots();
        let (mut firsts, mut found) = (vec![None; roots.len()], Vec::new());
        for (index, &point) in self.points.iter().enumerate() {
            others.tree.nearest_where(point, 1, f64::INFINITY, &mut found, |_| true);
            let first = firsts[roots[found[0].index as usize] as usize].get_or_insert(index);
            self.unite(*first, index);
        }
    }

    /// Joins groups that are near by the sparser one's spacing, or lie like lines beside lines.
    fn join(&mut self, reach: f64) {
        // Ways too long to join anything count whatever they leave: they end the search for shorter ones.
        let counts = |groups: &Self, a: usize, b: usize| {
            groups.beside(a, b) || !groups.is_near((a, b), reach)
        };
        let mut line_gap = None;
        loop {
            let gaps = self.gaps(counts);
            let of_lines = *line_gap.get_or_insert_with(|| self.usual_line_gap(&gaps));
            let joins = |gap: &&Gap| {
                let ends = (gap.from as usize, gap.to as usize);
                let line = [ends.0, ends.1].iter().any(|&end| self.around[end] == Around::InLine);
                let like_lines = line && gap.length <= LINE_REACH * of_lines;
                self.is_near(ends, reach) || like_lines && self.beside(ends.0, ends.1)
            };
            let joined: Vec<Gap> = gaps.iter().filter(joins).copied().collect();
            if joined.is_empty() {
                return;
            }
            for gap in joined {
                self.unite(gap.from as usize, gap.to as usize);
            }
        }
    }

    /// Whether two points are at most so many spacings of the sparser one apart.
    fn is_near(&self, (a, b): (usize, usize), reach: f64) -> bool {
        let spacing = self.spacing[a].max(self.spacing[b]);
        self.points[a].distance(self.points[b]) <= reach * spacing
    }

    /// The median gap between groups that end in a line there.
    fn usual_line_gap(&self, gaps: &[Gap]) -> f64 {
        let in_line = |gap: &&Gap| self.around[gap.from as usize] == Around::InLine;
        let of_lines = gaps.iter().filter(in_line);
        let mut lengths: Vec<f64> = of_lines.map(|gap| gap.length).collect();
        lengths.sort_by(f64::total_cmp);
        lengths.get(lengths.len() / 2).copied().unwrap_or(0.0)
    }

    /// The median distance of points from the nearest of another group.
    fn usual_distance(&mut self) -> f64 {
        let roots = self.roots();
        let distance = |found: &mut Vec<Neighbor>, index: usize| {
            let foreign = |to: u32| roots[to as usize] != roots[index];
            self.tree.nearest_where(self.points[index], 1, f64::INFINITY, found, foreign);
            found.first().map_or(f64::INFINITY, Neighbor::distance)
        };
        let telling = (0..roots.len()).into_par_iter().step_by(roots.len().div_ceil(TELLING));
        let mut distances: Vec<f64> = telling.map_init(Vec::new, distance).collect();
        distances.sort_by(f64::total_cmp);
        distances[distances.len() / 2]
    }

    /// From each group the shortest way to another of those that `count`, if there is one.
    fn gaps(&mut self, count: impl Fn(&Self, usize, usize) -> bool + Sync) -> Vec<Gap> {
        let roots = self.roots();
        let mut groups: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        (0..).zip(&roots).for_each(|(point, &root)| groups[root as usize].push(point));
        groups.retain(|group| !group.is_empty());
        if groups.len() < 2 {
            return Vec::new();
        }
        let seen = &*self;
        let is_most = |group: &[u32]| 2 * group.len() > seen.points.len();
        let shortest = |group: &Vec<u32>| {
            let own = roots[group[0] as usize];
            let mut best = Gap { length: f64::INFINITY, from: own, to: own };
            let mut found = Vec::new();
            let mut look = |from: u32, is_end: &dyn Fn(u32) -> bool| {
                let counts = |to: u32| is_end(to) && count(seen, from as usize, to as usize);
                let place = seen.points[from as usize];
                seen.tree.nearest_where(place, 1, best.length, &mut found, counts);
                // Ways of equal length do not replace one another.
                if let Some(near) = found.first().filter(|near| near.distance() < best.length) {
                    best = Gap { length: near.distance(), from, to: near.index };
                }
            };
            let is_own = |point: u32| roots[point as usize] == own;
            if is_most(group) {
                // The way is as long from its other end, and there are fewer to begin with.
                let others = (0..).take(roots.len()).filter(|&point| !is_own(point));
                others.for_each(|from| look(from, &is_own));
                (best.from, best.to) = (best.to, best.from);
            } else {
                for &from in group {
                    look(from, &|to| !is_own(to));
                }
            }
            best.length.is_finite().then_some(best)
        };
        groups.par_iter().filter_map(shortest).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn sizes(points: &[DVec3]) -> Vec<usize> {
        pieces(points, &mut Silent).unwrap().sizes
    }

    fn unit(i: u32) -> (f64, f64) {
        let i = f64::from(i);
        ((i * 0.754_877_666_246_692_7).fract(), (i * 0.569_840_290_998_053_2).fract())
    }

    #[test]
    fn density_that_varies_does_not_tear_a_sheet() {
        let points: Vec<DVec3> = (0..5000)
            .map(unit)
            .map(|(a, y)| DVec3::new(-(1.0 - a * 0.99).ln(), 4.0 * y, 0.0))
            .collect();
        assert_eq!(sizes(&points), [5000]);
    }

    #[test]
    fn lines_of_points_are_one_piece_and_stacked_sheets_are_not() {
        let lines = |z: f64| {
            (0..5000).map(move |i| DVec3::new(f64::from(i / 200), f64::from(i % 200) / 20.0, z))
        };
        assert_eq!(sizes(&lines(0.0).collect::<Vec<_>>()), [5000]);
        let sheet = |z: f64| (0..3000).map(unit).map(move |(x, y)| DVec3::new(x, y, z));
        let stacked: Vec<DVec3> = sheet(0.0).chain(sheet(0.3)).chain(sheet(0.5)).collect();
        let found = pieces(&stacked, &mut Silent).unwrap();
        assert_eq!(found.sizes, [3000; 3]);
        assert!((found.gap - 0.2).abs() < 1e-3);
        assert_eq!(found.indices(1)[0], 3000);
        assert!(found.warning().unwrap().contains("3 pieces (3000, 3000, 3000 points)"));
    }

    #[test]
    fn layers_three_spacings_apart_are_told_apart() {
        let spacing = 1.0 / 3000_f64.sqrt();
        let layer = |k: u32| {
            (3000 * k..3000 * (k + 1)).map(unit).map(move |(x, y)| {
                DVec3::new(
                    x,
                    y,
                    0.1 * (3.0 * x).sin() * (2.0 * y).cos() + 3.0 * spacing * f64::from(k),
                )
            })
        };
        let layers: Vec<DVec3> = (0..3).flat_map(layer).collect();
        assert_eq!(sizes(&layers), [3000; 3]);
    }

    #[test]
    fn a_sheet_with_a_crease_hangs_together() {
        let folded = |i: u32| {
            let (x, y) = unit(i);
            let along = 6.0 * x;
            if along < 3.0 { DVec3::new(along, y, 0.0) } else { DVec3::new(3.0, y, along - 3.0) }
        };
        assert_eq!(sizes(&(0..4000).map(folded).collect::<Vec<_>>()), [4000]);
    }

    #[test]
    fn a_large_cloud_is_judged_by_a_part_of_it() {
        let sheet = |z: f64| (0..30_000).map(unit).map(move |(x, y)| DVec3::new(x, y, z));
        let points: Vec<DVec3> = sheet(0.0).chain(sheet(0.4)).collect();
        assert_eq!(sizes(&points), [30_000, 30_000]);
    }
}
