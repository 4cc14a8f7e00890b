//! The four sides of a divided surface, with integer coordinates along them.

use glam::{DVec2, DVec3};

use super::block::{PATCH_STEPS, parameter};
use super::block_edges::EdgeIndex;
use super::block_grid::BlockGrid;
use super::cell::Direction;
use super::numbering::Numbering;
use super::partition::Partition;
use crate::nurbs::{NurbsCurve, NurbsSurface};

/// A side of the rectangle of a surface's parameters.
///
/// Steps are coordinates along it: [`PATCH_STEPS`] for each patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SurfaceSide {
    /// The parameter that is constant.
    constant: Direction,
    /// Whether it is at the end of its domain.
    at_end: bool,
}

impl SurfaceSide {
    /// The side along which a segment in (u, v) runs.
    pub(super) fn of(surface: &NurbsSurface, [from, to]: [DVec2; 2]) -> Self {
        let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
        let size = DVec2::new(u.1 - u.0, v.1 - v.0);
        let along = (to - from).abs() / size;
        let middle = (0.5 * (from + to) - DVec2::new(u.0, v.0)) / size;
        if along.x < along.y {
            Self { constant: Direction::U, at_end: middle.x > 0.5 }
        } else {
            Self { constant: Direction::V, at_end: middle.y > 0.5 }
        }
    }

    /// The parameter along the side.
    pub(super) fn along(self, at: DVec2) -> f64 {
        match self.constant {
            Direction::U => at.y,
            Direction::V => at.x,
        }
    }

    /// Whether the side is a pole of the grid.
    pub(super) fn is_pole(self, grid: &BlockGrid) -> bool {
        match self.constant {
            Direction::U => grid.is_pole_u(self.line(grid)),
            Direction::V => grid.is_pole_v(self.line(grid)),
        }
    }

    /// The step nearest to a parameter.
    pub(super) fn step(self, grid: &BlockGrid, at: f64) -> u64 {
        let (breaks, _) = self.lines(grid);
        let patch = breaks.partition_point(|start| *start <= at).clamp(1, breaks.len() - 1) - 1;
        let share = (at - breaks[patch]) / (breaks[patch + 1] - breaks[patch]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let rest = (share.clamp(0.0, 1.0) * f64::from(PATCH_STEPS)).round() as u64;
        first_step(patch) + rest
    }

    /// The parameter of a step.
    pub(super) fn parameter(self, grid: &BlockGrid, step: u64) -> f64 {
        let (patch, rest) = split(step);
        parameter(self.lines(grid).0, patch, rest)
    }

    /// The steps of the vertices, ends included, in order.
    pub(super) fn steps(self, partition: &Partition<'_>) -> Vec<u64> {
        let (_, lines) = self.lines(&partition.grid);
        let mut all = vec![];
        for (k, start) in lines[..lines.len() - 1].iter().enumerate() {
            let inside = partition.edges.vertices(self.edge(partition, k)).iter();
            all.push(first_step(*start));
            all.extend(inside.map(|step| first_step(*start) + u64::from(*step)));
        }
        all.push(first_step(lines[lines.len() - 1]));
        all
    }

    /// The indices of these vertices.
    pub(super) fn vertices(self, partition: &Partition<'_>, numbering: &Numbering) -> Vec<u32> {
        let (line, cols) = (self.line(&partition.grid), partition.grid.shape().1);
        let corner = |k: usize| match self.constant {
            Direction::U => numbering.corners[line * (cols + 1) + k],
            Direction::V => numbering.corners[k * (cols + 1) + line],
        };
        let blocks = self.lines(&partition.grid).1.len() - 1;
        let mut all = vec![];
        for k in 0..blocks {
            let (first, _) = match self.constant {
                Direction::U => numbering.edges_u[line * cols + k],
                Direction::V => numbering.edges_v[k * (cols + 1) + line],
            };
            let inside = partition.edges.vertices(self.edge(partition, k));
            all.push(corner(k));
            all.extend((first..).take(inside.len()));
        }
        all.push(corner(blocks));
        all
    }

    /// Adds a vertex; returns whether it is new.
    pub(super) fn add(self, partition: &mut Partition<'_>, step: u64) -> bool {
        let (_, lines) = self.lines(&partition.grid);
        let block = lines.partition_point(|line| first_step(*line) <= step) - 1;
        let inside = step - first_step(lines[block]);
        if inside == 0 {
            return false;
        }
        let edge = self.edge(partition, block);
        partition.edges.add(edge, &[u32::try_from(inside).unwrap_or(u32::MAX)])
    }

    /// The line between blocks on which the side lies.
    fn line(self, grid: &BlockGrid) -> usize {
        let (rows, cols) = grid.shape();
        match (self.at_end, self.constant) {
            (false, _) => 0,
            (true, Direction::U) => rows,
            (true, Direction::V) => cols,
        }
    }

    /// The parameters between patches along the side, and the indices of those between blocks.
    fn lines(self, grid: &BlockGrid) -> (&[f64], &[usize]) {
        match self.constant {
            Direction::U => (&grid.nets.v, &grid.v),
            Direction::V => (&grid.nets.u, &grid.u),
        }
    }

    /// The edge of the k-th block along the side.
    fn edge(self, partition: &Partition<'_>, k: usize) -> EdgeIndex {
        let line = self.line(&partition.grid);
        match self.constant {
            Direction::U => partition.edges.at_u(line, k),
            Direction::V => partition.edges.at_v(k, line),
        }
    }
}

/// The first and the last point of a curve in (u, v).
pub(super) fn ends(curve: &NurbsCurve) -> [DVec2; 2] {
    let points = curve.control_points();
    [points[0], points[points.len() - 1]].map(DVec3::truncate)
}

/// The step at the start of a patch.
fn first_step(patch: usize) -> u64 {
    patch as u64 * u64::from(PATCH_STEPS)
}

/// The patch of a step, and the steps from its start.
fn split(step: u64) -> (usize, u32) {
    let (patch, rest) = (step / u64::from(PATCH_STEPS), step % u64::from(PATCH_STEPS));
    (usize::try_from(patch).unwrap_or(usize::MAX), u32::try_from(rest).unwrap_or(0))
}
