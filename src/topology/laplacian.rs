//! Sums of squared differences along the edges of a graph, and where they are least.

use rayon::prelude::*;

use crate::cloud::NeighborGraph;

/// Steps of the conjugate gradients; some tens suffice for a thousand nodes.
const MOST_STEPS: usize = 400;

/// Residual at which they end, as a share of the first: for angles finer than the points tell.
const SOLVED: f64 = 1e-4;

/// Nodes that a thread takes at a time: fewer are done before another one is awake.
const NODES_PER_TASK: usize = 2048;

/// The Laplace matrix of a graph with weighted edges.
pub(super) struct Laplacian {
    /// Where each node's links begin; one more than nodes.
    starts: Vec<usize>,
    /// The other end of each and its weight.
    links: Vec<(u32, f64)>,
    /// The sums of the nodes' weights.
    diagonal: Vec<f64>,
}

impl Laplacian {
    /// That of a graph with this number of nodes and these links: from, to and weight, from both
    /// ends of an edge. A node's links add up in the order in which they come.
    pub(super) fn of(nodes: usize, links: impl Iterator<Item = (u32, u32, f64)> + Clone) -> Self {
        let (mut starts, mut diagonal) = (vec![0; nodes + 1], vec![0.0; nodes]);
        for (from, _, weight) in links.clone() {
            starts[from as usize + 1] += 1;
            diagonal[from as usize] += weight;
        }
        (1..starts.len()).for_each(|node| starts[node] += starts[node - 1]);
        let (mut next, mut sorted) = (starts.clone(), vec![(0, 0.0); starts[nodes]]);
        for (from, to, weight) in links {
            sorted[next[from as usize]] = (to, weight);
            next[from as usize] += 1;
        }
        Self { starts, links: sorted, diagonal }
    }

    /// That of neighbours, all of whose links count alike.
    pub(super) fn of_neighbors(graph: &NeighborGraph) -> Self {
        let links = |from: u32| graph.edges(from as usize).iter().map(move |e| (from, e.to, 1.0));
        let nodes = u32::try_from(graph.len()).unwrap_or(u32::MAX);
        Self::of(graph.len(), (0..nodes).flat_map(links))
    }

    /// Writes its product with a vector into `image`.
    fn apply(&self, x: &[f64], image: &mut [f64]) {
        let row = |(node, image): (usize, &mut f64)| {
            let links = &self.links[self.starts[node]..self.starts[node + 1]];
            let (groups, rest) = links.as_chunks::<4>();
            let value = |&(to, weight): &(u32, f64)| weight * x[to as usize];
            let mut sums = [0.0; 4];
            for group in groups {
                sums.iter_mut().zip(group).for_each(|(sum, link)| *sum += value(link));
            }
            let rest: f64 = rest.iter().map(value).sum();
            *image = self.diagonal[node] * x[node] - (sums.iter().sum::<f64>() + rest);
        };
        image.par_iter_mut().with_min_len(NODES_PER_TASK).enumerate().for_each(row);
    }

    /// Writes the residual into `prepared`, divided by the diagonal, and answers with the product of
    /// both.
    fn prepare(&self, residual: &[f64], prepared: &mut [f64]) -> f64 {
        for ((prepared, r), d) in prepared.iter_mut().zip(residual).zip(&self.diagonal) {
            *prepared = if *d > 0.0 { r / d } else { 0.0 };
        }
        dot(residual, prepared)
    }

    /// Numbers for the nodes whose image is `right`, which sums up to 0, by conjugate gradients
    /// (Golub and Van Loan, Matrix Computations, section 11.5), preconditioned by the diagonal.
    pub(super) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; right.len()];
        let (mut image, mut prepared) = (x.clone(), x.clone());
        let mut residual = right.to_vec();
        let mut energy = self.prepare(&residual, &mut prepared);
        let mut direction = prepared.clone();
        let enough = SOLVED * SOLVED * energy;
        for _ in 0..MOST_STEPS {
            if energy <= enough {
                break;
            }
            self.apply(&direction, &mut image);
            let step = energy / dot(&direction, &image);
            for (x, direction) in x.iter_mut().zip(&direction) {
                *x += step * direction;
            }
            for (residual, image) in residual.iter_mut().zip(&image) {
                *residual -= step * image;
            }
            let before = std::mem::replace(&mut energy, self.prepare(&residual, &mut prepared));
            for (direction, prepared) in direction.iter_mut().zip(&prepared) {
                *direction = prepared + energy / before * *direction;
            }
        }
        x
    }
}

/// Sums that are added at last: one alone would wait for each product.
const LANES: usize = 8;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_flows_evenly_along_a_line() {
        let ends = (0..40).flat_map(|node| [(node, node + 1, 2.0), (node + 1, node, 2.0)]);
        let mut right = vec![0.0; 41];
        (right[0], right[40]) = (6.0, -6.0);
        let found = Laplacian::of(41, ends).solve(&right);
        assert!(found.windows(2).all(|pair| (pair[0] - pair[1] - 3.0).abs() < 1e-5));
    }
}
