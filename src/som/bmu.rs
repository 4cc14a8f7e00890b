//! The best matching unit: the node nearest to a point.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;

/// Pairs of point and node compared between two reports: a few milliseconds.
pub(super) const VISITS_PER_REPORT: usize = 1 << 22;

/// Nodes compared side by side. A multiple of the widest vector registers' eight `f64`.
const LANES: usize = 16;

/// Positions of nodes, one array for each coordinate so that the search runs in vector registers.
pub(super) struct Nodes {
    count: usize,
    /// Padded to a multiple of [`LANES`] with places infinitely far away.
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Nodes {
    pub(super) fn new(codebook: &[DVec3]) -> Self {
        let padded = |coordinate: fn(&DVec3) -> f64| {
            let mut values: Vec<f64> = codebook.iter().map(coordinate).collect();
            values.resize(codebook.len().next_multiple_of(LANES), f64::INFINITY);
            values
        };
        Self { count: codebook.len(), x: padded(|p| p.x), y: padded(|p| p.y), z: padded(|p| p.z) }
    }

    /// The node nearest to `point`, the one with the lowest number among equals, and the square of
    /// its distance.
    ///
    /// Each lane keeps its own nearest block of nodes; the lanes are compared at the end.
    pub(super) fn nearest(&self, point: DVec3) -> (usize, f64) {
        let mut least = [f64::INFINITY; LANES];
        let mut block = [0_usize; LANES];
        let coordinates = self.x.chunks_exact(LANES).zip(self.y.chunks_exact(LANES));
        for (b, ((xs, ys), zs)) in coordinates.zip(self.z.chunks_exact(LANES)).enumerate() {
            for lane in 0..LANES {
                let (dx, dy, dz) = (xs[lane] - point.x, ys[lane] - point.y, zs[lane] - point.z);
                let distance = dx * dx + dy * dy + dz * dz;
                let nearer = distance < least[lane];
                least[lane] = if nearer { distance } else { least[lane] };
                block[lane] = if nearer { b } else { block[lane] };
            }
        }
        let candidates = (0..LANES).map(|lane| (block[lane] * LANES + lane, least[lane]));
        candidates.fold((usize::MAX, f64::INFINITY), |best, candidate| {
            let nearer = candidate.1 < best.1;
            let lower = candidate.1 == best.1 && candidate.0 < best.0;
            if nearer || lower { candidate } else { best }
        })
    }

    /// Calls `visit` with the index of each point and the square of its distance to the nearest
    /// node, in order; the search runs in parallel, and `report` is called every few milliseconds.
    pub(super) fn visit_distances(
        &self,
        points: &[DVec3],
        report: &mut dyn FnMut() -> Result<()>,
        mut visit: impl FnMut(usize, f64),
    ) -> Result<()> {
        let block = (VISITS_PER_REPORT / self.count).max(1);
        for (number, points) in points.chunks(block).enumerate() {
            report()?;
            let search = points.par_iter().map(|&point| self.nearest(point).1);
            for (offset, distance_squared) in search.collect::<Vec<f64>>().into_iter().enumerate() {
                visit(number * block + offset, distance_squared);
            }
        }
        Ok(())
    }

    /// Moves a range of nodes by the share `gain` of their way to `point`.
    pub(super) fn attract(&mut self, nodes: Range<usize>, point: DVec3, gain: f64) {
        let coordinates = [(&mut self.x, point.x), (&mut self.y, point.y), (&mut self.z, point.z)];
        for (values, target) in coordinates {
            for value in &mut values[nodes.clone()] {
                *value += gain * (target - *value);
            }
        }
    }

    /// Where the nodes are now.
    pub(super) fn positions(&self) -> impl Iterator<Item = DVec3> {
        (0..self.count).map(|i| DVec3::new(self.x[i], self.y[i], self.z[i]))
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    #[test]
    fn nearest_is_the_first_of_the_least() {
        let mut rng = Pcg64::seed_from_u64(1);
        // Few distinct coordinates, so that ties are frequent.
        let mut sample = || {
            let mut coordinate = || f64::from(rng.random_range(0..4_u8));
            DVec3::new(coordinate(), coordinate(), coordinate())
        };
        for count in [4, 15, 16, 17, 100] {
            let codebook: Vec<DVec3> = (0..count).map(|_| sample()).collect();
            let nodes = Nodes::new(&codebook);
            for _ in 0..200 {
                let p = sample();
                let least = codebook.iter().map(|w| w.distance_squared(p)).fold(f64::MAX, f64::min);
                let first = codebook.iter().position(|w| w.distance_squared(p) == least);
                assert_eq!(nodes.nearest(p), (first.unwrap(), least));
            }
        }
    }
}
