//! The region of a triangulation that holds the points: without bays and holes.

use std::f64::consts::PI;

use super::adjacency::Lists;
use super::pinches::mend_pinches;
use super::places::Places;
use super::settings::RegionSettings;
use super::spacing::local_spacing;
use super::thresholds::{Thresholds, clumping, irregularity};
use super::triangulation::{NONE, Triangulation, circumradius};
use crate::error::Result;
use crate::progress::InterruptCheck;

const SETTINGS: RegionSettings = RegionSettings::STANDARD;

/// The triangles that hold points.
#[derive(Clone, Debug)]
pub(super) struct Region {
    /// Per triangle, the number of its piece, or `None` if it is left out.
    pub pieces: Vec<Option<u32>>,
    /// Per place, the local spacing.
    pub spacing: Vec<f64>,
    /// How unevenly the places scatter: 1 at random.
    pub clumping: f64,
    /// How far the places are from a lattice: 0 on one, 1 at random.
    pub irregularity: f64,
    /// Places in no triangle of the region.
    pub left_out: usize,
}

impl Region {
    /// The tightest region that leaves out few places.
    pub(super) fn of(
        places: &Places,
        triangulation: &Triangulation,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let mesh = Mesh::of(places, triangulation);
        let few = SETTINGS.left_out * places.len() as f64;
        let mut growth = SETTINGS.growth.into_iter();
        loop {
            let times = growth.next().unwrap_or(1.0);
            let thresholds = Thresholds::of_scatter(places.len()).grown(times);
            let region = mesh.region(thresholds, check_interrupt)?;
            let done = region.left_out as f64 <= few || region.islands() > 1;
            if done || growth.len() == 0 {
                return Ok(region);
            }
        }
    }

    /// The number of pieces.
    pub(super) fn islands(&self) -> usize {
        self.pieces.iter().flatten().max().map_or(0, |last| *last as usize + 1)
    }
}

/// A triangulation with what the search for the region needs.
struct Mesh<'a> {
    places: &'a Places,
    triangulation: &'a Triangulation,
    around: Lists,
    radii: Vec<f64>,
    areas: Vec<f64>,
}

impl<'a> Mesh<'a> {
    fn of(places: &'a Places, triangulation: &'a Triangulation) -> Self {
        let around = Lists::triangles(places.len(), triangulation);
        let corners = triangulation.corners.iter();
        let triangles = corners.map(|corners| corners.map(|k| places.points[k as usize]));
        let (radii, areas) = triangles
            .map(|[a, b, c]| (circumradius([a, b, c]), 0.5 * (b - a).cross(c - a).length()))
            .unzip();
        Self { places, triangulation, around, radii, areas }
    }

    /// The region with these thresholds.
    fn region(
        &self,
        scatter: Thresholds,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Region> {
        let count = self.triangulation.corners.len();
        let (mut keep, mut even) = (vec![true; count], 1.0);
        let (mut counted, mut spacing) = (keep.clone(), vec![]);
        for round in 0..SETTINGS.rounds {
            check_interrupt()?;
            spacing = local_spacing(self.triangulation, &self.around, &self.radii, &counted);
            let relative = self.relative_radii(&spacing);
            // The first round's outer triangles would look like clumps.
            if round > 0 {
                let kept = relative.iter().zip(&keep).filter(|(_, keep)| **keep);
                even = clumping(kept.map(|(radius, _)| *radius));
            }
            let thresholds = scatter.of_clumps(even);
            keep = self.kept(&relative, &spacing, thresholds);
            // Wide triangles would hide a hole that they belong to: they make the spacing larger.
            let narrow = relative.iter().zip(&keep);
            let narrow = narrow.map(|(radius, keep)| *keep && *radius <= thresholds.grow).collect();
            let before = std::mem::replace(&mut counted, narrow);
            if before == counted {
                break;
            }
        }
        let pieces = self.without_islands(&keep);
        let mut held = vec![false; self.places.len()];
        let all = self.triangulation.corners.iter().zip(&pieces);
        for (corners, _) in all.filter(|(_, piece)| piece.is_some()) {
            for place in corners {
                held[*place as usize] = true;
            }
        }
        let left_out = held.iter().filter(|held| !**held).count();
        let relative = self.relative_radii(&spacing).into_iter().zip(&pieces);
        let relative = relative.filter(|(_, piece)| piece.is_some()).map(|(radius, _)| radius);
        let irregularity = irregularity(&relative.collect::<Vec<f64>>());
        Ok(Region { pieces, spacing, clumping: even, irregularity, left_out })
    }

    /// The spacing at a triangle: the geometric mean over its corners.
    fn spacing_at(&self, t: usize, spacing: &[f64]) -> f64 {
        let [a, b, c] = self.triangulation.corners[t].map(|place| spacing[place as usize]);
        (a * b * c).cbrt()
    }

    /// Circumradii in local spacings.
    fn relative_radii(&self, spacing: &[f64]) -> Vec<f64> {
        let all = self.radii.iter().enumerate();
        all.map(|(t, radius)| radius / self.spacing_at(t, spacing)).collect()
    }

    /// Which triangles neither bays nor holes reach. `relative` are circumradii in spacings.
    fn kept(&self, relative: &[f64], spacing: &[f64], thresholds: Thresholds) -> Vec<bool> {
        let wide = |t: usize| relative[t] > thresholds.grow;
        let neighbors = &self.triangulation.neighbors;
        let hull = (0..relative.len()).filter(|t| neighbors[*t].contains(&NONE));
        let mut open = vec![false; relative.len()];
        self.flood(hull.filter(|t| wide(*t)), &mut open, wide);
        let seeds: Vec<usize> =
            (0..relative.len()).filter(|t| relative[*t] > thresholds.hole && !open[*t]).collect();
        // A sliver has a large circle without being a hole: a hole is as large as half the disc.
        let least = SETTINGS.hole_share * PI * thresholds.hole * thresholds.hole;
        let mut seen = open.clone();
        for seed in seeds {
            if seen[seed] {
                continue;
            }
            let hole = self.flood([seed].into_iter(), &mut seen, wide);
            let area = |t: &usize| self.areas[*t] / self.spacing_at(*t, spacing).powi(2);
            if hole.iter().map(area).sum::<f64>() > least {
                for t in hole {
                    open[t] = true;
                }
            }
        }
        open.into_iter().map(|open| !open).collect()
    }

    /// Marks what is reached from the seeds through allowed triangles; returns it.
    fn flood(
        &self,
        seeds: impl Iterator<Item = usize>,
        seen: &mut [bool],
        allowed: impl Fn(usize) -> bool,
    ) -> Vec<usize> {
        let mut reached: Vec<usize> = seeds.collect();
        for t in &reached {
            seen[*t] = true;
        }
        let mut next = 0;
        while next < reached.len() {
            for other in self.triangulation.neighbors[reached[next]] {
                let t = other as usize;
                if other != NONE && !seen[t] && allowed(t) {
                    seen[t] = true;
                    reached.push(t);
                }
            }
            next += 1;
        }
        reached
    }

    /// The pieces that are kept, numbered; those with few places are left out.
    fn without_islands(&self, keep: &[bool]) -> Vec<Option<u32>> {
        let mut pieces = self.connected(keep);
        let places = |piece: &Vec<usize>| {
            let corners = piece.iter().flat_map(|t| self.triangulation.corners[*t]);
            let mut corners: Vec<u32> = corners.collect();
            corners.sort_unstable();
            corners.dedup();
            corners.len()
        };
        let counts: Vec<usize> = pieces.iter().map(places).collect();
        let least = SETTINGS.island_share * counts.iter().sum::<usize>() as f64;
        let mut counts = counts.iter();
        pieces.retain(|_| counts.next().is_some_and(|count| *count as f64 >= least));
        let mut keep = vec![false; keep.len()];
        pieces.iter().flatten().for_each(|t| keep[*t] = true);
        mend_pinches(self.triangulation, &self.around, &mut keep);
        let mut numbers = vec![None; keep.len()];
        for (piece, number) in self.connected(&keep).iter().zip(0..) {
            for t in piece {
                numbers[*t] = Some(number);
            }
        }
        numbers
    }

    /// The connected pieces of what is kept.
    fn connected(&self, keep: &[bool]) -> Vec<Vec<usize>> {
        let (mut seen, mut pieces) = (vec![false; keep.len()], vec![]);
        for t in 0..keep.len() {
            if keep[t] && !seen[t] {
                pieces.push(self.flood([t].into_iter(), &mut seen, |t| keep[t]));
            }
        }
        pieces
    }
}
