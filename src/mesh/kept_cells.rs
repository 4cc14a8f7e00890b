//! The cells of a surface inside the loops of a face: their certified triangles are kept.
//!
//! Cells that a loop touches or comes near are left out. Their corners are the points to
//! triangulate the strip along the loops with.

use glam::DVec2;

use super::TriangleMesh;
use super::outline::{Node, Origin, Outline};
use super::side_grid::SideGrid;
use super::write::WrittenCell;
use crate::disjoint_sets::DisjointSets;

/// Distance from a loop below which a cell or a vertex is left out, as a share of the shorter of
/// the cell's diagonal and the loop's side. Nearer vertices would make narrow triangles.
const NEAR: f64 = 0.3;

/// No vertex.
const NONE: usize = usize::MAX;

/// The kept triangles of a face, and the points of its strip.
#[derive(Debug, Default)]
pub(super) struct KeptCells {
    /// The triangles, by nodes.
    pub triangles: Vec<[usize; 3]>,
    /// The sides of kept triangles that border the strip.
    pub border: Vec<[usize; 2]>,
    /// The nodes inside the kept region, which follow those of the strip.
    pub inner: Vec<Node>,
}

/// Selects the cells of a surface's mesh, and appends the nodes of the strip to those of the
/// outline. The kept triangles' nodes off the strip have indices from `usize::MAX / 2` on.
pub(super) fn keep(
    outline: &mut Outline,
    mesh: &TriangleMesh,
    cells: &[WrittenCell],
    scale: DVec2,
) -> KeptCells {
    let grid = SideGrid::new(outline, scale);
    let diagonal = |cell: &WrittenCell| (scale * (cell.high - cell.low)).length();
    let touched: Vec<bool> = cells
        .iter()
        .map(|cell| grid.is_near(scale * cell.low, scale * cell.high, diagonal(cell), NEAR))
        .collect();
    let is_inside = inside(outline, mesh, cells, &touched);
    let of = |cell: &WrittenCell| &mesh.triangles[cell.triangles.clone()];
    let mut sizes = vec![f64::INFINITY; mesh.vertices.len()];
    let mut kept: Vec<[u32; 3]> = vec![];
    for (cell, touched) in cells.iter().zip(&touched) {
        let first = of(cell).first().map_or(NONE, |triangle| triangle[0] as usize);
        if !touched && first != NONE && is_inside[first] == Some(true) {
            kept.extend_from_slice(of(cell));
        }
        for &vertex in of(cell).iter().flatten() {
            let size = &mut sizes[vertex as usize];
            *size = size.min(diagonal(cell));
        }
    }
    let border = border(&kept);
    let mut nodes = vec![NONE; mesh.vertices.len()];
    let mut take = |vertex: usize| {
        if nodes[vertex] == NONE {
            nodes[vertex] = outline.nodes.len();
            outline.nodes.push(node(mesh, vertex));
        }
    };
    border.iter().flatten().for_each(|vertex| take(*vertex as usize));
    for (cell, _) in cells.iter().zip(&touched).filter(|(_, touched)| **touched) {
        for vertex in of(cell).iter().flatten().map(|vertex| *vertex as usize) {
            let at = scale * mesh.uv[vertex];
            if is_inside[vertex].is_none() && !grid.is_near(at, at, sizes[vertex], NEAR) {
                take(vertex);
            }
        }
    }
    let mut inner = vec![];
    let mut of_vertex = |vertex: u32| {
        let vertex = vertex as usize;
        if nodes[vertex] == NONE {
            nodes[vertex] = INNER + inner.len();
            inner.push(node(mesh, vertex));
        }
        nodes[vertex]
    };
    let triangles = kept.iter().map(|triangle| triangle.map(&mut of_vertex)).collect();
    let border = border.iter().map(|side| side.map(|vertex| nodes[vertex as usize])).collect();
    KeptCells { triangles, border, inner }
}

/// The index from which on the nodes inside the kept region are numbered.
pub(super) const INNER: usize = usize::MAX / 2;

fn node(mesh: &TriangleMesh, vertex: usize) -> Node {
    Node { uv: mesh.uv[vertex], point: mesh.vertices[vertex], origin: Origin::Inside }
}

/// Whether each vertex of untouched cells is inside the loops; `None` for other vertices.
fn inside(
    outline: &Outline,
    mesh: &TriangleMesh,
    cells: &[WrittenCell],
    touched: &[bool],
) -> Vec<Option<bool>> {
    // No loop passes between vertices of connected untouched cells.
    let mut connected = DisjointSets::new(mesh.vertices.len());
    let mut used = vec![false; mesh.vertices.len()];
    for (cell, _) in cells.iter().zip(touched).filter(|(_, touched)| !**touched) {
        for triangle in &mesh.triangles[cell.triangles.clone()] {
            for &vertex in triangle {
                used[vertex as usize] = true;
                connected.unite(triangle[0], vertex);
            }
        }
    }
    let mut found = vec![None; mesh.vertices.len()];
    let roots = connected.roots();
    for vertex in (0..found.len()).filter(|vertex| used[*vertex]) {
        let first = roots[vertex] as usize;
        if first == vertex {
            found[vertex] = Some(outline.contains(mesh.uv[vertex]));
        } else {
            found[vertex] = found[first];
        }
    }
    found
}

/// The sides that only one of some triangles has, in order of their vertices.
fn border(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut sides: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    sides.sort_unstable();
    let runs = sides.chunk_by(|a, b| a == b);
    runs.filter(|run| run.len() == 1).map(|run| run[0]).collect()
}
