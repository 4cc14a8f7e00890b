//! Adaptive tessellation: as few triangles as a certified tolerance allows.
//!
//! The surface is cut into blocks of Bézier patches, and each block into pieces (rectangles of the
//! parameters), until two triangles meet every piece within the tolerance. Then the corners that
//! neighbours have put on a piece's sides become corners of its triangles as well, so that no
//! vertex lies on an edge; a piece that these triangles do not meet is divided again, until nothing
//! changes. Blocks are independent in between, so the result does not depend on the threads.

use glam::{DVec2, DVec3};

use super::bernstein::Bernstein;
use super::desk::Desk;
use super::divider::Divider;
use super::estimate::Estimate;
use super::groups::{FEW, in_groups};
use super::lattice::Lattice;
use super::numbering::Numbers;
use super::options::{Limits, TessellateOptions, diagonal};
use super::piece::Piece;
use super::stitch::Borders;
use super::{MeshSlices, TriangleMesh};
use crate::error::{Error, Result};
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Share by which an estimate must pass the limit on triangles before the work is refused.
const SURELY: f64 = 2.0;

/// Parts that a surface worth sharing is divided in at least, where it can be foreseen, so that no
/// thread has long to wait for the others in the end.
const JOBS: usize = 16;

/// A finished division of a surface, ready to be written into memory of whatever origin.
#[derive(Debug)]
pub struct Tessellation<'a> {
    pub(super) surface: &'a NurbsSurface,
    pub(super) limits: Limits,
    pub(super) lattice: Lattice,
    bernstein: &'static Bernstein,
    /// The pieces of each block.
    pub(super) pieces: Vec<Vec<Piece>>,
    pub(super) borders: Borders,
    pub(super) numbers: Numbers,
    pub(super) deviation: f64,
}

impl NurbsSurface {
    /// The surface as triangles that lie within a certified tolerance of it everywhere.
    ///
    /// No vertex lies on an edge, every inner edge belongs to two triangles, closed directions are
    /// welded (unless split on request), poles are one vertex, and creases (knots repeated as often
    /// as the degree) lie on edges. The same bits for any number of threads; O(triangles).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a limit is out of its range, or so small that the mesh would have
    /// more than `options.max_triangles`; [`Error::Interrupted`] if the observer stops it.
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
        let limits = options.limits(diagonal(&[surface]))?;
        let nets = surface.patch_nets();
        let estimate = Estimate::of(&nets, &limits);
        if estimate.triangles > SURELY * options.max_triangles as f64 {
            return Err(too_many(options, &limits, estimate.triangles));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let triangles = estimate.triangles as usize;
        let lattice = Lattice::new(surface, nets, estimate);
        let bernstein = Bernstein::of(lattice.nets.degrees);
        let borders = Borders::new(&lattice);
        let mut this = Self {
            surface,
            limits,
            lattice,
            bernstein,
            pieces: vec![],
            borders,
            numbers: Numbers::default(),
            deviation: 0.0,
        };
        this.divide(options, triangles, observer)?;
        this.conform(options, observer)?;
        this.number(options.split_seams);
        if this.triangles() > options.max_triangles {
            return Err(too_many(options, &limits, this.triangles() as f64));
        }
        Ok(this)
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.numbers.vertices[self.lattice.blocks()]
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.numbers.triangles[self.lattice.blocks()]
    }

    /// See [`TriangleMesh::max_deviation`].
    #[must_use]
    pub fn max_deviation(&self) -> f64 {
        self.deviation
    }

    /// The mesh.
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn mesh(&self, observer: &mut dyn Observer) -> Result<TriangleMesh> {
        let mut mesh = TriangleMesh {
            vertices: vec![DVec3::ZERO; self.vertices()],
            triangles: vec![[0; 3]; self.triangles()],
            normals: vec![DVec3::ZERO; self.vertices()],
            uv: vec![DVec2::ZERO; self.vertices()],
            max_deviation: Some(self.deviation),
        };
        let TriangleMesh { vertices, triangles, normals, uv, .. } = &mut mesh;
        self.write(MeshSlices { vertices, triangles, normals, uv }, observer)?;
        Ok(mesh)
    }

    pub(super) fn divider(&self) -> Divider<'_> {
        let (surface, nets, bernstein) = (self.surface, &self.lattice.nets, self.bernstein);
        Divider { surface, nets, bernstein, limits: self.limits }
    }

    /// Divides each block; there will be about so many triangles.
    fn divide(
        &mut self,
        options: &TessellateOptions,
        triangles: usize,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (divider, lattice) = (self.divider(), &self.lattice);
        let blocks = lattice.blocks();
        let halvings = if triangles > FEW { JOBS / blocks } else { 0 }.checked_ilog2();
        let mut parts = Vec::with_capacity(blocks.max(JOBS));
        let mut found = vec![];
        for index in 0..blocks {
            let block = lattice.block(index);
            let whole = (Piece::of(block), halvings.unwrap_or(0));
            Desk::with(|desk| divider.spread(block, whole, desk, &mut found));
            parts.extend(found.drain(..).map(|part| (index, part)));
        }
        let job = |(): &mut (), (index, part): (usize, Piece)| {
            let mut done = vec![];
            let divide =
                |desk: &mut Desk| divider.divide(lattice.block(index), part, desk, &mut done);
            let ((), deviation) = Desk::with(divide);
            done.shrink_to_fit();
            (index, done, deviation)
        };
        let (mut count, mut deviation) = (0, 0.0_f64);
        let mut pieces: Vec<Vec<Piece>> = Vec::with_capacity(blocks);
        in_groups(parts, triangles, observer, job, |(index, done, most)| {
            count += done.len();
            deviation = deviation.max(most);
            match pieces.get_mut(index) {
                Some(others) => others.extend(done),
                None => pieces.push(done),
            }
            if 2 * count > options.max_triangles {
                let share = blocks as f64 / pieces.len() as f64;
                return Err(too_many(options, &self.limits, 2.0 * count as f64 * share));
            }
            Ok(())
        })?;
        (self.pieces, self.deviation) = (pieces, deviation);
        Ok(())
    }

    pub(super) fn sides(&self, index: usize) -> [&[u32]; 4] {
        self.borders.around(index).map(|side| self.borders.at(side))
    }
}

pub(super) fn too_many(options: &TessellateOptions, limits: &Limits, triangles: f64) -> Error {
    let must = format!("large enough for at most {} triangles", options.max_triangles);
    let got = format!("{:e}, which would take about {triangles:.1e}", limits.tolerance);
    Error::parameter("tolerance", must, got)
}
