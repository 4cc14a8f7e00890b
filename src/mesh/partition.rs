//! The partition of a surface into blocks of cells, and its first stage: each block on its own.

use glam::DVec2;

use super::block::parameter;
use super::block_edges::BlockEdges;
use super::block_grid::BlockGrid;
use super::cell::Cell;
use super::estimate::Estimate;
use super::options::{Limits, TessellateOptions};
use super::parallel_map::{MIN_PARALLEL_TRIANGLES, parallel_map};
use super::subdivider::Subdivider;
use super::triangle_conversion::TriangleConversion;
use super::workspace::Workspace;
use crate::error::{Error, Result};
use crate::memory;
use crate::nurbs::NurbsSurface;
use crate::progress::Observer;

/// Factor by which an estimate must exceed the limit on triangles before the work is refused.
const REFUSAL_FACTOR: f64 = 2.0;

/// Memory for a triangle, in bytes: its cell, and the vertices, normals and parameters of the mesh.
const BYTES_PER_TRIANGLE: u128 = 150;

/// Parts that a large surface is divided into at least, so that all threads finish together.
const MIN_PARTS: usize = 16;

/// A surface divided into cells.
#[derive(Debug)]
pub(super) struct Partition<'a> {
    pub surface: &'a NurbsSurface,
    pub limits: Limits,
    pub grid: BlockGrid,
    conversion: &'static TriangleConversion,
    /// The cells of each block.
    pub cells: Vec<Vec<Cell>>,
    pub edges: BlockEdges,
    /// The largest certified distance between the surface and the triangles of a cell.
    pub deviation: f64,
}

impl<'a> Partition<'a> {
    /// Divides each block until two triangles for each cell meet the limits.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a limit out of its range, or if the cells become too many;
    /// [`Error::Interrupted`] if the observer stops it.
    pub(super) fn new(
        surface: &'a NurbsSurface,
        options: &TessellateOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let limits = options.limits(&[surface])?;
        let nets = surface.patch_nets();
        let estimate = Estimate::of(&nets, &limits);
        if estimate.triangles > REFUSAL_FACTOR * options.max_triangles as f64 {
            return Err(too_many_triangles(options, &limits, estimate.triangles));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let triangles = estimate.triangles as usize;
        memory::check(BYTES_PER_TRIANGLE * triangles as u128, || {
            format!("a mesh of about {:.1e} triangles", estimate.triangles)
        })?;
        let grid = BlockGrid::new(surface, nets, estimate);
        let conversion = TriangleConversion::of(grid.nets.degrees);
        let edges = BlockEdges::new(&grid);
        let mut this =
            Self { surface, limits, grid, conversion, cells: vec![], edges, deviation: 0.0 };
        this.subdivide(options, triangles, observer)?;
        Ok(this)
    }

    /// The subdivision of this surface's cells.
    pub(super) fn subdivider(&self) -> Subdivider<'_> {
        let (surface, nets, conversion) = (self.surface, &self.grid.nets, self.conversion);
        Subdivider { surface, nets, conversion, limits: self.limits }
    }

    /// The vertices inside the four edges of a block, in the order of [`BlockEdges::of_block`].
    pub(super) fn edge_vertices(&self, block: usize) -> [&[u32]; 4] {
        self.edges.of_block(block).map(|edge| self.edges.vertices(edge))
    }

    /// The parameters of the corners of cells on sides that are poles.
    pub(super) fn at_poles(&self) -> Vec<DVec2> {
        let (grid, mut all) = (&self.grid, vec![]);
        let (rows, cols) = grid.shape();
        for line in [0, rows].into_iter().filter(|line| grid.is_pole_u(*line)) {
            let u = grid.nets.u[grid.u[line]];
            for j in 0..cols {
                let steps = self.edges.vertices(self.edges.at_u(line, j));
                let on_edge = steps.iter().map(|step| parameter(&grid.nets.v, grid.v[j], *step));
                let corner = grid.nets.v[grid.v[j]];
                all.extend(on_edge.chain([corner]).map(|v| DVec2::new(u, v)));
            }
        }
        for line in [0, cols].into_iter().filter(|line| grid.is_pole_v(*line)) {
            let v = grid.nets.v[grid.v[line]];
            for i in 0..rows {
                let steps = self.edges.vertices(self.edges.at_v(i, line));
                let on_edge = steps.iter().map(|step| parameter(&grid.nets.u, grid.u[i], *step));
                let corner = grid.nets.u[grid.u[i]];
                all.extend(on_edge.chain([corner]).map(|u| DVec2::new(u, v)));
            }
        }
        all
    }

    /// Subdivides each block; `triangles` is the estimated number of all triangles.
    fn subdivide(
        &mut self,
        options: &TessellateOptions,
        triangles: usize,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (subdivider, grid) = (self.subdivider(), &self.grid);
        let blocks = grid.blocks();
        let halvings =
            if triangles > MIN_PARALLEL_TRIANGLES { MIN_PARTS / blocks } else { 0 }.checked_ilog2();
        let mut parts = Vec::with_capacity(blocks.max(MIN_PARTS));
        let mut found = vec![];
        for index in 0..blocks {
            let block = grid.block(index);
            let whole = (Cell::of(block), halvings.unwrap_or(0));
            Workspace::with(|workspace| {
                subdivider.split_into_parts(block, whole, workspace, &mut found);
            });
            parts.extend(found.drain(..).map(|part| (index, part)));
        }
        let job = |(): &mut (), (index, part): (usize, Cell)| {
            let mut done = vec![];
            let ((), deviation) = Workspace::with(|workspace| {
                subdivider.subdivide(grid.block(index), part, workspace, &mut done);
            });
            done.shrink_to_fit();
            (index, done, deviation)
        };
        let (mut count, mut deviation) = (0, 0.0_f64);
        let mut cells: Vec<Vec<Cell>> = Vec::with_capacity(blocks);
        parallel_map(parts, triangles, observer, job, |(index, done, most)| {
            count += done.len();
            deviation = deviation.max(most);
            match cells.get_mut(index) {
                Some(others) => others.extend(done),
                None => cells.push(done),
            }
            if 2 * count > options.max_triangles {
                let share = blocks as f64 / cells.len() as f64;
                return Err(too_many_triangles(options, &self.limits, 2.0 * count as f64 * share));
            }
            Ok(())
        })?;
        (self.cells, self.deviation) = (cells, deviation);
        Ok(())
    }
}

/// The error for a tolerance that would make too many triangles.
pub(super) fn too_many_triangles(
    options: &TessellateOptions,
    limits: &Limits,
    triangles: f64,
) -> Error {
    let must = format!("large enough for at most {} triangles", options.max_triangles);
    let got = format!("{:e}, which would take about {triangles:.1e}", limits.tolerance);
    Error::parameter("tolerance", must, got)
}
