//! The meshes of whole faces: those of their surfaces, with common vertices on common edges.
//!
//! 1. Each surface is divided on its own.
//! 2. Faces on both sides of an edge get the vertices of each other, until nothing changes.
//! 3. The meshes are written. Vertices on edges move to the same place, by rounding in general.
//!
//! This needs edges whose faces have the same parameters along it, up to scale. Groups of connected
//! faces with other edges, or with trimmed faces, get no mesh here.

use std::collections::{BTreeSet, HashMap};

use glam::DVec3;

use super::TessellateOptions;
use super::adaptive::Tessellation;
use super::conform::conform;
use super::face_mesh::FaceMesh;
use super::mesh_join::overused;
use super::options::Limits;
use super::outline::{Node, Origin};
use super::parallel_map::parallel_map;
use super::partition::Partition;
use super::shared_side::{SharedSide, SideUse};
use super::surface_side::{SurfaceSide, ends};
use crate::brep::Shell;
use crate::disjoint_sets::DisjointSets;
use crate::error::Result;
use crate::numeric::index;
use crate::progress::{Observer, Silent};

/// Share of the tolerance that vertices on edges may move by.
const MOVE_SHARE: f64 = 1e-2;

/// The whole faces of a shell, each divided into cells.
struct WholeFaces<'a> {
    shell: &'a Shell,
    options: TessellateOptions,
    /// The largest move of a vertex.
    most: f64,
    /// The number of the group of connected faces that each face belongs to.
    groups: Vec<u32>,
    /// The cells of each face; `None` if another method must triangulate it.
    partitions: Vec<Option<Partition<'a>>>,
}

/// Triangulates the groups of whole faces. Each edge is halved at least as often as `least` says.
pub(super) fn mesh_whole_faces(
    shell: &Shell,
    options: &TessellateOptions,
    limits: &Limits,
    least: &[u32],
    observer: &mut dyn Observer,
) -> Result<Vec<Option<FaceMesh>>> {
    let most = MOVE_SHARE * limits.tolerance;
    let tolerance = Some(limits.tolerance - most);
    let options = TessellateOptions { tolerance, relative: false, split_seams: true, ..*options };
    let count = shell.faces().len();
    let mut partitions = Vec::with_capacity(count);
    partitions.resize_with(count, || None);
    let mut this = WholeFaces { shell, options, most, groups: groups(shell), partitions };
    this.divide(observer)?;
    let sides = this.share_sides(least, observer)?;
    let mut meshes = this.write(&sides, observer)?;
    this.join_sides(&mut meshes);
    Ok(meshes)
}

impl<'a> WholeFaces<'a> {
    /// Divides the surfaces of groups without trimmed faces.
    fn divide(&mut self, observer: &mut dyn Observer) -> Result<()> {
        let (shell, options) = (self.shell, self.options);
        let faces = shell.faces().iter().zip(&self.groups);
        let trimmed = faces.filter(|(face, _)| face.is_trimmed());
        let trimmed: BTreeSet<u32> = trimmed.map(|(_, group)| *group).collect();
        let whole = (0..shell.faces().len()).filter(|face| !trimmed.contains(&self.groups[*face]));
        let divide = |(): &mut (), face: usize| {
            let surface = shell.faces()[face].surface();
            let mut partition = Partition::new(surface, &options, &mut Silent)?;
            conform(&mut partition, &options, &mut Silent)?;
            Ok((face, partition))
        };
        let whole: Vec<usize> = whole.collect();
        let partitions = &mut self.partitions;
        parallel_map(whole.iter().copied(), usize::MAX, observer, divide, |divided: Result<_>| {
            let (face, partition) = divided?;
            partitions[face] = Some(partition);
            Ok(())
        })?;
        for face in whole {
            if !self.agrees_on_poles(face) {
                self.leave_group(face);
            }
        }
        Ok(())
    }

    /// Whether the same sides are poles of the surface and of the shell.
    fn agrees_on_poles(&self, face: usize) -> bool {
        let Some(partition) = &self.partitions[face] else { return true };
        self.shell.coedges(face).iter().flatten().all(|coedge| {
            let side = SurfaceSide::of(partition.surface, ends(&coedge.curve));
            side.is_pole(&partition.grid) == coedge.edge.is_none()
        })
    }

    /// Leaves the group of a face to another method.
    fn leave_group(&mut self, face: usize) {
        if self.partitions[face].is_some() {
            let of_group = self.groups.iter().zip(&mut self.partitions);
            let of_group = of_group.filter(|(group, _)| **group == self.groups[face]);
            of_group.for_each(|(_, partition)| *partition = None);
        }
    }

    /// Makes neighbors have the same vertices on their common edges.
    fn share_sides(
        &mut self,
        least: &[u32],
        observer: &mut dyn Observer,
    ) -> Result<Vec<SharedSide>> {
        let mut sides = vec![];
        for (edge, of) in self.shell.edges().iter().enumerate() {
            let face = of.uses[0].face;
            if self.partitions[face].is_some() {
                match SharedSide::new(self.shell, (edge, least[edge]), &self.partitions) {
                    Ok(side) => sides.push(side),
                    Err(_) => self.leave_group(face),
                }
            }
        }
        loop {
            let mut changed = BTreeSet::new();
            for side in &mut sides {
                match side.exchange(&mut self.partitions) {
                    Ok(faces) => changed.extend(faces),
                    Err(_) => self.leave_group(side.uses[0].face),
                }
            }
            if changed.is_empty() {
                return Ok(sides);
            }
            self.conform(&changed, observer)?;
        }
    }

    /// Divides the cells of faces further, for new vertices on their sides.
    fn conform(&mut self, faces: &BTreeSet<usize>, observer: &mut dyn Observer) -> Result<()> {
        let (options, partitions) = (self.options, &mut self.partitions);
        let changed = faces.iter().filter_map(|face| Some((*face, partitions[*face].take()?)));
        let changed: Vec<(usize, Partition<'_>)> = changed.collect();
        let job = |(): &mut (), (face, mut partition): (usize, Partition<'a>)| {
            conform(&mut partition, &options, &mut Silent).map(|()| (face, partition))
        };
        parallel_map(changed, usize::MAX, observer, job, |divided| {
            let (face, partition) = divided?;
            partitions[face] = Some(partition);
            Ok(())
        })
    }

    /// The mesh of each face.
    fn write(
        &mut self,
        sides: &[SharedSide],
        observer: &mut dyn Observer,
    ) -> Result<Vec<Option<FaceMesh>>> {
        let count = self.partitions.len();
        let mut of_faces: Vec<Vec<(usize, &SideUse)>> = vec![vec![]; count];
        for side in sides {
            side.uses.iter().for_each(|used| of_faces[used.face].push((side.edge, used)));
        }
        let shell = self.shell;
        let write = |(): &mut (), (partition, sides): (Option<Partition<'_>>, Vec<_>)| {
            partition.map(|partition| face_mesh(shell, partition, &sides)).transpose()
        };
        let mut meshes = Vec::with_capacity(count);
        let partitions = std::mem::take(&mut self.partitions).into_iter();
        parallel_map(partitions.zip(of_faces), usize::MAX, observer, write, |mesh| {
            meshes.push(mesh?);
            Ok(())
        })?;
        Ok(meshes)
    }

    /// Moves the vertices of neighbors on edges to one place. Drops the meshes of groups where this
    /// is too far, or where more than two triangles would share a side.
    fn join_sides(&self, meshes: &mut [Option<FaceMesh>]) {
        let mut places: HashMap<Origin, DVec3> = HashMap::new();
        let mut dropped = BTreeSet::new();
        for (mesh, group) in meshes.iter_mut().zip(&self.groups) {
            let Some(mesh) = mesh else { continue };
            let mut moved = 0.0_f64;
            for node in &mut mesh.nodes {
                let place = match node.origin {
                    Origin::Inside => continue,
                    Origin::Vertex(vertex) => self.shell.vertices()[vertex],
                    Origin::Edge(..) => *places.entry(node.origin).or_insert(node.point),
                };
                moved = moved.max(node.point.distance(place));
                node.point = place;
            }
            mesh.deviation += moved;
            if moved > self.most || mesh.has_collapsed() {
                dropped.insert(*group);
            }
        }
        let overused = overused(meshes);
        dropped.extend(overused.iter().map(|(face, _)| self.groups[*face]));
        let of_groups = meshes.iter_mut().zip(&self.groups);
        of_groups.filter(|(_, group)| dropped.contains(group)).for_each(|(mesh, _)| *mesh = None);
    }
}

/// The mesh of a whole face, with the parts of its sides that follow the edges of the shell.
fn face_mesh(
    shell: &Shell,
    partition: Partition<'_>,
    sides: &[(usize, &SideUse)],
) -> Result<FaceMesh> {
    let cells = Tessellation::numbered(partition, true);
    let mesh = cells.mesh(&mut Silent)?;
    let mut origins = vec![Origin::Inside; mesh.vertices.len()];
    for (edge, used) in sides {
        for (step, vertex) in cells.on_side(used.side) {
            if let Some(&index) = used.vertices.get(&step) {
                let ends = shell.edges()[*edge].vertices;
                let end = ends.get(index).map(|vertex| Origin::Vertex(*vertex));
                origins[vertex as usize] = end.unwrap_or(Origin::Edge(*edge, index));
            }
        }
    }
    let places = mesh.uv.iter().zip(&mesh.vertices).zip(origins);
    let nodes = places.map(|((&uv, &point), origin)| Node { uv, point, origin }).collect();
    let triangles = mesh.triangles.iter().map(|triangle| triangle.map(|k| k as usize)).collect();
    let deviation = cells.max_deviation();
    Ok(FaceMesh { nodes, normals: mesh.normals, triangles, deviation, is_proven: true })
}

/// The number of the group of each face; the faces of a group are connected by vertices.
fn groups(shell: &Shell) -> Vec<u32> {
    let count = shell.faces().len();
    let mut connected = DisjointSets::new(count + shell.vertices().len());
    for face in 0..count {
        for coedge in shell.coedges(face).iter().flatten() {
            connected.unite(index(face), index(count + coedge.vertex));
        }
    }
    (0..count).map(|face| connected.root(index(face))).collect()
}
