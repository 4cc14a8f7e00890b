//! Whether a cell must be split, and in which direction.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec3, DVec4};

use super::block::{Block, GridPoint, parameter};
use super::cell::{Cell, Direction};
use super::cell_mesh::{CellMesh, UNIT_SQUARE};
use super::curve_extent::CurveExtent;
use super::options::Limits;
use super::subdivider::Subdivider;
use crate::nurbs::Bending;

/// Sag of a curve, relative to the tolerance, below which its length decides how to split.
const MIN_RELATIVE_SAG: f64 = 1.0 / 4.0;

impl Subdivider<'_> {
    /// The bending of a cell, and the direction to split it in if its sag exceeds the tolerance.
    ///
    /// The sag is an estimate: cells above the tolerance are split without a certified distance.
    #[inline(always)]
    pub(super) fn predicted_split(
        &self,
        cell: &Cell,
        points: &[DVec4],
    ) -> (Option<Direction>, Bending) {
        let bending = if cell.is_single() {
            Bending::of(points, self.nets.degrees)
        } else {
            Bending::through(points, self.net_degrees(cell))
        };
        if cell.divisible() && bending.sag_of_square() > self.limits.tolerance {
            return (Some(self.split_direction(cell, points)), bending);
        }
        (None, bending)
    }

    /// The direction to split a cell in if its triangles exceed the limits and it is divisible.
    ///
    /// `distance` bounds the distance of the triangles from the surface.
    #[inline(always)]
    pub(super) fn required_split(
        &self,
        (block, cell): (Block, Cell),
        outline: &[GridPoint],
        mesh: CellMesh<'_>,
        (distance, points): (f64, &[DVec4]),
    ) -> Option<Direction> {
        let direction = if distance <= self.limits.tolerance {
            self.split_for_shape(block, outline, mesh)
        } else {
            Some(self.split_direction(&cell, points))
        };
        direction.filter(|_| cell.divisible())
    }

    /// The direction whose curves bend more, or are longer if both are nearly straight.
    #[inline(always)]
    pub(super) fn split_direction(&self, cell: &Cell, points: &[DVec4]) -> Direction {
        let (p, q) = self.net_degrees(cell);
        let (mut u, mut v) = (CurveExtent::default(), CurveExtent::default());
        for j in 0..=q {
            u.add(points, (j, q + 1), p);
        }
        for i in 0..=p {
            v.add(points, (i * (q + 1), 1), q);
        }
        let sag_squared = (self.limits.tolerance * MIN_RELATIVE_SAG).powi(2);
        let bent = u.sag_squared.max(v.sag_squared) > sag_squared;
        let along_u = if bent {
            u.sag_squared >= v.sag_squared
        } else {
            u.length_squared >= v.length_squared
        };
        if along_u { Direction::U } else { Direction::V }
    }

    /// The direction to split a cell in if its triangles exceed the limits of edges, aspect or
    /// angles.
    fn split_for_shape(
        &self,
        block: Block,
        outline: &[GridPoint],
        (corners, faces): CellMesh<'_>,
    ) -> Option<Direction> {
        if self.limits.only_distance() {
            return None;
        }
        let Limits { cosine, edge, aspect, .. } = self.limits;
        let [a, b, c, d] = UNIT_SQUARE.map(|at| corners.iter().position(|corner| corner.at == at));
        let (a, b, c, d) = (a?, b?, c?, d?);
        let length = |i: usize, j: usize| corners[i].point.distance(corners[j].point);
        let (along_u, along_v) = (length(a, b) + length(d, c), length(a, d) + length(b, c));
        let longer = if along_u >= along_v { Direction::U } else { Direction::V };
        let edges = || faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        if edge.is_some_and(|most| edges().any(|(i, j)| length(i, j) > most)) {
            return Some(longer);
        }
        let (short, long) = (along_u.min(along_v), along_u.max(along_v));
        if aspect.is_some_and(|most| short > 0.0 && long > most * short) {
            return Some(longer);
        }
        let least = cosine?;
        let normal = |&(u, v): &GridPoint| {
            let u = parameter(&self.nets.u, block.rows.0, u);
            self.surface.normal(u, parameter(&self.nets.v, block.cols.0, v))
        };
        let normals: Vec<DVec3> = outline.iter().map(normal).collect();
        let cosine = |i: usize, j: usize| normals[i].dot(normals[j]);
        let turned = edges().any(|(i, j)| cosine(i, j) < least && length(i, j) > 0.0);
        let in_u = cosine(a, b) + cosine(d, c) <= cosine(a, d) + cosine(b, c);
        turned.then_some(if in_u { Direction::U } else { Direction::V })
    }
}
