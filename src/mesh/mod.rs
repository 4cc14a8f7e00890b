//! Triangle meshes of surfaces, faces and shells, within a tolerance or on a uniform grid, and their measures.

mod adaptive;
mod basis_weights;
mod bernstein;
mod bezier_triangle;
mod block;
mod block_edges;
mod block_grid;
mod block_vertices;
mod cell;
mod cell_mesh;
mod certify;
mod chord;
mod conform;
mod curve_extent;
mod de_casteljau;
mod distance;
mod distance_bound;
mod edge_points;
mod edge_use;
mod estimate;
mod face_frame;
mod face_mesh;
mod kept_cells;
mod lanes;
mod measure;
mod mesh_join;
mod net;
mod numbering;
mod options;
mod outline;
mod parallel_map;
mod partition;
mod patch_bound;
mod polygon;
mod recheck;
mod retriangulate;
mod segment_bound;
mod shared_side;
mod shell_mesh;
mod side_grid;
mod sparse_matrix;
mod split_rule;
mod strip;
mod strip_triangulation;
mod subdivide;
mod subdivider;
mod surface_bound;
mod surface_part;
mod surface_side;
mod triangle_conversion;
mod triangulation;
mod uniform;
mod whole_faces;
mod workspace;
mod write;

use glam::{DVec2, DVec3};

pub use self::adaptive::Tessellation;
pub use self::distance::DistanceSearch;
pub use self::options::{MAX_TRIANGLES, TessellateOptions};
pub use self::shell_mesh::ShellMesh;
pub use self::uniform::{MeshSlices, UniformGrid};

/// A triangle mesh with a normal and the surface's parameters at each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, in the points' unit.
    pub vertices: Vec<DVec3>,
    /// Three vertex indices each, counter-clockwise seen from the side that the normals point to.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the surface at the vertices.
    pub normals: Vec<DVec3>,
    /// Parameters (u, v) of the vertices on the surface.
    pub uv: Vec<DVec2>,
    /// An upper bound of the distance between the surface and the triangles, in both directions, in
    /// the points' unit. `None` for uniform grids.
    pub max_deviation: Option<f64>,
}

/// Borrowed arrays of a mesh, the input of all functions on meshes.
#[derive(Clone, Copy, Debug)]
pub struct MeshView<'a> {
    /// See [`TriangleMesh::vertices`].
    pub vertices: &'a [DVec3],
    /// See [`TriangleMesh::triangles`].
    pub triangles: &'a [[u32; 3]],
    /// See [`TriangleMesh::normals`].
    pub normals: &'a [DVec3],
    /// See [`TriangleMesh::uv`].
    pub uv: &'a [DVec2],
}

impl TriangleMesh {
    /// The arrays of this mesh.
    #[must_use]
    pub fn view(&self) -> MeshView<'_> {
        let Self { vertices, triangles, normals, uv, .. } = self;
        MeshView { vertices, triangles, normals, uv }
    }
}
