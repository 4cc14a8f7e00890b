//! Sums of points per node, and parallel loops over nodes that can be interrupted.

use rayon::prelude::*;

use super::graph::{Graph, Visits};
use super::lattice::Lattice;
use crate::error::Result;
use crate::progress::InterruptCheck;
use crate::worker_pool;

/// Values processed between two reports, about ten milliseconds.
pub(super) const VALUES_PER_REPORT: usize = 1 << 23;

/// Graph nodes visited between two reports, about ten milliseconds.
const VISITS_PER_REPORT: usize = 1 << 18;

/// The sums of one node: number of points, and sums of their x, y and z.
pub(super) type Channels = [f64; 4];

/// Fills in one value per node, row by row, in parallel. `cost` is the number of values read for
/// each node.
pub(super) fn by_rows<T: Send>(
    cols: usize,
    mut values: Vec<T>,
    cost: usize,
    check_interrupt: &mut InterruptCheck<'_>,
    make: impl Fn(usize, &mut [T]) + Sync,
) -> Result<Vec<T>> {
    let rows_per_report = (VALUES_PER_REPORT / (cols * cost)).max(1);
    for (number, rows) in values.chunks_mut(rows_per_report * cols).enumerate() {
        check_interrupt()?;
        let first = number * rows_per_report;
        let rows = rows.par_chunks_mut(cols).enumerate();
        worker_pool::install(|| rows.for_each(|(row, values)| make(first + row, values)));
    }
    Ok(values)
}

/// As [`by_rows`], with a function of the node index.
pub(super) fn by_nodes<T: Clone + Default + Send>(
    lattice: &Lattice,
    cost: usize,
    check_interrupt: &mut InterruptCheck<'_>,
    make: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>> {
    let (_, cols) = lattice.shape();
    by_rows(cols, vec![T::default(); lattice.len()], cost, check_interrupt, |row, values| {
        for (col, value) in values.iter_mut().enumerate() {
            *value = make(row * cols + col);
        }
    })
}

/// Adds each node's sums to all nodes in reach, multiplied by the weight for the number of edges.
pub(super) fn graph_sums(
    graph: &Graph,
    sums: &[Channels],
    weights: &[f64],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<Channels>> {
    let mut result = vec![Channels::default(); sums.len()];
    let mut visits = Visits::default();
    let mut visited = 0;
    for (node, sum) in sums.iter().enumerate().filter(|(_, sum)| **sum != Channels::default()) {
        if visited > VISITS_PER_REPORT {
            check_interrupt()?;
            visited = 0;
        }
        graph.visit(node, weights.len() - 1, &mut visits, |other, edges| {
            for (total, value) in result[other].iter_mut().zip(sum) {
                *total += weights[edges] * value;
            }
            visited += 1;
        });
    }
    Ok(result)
}
