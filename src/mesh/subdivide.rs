//! Subdivides the cells of a block until their triangles meet the limits.
//!
//! A cell beyond the limits is halved across the direction that bends more. A cell of several
//! patches is halved between patches.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use pulp::{Simd, WithSimd};

use super::block::Block;
use super::cell::{Cell, Direction};
use super::cell_mesh::{Corner, UNIT_SQUARE};
use super::certify::ball_bound;
use super::net::Net;
use super::subdivider::Subdivider;
use super::surface_part::SurfacePart;
use super::triangulation::Triangulation;
use super::workspace::Workspace;
use crate::nurbs::{halve, in_space};

impl Subdivider<'_> {
    /// Divides a cell until two triangles for each part meet the limits; appends the parts to
    /// `done`.
    pub(super) fn subdivide(
        &self,
        block: Block,
        cell: Cell,
        workspace: &mut Workspace,
        done: &mut Vec<Cell>,
    ) {
        if cell.is_single() {
            self.load(block, cell, workspace);
            workspace.arch.dispatch(SubdividePatch {
                subdivider: self,
                block,
                cell,
                workspace,
                done,
            });
            return;
        }
        let mut certified = cell;
        match self.triangulate(block, &mut certified, &cell.corners(), workspace) {
            None => done.push(certified),
            Some(direction) => self.split(block, (cell, direction), workspace, done),
        }
    }

    /// Halves a cell of several patches at most `halvings` times; appends the parts.
    ///
    /// It stops early at cells that [`Subdivider::subdivide`] may leave whole.
    pub(super) fn split_into_parts(
        &self,
        block: Block,
        (cell, halvings): (Cell, u32),
        workspace: &mut Workspace,
        parts: &mut Vec<Cell>,
    ) {
        if halvings > 0 && !cell.is_single() {
            self.load(block, cell, workspace);
            if let (Some(direction), _) = self.predicted_split(&cell, &workspace.points) {
                for half in cell.halves(direction) {
                    self.split_into_parts(block, (half, halvings - 1), workspace, parts);
                }
                return;
            }
        }
        parts.push(cell);
    }

    /// Splits a cell in a direction and subdivides both halves.
    pub(super) fn split(
        &self,
        block: Block,
        (cell, direction): (Cell, Direction),
        workspace: &mut Workspace,
        done: &mut Vec<Cell>,
    ) {
        for half in cell.halves(direction) {
            self.subdivide(block, half, workspace, done);
        }
    }

    /// As [`Subdivider::subdivide`], for a cell of one patch whose net is loaded; removes the net.
    #[inline(always)]
    fn subdivide_patch<S: Simd>(
        &self,
        simd: S,
        (block, cell): (Block, Cell),
        workspace: &mut Workspace,
        done: &mut Vec<Cell>,
    ) {
        let (p, q) = (self.conversion.p, self.conversion.q);
        let size = (p + 1) * (q + 1);
        workspace.cells.clear();
        workspace.cells.push(cell);
        while let Some(cell) = workspace.cells.pop() {
            let start = workspace.nets.len() - size;
            let Some(direction) = self.triangulate_loaded(simd, (block, cell), workspace, done)
            else {
                workspace.nets.truncate(start);
                continue;
            };
            let [first, second] = cell.halves(direction);
            // The net of the second half replaces that of the cell; the first half's is appended.
            workspace.cells.extend([second, first]);
            workspace.nets.extend_from_within(start..);
            let (below, above) = workspace.nets.split_at_mut(start + size);
            let below = &mut below[start..];
            match direction {
                Direction::U => halve(above, below, p, q + 1, 0..=q),
                Direction::V => halve(above, below, q, 1, (0..=p).map(|row| row * (q + 1))),
            }
        }
    }

    /// Triangulates the cell whose net is the last of the workspace.
    ///
    /// Appends the cell to `done` if it meets the limits; else returns the direction to split it
    /// in.
    #[inline(always)]
    fn triangulate_loaded<S: Simd>(
        &self,
        simd: S,
        (block, cell): (Block, Cell),
        workspace: &mut Workspace,
        done: &mut Vec<Cell>,
    ) -> Option<Direction> {
        let degrees = self.nets.degrees;
        let tolerance = self.limits.tolerance;
        let net = &workspace.nets[workspace.nets.len() - (degrees.0 + 1) * (degrees.1 + 1)..];
        workspace.points.clear();
        workspace.points.extend(net.iter().map(|h| in_space(*h)));
        let (predicted, bending) = self.predicted_split(&cell, &workspace.points);
        if predicted.is_some() {
            return predicted;
        }
        let ends = self.corner_indices(&cell).map(|k| workspace.points[k].truncate());
        let corners = [0, 1, 2, 3].map(|k| Corner { at: UNIT_SQUARE[k], point: ends[k] });
        let triangulation = Triangulation::best(&corners, [0, 1, 2, 3], bending, tolerance);
        workspace.faces.clear();
        triangulation.faces([0, 1, 2, 3], &mut workspace.faces);
        let mesh = (&corners[..], &workspace.faces[..]);
        let certifier = &mut workspace.certifier;
        let distance = if certifier.start(mesh) {
            let whole = SurfacePart::whole(Net::single(net, degrees));
            certifier.certify(self.conversion, whole, mesh, tolerance).with_simd(simd)
        } else {
            ball_bound(Net::single(net, degrees), mesh)
        };
        let corners = cell.corners();
        let samples = (distance, &workspace.points[..]);
        let direction = self.required_split((block, cell), &corners, mesh, samples);
        if direction.is_none() {
            workspace.deviation = workspace.deviation.max(distance);
            let triangulation = triangulation.with_certified_share(distance / tolerance);
            done.push(Cell { triangulation, ..cell });
        }
        direction
    }
}

/// The call of [`Subdivider::subdivide_patch`] for SIMD dispatch.
struct SubdividePatch<'a> {
    subdivider: &'a Subdivider<'a>,
    block: Block,
    cell: Cell,
    workspace: &'a mut Workspace,
    done: &'a mut Vec<Cell>,
}

impl WithSimd for SubdividePatch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { subdivider, block, cell, workspace, done } = self;
        subdivider.subdivide_patch(simd, (block, cell), workspace, done);
    }
}
