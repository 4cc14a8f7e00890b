//! The surface over cells during subdivision: their control nets, samples and points.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use std::ops::Range;

use glam::{DVec2, DVec4};

use super::basis_weights::BasisWeights;
use super::block::{Block, GridPoint, PATCH_STEPS, fraction};
use super::cell::{Cell, PatchRange};
use super::net::Net;
use super::options::Limits;
use super::surface_part::SurfacePart;
use super::triangle_conversion::TriangleConversion;
use super::workspace::{MAX_SAMPLES, Workspace};
use crate::nurbs::{NurbsSurface, PatchNets, in_space};

/// Patches of a cell along one direction from which on it is sampled at four points, not at three.
///
/// Most cells of several patches have two or three in a direction and will be split.
const MIN_PATCHES_FOR_FOUR_SAMPLES: u32 = 16;

/// The data for subdividing the cells of one surface.
#[derive(Debug)]
pub(super) struct Subdivider<'a> {
    pub surface: &'a NurbsSurface,
    /// The Bézier patches of the surface.
    pub nets: &'a PatchNets,
    /// The conversion of these patches to triangles.
    pub conversion: &'a TriangleConversion,
    pub limits: Limits,
}

impl Subdivider<'_> {
    /// Loads the net of a cell as the only one of the workspace; of several patches, the samples.
    pub(super) fn load(&self, block: Block, cell: Cell, workspace: &mut Workspace) {
        workspace.nets.clear();
        workspace.points.clear();
        if cell.is_single() {
            for range in cell.patch_ranges() {
                self.surface_part(block, &range, &mut workspace.nets);
            }
            workspace.points.extend(workspace.nets.iter().map(|h| in_space(*h)));
            return;
        }
        let (p, q) = self.nets.degrees;
        let degrees = self.net_degrees(&cell);
        let (Workspace { points, sample_uv, columns, .. }, mut row) =
            (workspace, BasisWeights::default());
        let (columns, mut ys) = (&mut columns[..=degrees.1], [0.0; MAX_SAMPLES]);
        for (j, (column, y)) in columns.iter_mut().zip(&mut ys).enumerate() {
            let at = sample_step(cell.v, j, degrees.1);
            column.set(at, block.cols.0, q);
            *y = fraction(at, cell.v);
        }
        sample_uv.clear();
        for i in 0..=degrees.0 {
            let at = sample_step(cell.u, i, degrees.0);
            row.set(at, block.rows.0, p);
            let x = fraction(at, cell.u);
            sample_uv.extend(ys[..=degrees.1].iter().map(|y| DVec2::new(x, *y)));
            let point = |column: &BasisWeights| self.nets.point(row.weights(), column.weights());
            points.extend(columns.iter().map(|column| in_space(point(column))));
        }
    }

    /// The degrees of the net that a cell is loaded as.
    ///
    /// For a cell of several patches, the points are surface points: at the ends and evenly spaced
    /// between them.
    #[inline(always)]
    pub(super) fn net_degrees(&self, cell: &Cell) -> (usize, usize) {
        if cell.is_single() {
            return self.nets.degrees;
        }
        let degree = |(from, to): (u32, u32)| {
            if (to - from) / PATCH_STEPS < MIN_PATCHES_FOR_FOUR_SAMPLES {
                2
            } else {
                MAX_SAMPLES - 1
            }
        };
        (degree(cell.u), degree(cell.v))
    }

    /// The indices of the corners in the loaded net of a cell, counter-clockwise.
    #[inline(always)]
    pub(super) fn corner_indices(&self, cell: &Cell) -> [usize; 4] {
        let (p, q) = self.net_degrees(cell);
        [0, p * (q + 1), (p + 1) * (q + 1) - 1, q]
    }

    /// The surface over a range of patches of a cell; its control points are written to `points`.
    ///
    /// `points` must be empty.
    pub(super) fn surface_part<'a>(
        &self,
        block: Block,
        range: &PatchRange,
        points: &'a mut Vec<DVec4>,
    ) -> SurfacePart<'a> {
        let PatchRange { rows, cols, u, v, low, high } = range;
        let move_by = |range: &Range<usize>, by: usize| range.start + by..range.end + by;
        let (rows, cols) = (move_by(rows, block.rows.0), move_by(cols, block.cols.0));
        let (patches, degrees) = ((rows.len(), cols.len()), self.nets.degrees);
        self.nets.append(rows, cols, points);
        self.conversion.rectangle(points, patches.1 * degrees.1 + 1, *u, *v);
        SurfacePart { low: *low, high: *high, net: Net { points, patches, degrees } }
    }

    /// The homogeneous surface point at integer coordinates of a block.
    pub(super) fn point(&self, block: Block, (u, v): GridPoint) -> DVec4 {
        let (p, q) = self.nets.degrees;
        let row = BasisWeights::of(u, block.rows.0, p);
        let col = BasisWeights::of(v, block.cols.0, q);
        self.nets.point(row.weights(), col.weights())
    }
}

/// The k-th of n + 1 samples of a range; of several patches, at boundaries of patches.
fn sample_step((from, to): (u32, u32), k: usize, n: usize) -> u32 {
    if k == n {
        return to;
    }
    let step = if to - from > PATCH_STEPS { PATCH_STEPS } else { 1 };
    let steps = ((to - from) / step) as usize * k / n;
    from + u32::try_from(steps).unwrap_or(0) * step
}
