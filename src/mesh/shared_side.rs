//! The vertices that the meshes of whole faces share on an edge between them.

use std::collections::BTreeMap;

use super::partition::Partition;
use super::surface_side::{SurfaceSide, ends};
use crate::brep::Shell;

/// A part of a face's side that follows an edge of the shell.
#[derive(Clone, Debug)]
pub(super) struct SideUse {
    pub face: usize,
    pub side: SurfaceSide,
    /// The parameters along the side at the start and the end of the edge.
    ends: [f64; 2],
    /// The indices of the vertices by their steps on the side.
    pub vertices: BTreeMap<u64, usize>,
}

/// An edge of a shell, whose uses have the same vertices at the same shares of their lengths in
/// (u, v).
#[derive(Clone, Debug)]
pub(super) struct SharedSide {
    pub edge: usize,
    pub uses: Vec<SideUse>,
    /// The share of the edge that lies before each vertex. The first two are the ends.
    shares: Vec<f64>,
    /// Vertices that the partitions may lack yet: the index of the use, and the step.
    missing: Vec<(usize, u64)>,
}

/// Two vertices of one face would be the same on another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conflict;

impl SharedSide {
    /// An edge, halved at least `least` times.
    pub(super) fn new(
        shell: &Shell,
        (edge, least): (usize, u32),
        partitions: &[Option<Partition<'_>>],
    ) -> Result<Self, Conflict> {
        let mut uses = vec![];
        for place in &shell.edges()[edge].uses {
            let coedge = &shell.coedges(place.face)[place.in_loop][place.place];
            let mut ends = ends(&coedge.curve);
            if !coedge.forward {
                ends.reverse();
            }
            let side = SurfaceSide::of(shell.faces()[place.face].surface(), ends);
            let ends = ends.map(|at| side.along(at));
            uses.push(SideUse { face: place.face, side, ends, vertices: BTreeMap::new() });
        }
        let mut this = Self { edge, uses, shares: vec![], missing: vec![] };
        let parts = 1_u32 << least;
        let shares = (1..parts).map(|k| f64::from(k) / f64::from(parts));
        for share in [0.0, 1.0].into_iter().chain(shares) {
            this.add(share, None, partitions)?;
        }
        Ok(this)
    }

    /// Adds the vertices of each use to the others. Returns the faces with new vertices.
    pub(super) fn exchange(
        &mut self,
        partitions: &mut [Option<Partition<'_>>],
    ) -> Result<Vec<usize>, Conflict> {
        for k in 0..self.uses.len() {
            let SideUse { face, side, ends: [start, end], vertices } = &self.uses[k];
            let Some(partition) = &partitions[*face] else { continue };
            let steps = side.steps(partition);
            let (low, high) = (start.min(*end), start.max(*end));
            let [low, high] = [low, high].map(|at| side.step(&partition.grid, at));
            let new = steps.into_iter().filter(|step| low < *step && *step < high);
            let new: Vec<(u64, f64)> = new
                .filter(|step| !vertices.contains_key(step))
                .map(|step| (step, (side.parameter(&partition.grid, step) - start) / (end - start)))
                .collect();
            for (step, share) in new {
                self.add(share, Some((k, step)), partitions)?;
            }
        }
        let mut changed = vec![];
        for (k, step) in self.missing.drain(..) {
            let SideUse { face, side, .. } = self.uses[k];
            if let Some(partition) = &mut partitions[face]
                && side.add(partition, step)
            {
                changed.push(face);
            }
        }
        Ok(changed)
    }

    /// Adds a vertex to all uses; `known` has the index of a use and the step there.
    fn add(
        &mut self,
        share: f64,
        known: Option<(usize, u64)>,
        partitions: &[Option<Partition<'_>>],
    ) -> Result<(), Conflict> {
        let index = self.shares.len();
        self.shares.push(share);
        for (k, SideUse { face, side, ends: [start, end], vertices }) in
            self.uses.iter_mut().enumerate()
        {
            let Some(partition) = &partitions[*face] else { continue };
            let step = match known {
                Some((of, step)) if of == k => step,
                _ => side.step(&partition.grid, (1.0 - share) * *start + share * *end),
            };
            if vertices.insert(step, index).is_some() {
                return Err(Conflict);
            }
            self.missing.push((k, step));
        }
        Ok(())
    }
}
