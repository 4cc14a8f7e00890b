//! Writes a partition as arrays: vertices with their normals and parameters, and triangles.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::MeshSlices;
use super::block::parameter;
use super::block_vertices::BlockVertices;
use super::cell::Cell;
use super::cell_mesh::Face;
use super::numbering::{Numbering, vertex_index};
use super::parallel_map::parallel_map;
use super::partition::Partition;
use super::uniform::check_length;
use crate::error::Result;
use crate::progress::Observer;

/// Vertices on block edges in one task.
const VERTICES_PER_TASK: usize = 1 << 8;

/// Output arrays of some vertices.
struct Slices<'a> {
    uv: &'a mut [DVec2],
    points: &'a mut [DVec3],
    normals: &'a mut [DVec3],
}

/// The output of one task.
enum Task<'a> {
    /// Vertices on block edges, whose parameters are already written.
    Edge(Slices<'a>),
    /// The inner vertices and the triangles of a block.
    Block { index: usize, vertices: Slices<'a>, triangles: &'a mut [[u32; 3]] },
}

/// Scratch memory of a thread.
#[derive(Default)]
struct Scratch {
    vertices: BlockVertices,
    /// The indices of the vertices, in order of their ranks.
    indices: Vec<u32>,
    /// The ranks of the vertices around a cell.
    outline: Vec<usize>,
    faces: Vec<Face>,
}

/// Writes the mesh to memory of the caller.
pub(super) fn write(
    partition: &Partition<'_>,
    numbering: &Numbering,
    out: MeshSlices<'_>,
    observer: &mut dyn Observer,
) -> Result<()> {
    let MeshSlices { vertices, triangles, normals, uv } = out;
    let blocks = partition.grid.blocks();
    let (vertex_count, triangle_count) = (numbering.vertices[blocks], numbering.triangles[blocks]);
    check_length("uv", uv.len(), vertex_count)?;
    check_length("triangles", triangles.len(), triangle_count)?;
    check_length("vertices", vertices.len(), vertex_count)?;
    check_length("normals", normals.len(), vertex_count)?;
    let on_edges = numbering.edge_uv.len();
    let (edge_points, vertices) = vertices.split_at_mut(on_edges);
    let (edge_normals, normals) = normals.split_at_mut(on_edges);
    let (edge_uv, uv) = uv.split_at_mut(on_edges);
    edge_uv.copy_from_slice(&numbering.edge_uv);
    let (points, normals) =
        (parts(vertices, &numbering.vertices), parts(normals, &numbering.vertices));
    let inside = points.into_iter().zip(normals).zip(parts(uv, &numbering.vertices));
    let blocks = inside.zip(parts(triangles, &numbering.triangles)).enumerate();
    let blocks = blocks.map(|(index, (((points, normals), uv), triangles))| Task::Block {
        index,
        vertices: Slices { uv, points, normals },
        triangles,
    });
    let edges = edge_uv.chunks_mut(VERTICES_PER_TASK);
    let edges = edges.zip(edge_points.chunks_mut(VERTICES_PER_TASK));
    let edges = edges.zip(edge_normals.chunks_mut(VERTICES_PER_TASK));
    let edges = edges.map(|((uv, points), normals)| Task::Edge(Slices { uv, points, normals }));
    let tasks: Vec<Task> = blocks.chain(edges).collect();
    let write = |scratch: &mut Scratch, task: Task| {
        let Slices { uv, points, normals } = match task {
            Task::Edge(vertices) => vertices,
            Task::Block { index, vertices, triangles } => {
                write_block((partition, numbering), index, scratch, (vertices.uv, triangles));
                vertices
            }
        };
        partition.surface.points_and_normals(uv, points, normals);
    };
    parallel_map(tasks, triangle_count, observer, write, Ok)
}

/// Writes the parameters of a block's inner vertices, and its triangles.
fn write_block(
    (partition, numbering): (&Partition<'_>, &Numbering),
    index: usize,
    Scratch { vertices, indices, outline, faces }: &mut Scratch,
    (uv, triangles): (&mut [DVec2], &mut [[u32; 3]]),
) {
    let (block, cells) = (partition.grid.block(index), &partition.cells[index]);
    vertices.collect(block, cells, partition.edge_vertices(index));
    let first = vertex_index(numbering.vertices[index]);
    numbering.vertex_indices((partition, index), vertices, first, indices);
    let nets = &partition.grid.nets;
    for ((u, v), &vertex) in vertices.points().zip(&*indices) {
        if vertex >= first {
            let u = parameter(&nets.u, block.rows.0, u);
            uv[(vertex - first) as usize] = DVec2::new(u, parameter(&nets.v, block.cols.0, v));
        }
    }
    let mut next = triangles.iter_mut();
    for cell in cells {
        let found = cell_triangles(cell, vertices, indices, (&mut *outline, &mut *faces));
        found.zip(&mut next).for_each(|(corners, out)| *out = corners);
    }
}

/// The triangles of a cell. Those with two corners at the same pole are left out.
fn cell_triangles<'a>(
    cell: &Cell,
    vertices: &BlockVertices,
    indices: &'a [u32],
    (outline, faces): (&'a mut Vec<usize>, &'a mut Vec<Face>),
) -> impl Iterator<Item = [u32; 3]> + 'a {
    outline.clear();
    vertices.outline(cell, outline);
    faces.clear();
    let at = |rank: &usize| vertices.point(*rank);
    cell.triangulation.faces(cell.corner_indices(outline.iter().map(at)), faces);
    let corners = faces.iter().map(|face| face.map(|k| indices[outline[k]]));
    corners.filter(|[a, b, c]| a != b && b != c && c != a)
}

/// A cell in (u, v), and its triangles in the arrays.
#[derive(Clone, Debug)]
pub(super) struct WrittenCell {
    pub low: DVec2,
    pub high: DVec2,
    pub triangles: Range<usize>,
}

/// The cells in the order of their triangles.
pub(super) fn written_cells(partition: &Partition<'_>, numbering: &Numbering) -> Vec<WrittenCell> {
    let Scratch { mut vertices, mut indices, mut outline, mut faces } = Scratch::default();
    let nets = &partition.grid.nets;
    let mut all = vec![];
    let mut start = 0;
    for index in 0..partition.grid.blocks() {
        let (block, cells) = (partition.grid.block(index), &partition.cells[index]);
        vertices.collect(block, cells, partition.edge_vertices(index));
        let first = vertex_index(numbering.vertices[index]);
        numbering.vertex_indices((partition, index), &vertices, first, &mut indices);
        for cell in cells {
            let found = cell_triangles(cell, &vertices, &indices, (&mut outline, &mut faces));
            let end = start + found.count();
            let corner = |u, v| {
                let u = parameter(&nets.u, block.rows.0, u);
                DVec2::new(u, parameter(&nets.v, block.cols.0, v))
            };
            let (low, high) = (corner(cell.u.0, cell.v.0), corner(cell.u.1, cell.v.1));
            all.push(WrittenCell { low, high, triangles: start..end });
            start = end;
        }
    }
    all
}

/// Splits a slice at these bounds.
fn parts<'a, T>(mut whole: &'a mut [T], bounds: &[usize]) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(bounds.len() - 1);
    for pair in bounds.windows(2) {
        let (part, rest) = whole.split_at_mut(pair[1] - pair[0]);
        parts.push(part);
        whole = rest;
    }
    parts
}
