//! Which sections are the same edge.

use std::collections::HashMap;

use glam::DVec3;

use super::face::Face;
use super::section::Section;
use crate::error::{Error, Result};
use crate::nurbs::CurveSearch;

/// Shares of a section at which it is compared with another one.
const SHARES: [f64; 7] = [0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9];

/// The edge of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Match {
    pub edge: usize,
    /// Whether the section runs like the edge's first one.
    pub forward: bool,
}

/// Matches sections by position: the edge of each, `None` for points.
pub(super) fn match_by_position(
    faces: &[Face],
    sections: &[Section],
    tolerance: f64,
) -> Result<Vec<Option<Match>>> {
    let mut clusters = Clusters::new(tolerance);
    let mut candidates: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
    let mut edges = Edges { faces, sections, uses: vec![], found: vec![] };
    for (k, section) in sections.iter().enumerate() {
        if section.is_point {
            edges.found.push(None);
            continue;
        }
        let ends = (clusters.of(section.start()), clusters.of(section.end()));
        let known = candidates.entry((ends.0.min(ends.1), ends.0.max(ends.1))).or_default();
        let mut matched = None;
        for &edge in &*known {
            let first = &sections[edges.uses[edge][0]];
            let Some(forward) = same_curve(first, section, tolerance)? else { continue };
            let found = Match { edge, forward };
            // A Möbius band meets itself in the same direction: it has two borders there.
            if first.face == section.face && !edges.is_opposite(k, found) {
                continue;
            }
            matched = Some(found);
            break;
        }
        match matched {
            Some(found) => edges.join(k, found)?,
            None => known.push(edges.add(k)),
        }
    }
    Ok(edges.found)
}

/// Matches sections that have the same identifier: the edge of each, `None` for points.
pub(super) fn match_by_identifier(
    faces: &[Face],
    sections: &[Section],
    identifiers: &[Option<usize>],
) -> Result<Vec<Option<Match>>> {
    let mut known: HashMap<usize, usize> = HashMap::new();
    let mut edges = Edges { faces, sections, uses: vec![], found: vec![] };
    for (k, identifier) in identifiers.iter().enumerate() {
        let Some(identifier) = identifier else {
            edges.found.push(None);
            continue;
        };
        match known.get(identifier) {
            Some(&edge) => {
                let first = &sections[edges.uses[edge][0]];
                let forward = same_direction(first, &sections[k])?;
                edges.join(k, Match { edge, forward })?;
            }
            None => {
                known.insert(*identifier, edges.add(k));
            }
        }
    }
    Ok(edges.found)
}

/// The edges so far.
struct Edges<'a> {
    faces: &'a [Face],
    sections: &'a [Section],
    /// The sections of each edge.
    uses: Vec<Vec<usize>>,
    found: Vec<Option<Match>>,
}

impl Edges<'_> {
    /// Adds an edge of one section.
    fn add(&mut self, section: usize) -> usize {
        let edge = self.uses.len();
        self.uses.push(vec![section]);
        self.found.push(Some(Match { edge, forward: true }));
        edge
    }

    /// Adds a section to an edge.
    fn join(&mut self, section: usize, found: Match) -> Result<()> {
        let first = self.uses[found.edge][0];
        let place = self.sections[first].point(0.5);
        let [a, b] = [first, section].map(|k| self.sections[k].face);
        let place = format!("near ({:.6}, {:.6}, {:.6})", place.x, place.y, place.z);
        if self.uses[found.edge].len() > 1 {
            let second = self.sections[self.uses[found.edge][1]].face;
            let must = "have at most two faces at each edge";
            let got = format!("faces {a}, {second} and {b} meet {place}");
            return Err(Error::Shell { must, got });
        }
        if !self.is_opposite(section, found) {
            let must = "have faces whose normals agree across each edge";
            let got =
                format!("those of faces {a} and {b} are opposite {place}: reverse one of them");
            return Err(Error::Shell { must, got });
        }
        self.uses[found.edge].push(section);
        self.found.push(Some(found));
        Ok(())
    }

    /// Whether a section runs against the first one of an edge, as seen from outside both faces.
    fn is_opposite(&self, section: usize, found: Match) -> bool {
        let reversed = |k: usize| self.faces[self.sections[k].face].is_reversed();
        let same_side = reversed(section) == reversed(self.uses[found.edge][0]);
        found.forward != same_side
    }
}

/// Whether two sections with the same ends are the same curve, and if so, whether they run in the
/// same direction.
fn same_curve(a: &Section, b: &Section, tolerance: f64) -> Result<Option<bool>> {
    for (from, to) in [(a, b), (b, a)] {
        let search = CurveSearch::new(&to.in_space)?;
        if SHARES.iter().any(|&s| search.closest_point(from.point(s)).distance > tolerance) {
            return Ok(None);
        }
    }
    same_direction(a, b).map(Some)
}

/// Whether two sections along the same curve run in the same direction.
fn same_direction(a: &Section, b: &Section) -> Result<bool> {
    let search = CurveSearch::new(&a.in_space)?;
    let [first, second] = [0.4, 0.6].map(|share| search.closest_point(b.point(share)).u);
    Ok(first < second)
}

/// Clusters of points: each within the tolerance of its first point.
struct Clusters {
    tolerance: f64,
    points: Vec<DVec3>,
    /// The clusters of each cell of a grid.
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl Clusters {
    fn new(tolerance: f64) -> Self {
        Self { tolerance, points: vec![], cells: HashMap::new() }
    }

    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    fn cell(&self, point: DVec3) -> [i64; 3] {
        (point / (2.0 * self.tolerance)).floor().to_array().map(|x| x as i64)
    }

    /// The cluster of a point, a new one if none is near.
    fn of(&mut self, point: DVec3) -> usize {
        for dx in [-self.tolerance, self.tolerance] {
            for dy in [-self.tolerance, self.tolerance] {
                for dz in [-self.tolerance, self.tolerance] {
                    let cell = self.cell(point + DVec3::new(dx, dy, dz));
                    let near = self.cells.get(&cell).into_iter().flatten();
                    let near =
                        near.copied().find(|&k| self.points[k].distance(point) <= self.tolerance);
                    if let Some(found) = near {
                        return found;
                    }
                }
            }
        }
        let new = self.points.len();
        self.points.push(point);
        self.cells.entry(self.cell(point)).or_default().push(new);
        new
    }
}
