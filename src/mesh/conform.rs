//! Makes neighboring cells conform: no vertex of one lies inside an edge of the other's triangles.
//!
//! The corners on a cell's sides become corners of its triangles. A cell whose new triangles exceed
//! the limits is split, which adds corners, until nothing changes.

use super::block_edges::cell_corners_on_edges;
use super::block_vertices::BlockVertices;
use super::cell::Cell;
use super::options::TessellateOptions;
use super::parallel_map::{CELLS_COLLECTED_PER_TRIANGLE, MIN_PARALLEL_TRIANGLES, parallel_map};
use super::partition::{Partition, too_many_triangles};
use super::recheck::{CellRun, OutlineWorkspace, SplitCells, recheck};
use super::workspace::Workspace;
use crate::error::Result;
use crate::progress::Observer;

/// Runs of cells that parallel work is divided into at least, if there are enough cells.
const MIN_RUNS: usize = 32;

/// Cells in a run at least.
const MIN_CELLS_PER_RUN: usize = 4;

/// Splits cells until their triangles meet the limits with all vertices on their sides.
pub(super) fn conform(
    partition: &mut Partition<'_>,
    options: &TessellateOptions,
    observer: &mut dyn Observer,
) -> Result<()> {
    let mut pending = vec![true; partition.grid.blocks()];
    (0..pending.len()).for_each(|index| add_to_edges(partition, index, &mut pending));
    while pending.contains(&true) {
        let split = recheck_blocks(partition, &pending, observer)?;
        let blocks = split.chunk_by(|a, b| a.block == b.block);
        let blocks: Vec<usize> = blocks.map(|split| split[0].block).collect();
        replace_cells(partition, &split, observer)?;
        pending.fill(false);
        for index in blocks {
            pending[index] = true;
            add_to_edges(partition, index, &mut pending);
        }
        let count = partition.cells.iter().map(Vec::len).sum::<usize>();
        if 2 * count > options.max_triangles {
            return Err(too_many_triangles(options, &partition.limits, 2.0 * count as f64));
        }
    }
    Ok(())
}

/// Adds the cell corners of a block to its edges; marks the blocks beside changed edges as pending.
fn add_to_edges(partition: &mut Partition<'_>, index: usize, pending: &mut [bool]) {
    let corners = cell_corners_on_edges(partition.grid.block(index), &partition.cells[index]);
    let edges = &mut partition.edges;
    for (edge, corners) in edges.of_block(index).into_iter().zip(corners) {
        if edges.add(edge, &corners) {
            edges.adjacent_blocks(edge).into_iter().for_each(|other| pending[other] = true);
        }
    }
}

/// Rechecks the cells of pending blocks; returns those that were split, in order of blocks.
fn recheck_blocks(
    partition: &mut Partition<'_>,
    pending: &[bool],
    observer: &mut dyn Observer,
) -> Result<Vec<SplitCells>> {
    let pending = || (0..pending.len()).filter(|&index| pending[index]);
    let count = pending().map(|index| partition.cells[index].len()).sum::<usize>();
    let per_run = if 2 * count > MIN_PARALLEL_TRIANGLES {
        (count / MIN_RUNS).max(MIN_CELLS_PER_RUN)
    } else {
        count
    };
    let in_runs: Vec<usize> =
        pending().filter(|&index| partition.cells[index].len() > per_run).collect();
    let vertices = collect_vertices(partition, &in_runs, observer)?;
    // Cells are changed in place: for a large mesh, a copy would take too much memory.
    let mut cells = std::mem::take(&mut partition.cells);
    let (mut runs, mut left) = (vec![], cells.iter_mut().enumerate());
    let mut vertices = in_runs.iter().zip(&vertices).peekable();
    for block in pending() {
        let Some((_, cells)) = left.find(|(index, _)| *index == block) else { continue };
        let vertices = vertices.next_if(|(index, _)| **index == block).map(|(_, found)| found);
        let run = |(k, cells)| CellRun { block, first: k * per_run, cells, vertices };
        runs.extend(cells.chunks_mut(per_run).enumerate().map(run));
    }
    let recheck = |outlines: &mut OutlineWorkspace, run: CellRun<'_>| {
        Workspace::with(|workspace| recheck(partition, workspace, outlines, run))
    };
    let (mut all, mut deviation) = (vec![], partition.deviation);
    let result = parallel_map(runs, 2 * count, observer, recheck, |(split, most)| {
        deviation = deviation.max(most);
        all.extend((!split.is_empty()).then_some(split));
        Ok(())
    });
    (partition.cells, partition.deviation) = (cells, deviation);
    result.map(|()| all)
}

/// The vertices of the blocks that are rechecked in several runs.
fn collect_vertices(
    partition: &Partition<'_>,
    blocks: &[usize],
    observer: &mut dyn Observer,
) -> Result<Vec<BlockVertices>> {
    let collect = |(): &mut (), index: usize| {
        let mut vertices = BlockVertices::default();
        let (block, cells) = (partition.grid.block(index), &partition.cells[index]);
        vertices.collect(block, cells, partition.edge_vertices(index));
        vertices
    };
    let mut all = Vec::with_capacity(blocks.len());
    let count = blocks.iter().map(|&index| partition.cells[index].len()).sum::<usize>();
    let triangles = count / CELLS_COLLECTED_PER_TRIANGLE;
    parallel_map(blocks.iter().copied(), triangles, observer, collect, |vertices| {
        all.push(vertices);
        Ok(())
    })?;
    Ok(all)
}

/// Replaces split cells by their parts.
fn replace_cells(
    partition: &mut Partition<'_>,
    all: &[SplitCells],
    observer: &mut dyn Observer,
) -> Result<()> {
    let mut groups = all.chunk_by(|a, b| a.block == b.block).peekable();
    let blocks = partition.cells.iter_mut().enumerate();
    let blocks: Vec<(&[SplitCells], &mut Vec<Cell>)> = blocks
        .filter_map(|(index, cells)| {
            Some((groups.next_if(|group| group[0].block == index)?, cells))
        })
        .collect();
    let count = all.iter().map(SplitCells::parts).sum();
    let replace = |(): &mut (), (all, cells): (&[SplitCells], _)| SplitCells::replace(all, cells);
    parallel_map(blocks, count, observer, replace, Ok)
}
