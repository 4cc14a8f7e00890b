//! Adaptive tessellation: as few triangles as a certified tolerance allows.
//!
//! 1. The surface is cut into blocks of Bézier patches, and each block into cells (rectangles of
//!    the parameters), until the two triangles of every cell are within the tolerance.
//! 2. Cell corners on the sides of a neighboring cell become corners of its triangles as well, so
//!    that no vertex lies on an edge. A cell whose new triangles exceed the tolerance is divided
//!    again, until nothing changes.
//! 3. Vertices and triangles get their indices, and the arrays are written.
//!
//! Blocks are independent within each step, so the result does not depend on the number of threads.

use glam::{DVec2, DVec3};

use super::conform::conform;
use super::numbering::Numbering;
use super::options::TessellateOptions;
use super::partition::{Partition, too_many_triangles};
use super::surface_side::SurfaceSide;
use super::write::{WrittenCell, write, written_cells};
use super::{MeshSlices, TriangleMesh};
use crate::error::Result;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// A finished division of a surface into triangles, ready to be written to memory of the caller.
#[derive(Debug)]
pub struct Tessellation<'a> {
    partition: Partition<'a>,
    numbering: Numbering,
}

impl NurbsSurface {
    /// The surface as triangles that lie within a certified tolerance of it everywhere.
    ///
    /// No vertex lies on an edge, and every inner edge belongs to two triangles. Closed directions
    /// are welded, unless split on request. A pole is one vertex. Creases (knots repeated as often
    /// as the degree) lie on edges. The same bits for any number of threads; O(triangles).
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`](crate::Error::Parameter) if a limit is out of its range, or so small
    ///   that the mesh would have more than `options.max_triangles`.
    /// - [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn tessellate(
        &self,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<TriangleMesh> {
        Tessellation::new(self, options, observer)?.mesh(observer)
    }
}

impl<'a> Tessellation<'a> {
    /// Divides a surface.
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::tessellate`].
    pub fn new(
        surface: &'a NurbsSurface,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let mut partition = Partition::new(surface, options, observer)?;
        conform(&mut partition, options, observer)?;
        let this = Self::numbered(partition, options.split_seams);
        if this.triangles() > options.max_triangles {
            let count = this.triangles() as f64;
            return Err(too_many_triangles(options, &this.partition.limits, count));
        }
        Ok(this)
    }

    /// Numbers the vertices of cells that conform; `split` as in [`Numbering::new`].
    pub(super) fn numbered(partition: Partition<'a>, split: bool) -> Self {
        let numbering = Numbering::new(&partition, split);
        Self { partition, numbering }
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.numbering.vertices[self.partition.grid.blocks()]
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.numbering.triangles[self.partition.grid.blocks()]
    }

    /// See [`TriangleMesh::max_deviation`].
    #[must_use]
    pub fn max_deviation(&self) -> f64 {
        self.partition.deviation
    }

    /// The cells, in the order of their triangles.
    pub(super) fn cells(&self) -> Vec<WrittenCell> {
        written_cells(&self.partition, &self.numbering)
    }

    /// The parameters of the corners of cells at poles, which are one vertex in the mesh.
    pub(super) fn at_poles(&self) -> Vec<DVec2> {
        self.partition.at_poles()
    }

    /// The steps and the indices of the vertices on a side.
    pub(super) fn on_side(&self, side: SurfaceSide) -> impl Iterator<Item = (u64, u32)> + use<> {
        let vertices = side.vertices(&self.partition, &self.numbering);
        side.steps(&self.partition).into_iter().zip(vertices)
    }

    /// The mesh.
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn mesh(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        let mut mesh = TriangleMesh {
            vertices: vec![DVec3::ZERO; self.vertices()],
            triangles: vec![[0; 3]; self.triangles()],
            normals: vec![DVec3::ZERO; self.vertices()],
            uv: vec![DVec2::ZERO; self.vertices()],
            max_deviation: Some(self.max_deviation()),
        };
        let TriangleMesh { vertices, triangles, normals, uv, .. } = &mut mesh;
        self.write(MeshSlices { vertices, triangles, normals, uv }, observer)?;
        Ok(mesh)
    }

    /// Writes the mesh to memory of the caller.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if a slice has the wrong length;
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn write(&self, out: MeshSlices<'_>, observer: &mut dyn Observer) -> Result<()> {
        write(&self.partition, &self.numbering, out, observer)
    }
}
