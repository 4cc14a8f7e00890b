//! A finished division becomes arrays: vertices with their normals and parameters, triangles.

use glam::{DVec2, DVec3};

use super::MeshSlices;
use super::adaptive::Tessellation;
use super::certify::Face;
use super::groups::in_groups;
use super::numbering::number_of;
use super::stitch::{Vertices, parameter};
use super::uniform::check_length;
use crate::error::Result;
use crate::progress::Observer;

/// Vertices on borders that a thread evaluates at a time.
const VERTICES_PER_TASK: usize = 1 << 8;

/// Some vertices.
struct Slices<'a> {
    uv: &'a mut [DVec2],
    points: &'a mut [DVec3],
    normals: &'a mut [DVec3],
}

/// What a thread writes at a time.
enum Task<'a> {
    /// Vertices whose parameters are known.
    Border(Slices<'a>),
    /// What is inside a block.
    Block { index: usize, vertices: Slices<'a>, triangles: &'a mut [[u32; 3]] },
}

/// Memory of a thread.
#[derive(Default)]
struct Room {
    vertices: Vertices,
    /// The numbers of the vertices, in their order.
    numbers: Vec<u32>,
    /// Which vertices stand around a piece.
    outline: Vec<usize>,
    faces: Vec<Face>,
}

impl Tessellation<'_> {
    /// Writes the mesh into memory of the caller.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if a slice has not the right length;
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn write(&self, out: MeshSlices<'_>, observer: &mut dyn Observer) -> Result<()> {
        let MeshSlices { vertices, triangles, normals, uv } = out;
        check_length("uv", uv.len(), self.vertices())?;
        check_length("triangles", triangles.len(), self.triangles())?;
        check_length("vertices", vertices.len(), self.vertices())?;
        check_length("normals", normals.len(), self.vertices())?;
        let (numbers, borders) = (&self.numbers, self.numbers.on_borders.len());
        let (border_points, vertices) = vertices.split_at_mut(borders);
        let (border_normals, normals) = normals.split_at_mut(borders);
        let (border_uv, uv) = uv.split_at_mut(borders);
        border_uv.copy_from_slice(&numbers.on_borders);
        let (points, normals) =
            (parts(vertices, &numbers.vertices), parts(normals, &numbers.vertices));
        let inside = points.into_iter().zip(normals).zip(parts(uv, &numbers.vertices));
        let blocks = inside.zip(parts(triangles, &numbers.triangles)).enumerate();
        let blocks = blocks.map(|(index, (((points, normals), uv), triangles))| Task::Block {
            index,
            vertices: Slices { uv, points, normals },
            triangles,
        });
        let on_borders = border_uv.chunks_mut(VERTICES_PER_TASK);
        let on_borders = on_borders.zip(border_points.chunks_mut(VERTICES_PER_TASK));
        let on_borders = on_borders.zip(border_normals.chunks_mut(VERTICES_PER_TASK));
        let on_borders =
            on_borders.map(|((uv, points), normals)| Task::Border(Slices { uv, points, normals }));
        let tasks: Vec<Task> = blocks.chain(on_borders).collect();
        let write = |room: &mut Room, task: Task| {
            let Slices { uv, points, normals } = match task {
                Task::Border(vertices) => vertices,
                Task::Block { index, vertices, triangles } => {
                    self.write_block(room, index, vertices.uv, triangles);
                    vertices
                }
            };
            self.surface.points_and_normals(uv, points, normals);
        };
        in_groups(tasks, self.triangles(), observer, write, Ok)
    }

    /// Writes the parameters of a block's inner vertices, and its triangles.
    fn write_block(
        &self,
        room: &mut Room,
        index: usize,
        uv: &mut [DVec2],
        triangles: &mut [[u32; 3]],
    ) {
        let (block, pieces) = (self.lattice.block(index), &self.pieces[index]);
        let Room { vertices, numbers, outline, faces } = room;
        vertices.collect(block, pieces, self.sides(index));
        let first = number_of(self.numbers.vertices[index]);
        self.names(vertices, index, first, numbers);
        let (cuts_u, cuts_v) = (&self.lattice.nets.u, &self.lattice.nets.v);
        for ((u, v), &number) in vertices.places().zip(&*numbers) {
            if number >= first {
                let u = parameter(cuts_u, block.rows.0, u);
                uv[(number - first) as usize] = DVec2::new(u, parameter(cuts_v, block.cols.0, v));
            }
        }
        let mut next = triangles.iter_mut();
        for piece in pieces {
            outline.clear();
            vertices.outline(piece, outline);
            faces.clear();
            let at = |corner: &usize| vertices.place(*corner);
            piece.cut.faces(piece.ends(outline.iter().map(at)), faces);
            let corners = faces.iter().map(|face| face.map(|k| numbers[outline[k]]));
            let whole = corners.filter(|[a, b, c]| a != b && b != c && c != a);
            whole.zip(&mut next).for_each(|(corners, out)| *out = corners);
        }
    }
}

/// Slices of a whole between these bounds.
fn parts<'a, T>(mut whole: &'a mut [T], bounds: &[usize]) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(bounds.len() - 1);
    for pair in bounds.windows(2) {
        let (part, rest) = whole.split_at_mut(pair[1] - pair[0]);
        parts.push(part);
        whole = rest;
    }
    parts
}
