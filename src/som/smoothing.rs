//! The second half of an epoch of batch training: from the sums of winners to new nodes.

use std::array;
use std::ops::Range;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::bell::{Bell, gaussian};
use super::graph::{Graph, Visits};
use super::grid::Grid;
use super::lattice::{Distances, Lattice};
use super::options::{Kernel, Neighborhood};
use super::topology::Cells;
use super::triangular;
use crate::error::Result;
use crate::progress::Listen;

/// A share of the neighbourhood's own variance that is added to that of its data: where almost all
/// points lie on one line of nodes, the line fitted to them must not tip over.
const RIDGE: f64 = 1e-3;

/// A Gaussian counts as zero where it is under this share of its middle, when distances are
/// numbers of edges: 7.4 radii away.
const NEGLIGIBLE: f64 = 1e-12;

/// Values looked at between two reports: some ten milliseconds.
pub(super) const VALUES_PER_REPORT: usize = 1 << 23;

/// Nodes of a graph visited between two reports: some ten milliseconds.
const VISITS_PER_REPORT: usize = 1 << 18;

/// Sums of one node: number of points, and their coordinates.
pub(super) type Channels = [f64; 4];

/// The new place of each node: the weighted mean of the points, or the local line's value; `None`
/// where no points weigh anything. Places are in the unit of the sums.
///
/// On a quadrilateral grid a Gaussian is a product of one along the rows and one along the columns,
/// which costs O(m (rows + cols)); a bubble, by running sums, O(m rows), as both do on a triangular
/// one. On a graph each node that has won points visits its neighbours, as far as the neighbourhood
/// reaches.
pub(super) fn smooth(
    lattice: &Lattice,
    sums: &[Channels],
    neighborhood: Neighborhood,
    kernel: Kernel,
    radius: f64,
    listen: &mut Listen<'_>,
) -> Result<Vec<Option<DVec3>>> {
    let totals = match (neighborhood, lattice.distances()) {
        (Neighborhood::Gaussian, Distances::Grid(_)) if kernel == Kernel::Linear => {
            return local_lines(lattice, sums, radius, listen);
        }
        (Neighborhood::Gaussian, Distances::Grid(_)) => {
            let around = Separable::new(lattice, radius);
            let along_rows = around.over_rows(0, sums, listen)?;
            around.over_cols(0, &along_rows, listen)?
        }
        (Neighborhood::Bubble, Distances::Grid(grid)) => {
            let around = bubble(grid, sums, edges_within(radius));
            by_nodes(lattice, grid.rows, listen, around)?
        }
        (_, Distances::Graph(graph)) => {
            let weights = by_edges(lattice, neighborhood, radius);
            if lattice.cells() == Some(Cells::Triangular) {
                triangular::sums_around(lattice, sums, &weights, listen)?
            } else {
                spread(graph, sums, &weights, listen)?
            }
        }
    };
    by_nodes(lattice, 1, listen, |node| {
        let [count, x, y, z] = totals[node];
        (count > f64::MIN_POSITIVE).then(|| DVec3::new(x, y, z) / count)
    })
}

/// The paper's radius counts whole edges.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a radius is not negative, and one beyond all edges may saturate"
)]
pub(super) fn edges_within(radius: f64) -> usize {
    radius as usize
}

/// The weights by number of edges, as far as they count.
fn by_edges(lattice: &Lattice, neighborhood: Neighborhood, radius: f64) -> Vec<f64> {
    let (rows, cols) = lattice.shape();
    // No two nodes are farther apart.
    let farthest = 0..rows + cols;
    match neighborhood {
        Neighborhood::Bubble => {
            farthest.take_while(|&edges| edges <= edges_within(radius)).map(|_| 1.0).collect()
        }
        Neighborhood::Gaussian => {
            // The winner itself counts even when the radius is zero.
            let weight = |edges: usize| {
                if edges == 0 { 1.0 } else { (-0.5 * (edges as f64 / radius).powi(2)).exp() }
            };
            farthest.map(weight).take_while(|&weight| weight > NEGLIGIBLE).collect()
        }
    }
}

/// The weights along a side of the lattice, times the signed distance to the power of 0, 1 and 2.
struct Side {
    count: usize,
    /// By the number of the other node less that of the node itself, from `1 - count` up.
    powers: [Vec<f64>; 3],
    /// The differences whose weights are not all zero.
    range: Range<usize>,
}

impl Side {
    fn new(count: usize, closed: bool, radius: f64) -> Self {
        let (mut weights, mut bell) = (vec![0.0; count], Bell::new(count, closed));
        gaussian(radius, &mut weights);
        bell.set(&weights);
        let weight = |place: usize, power: i32| {
            let mut apart = place as f64 - (count - 1) as f64;
            let distance = place.abs_diff(count - 1);
            if closed && 2 * distance > count {
                apart -= (count as f64).copysign(apart);
            } else if closed && 2 * distance == count && power == 1 {
                // Opposite on the ring: as far one way as the other.
                return 0.0;
            }
            bell.values()[place] * apart.powi(power)
        };
        let powers: [Vec<f64>; 3] =
            [0, 1, 2].map(|power| (0..2 * count - 1).map(|at| weight(at, power)).collect());
        let [first, ..] = &powers;
        let used = |weight: &f64| *weight != 0.0;
        let from = first.iter().position(used).unwrap_or(0);
        let to = first.iter().rposition(used).unwrap_or(0) + 1;
        Self { count, powers, range: from..to }
    }

    /// The nodes that weigh on a node, the first one's number, and their weights.
    fn around(&self, node: usize, power: usize) -> (usize, &[f64]) {
        let shift = self.count - 1 - node;
        let from = self.range.start.max(shift);
        let to = self.range.end.min(shift + self.count);
        (from - shift, &self.powers[power][from..to])
    }
}

/// The Gaussian around each node of a quadrilateral grid, as one along rows and one along columns.
struct Separable {
    rows: Side,
    cols: Side,
}

impl Separable {
    fn new(lattice: &Lattice, radius: f64) -> Self {
        let (rows, cols) = lattice.shape();
        let (closed_u, closed_v) = lattice.topology().closed();
        Self { rows: Side::new(rows, closed_u, radius), cols: Side::new(cols, closed_v, radius) }
    }

    /// Weighted sums along u: row `to` of the result is Σ weight(to, from) · row `from`.
    fn over_rows<const N: usize>(
        &self,
        power: usize,
        sums: &[[f64; N]],
        listen: &mut Listen<'_>,
    ) -> Result<Vec<[f64; N]>> {
        let (rows, cols) = (&self.rows, self.cols.count);
        by_rows(cols, vec![[0.0; N]; sums.len()], rows.count, listen, |to, row: &mut [[f64; N]]| {
            let (first, weights) = rows.around(to, power);
            for (&weight, from) in weights.iter().zip(sums[first * cols..].chunks(cols)) {
                if weight != 0.0 {
                    let (row, from) = (row.as_flattened_mut(), from.as_flattened());
                    row.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
                }
            }
        })
    }

    /// Weighted sums along v.
    fn over_cols<const N: usize>(
        &self,
        power: usize,
        sums: &[[f64; N]],
        listen: &mut Listen<'_>,
    ) -> Result<Vec<[f64; N]>> {
        let cols = &self.cols;
        by_rows(
            cols.count,
            vec![[0.0; N]; sums.len()],
            cols.count,
            listen,
            |row, totals: &mut [[f64; N]]| {
                let sums: &[[f64; N]] = &sums[row * cols.count..][..cols.count];
                for (node, total) in totals.iter_mut().enumerate() {
                    let (first, weights) = cols.around(node, power);
                    for (&weight, from) in weights.iter().zip(&sums[first..]) {
                        for (total, value) in total.iter_mut().zip(from) {
                            *total += weight * value;
                        }
                    }
                }
            },
        )
    }
}

/// Fills in the values of all nodes, row by row, in parallel. `cost` is the number of values
/// that each looks at.
fn by_rows<T: Send>(
    cols: usize,
    mut values: Vec<T>,
    cost: usize,
    listen: &mut Listen<'_>,
    make: impl Fn(usize, &mut [T]) + Sync,
) -> Result<Vec<T>> {
    let rows_per_report = (VALUES_PER_REPORT / (cols * cost)).max(1);
    for (number, rows) in values.chunks_mut(rows_per_report * cols).enumerate() {
        listen()?;
        let first = number * rows_per_report;
        rows.par_chunks_mut(cols).enumerate().for_each(|(row, values)| make(first + row, values));
    }
    Ok(values)
}

/// Local linear regression over the lattice: the line through the weighted points whose value at
/// the node itself is the node's new place (Fan and Gijbels, Local Polynomial Modelling, 1996).
fn local_lines(
    lattice: &Lattice,
    sums: &[Channels],
    radius: f64,
    listen: &mut Listen<'_>,
) -> Result<Vec<Option<DVec3>>> {
    let around = Separable::new(lattice, radius);
    let count = |sums: &[Channels]| -> Vec<[f64; 1]> { sums.iter().map(|s| [s[0]]).collect() };
    let r0 = around.over_rows(0, sums, listen)?;
    let r1 = around.over_rows(1, sums, listen)?;
    let r2 = around.over_rows(2, &count(sums), listen)?;
    let s00 = around.over_cols(0, &r0, listen)?;
    let s01 = around.over_cols(1, &r0, listen)?;
    let s10 = around.over_cols(0, &r1, listen)?;
    let s02 = around.over_cols(2, &count(&r0), listen)?;
    let s11 = around.over_cols(1, &count(&r1), listen)?;
    let s20 = around.over_cols(0, &r2, listen)?;
    let line = |node: usize| {
        let split = |[count, x, y, z]: Channels| (count, DVec3::new(x, y, z));
        let (n00, p00) = split(s00[node]);
        let ((n10, p10), (n01, p01)) = (split(s10[node]), split(s01[node]));
        let ([n20], [n11], [n02]) = (s20[node], s11[node], s02[node]);
        if n00 <= f64::MIN_POSITIVE {
            return None;
        }
        // Divided by the weight, so that the matrix is of ordinary size; distances in radii.
        let scale = 1.0 / radius;
        let (a, b) = (n10 / n00 * scale, n01 / n00 * scale);
        let (aa, ab, bb) = (n20 / n00, n11 / n00, n02 / n00);
        let [aa, ab, bb] = [aa, ab, bb].map(|moment| moment * scale * scale);
        let matrix = DMat3::from_cols_array(&[1.0, a, b, a, aa + RIDGE, ab, b, ab, bb + RIDGE]);
        let first = matrix.inverse().row(0);
        let place = first.x * p00 + (first.y * p10 + first.z * p01) * scale;
        Some(place / n00).filter(|place| place.is_finite()).or(Some(p00 / n00))
    };
    by_nodes(lattice, 1, listen, line)
}

/// As [`by_rows`], node by node.
fn by_nodes<T: Clone + Default + Send>(
    lattice: &Lattice,
    cost: usize,
    listen: &mut Listen<'_>,
    make: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>> {
    let (_, cols) = lattice.shape();
    by_rows(cols, vec![T::default(); lattice.len()], cost, listen, |row, values| {
        for (col, value) in values.iter_mut().enumerate() {
            *value = make(row * cols + col);
        }
    })
}

/// The sums over all nodes at most `radius` edges from a node, from running sums along the rows.
fn bubble(grid: &Grid, sums: &[Channels], radius: usize) -> impl Fn(usize) -> Channels {
    let cols = grid.cols;
    let mut running = Vec::with_capacity(sums.len() + sums.len() / cols);
    for row in sums.chunks(cols) {
        let mut sum = Channels::default();
        running.push(sum);
        for value in row {
            sum = array::from_fn(|channel| sum[channel] + value[channel]);
            running.push(sum);
        }
    }
    move |node| {
        let mut total = Channels::default();
        grid.visit_ball(node, radius, |range| {
            if let Some(last) = range.end.checked_sub(1).filter(|_| !range.is_empty()) {
                let row = last / cols;
                // Each row has one running sum more than it has nodes.
                let (from, to) = (range.start + row, range.end + row);
                total = array::from_fn(|c| total[c] + (running[to][c] - running[from][c]));
            }
        });
        total
    }
}

/// Each node gives its sums to all in reach, times the weight for their number of edges.
pub(super) fn spread(
    graph: &Graph,
    sums: &[Channels],
    weights: &[f64],
    listen: &mut Listen<'_>,
) -> Result<Vec<Channels>> {
    let mut result = vec![Channels::default(); sums.len()];
    let mut visits = Visits::default();
    let mut visited = 0;
    for (node, sum) in sums.iter().enumerate().filter(|(_, sum)| **sum != Channels::default()) {
        if visited > VISITS_PER_REPORT {
            listen()?;
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
