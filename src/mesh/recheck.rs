//! Rechecks a run of cells against the vertices on their sides, and splits those that fail.

use super::block::GridPoint;
use super::block_vertices::BlockVertices;
use super::cell::Cell;
use super::partition::Partition;
use super::workspace::Workspace;

/// Scratch memory of a thread for the outlines of cells.
#[derive(Default)]
pub(super) struct OutlineWorkspace {
    vertices: BlockVertices,
    /// The ranks of the vertices around a cell.
    ranks: Vec<usize>,
    /// The coordinates of the vertices around a cell.
    outline: Vec<GridPoint>,
}

/// Consecutive cells of a block.
pub(super) struct CellRun<'a> {
    pub block: usize,
    /// The index of the first cell in the block.
    pub first: usize,
    pub cells: &'a mut [Cell],
    /// The vertices of the block; `None` if these are all its cells.
    pub vertices: Option<&'a BlockVertices>,
}

/// Cells of a block that were split, in order.
pub(super) struct SplitCells {
    pub block: usize,
    /// The index of each cell, and the end of its parts in `parts`.
    ends: Vec<(usize, usize)>,
    parts: Vec<Cell>,
}

impl SplitCells {
    /// Whether no cell was split.
    pub(super) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Number of parts of all cells.
    pub(super) fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Replaces the split cells of one block by their parts.
    pub(super) fn replace(all: &[Self], cells: &mut Vec<Cell>) {
        let more = all.iter().map(|split| split.parts.len() - split.ends.len());
        let mut new = Vec::with_capacity(cells.len() + more.sum::<usize>());
        let mut kept = 0;
        for Self { ends, parts, .. } in all {
            let mut start = 0;
            for &(index, end) in ends {
                new.extend_from_slice(&cells[kept..index]);
                new.extend_from_slice(&parts[start..end]);
                (kept, start) = (index + 1, end);
            }
        }
        new.extend_from_slice(&cells[kept..]);
        *cells = new;
    }
}

/// Triangulates the cells that have new vertices on their sides; splits those beyond the limits.
pub(super) fn recheck(
    partition: &Partition<'_>,
    workspace: &mut Workspace,
    outlines: &mut OutlineWorkspace,
    run: CellRun<'_>,
) -> SplitCells {
    let CellRun { block: index, first, cells, vertices } = run;
    let (block, subdivider) = (partition.grid.block(index), partition.subdivider());
    let OutlineWorkspace { vertices: own, ranks, outline } = outlines;
    let vertices = vertices.unwrap_or_else(|| {
        own.collect(block, cells, partition.edge_vertices(index));
        own
    });
    let mut split = SplitCells { block: index, ends: vec![], parts: vec![] };
    for (k, cell) in cells.iter_mut().enumerate() {
        ranks.clear();
        vertices.outline(cell, ranks);
        if ranks.len() <= cell.triangulation.corner_count() {
            continue;
        }
        outline.clear();
        outline.extend(ranks.iter().map(|&rank| vertices.point(rank)));
        if let Some(direction) = subdivider.triangulate(block, cell, outline, workspace) {
            let SplitCells { ends, parts, .. } = &mut split;
            subdivider.split(block, (*cell, direction), workspace, parts);
            ends.push((first + k, parts.len()));
        }
    }
    split
}
