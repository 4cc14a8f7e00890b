//! Error terms of a surface against its points, as numbers: torn, uncovered, misaligned, folded,
//! pinched.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cell_grid::CellGrid;
use super::settings::TermSettings;
use crate::cloud::{KdTree, Neighbor, convex_hull};
use crate::error::Result;
use crate::numeric::median;
use crate::nurbs::{NurbsSurface, Outside};
use crate::observe::Observations;
use crate::progress::Silent;

/// The error terms; 0 is best.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// Share of the links between neighbors that are far longer on the surface than in space.
    pub torn: f64,
    /// Share of the area within the points' parameters that is far from all points.
    pub uncovered: f64,
    /// Share of the covered area whose normals disagree with the local planes.
    pub misaligned: f64,
    /// Share of neighboring cells whose normals turn over.
    pub folded: f64,
    /// Shrinkage of the ends of a tube below half its circumference: 2 if both end in a point.
    pub pinched: f64,
}

/// A surface and the observed points, with their parameters on it.
pub struct Comparison<'a> {
    /// The observations.
    pub observations: &'a Observations<'a>,
    /// A tree over the larger sample by which folds are detected.
    pub tree: &'a KdTree<'a>,
    /// The surface.
    pub surface: &'a NurbsSurface,
    /// Whether u and v are closed.
    pub closed: [bool; 2],
    /// The points' parameters.
    pub uv: &'a [DVec2],
    /// Their distances from the surface.
    pub distances: &'a [f64],
}

impl Comparison<'_> {
    /// Computes all terms.
    ///
    /// # Errors
    ///
    /// Those of the surface's evaluation; parameters in the domain cause none.
    pub fn terms(&self, settings: &TermSettings) -> Result<Terms> {
        let grid = CellGrid::of(self.surface, settings.cells, &mut Silent)?;
        let inside = self.inside(&grid);
        let nearest = self.nearest(&grid);
        let area: f64 =
            grid.areas.iter().zip(&inside).filter(|(_, inside)| **inside).map(|(a, _)| a).sum();
        let usual = (area / self.uv.len() as f64).sqrt();
        let (local, mean) = (settings.max_local_gap, settings.max_mean_gap);
        let spacing = self.observations.local_spacing();
        let (mut uncovered, mut planar, mut misaligned) = (0.0, 0.0, 0.0);
        let planes = self.observations.planes();
        for cell in (0..grid.areas.len()).filter(|&cell| inside[cell]) {
            let (own, near) = (grid.areas[cell], &nearest[cell]);
            let reach = (local * spacing[near.index as usize]).max(mean * usual);
            if near.distance() > reach {
                uncovered += own;
            } else if planes.flatness[near.index as usize] < settings.max_flatness {
                planar += own;
                let cosine = grid.normals[cell].dot(planes.normals[near.index as usize]);
                misaligned += if cosine.abs() < settings.min_alignment { own } else { 0.0 };
            }
        }
        Ok(Terms {
            torn: self.torn(settings)?,
            uncovered: share(uncovered, area),
            misaligned: share(misaligned, planar),
            folded: turned_share(&grid, settings),
            pinched: self.pinched(&grid),
        })
    }

    /// Whether each cell lies within the points' parameters.
    fn inside(&self, grid: &CellGrid) -> Vec<bool> {
        let (low, high) = self
            .uv
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), uv| (l.min(*uv), h.max(*uv)));
        match self.closed {
            [false, false] => {
                let hull = convex_hull(self.uv);
                let sides = || hull.iter().zip(hull.iter().cycle().skip(1));
                let inside = |at: &DVec2| sides().all(|(a, b)| (b - a).perp_dot(*at - a) >= 0.0);
                grid.uv.iter().map(inside).collect()
            }
            closed => {
                let fits = |at: &DVec2, d: usize| closed[d] || (low[d]..=high[d]).contains(&at[d]);
                grid.uv.iter().map(|at| fits(at, 0) && fits(at, 1)).collect()
            }
        }
    }

    /// The point nearest to each cell.
    fn nearest(&self, grid: &CellGrid) -> Vec<Neighbor> {
        let tree = self.observations.tree();
        let nearest = |found: &mut Vec<Neighbor>, place: &DVec3| {
            tree.nearest_where(*place, 1, f64::INFINITY, found, |_| true);
            found[0]
        };
        grid.places.par_iter().map_init(Vec::new, nearest).collect()
    }

    /// Share of the links that are torn: their straight image in the parameters is far longer on
    /// the surface than they are in space.
    fn torn(&self, settings: &TermSettings) -> Result<f64> {
        let parts = settings.link_parts;
        let (graph, points) = (self.observations.graph(), self.observations.points());
        let least = settings.min_link * self.observations.spacing();
        let steepest = self.steepest();
        let (mut links, mut limits, mut starts) = (0_usize, Vec::new(), Vec::new());
        for from in 0..points.len() {
            for edge in graph.edges(from).iter().filter(|edge| edge.to as usize > from) {
                let to = edge.to as usize;
                let way = self.wrapped(self.uv[to] - self.uv[from]);
                let slack = self.distances[from] + self.distances[to];
                let limit = settings.max_stretch * points[from].distance(points[to]).max(least);
                let limit = limit + 2.0 * slack;
                links += 1;
                if (way.abs() * steepest).element_sum() > limit {
                    limits.push(limit);
                    starts.push((self.uv[from], way));
                }
            }
        }
        let at = |(from, way): &(DVec2, DVec2), part: usize| {
            self.inside_domain(*from + *way * (part as f64 / parts as f64))
        };
        let uv: Vec<DVec2> =
            starts.iter().flat_map(|way| (0..=parts).map(move |k| at(way, k))).collect();
        let mut places = vec![DVec3::ZERO; uv.len()];
        self.surface.evaluate(&uv, &mut places, Outside::Refuse, &mut Silent)?;
        let length =
            |way: &[DVec3]| way.windows(2).map(|ends| ends[0].distance(ends[1])).sum::<f64>();
        let torn = places.chunks(parts + 1).zip(limits).filter(|(way, limit)| length(way) > *limit);
        Ok(share(torn.count() as f64, links as f64))
    }

    /// Upper bounds of the derivatives by u and v, from the control net.
    fn steepest(&self) -> DVec2 {
        let ((rows, cols), net) = (self.surface.shape(), self.surface.control_points());
        let bound = |knots: &crate::nurbs::KnotVector, count: usize, step: usize, line: usize| {
            let (degree, values) = (knots.degree(), knots.as_slice());
            let mut most = 0.0_f64;
            for i in 0..count - 1 {
                let span = (values[i + degree + 1] - values[i + 1]) / degree as f64;
                for k in 0..rows * cols / count {
                    let first = i * step + k * line;
                    most = most.max(net[first].distance(net[first + step]) / span);
                }
            }
            most
        };
        DVec2::new(
            bound(self.surface.knots_u(), rows, cols, 1),
            bound(self.surface.knots_v(), cols, 1, cols),
        )
    }

    /// A step in the parameters, taken the short way around closed directions.
    fn wrapped(&self, way: DVec2) -> DVec2 {
        let around = |d: usize| if self.closed[d] { way[d] - way[d].round() } else { way[d] };
        DVec2::new(around(0), around(1))
    }

    /// Parameters moved into the domain: wrapped in closed directions, clamped in open ones.
    fn inside_domain(&self, uv: DVec2) -> DVec2 {
        let place =
            |d: usize| if self.closed[d] { uv[d].rem_euclid(1.0) } else { uv[d].clamp(0.0, 1.0) };
        DVec2::new(place(0), place(1))
    }

    /// Shrinkage of the ends of a tube below half its median circumference.
    fn pinched(&self, grid: &CellGrid) -> f64 {
        if self.closed != [true, false] {
            return 0.0;
        }
        let lengths = grid.line_lengths(0);
        let usual = median(lengths.iter().copied());
        let ends = [lengths[0], lengths[lengths.len() - 1]];
        ends.iter().map(|length| (1.0 - 2.0 * length / usual).max(0.0)).sum()
    }
}

/// Share of neighboring cells whose normals turn over.
fn turned_share(grid: &CellGrid, settings: &TermSettings) -> f64 {
    let (mut turned, mut count) = (0.0, 0.0);
    for [a, b] in grid.neighbors() {
        count += 1.0;
        turned += f64::from(grid.normals[a].dot(grid.normals[b]) < settings.max_turned_cosine);
    }
    share(turned, count)
}

/// A part over the whole; 0 of an empty whole.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}
