//! The second half of an epoch of batch training: from the sums of winners to new nodes.

use std::array;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::graph::Visits;
use super::lattice::Lattice;
use super::options::{Kernel, Neighborhood};

/// A share of the neighbourhood's own variance that is added to that of its data: where almost all
/// points lie on one line of nodes, the line fitted to them must not tip over.
const RIDGE: f64 = 1e-3;

/// A Gaussian counts as zero where it is under this share of its middle, when distances are
/// searched in a graph: 7.4 radii away.
const NEGLIGIBLE: f64 = 1e-12;

/// Sums of one node: number of points, and their coordinates.
pub(super) type Channels = [f64; 4];

/// The new place of each node: the weighted mean of the points, or the local line's value; `None`
/// where no points weigh anything. Places are in the unit of the sums.
///
/// On a quadrilateral grid a Gaussian is a product of one along the rows and one along the columns,
/// which costs O(m (rows + cols)); a bubble, by running sums, O(m rows). On other lattices each
/// node that has won points tells its neighbours, as far as the neighbourhood reaches.
pub(super) fn smooth(
    lattice: &Lattice,
    sums: &[Channels],
    neighborhood: Neighborhood,
    kernel: Kernel,
    radius: f64,
) -> Vec<Option<DVec3>> {
    let grid = lattice.as_graph().is_none();
    match (neighborhood, kernel) {
        (Neighborhood::Gaussian, Kernel::Linear) => local_lines(lattice, sums, radius),
        (Neighborhood::Gaussian, Kernel::Mean) if grid => {
            let (rows, cols) = weights(lattice, radius);
            let along_rows = over_rows(lattice, &rows[0], sums);
            means(&over_cols(lattice, &cols[0], &along_rows))
        }
        (Neighborhood::Bubble, _) if grid => means(&bubble(lattice, sums, edges_within(radius))),
        (Neighborhood::Gaussian, _) => {
            let weight = |hops| (-0.5 * (hops as f64 / radius).powi(2)).exp();
            let reach =
                (0..lattice.len()).take_while(|&hops| hops == 0 || weight(hops) > NEGLIGIBLE);
            let reach = reach.last().unwrap_or(0);
            means(&spread(lattice, sums, reach, |hops| if hops == 0 { 1.0 } else { weight(hops) }))
        }
        (Neighborhood::Bubble, _) => means(&spread(lattice, sums, edges_within(radius), |_| 1.0)),
    }
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

/// `exp(-(d / radius)² / 2)` for d = 0, 1, … Each follows from the one before by the next power of
/// the same ratio, so that one exponential is enough.
pub(super) fn gaussian(radius: f64, weights: &mut [f64]) {
    let ratio = (-0.5 / (radius * radius)).exp();
    let (mut weight, mut factor) = (1.0, ratio);
    for value in weights {
        *value = weight;
        weight *= factor;
        factor *= ratio * ratio;
    }
}

/// The weights among rows, and among columns: `[to * count + from]`, times the signed distance from
/// `to` to `from` to the power of 0, 1 and 2.
type Weights = [Vec<f64>; 3];

fn weights(lattice: &Lattice, radius: f64) -> (Weights, Weights) {
    let (rows, cols) = lattice.shape();
    let (closed_u, closed_v) = lattice.topology().closed();
    (powers(rows, closed_u, radius), powers(cols, closed_v, radius))
}

fn powers(count: usize, closed: bool, radius: f64) -> Weights {
    let mut profile = vec![0.0; count];
    gaussian(radius, &mut profile);
    let weight = |to: usize, from: usize, power: i32| {
        let mut apart = from as f64 - to as f64;
        let mut distance = from.abs_diff(to);
        if closed && 2 * distance > count {
            distance = count - distance;
            apart -= (count as f64).copysign(apart);
        } else if closed && 2 * distance == count && power == 1 {
            // Opposite on the ring: as far one way as the other.
            return 0.0;
        }
        profile[distance] * apart.powi(power)
    };
    array::from_fn(|power| {
        let power = i32::try_from(power).unwrap_or(0);
        let pairs = (0..count).flat_map(|to| (0..count).map(move |from| (to, from)));
        pairs.map(|(to, from)| weight(to, from, power)).collect()
    })
}

/// Weighted sums along u: row `to` of the result is Σ weight[to, from] · row `from`.
fn over_rows<const N: usize>(
    lattice: &Lattice,
    weights: &[f64],
    sums: &[[f64; N]],
) -> Vec<[f64; N]> {
    let (rows, cols) = lattice.shape();
    let mut result = vec![[0.0; N]; sums.len()];
    result.par_chunks_mut(cols).zip(weights.par_chunks(rows)).for_each(|(row, weights)| {
        for (&weight, from) in weights.iter().zip(sums.chunks(cols)) {
            if weight != 0.0 {
                let (row, from) = (row.as_flattened_mut(), from.as_flattened());
                row.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    });
    result
}

/// Weighted sums along v.
fn over_cols<const N: usize>(
    lattice: &Lattice,
    weights: &[f64],
    sums: &[[f64; N]],
) -> Vec<[f64; N]> {
    let (_, cols) = lattice.shape();
    let mut result = vec![[0.0; N]; sums.len()];
    result.par_chunks_mut(cols).zip(sums.par_chunks(cols)).for_each(|(row, sums)| {
        for (sum, weights) in row.iter_mut().zip(weights.chunks(cols)) {
            for (&weight, from) in weights.iter().zip(sums) {
                for (sum, value) in sum.iter_mut().zip(from) {
                    *sum += weight * value;
                }
            }
        }
    });
    result
}

fn means(sums: &[Channels]) -> Vec<Option<DVec3>> {
    let mean = |&[count, x, y, z]: &Channels| {
        (count > f64::MIN_POSITIVE).then(|| DVec3::new(x, y, z) / count)
    };
    sums.iter().map(mean).collect()
}

/// Local linear regression over the lattice: the line through the weighted points whose value at
/// the node itself is the node's new place (Fan and Gijbels, Local Polynomial Modelling, 1996).
fn local_lines(lattice: &Lattice, sums: &[Channels], radius: f64) -> Vec<Option<DVec3>> {
    let (rows, cols) = weights(lattice, radius);
    let count = |sums: &[Channels]| -> Vec<[f64; 1]> { sums.iter().map(|s| [s[0]]).collect() };
    let [r0, r1] = [0, 1].map(|power| over_rows(lattice, &rows[power], sums));
    let r2 = over_rows(lattice, &rows[2], &count(sums));
    let s00 = over_cols(lattice, &cols[0], &r0);
    let s01 = over_cols(lattice, &cols[1], &r0);
    let s10 = over_cols(lattice, &cols[0], &r1);
    let s02 = over_cols(lattice, &cols[2], &count(&r0));
    let s11 = over_cols(lattice, &cols[1], &count(&r1));
    let s20 = over_cols(lattice, &cols[0], &r2);
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
    (0..sums.len()).into_par_iter().map(line).collect()
}

/// Sums over all nodes at most `radius` edges away, from running sums along the rows.
fn bubble(lattice: &Lattice, sums: &[Channels], radius: usize) -> Vec<Channels> {
    let (_, cols) = lattice.shape();
    let mut running = Vec::with_capacity(sums.len() + sums.len() / cols);
    for row in sums.chunks(cols) {
        let mut sum = Channels::default();
        running.push(sum);
        for value in row {
            sum = array::from_fn(|channel| sum[channel] + value[channel]);
            running.push(sum);
        }
    }
    let around = |node: usize| {
        let mut total = Channels::default();
        lattice.visit_ball(node, radius, |range| {
            if let Some(last) = range.end.checked_sub(1).filter(|_| !range.is_empty()) {
                let row = last / cols;
                // Each row has one running sum more than it has nodes.
                let (from, to) = (range.start + row, range.end + row);
                total = array::from_fn(|c| total[c] + (running[to][c] - running[from][c]));
            }
        });
        total
    };
    (0..sums.len()).into_par_iter().map(around).collect()
}

/// Each node gives its sums to those at most `reach` edges away, times a weight.
fn spread(
    lattice: &Lattice,
    sums: &[Channels],
    reach: usize,
    weight: impl Fn(usize) -> f64,
) -> Vec<Channels> {
    let mut result = vec![Channels::default(); sums.len()];
    let Some(graph) = lattice.as_graph() else { return result };
    let weights: Vec<f64> = (0..=reach.min(lattice.len())).map(weight).collect();
    let mut visits = Visits::default();
    for (node, sum) in sums.iter().enumerate().filter(|(_, sum)| sum[0] > 0.0) {
        graph.visit(node, reach, &mut visits, |other, hops| {
            for (total, value) in result[other].iter_mut().zip(sum) {
                *total += weights[hops] * value;
            }
        });
    }
    result
}
