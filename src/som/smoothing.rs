//! The second half of a batch epoch: new node positions from the sums of each node's points.

use std::array;

use glam::{DMat3, DVec3};

use super::gaussian_sums::GaussianSums;
use super::grid::Grid;
use super::lattice::{Distances, Lattice};
use super::node_sums::{Channels, by_nodes, graph_sums};
use super::options::{Kernel, Neighborhood};
use super::topology::Cells;
use super::triangular;
use crate::error::Result;
use crate::progress::InterruptCheck;

/// Ridge term of the local regression, as a share of the neighborhood's variance. It keeps the line
/// stable where almost all points lie on one line of nodes.
const RIDGE: f64 = 1e-3;

/// Gaussian weights by number of edges are zero below this value, 7.4 radii away.
const NEGLIGIBLE: f64 = 1e-12;

/// The new position of each node, in the unit of the sums: the weighted mean of the points, or the
/// value of the local line. `None` where no point has weight.
///
/// On a quadrilateral grid a Gaussian is separable and costs O(m (rows + cols)); a bubble, by
/// running sums, O(m rows). On a triangular grid both cost O(m rows). On a graph each node with
/// points visits the nodes within the neighborhood.
pub(super) fn smooth(
    lattice: &Lattice,
    sums: &[Channels],
    neighborhood: Neighborhood,
    kernel: Kernel,
    radius: f64,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<Option<DVec3>>> {
    let totals = match (neighborhood, lattice.distances()) {
        (Neighborhood::Gaussian, Distances::Grid(_)) if kernel == Kernel::Linear => {
            return local_lines(lattice, sums, radius, check_interrupt);
        }
        (Neighborhood::Gaussian, Distances::Grid(_)) => {
            let around = GaussianSums::new(lattice, radius);
            let along_rows = around.over_rows(0, sums, check_interrupt)?;
            around.over_cols(0, &along_rows, check_interrupt)?
        }
        (Neighborhood::Bubble, Distances::Grid(grid)) => {
            let around = bubble(grid, sums, edges_within(radius));
            by_nodes(lattice, grid.rows, check_interrupt, around)?
        }
        (_, Distances::Graph(graph)) => {
            let weights = by_edges(lattice, neighborhood, radius);
            if lattice.cells() == Some(Cells::Triangular) {
                triangular::sums_around(lattice, sums, &weights, check_interrupt)?
            } else {
                graph_sums(graph, sums, &weights, check_interrupt)?
            }
        }
    };
    by_nodes(lattice, 1, check_interrupt, |node| {
        let [count, x, y, z] = totals[node];
        (count > f64::MIN_POSITIVE).then(|| DVec3::new(x, y, z) / count)
    })
}

/// The paper's radius is a whole number of edges.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative; a radius beyond all edges may saturate"
)]
pub(super) fn edges_within(radius: f64) -> usize {
    radius as usize
}

/// The weights by number of edges, up to the last one that is not negligible.
fn by_edges(lattice: &Lattice, neighborhood: Neighborhood, radius: f64) -> Vec<f64> {
    let (rows, cols) = lattice.shape();
    // An upper bound of the distance between two nodes.
    let farthest = 0..rows + cols;
    match neighborhood {
        Neighborhood::Bubble => {
            farthest.take_while(|&edges| edges <= edges_within(radius)).map(|_| 1.0).collect()
        }
        Neighborhood::Gaussian => {
            // The winner itself has weight 1 even if the radius is zero.
            let weight = |edges: usize| {
                if edges == 0 { 1.0 } else { (-0.5 * (edges as f64 / radius).powi(2)).exp() }
            };
            farthest.map(weight).take_while(|&weight| weight > NEGLIGIBLE).collect()
        }
    }
}

/// Local linear regression over the lattice: a node's position is the value at the node of the line
/// fitted to the weighted points. Fan and Gijbels, *Local Polynomial Modelling*, 1996.
fn local_lines(
    lattice: &Lattice,
    sums: &[Channels],
    radius: f64,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<Option<DVec3>>> {
    let around = GaussianSums::new(lattice, radius);
    let count = |sums: &[Channels]| -> Vec<[f64; 1]> { sums.iter().map(|s| [s[0]]).collect() };
    let r0 = around.over_rows(0, sums, check_interrupt)?;
    let r1 = around.over_rows(1, sums, check_interrupt)?;
    let r2 = around.over_rows(2, &count(sums), check_interrupt)?;
    let s00 = around.over_cols(0, &r0, check_interrupt)?;
    let s01 = around.over_cols(1, &r0, check_interrupt)?;
    let s10 = around.over_cols(0, &r1, check_interrupt)?;
    let s02 = around.over_cols(2, &count(&r0), check_interrupt)?;
    let s11 = around.over_cols(1, &count(&r1), check_interrupt)?;
    let s20 = around.over_cols(0, &r2, check_interrupt)?;
    let line = |node: usize| {
        let split = |[count, x, y, z]: Channels| (count, DVec3::new(x, y, z));
        let (n00, p00) = split(s00[node]);
        let ((n10, p10), (n01, p01)) = (split(s10[node]), split(s01[node]));
        let ([n20], [n11], [n02]) = (s20[node], s11[node], s02[node]);
        if n00 <= f64::MIN_POSITIVE {
            return None;
        }
        // Normalized by the total weight and the radius, so that the matrix is well scaled.
        let scale = 1.0 / radius;
        let (a, b) = (n10 / n00 * scale, n01 / n00 * scale);
        let (aa, ab, bb) = (n20 / n00, n11 / n00, n02 / n00);
        let [aa, ab, bb] = [aa, ab, bb].map(|moment| moment * scale * scale);
        let matrix = DMat3::from_cols_array(&[1.0, a, b, a, aa + RIDGE, ab, b, ab, bb + RIDGE]);
        let first = matrix.inverse().row(0);
        let place = first.x * p00 + (first.y * p10 + first.z * p01) * scale;
        Some(place / n00).filter(|place| place.is_finite()).or(Some(p00 / n00))
    };
    by_nodes(lattice, 1, check_interrupt, line)
}

/// The sums over all nodes at most `radius` edges from a node, by running sums along rows.
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
                // Each row has one more running sum than nodes.
                let (from, to) = (range.start + row, range.end + row);
                total = array::from_fn(|c| total[c] + (running[to][c] - running[from][c]));
            }
        });
        total
    }
}
