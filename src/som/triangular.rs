//! Weighted sums around each node of a triangular grid.

use std::array;
use std::cmp::Reverse;

use rayon::prelude::*;

use super::lattice::Lattice;
use super::smoothing::{Channels, VALUES_PER_REPORT};
use crate::error::Result;
use crate::progress::Listen;

/// The way to a row that cannot be reached on that side: longer than any other.
const NO_WAY: usize = usize::MAX / 4;

/// Values looked at for each node of a row on the way to another row, in both halves and all
/// channels.
const VALUES_PER_WAY: usize = 64;

/// The sums over all nodes, each times the weight for its number of edges from the node in
/// question; `weights` do not rise, and beyond them there is nothing.
///
/// Diagonals lead a row down and a column right. So a node that is `a` rows below and `b` columns to
/// the right is max(a, b) edges away, and one that is `a` rows above and `b` columns to the right
/// a + b; on a closed grid the shorter way round counts. To the right along a row, distances rise by
/// one from node to node or stay: at most three stretches, whose ends and distances change by little
/// from row to row. A stretch's weighted sum follows from that of the row before, so that all sums
/// cost O(m rows). To the left it is the same with all nodes in reverse.
///
/// What leaves a sum again has never weighed more in it than in the result, so that nothing is lost
/// by cancellation.
pub(super) fn sums_around(
    lattice: &Lattice,
    sums: &[Channels],
    weights: &[f64],
    listen: &mut Listen<'_>,
) -> Result<Vec<Channels>> {
    let (rows, cols) = lattice.shape();
    let halves = [0, 1].map(|first| Half::new(lattice, weights, first));
    let [right, left] = &halves;
    let channel = |channel: usize| move |sum: &Channels| sum[channel];
    let forward = (0..4).map(|c| Plane::new(right, sums.iter().map(channel(c))));
    let backward = (0..4).map(|c| Plane::new(left, sums.iter().rev().map(channel(c))));
    let mut planes: Vec<Plane<'_>> = forward.chain(backward).collect();
    let rows_per_report = VALUES_PER_REPORT / (VALUES_PER_WAY * cols * rows.min(weights.len()));
    for first in (0..rows).step_by(rows_per_report.max(1)) {
        listen()?;
        let last = rows.min(first + rows_per_report.max(1));
        planes.par_iter_mut().for_each(|plane| (first..last).for_each(|row| plane.give(row)));
    }
    let total = |node: usize| {
        let opposite = sums.len() - 1 - node;
        array::from_fn(|c| planes[c].totals[node] + planes[4 + c].totals[opposite])
    };
    Ok((0..sums.len()).map(total).collect())
}

/// How a row of nodes that gives lies to one that takes: so many edges below it, and above.
#[derive(Clone, Copy)]
struct Way {
    below: usize,
    above: usize,
}

impl Way {
    /// Edges to the node `cols` columns to the right, if columns are not closed.
    fn edges(self, cols: usize) -> usize {
        self.below.max(cols).min(self.above + cols)
    }

    fn reversed(self) -> Self {
        Self { below: self.above, above: self.below }
    }
}

/// A stretch along which distances rise: from `from` edges up to `to`, of which the first `lead`
/// would lie before the taking node.
struct Rise {
    way: Way,
    lead: usize,
    from: usize,
    to: usize,
}

/// A stretch of nodes at the same distance: `length` nodes from `start` columns to the right.
struct Flat {
    way: Way,
    start: usize,
    length: usize,
    weight: f64,
}

/// What lies to the right of a node, as stretches.
struct Half<'a> {
    rows: usize,
    cols: usize,
    closed: (bool, bool),
    weights: &'a [f64],
    /// Those that come from above, and those in the node's own row and below; the longest way
    /// first, so that nodes enter a sum with less weight than they have later.
    rises: [Vec<Rise>; 2],
    /// The shortest first.
    flats: Vec<Flat>,
}

impl<'a> Half<'a> {
    /// From `first` columns to the right on: 0, or 1 where the node's own column and what is as far
    /// on the other way round are counted already.
    fn new(lattice: &Lattice, weights: &'a [f64], first: usize) -> Self {
        let (rows, cols) = lattice.shape();
        let closed @ (closed_u, closed_v) = lattice.topology().closed();
        let below = (0..rows).map(|below| {
            let above = if closed_u { rows - below } else { NO_WAY };
            Way { below, above }
        });
        let above = (1..rows).map(|above| Way { below: NO_WAY, above });
        let ways = below.chain(above.filter(|_| !closed_u));
        let reach = weights.len();
        let (mut rises, mut flats) = ([Vec::new(), Vec::new()], Vec::new());
        for way @ Way { below, above } in ways {
            // Beyond, the way round the columns is shorter.
            let nearer = |&col: &usize| way.edges(col) + first <= way.reversed().edges(cols - col);
            let end = first + (first..cols).take_while(nearer).count();
            let end = if closed_v { end } else { NO_WAY };
            // Up to here the way from above is shorter.
            let turn = below.saturating_sub(above).min(end);
            let (start, stop) = (turn.max(first), below.min(end));
            rises[0].push(Rise { way, lead: above, from: above + first, to: above + turn });
            rises[1].push(Rise { way, lead: 0, from: below.max(first), to: end });
            if let Some(&weight) = weights.get(below) {
                flats.push(Flat { way, start, length: stop.saturating_sub(start), weight });
            }
        }
        for rises in &mut rises {
            for rise in rises.iter_mut() {
                rise.to = rise.to.min(reach);
            }
            rises.retain(|rise| rise.from < rise.to);
            rises.sort_by_key(|rise| Reverse(rise.from));
        }
        flats.retain(|flat| flat.length > 0);
        flats.sort_by_key(|flat| flat.length);
        Self { rows, cols, closed, weights, rises, flats }
    }

    /// The row that takes what `row` gives on a way.
    fn taker(&self, row: usize, way: Way) -> Option<usize> {
        if self.closed.0 {
            Some((row + way.above) % self.rows)
        } else if way.below == NO_WAY {
            Some(row + way.above).filter(|&taker| taker < self.rows)
        } else {
            row.checked_sub(way.below)
        }
    }
}

/// One channel of all nodes: what they give to the left, and what they have taken.
struct Plane<'a> {
    half: &'a Half<'a>,
    given: Vec<f64>,
    totals: Vec<f64>,
}

impl<'a> Plane<'a> {
    fn new(half: &'a Half<'a>, given: impl Iterator<Item = f64>) -> Self {
        let given: Vec<f64> = given.collect();
        let totals = vec![0.0; given.len()];
        Self { half, given, totals }
    }

    /// Gives the nodes of a row to all that are in reach to the left.
    fn give(&mut self, row: usize) {
        let Half { cols, closed, weights, rises, flats, .. } = self.half;
        let given = &self.given[row * cols..][..*cols];
        if given.iter().all(|&value| value == 0.0) {
            return;
        }
        // The row goes on to both sides, as zeros or round and round.
        let lead = rises[0].first().map_or(0, |rise| rise.lead);
        let before = lead.next_multiple_of(*cols) - lead;
        let value = |place: usize| {
            let inside = closed.1 || (lead..lead + cols).contains(&place);
            if inside { given[(before + place) % cols] } else { 0.0 }
        };
        let line: Vec<f64> = (0..lead + cols + weights.len()).map(value).collect();

        for (rises, line) in rises.iter().zip([&line[..], &line[lead..]]) {
            let Some(longest) = rises.first() else { continue };
            let (mut from, mut to) = (longest.to, longest.to);
            let mut sums = vec![0.0; longest.lead + cols];
            for rise in rises {
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
                self.take(row, rise.way, 1.0, &sums[longest.lead - rise.lead..]);
            }
        }
        let farthest = flats.iter().map(|flat| flat.start).max().unwrap_or(0);
        let (mut sums, mut length) = (vec![0.0; farthest + cols], 0);
        for flat in flats {
            while length < flat.length {
                add(&mut sums, 1.0, &line[lead + length..]);
                length += 1;
            }
            self.take(row, flat.way, flat.weight, &sums[flat.start..]);
        }
    }

    /// Adds what `row` gives on a way to the row that takes it.
    fn take(&mut self, row: usize, way: Way, weight: f64, sums: &[f64]) {
        if let Some(taker) = self.half.taker(row, way) {
            add(&mut self.totals[taker * self.half.cols..][..self.half.cols], weight, sums);
        }
    }
}

fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
}

#[cfg(test)]
mod tests {
    use super::super::lattice::Distances;
    use super::super::random::Random;
    use super::super::smoothing::spread;
    use super::*;
    use crate::som::{Cells, Topology};

    #[test]
    fn sums_are_those_that_a_search_finds() {
        let mut random = Random::new(4);
        let sides = [(2, 2), (2, 9), (9, 2), (3, 3), (3, 17), (17, 3), (4, 5), (8, 7), (12, 13)];
        for topology in Topology::ALL {
            for (rows, cols) in sides {
                let Ok(lattice) = Lattice::grid(rows, cols, Cells::Triangular, topology) else {
                    continue;
                };
                let Distances::Graph(graph) = lattice.distances() else { unreachable!() };
                for (radius, edges) in [(0.4_f64, 0), (1.3, 1), (4.0, 4), (30.0, 30)] {
                    let bell = |edges: usize| (-0.5 * (edges as f64 / radius).powi(2)).exp();
                    let gaussian: Vec<f64> = (0..rows + cols).map(bell).collect();
                    let bubble = vec![1.0; 1 + edges];
                    for weights in [gaussian, bubble] {
                        // Most nodes have no points, so that far ones decide alone.
                        let mut value = || if random.unit() < 0.8 { 0.0 } else { random.unit() };
                        let sums: Vec<Channels> = (0..rows * cols)
                            .map(|_| [value(), value(), value(), value()])
                            .collect();
                        let got = sums_around(&lattice, &sums, &weights, &mut || Ok(())).unwrap();
                        let expected = spread(graph, &sums, &weights, &mut || Ok(())).unwrap();
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
