//! Triangles: what a surface becomes for renderers, printers and everything else that knows none.

mod adaptive;
mod bernstein;
mod certify;
mod chord;
mod conform;
mod cost;
mod desk;
mod distance;
mod divider;
mod estimate;
mod frame;
mod groups;
mod lattice;
mod located;
mod means;
mod measure;
mod net;
mod numbering;
mod options;
mod outline;
mod piece;
mod polygon;
mod recut;
mod review;
mod stitch;
mod triangle;
mod uniform;
mod write;

use glam::{DVec2, DVec3};

pub use self::adaptive::Tessellation;
pub use self::distance::DistanceSearch;
pub use self::options::{MAX_TRIANGLES, TessellateOptions};
pub use self::uniform::{MeshSlices, UniformGrid};

/// A triangle mesh with a normal and the surface's parameters at each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, in the points' unit.
    pub vertices: Vec<DVec3>,
    /// Three vertex numbers each, counter-clockwise seen from the side that normals point to.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the surface at the vertices.
    pub normals: Vec<DVec3>,
    /// Parameters (u, v) of the vertices on the surface.
    pub uv: Vec<DVec2>,
    /// An upper bound of the distance between the surface and the triangles, in both directions,
    /// in the points' unit; `None` of uniform grids.
    pub max_deviation: Option<f64>,
}

/// A mesh whose arrays belong to somebody else; what functions over meshes work on.
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
    /// The mesh's own arrays.
    #[must_use]
    pub fn view(&self) -> MeshView<'_> {
        let Self { vertices, triangles, normals, uv, .. } = self;
        MeshView { vertices, triangles, normals, uv }
    }
}
