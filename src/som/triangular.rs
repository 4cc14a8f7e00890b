//! Weighted sums around each node of a triangular grid.

use std::array;
use std::cmp::Reverse;

use rayon::prelude::*;

use super::lattice::Lattice;
use super::node_sums::{Channels, VALUES_PER_REPORT};
use crate::error::Result;
use crate::progress::InterruptCheck;
use crate::worker_pool;

/// Distance to a row that cannot be reached in this direction.
const UNREACHABLE: usize = usize::MAX / 4;

/// Values read for each node and pair of rows, over both halves and all channels.
const VALUES_PER_ROW_PAIR: usize = 64;

/// For each node, the sum over all nodes of their sums times the weight for the number of edges
/// between them. `weights` must not increase; beyond its end the weight is zero.
///
/// Diagonals lead one row down and one column right. A node `a` rows below and `b` columns to the
/// right is therefore max(a, b) edges away; a node `a` rows above and `b` columns to the right a +
/// b. On a closed grid the shorter way around applies. To the right along a row, distances rise by
/// one per node or stay constant: at most three runs, whose ends and distances change little from
/// row to row. The weighted sum of a run follows from that of the previous row, so all sums cost
/// O(m rows). The left half is the same with the nodes in reverse order.
///
/// A value that is subtracted from a running sum had no greater weight in it than in the result, so
/// there is no cancellation.
pub(super) fn sums_around(
    lattice: &Lattice,
    sums: &[Channels],
    weights: &[f64],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<Channels>> {
    let (rows, cols) = lattice.shape();
    let halves = [0, 1].map(|first| RightHalf::new(lattice, weights, first));
    let [right, left] = &halves;
    let channel = |channel: usize| move |sum: &Channels| sum[channel];
    let forward = (0..4).map(|c| ChannelSums::new(right, sums.iter().map(channel(c))));
    let backward = (0..4).map(|c| ChannelSums::new(left, sums.iter().rev().map(channel(c))));
    let mut channels: Vec<ChannelSums<'_>> = forward.chain(backward).collect();
    let rows_per_report =
        VALUES_PER_REPORT / (VALUES_PER_ROW_PAIR * cols * rows.min(weights.len()));
    for first in (0..rows).step_by(rows_per_report.max(1)) {
        check_interrupt()?;
        let last = rows.min(first + rows_per_report.max(1));
        let channels = channels.par_iter_mut();
        worker_pool::install(|| {
            channels.for_each(|channel| (first..last).for_each(|row| channel.scatter_row(row)));
        });
    }
    let total = |node: usize| {
        let opposite = sums.len() - 1 - node;
        array::from_fn(|c| channels[c].totals[node] + channels[4 + c].totals[opposite])
    };
    Ok((0..sums.len()).map(total).collect())
}

/// Position of a source row relative to a target row: the number of edges if it lies below, and if
/// above.
#[derive(Clone, Copy)]
struct RowOffset {
    below: usize,
    above: usize,
}

impl RowOffset {
    /// Number of edges to the node `cols` columns to the right, if columns are open.
    fn edges(self, cols: usize) -> usize {
        self.below.max(cols).min(self.above + cols)
    }

    fn reversed(self) -> Self {
        Self { below: self.above, above: self.below }
    }
}

/// A run of nodes with rising distances, `from` edges up to `to`. The first `lead` of them would
/// lie before the target node.
struct RisingRun {
    offset: RowOffset,
    lead: usize,
    from: usize,
    to: usize,
}

/// A run of `length` nodes at the same distance, from `start` columns to the right.
struct ConstantRun {
    offset: RowOffset,
    start: usize,
    length: usize,
    weight: f64,
}

/// The nodes to the right of a node, as runs.
struct RightHalf<'a> {
    rows: usize,
    cols: usize,
    closed: (bool, bool),
    weights: &'a [f64],
    /// Runs of rows above, and runs of the node's own row and rows below. Longest distance first,
    /// so that nodes enter a running sum with less weight than they have later.
    rising: [Vec<RisingRun>; 2],
    /// The shortest run first.
    constant: Vec<ConstantRun>,
}

impl<'a> RightHalf<'a> {
    /// The runs from `first` columns to the right on. `first` is 1 for the left half, whose own
    /// column and opposite nodes belong to the right half.
    fn new(lattice: &Lattice, weights: &'a [f64], first: usize) -> Self {
        let (rows, cols) = lattice.shape();
        let closed @ (closed_u, closed_v) = lattice.topology().closed();
        let below = (0..rows).map(|below| {
            let above = if closed_u { rows - below } else { UNREACHABLE };
            RowOffset { below, above }
        });
        let above = (1..rows).map(|above| RowOffset { below: UNREACHABLE, above });
        let offsets = below.chain(above.filter(|_| !closed_u));
        let reach = weights.len();
        let (mut rising, mut constant) = ([Vec::new(), Vec::new()], Vec::new());
        for offset @ RowOffset { below, above } in offsets {
            // Beyond it, the way around the columns is shorter.
            let nearer =
                |&col: &usize| offset.edges(col) + first <= offset.reversed().edges(cols - col);
            let end = first + (first..cols).take_while(nearer).count();
            let end = if closed_v { end } else { UNREACHABLE };
            // Up to here, the way from above is shorter.
            let turn = below.saturating_sub(above).min(end);
            let (start, stop) = (turn.max(first), below.min(end));
            rising[0].push(RisingRun {
                offset,
                lead: above,
                from: above + first,
                to: above + turn,
            });
            rising[1].push(RisingRun { offset, lead: 0, from: below.max(first), to: end });
            if let Some(&weight) = weights.get(below) {
                constant.push(ConstantRun {
                    offset,
                    start,
                    length: stop.saturating_sub(start),
                    weight,
                });
            }
        }
        for rising in &mut rising {
            for rise in rising.iter_mut() {
                rise.to = rise.to.min(reach);
            }
            rising.retain(|rise| rise.from < rise.to);
            rising.sort_by_key(|rise| Reverse(rise.from));
        }
        constant.retain(|flat| flat.length > 0);
        constant.sort_by_key(|flat| flat.length);
        Self { rows, cols, closed, weights, rising, constant }
    }

    /// The row that receives the values of `row` at this offset.
    fn target_row(&self, row: usize, offset: RowOffset) -> Option<usize> {
        if self.closed.0 {
            Some((row + offset.above) % self.rows)
        } else if offset.below == UNREACHABLE {
            Some(row + offset.above).filter(|&target_row| target_row < self.rows)
        } else {
            row.checked_sub(offset.below)
        }
    }
}

/// One channel of all nodes: the source values and the weighted sums.
struct ChannelSums<'a> {
    half: &'a RightHalf<'a>,
    values: Vec<f64>,
    totals: Vec<f64>,
}

impl<'a> ChannelSums<'a> {
    fn new(half: &'a RightHalf<'a>, values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.collect();
        let totals = vec![0.0; values.len()];
        Self { half, values, totals }
    }

    /// Adds the values of a row to the sums of all nodes in reach to the left.
    fn scatter_row(&mut self, row: usize) {
        let RightHalf { cols, closed, weights, rising, constant, .. } = self.half;
        let values = &self.values[row * cols..][..*cols];
        if values.iter().all(|&value| value == 0.0) {
            return;
        }
        // The row is continued on both sides: periodically if closed, else with zeros.
        let lead = rising[0].first().map_or(0, |rise| rise.lead);
        let before = lead.next_multiple_of(*cols) - lead;
        let value = |place: usize| {
            let inside = closed.1 || (lead..lead + cols).contains(&place);
            if inside { values[(before + place) % cols] } else { 0.0 }
        };
        let line: Vec<f64> = (0..lead + cols + weights.len()).map(value).collect();

        for (rising, line) in rising.iter().zip([&line[..], &line[lead..]]) {
            let Some(longest) = rising.first() else { continue };
            let (mut from, mut to) = (longest.to, longest.to);
            let mut sums = vec![0.0; longest.lead + cols];
            for rise in rising {
                while to < rise.to {
                    add(&mut sums, weights[to], &line[to..]);
                    to += 1;
                }
                while to > rise.to {
                    to -= 1;
                    add(&mut sums, -weights[to], &line[to..]);
                }
                while from > rise.from {
                    from -= 1;
                    add(&mut sums, weights[from], &line[from..]);
                }
                self.add_to_row(row, rise.offset, 1.0, &sums[longest.lead - rise.lead..]);
            }
        }
        let farthest = constant.iter().map(|flat| flat.start).max().unwrap_or(0);
        let (mut sums, mut length) = (vec![0.0; farthest + cols], 0);
        for flat in constant {
            while length < flat.length {
                add(&mut sums, 1.0, &line[lead + length..]);
                length += 1;
            }
            self.add_to_row(row, flat.offset, flat.weight, &sums[flat.start..]);
        }
    }

    /// Adds weighted sums of `row` to the row at this offset.
    fn add_to_row(&mut self, row: usize, offset: RowOffset, weight: f64, sums: &[f64]) {
        if let Some(target_row) = self.half.target_row(row, offset) {
            add(&mut self.totals[target_row * self.half.cols..][..self.half.cols], weight, sums);
        }
    }
}

fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
}

#[cfg(test)]
mod tests {
    use super::super::lattice::Distances;
    use super::super::node_sums::graph_sums;
    use super::super::random::Random;
    use super::*;
    use crate::som::{Cells, Topology};

    #[test]
    fn sums_agree_with_breadth_first_search() {
        let mut random = Random::new(4);
        let sides = [(2, 2), (2, 9), (9, 2), (3, 3), (3, 17), (17, 3), (4, 5), (8, 7), (12, 13)];
        for topology in Topology::ALL {
            for (rows, cols) in sides {
                let Ok(lattice) = Lattice::grid(rows, cols, Cells::Triangular, topology) else {
                    continue;
                };
                let Distances::Graph(graph) = lattice.distances() else { unreachable!() };
                for (radius, edges) in [(0.4_f64, 0), (1.3, 1), (4.0, 4), (30.0, 30)] {
                    let weight = |edges: usize| (-0.5 * (edges as f64 / radius).powi(2)).exp();
                    let gaussian: Vec<f64> = (0..rows + cols).map(weight).collect();
                    let bubble = vec![1.0; 1 + edges];
                    for weights in [gaussian, bubble] {
                        // Most nodes have no points, so that distant nodes alone decide the sums.
                        let mut value = || if random.unit() < 0.8 { 0.0 } else { random.unit() };
                        let sums: Vec<Channels> = (0..rows * cols)
                            .map(|_| [value(), value(), value(), value()])
                            .collect();
                        let got = sums_around(&lattice, &sums, &weights, &mut || Ok(())).unwrap();
                        let expected = graph_sums(graph, &sums, &weights, &mut || Ok(())).unwrap();
                        for (got, expected) in got.iter().zip(&expected) {
                            for (got, expected) in got.iter().zip(expected) {
                                let case = format!("{topology:?} {rows} {cols} {radius}");
                                assert!((got - expected).abs() <= 1e-13 * expected, "{case}");
                            }
                        }
                    }
                }
            }
        }
    }
}
