//! The meshes of faces as one, with common vertices on common edges.

use std::collections::HashMap;

use super::TriangleMesh;
use super::face_mesh::FaceMesh;
use super::numbering::vertex_index;
use super::outline::Origin;
use crate::brep::Face;

/// Joins the meshes of faces; `deviation` is that of the edges. Returns the mesh, and the index of the
/// face of each triangle.
pub(super) fn join(
    faces: &[Face],
    meshes: &[&FaceMesh],
    deviation: f64,
) -> (TriangleMesh, Vec<u32>) {
    let mut out = TriangleMesh::default();
    let mut on_edges: HashMap<Origin, u32> = HashMap::new();
    let (mut of_triangles, mut deviation) = (vec![], deviation);
    for (face, mesh) in meshes.iter().enumerate() {
        let is_reversed = faces[face].is_reversed();
        let mut numbers = Vec::with_capacity(mesh.nodes.len());
        for (node, normal) in mesh.nodes.iter().zip(&mesh.normals) {
            let next = vertex_index(out.vertices.len());
            let number = match node.origin {
                Origin::Inside => next,
                origin => *on_edges.entry(origin).or_insert(next),
            };
            numbers.push(number);
            if number == next {
                out.vertices.push(node.point);
                out.uv.push(node.uv);
                out.normals.push(if is_reversed { -*normal } else { *normal });
            }
        }
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|k| numbers[k]);
            out.triangles.push(if is_reversed { [a, c, b] } else { [a, b, c] });
        }
        of_triangles.resize(out.triangles.len(), vertex_index(face));
        deviation = deviation.max(mesh.deviation);
    }
    out.max_deviation = Some(deviation);
    (out, of_triangles)
}

/// The sides between points of edges that more than two triangles share, and their faces.
pub(super) fn overused(meshes: &[Option<FaceMesh>]) -> Vec<(usize, [Origin; 2])> {
    let mut sides = vec![];
    for (face, mesh) in meshes.iter().enumerate() {
        let Some(mesh) = mesh else { continue };
        for &[a, b, c] in &mesh.triangles {
            for ends in [[a, b], [b, c], [c, a]] {
                let [a, b] = ends.map(|k| mesh.nodes[k].origin);
                if a != Origin::Inside && b != Origin::Inside {
                    sides.push(([a.min(b), a.max(b)], face));
                }
            }
        }
    }
    sides.sort_unstable();
    let shared = sides.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 2);
    shared.flatten().map(|(side, face)| (*face, *side)).collect()
}
