//! Vertices, edges and coedges of a shell from matched sections.

use glam::DVec3;

use super::edge::{Edge, EdgeUse};
use super::edge_matching::Match;
use super::face::Face;
use super::loops::Coedge;
use super::section::Section;
use crate::disjoint_sets::DisjointSets;
use crate::numeric::index;

/// What joins the faces of a shell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Topology {
    /// The coedges of each loop of each face.
    pub loops: Vec<Vec<Vec<Coedge>>>,
    pub edges: Vec<Edge>,
    pub vertices: Vec<DVec3>,
}

impl Topology {
    /// Joins sections, in the order of faces and loops, by their matches.
    pub(super) fn new(faces: &[Face], sections: Vec<Section>, matches: &[Option<Match>]) -> Self {
        let ends = Ends::joined(&sections, matches);
        let (numbers, vertices) = ends.numbered(&sections);
        let mut loops: Vec<Vec<Vec<Coedge>>> =
            faces.iter().map(|face| vec![vec![]; face.loops().len()]).collect();
        let mut edges: Vec<Edge> = vec![];
        for (k, (section, matched)) in sections.into_iter().zip(matches).enumerate() {
            let coedges = &mut loops[section.face][section.in_loop];
            let place = coedges.len();
            let here = EdgeUse { face: section.face, in_loop: section.in_loop, place };
            if let Some(Match { edge, .. }) = matched {
                match edges.get_mut(*edge) {
                    Some(known) => known.uses.push(here),
                    None => edges.push(Edge {
                        curve: section.in_space,
                        vertices: [numbers[2 * k], numbers[2 * k + 1]],
                        uses: vec![here],
                    }),
                }
            }
            coedges.push(Coedge {
                curve: section.curve,
                edge: matched.map(|found| found.edge),
                forward: matched.is_none_or(|found| found.forward),
                vertex: numbers[2 * k],
            });
        }
        Self { loops, edges, vertices }
    }
}

/// The start (2 k) and end (2 k + 1) of each section, as sets of those that are one vertex.
struct Ends {
    sets: DisjointSets,
}

impl Ends {
    fn joined(sections: &[Section], matches: &[Option<Match>]) -> Self {
        let mut ends = Self { sets: DisjointSets::new(2 * sections.len()) };
        let of_loop = |k: usize| (sections[k].face, sections[k].in_loop);
        let mut first_of_loop = 0;
        let mut first_of_edge: Vec<usize> = vec![];
        for (k, section) in sections.iter().enumerate() {
            if of_loop(k) != of_loop(first_of_loop) {
                first_of_loop = k;
            }
            let is_last = sections.get(k + 1).is_none_or(|_| of_loop(k + 1) != of_loop(k));
            let next = if is_last { first_of_loop } else { k + 1 };
            ends.join(2 * k + 1, 2 * next);
            if section.is_point {
                ends.join(2 * k, 2 * k + 1);
            }
            let Some(Match { edge, forward }) = matches[k] else { continue };
            if edge == first_of_edge.len() {
                first_of_edge.push(k);
            }
            let first = first_of_edge[edge];
            let turn = usize::from(!forward);
            ends.join(2 * k, 2 * first + turn);
            ends.join(2 * k + 1, 2 * first + 1 - turn);
        }
        ends
    }

    fn join(&mut self, a: usize, b: usize) {
        self.sets.unite(index(a), index(b));
    }

    /// The vertex of each end, and the vertices' places, in the order of the sections.
    fn numbered(mut self, sections: &[Section]) -> (Vec<usize>, Vec<DVec3>) {
        let roots = self.sets.roots();
        let mut of_root = vec![usize::MAX; roots.len()];
        let mut vertices = vec![];
        let mut numbers = vec![];
        for (end, root) in roots.into_iter().enumerate() {
            let root = root as usize;
            if of_root[root] == usize::MAX {
                of_root[root] = vertices.len();
                let section = &sections[end / 2];
                vertices.push(if end % 2 == 0 { section.start() } else { section.end() });
            }
            numbers.push(of_root[root]);
        }
        (numbers, vertices)
    }
}
