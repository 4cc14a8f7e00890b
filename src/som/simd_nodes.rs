//! Node positions of online training in vector-register lanes, for SIMD search and update.

use std::ops::Range;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::gaussian::{LANES, SideWeights, gaussian_weights};
use super::lattice::{Distances, Lattice};
use crate::error::Result;
use crate::progress::InterruptCheck;

/// Moves by a smaller share of the distance vanish in rounding and are skipped.
const NEGLIGIBLE_SHARE: f64 = 1e-18;

/// Positions of consecutive nodes of a row.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Block {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
}

/// Node positions in SIMD layout. The widest vector instructions of the processor are chosen at run
/// time. All give the same bits, because none fuses multiplication and addition.
pub(super) struct SimdNodes {
    rows: usize,
    cols: usize,
    /// Row by row. Each row is padded with NaN, which no search selects.
    blocks: Vec<Block>,
    arch: Arch,
    /// Weights by distance, and those along rows and columns.
    weights: Vec<f64>,
    along: SideWeights,
    across: SideWeights,
}

impl SimdNodes {
    pub(super) fn new(
        nodes: &[DVec3],
        lattice: &Lattice,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        // The nodes of a graph form one row.
        let (rows, cols) = match lattice.distances() {
            Distances::Grid(grid) => (grid.rows, grid.cols),
            Distances::Graph(graph) => (1, graph.len()),
        };
        let mut blocks = Vec::with_capacity(rows * cols.div_ceil(LANES));
        for row in nodes.chunks(cols) {
            check_interrupt()?;
            blocks.extend(row.chunks(LANES).map(Block::of));
        }
        let (closed_u, closed_v) = lattice.topology().closed();
        let (along, across) = (SideWeights::new(rows, closed_u), SideWeights::new(cols, closed_v));
        let weights = vec![0.0; rows.max(cols)];
        Ok(Self { rows, cols, blocks, arch: Arch::new(), weights, along, across })
    }

    /// The node nearest to `point` and its squared distance. Ties go to the lowest index.
    pub(super) fn nearest(&self, point: DVec3) -> (usize, f64) {
        let (place, squared) = self.arch.dispatch(Nearest { blocks: &self.blocks, point });
        let width = self.width();
        (place / width * self.cols + place % width, squared)
    }

    /// Moves a range of nodes of one row toward `point`, by the share `gain` of their distance.
    pub(super) fn attract(&mut self, nodes: Range<usize>, point: DVec3, gain: f64) {
        let filled = nodes.start / self.cols * (self.width() - self.cols);
        let places = nodes.start + filled..nodes.end + filled;
        self.arch.dispatch(MoveRange { blocks: &mut self.blocks, places, point, gain });
    }

    /// Sets the radius of [`Self::attract_gaussian`].
    pub(super) fn set_radius(&mut self, radius: f64) {
        gaussian_weights(radius, &mut self.weights);
        self.along.set(&self.weights);
        self.across.set(&self.weights);
    }

    /// Moves all nodes of a quadrilateral grid toward `point`. The share is `gain` times a Gaussian
    /// weight for the row and one for the column.
    pub(super) fn attract_gaussian(&mut self, winner: usize, point: DVec3, gain: f64) {
        let along = self.along.around(winner / self.cols);
        let across = self.across.around(winner % self.cols);
        let blocks = &mut self.blocks;
        self.arch.dispatch(MoveAll { blocks, along, across, point, gain });
    }

    /// The current node positions.
    pub(super) fn positions(&self) -> impl Iterator<Item = DVec3> {
        let width = self.width();
        (0..self.rows * self.cols).map(move |node| {
            let place = node / self.cols * width + node % self.cols;
            self.blocks[place / LANES].node(place % LANES)
        })
    }

    /// Positions per row, padding included.
    fn width(&self) -> usize {
        self.cols.next_multiple_of(LANES)
    }
}

impl Block {
    fn of(nodes: &[DVec3]) -> Self {
        let lanes = |coordinate: fn(&DVec3) -> f64| {
            let mut values = [f64::NAN; LANES];
            values.iter_mut().zip(nodes).for_each(|(value, node)| *value = coordinate(node));
            values
        };
        Self { x: lanes(|p| p.x), y: lanes(|p| p.y), z: lanes(|p| p.z) }
    }

    fn node(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Moves each node toward `point` by a share of its distance.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "inlined into the code for each register width")]
    fn pull(&mut self, point: DVec3, share: impl Fn(usize) -> f64) {
        for lane in 0..LANES {
            let share = share(lane);
            self.x[lane] += share * (point.x - self.x[lane]);
            self.y[lane] += share * (point.y - self.y[lane]);
            self.z[lane] += share * (point.z - self.z[lane]);
        }
    }
}

/// The nearest-node search, in registers of any width.
struct Nearest<'a> {
    blocks: &'a [Block],
    point: DVec3,
}

impl WithSimd for Nearest<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "inlined into the code for each register width")]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { blocks, point } = self;
        // Block indices are `f64` so that they use the same registers as distances.
        let (mut least, mut found) = ([f64::INFINITY; LANES], [0.0; LANES]);
        let mut number = 0.0;
        for block in blocks {
            for lane in 0..LANES {
                let (dx, dy) = (block.x[lane] - point.x, block.y[lane] - point.y);
                let dz = block.z[lane] - point.z;
                let squared = dx * dx + dy * dy + dz * dz;
                let nearer = squared < least[lane];
                least[lane] = if nearer { squared } else { least[lane] };
                found[lane] = if nearer { number } else { found[lane] };
            }
            number += 1.0;
        }
        let mut best = (0, f64::INFINITY);
        for lane in 0..LANES {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "the number of a block"
            )]
            let (place, squared) = (found[lane] as usize * LANES + lane, least[lane]);
            if squared < best.1 || (squared == best.1 && place < best.0) {
                best = (place, squared);
            }
        }
        best
    }
}

/// The move of a range of nodes toward a point.
struct MoveRange<'a> {
    blocks: &'a mut [Block],
    places: Range<usize>,
    point: DVec3,
    gain: f64,
}

impl WithSimd for MoveRange<'_> {
    type Output = ();

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "inlined into the code for each register width")]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { blocks, places, point, gain } = self;
        let numbers = places.start / LANES..places.end.div_ceil(LANES);
        for (block, number) in blocks[numbers.clone()].iter_mut().zip(numbers) {
            let first = number * LANES;
            block.pull(point, |lane| {
                if (places.start..places.end).contains(&(first + lane)) { gain } else { 0.0 }
            });
        }
    }
}

/// The move of all nodes of a grid toward a point.
struct MoveAll<'a> {
    blocks: &'a mut [Block],
    along: &'a [f64],
    across: &'a [f64],
    point: DVec3,
    gain: f64,
}

impl WithSimd for MoveAll<'_> {
    type Output = ();

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "inlined into the code for each register width")]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { blocks, along, across, point, gain } = self;
        let across = across.as_chunks::<LANES>().0;
        for (row, weight) in blocks.chunks_exact_mut(across.len()).zip(along) {
            let weight = gain * weight;
            if weight < NEGLIGIBLE_SHARE {
                continue;
            }
            for (block, across) in row.iter_mut().zip(across) {
                block.pull(point, |lane| weight * across[lane]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    #[test]
    fn nearest_returns_the_first_of_equal_nodes() {
        let mut random = Random::new(1);
        // Few distinct coordinates, so that ties are frequent.
        let mut sample = || {
            let mut coordinate = || random.index(4) as f64;
            DVec3::new(coordinate(), coordinate(), coordinate())
        };
        for count in [4, 63, 64, 65, 200] {
            let nodes: Vec<DVec3> = (0..count).map(|_| sample()).collect();
            let star: Vec<_> = (1..count).map(|i| (0, i)).collect();
            let lattice = Lattice::graph(count, &star).unwrap();
            let simd_nodes = SimdNodes::new(&nodes, &lattice, &mut || Ok(())).unwrap();
            for _ in 0..200 {
                let p = sample();
                let least = nodes.iter().map(|w| w.distance_squared(p)).fold(f64::MAX, f64::min);
                let first = nodes.iter().position(|w| w.distance_squared(p) == least);
                assert_eq!(simd_nodes.nearest(p), (first.unwrap(), least));
            }
        }
    }

    #[test]
    fn attract_gaussian_weights_by_distance() {
        let lattice = Lattice::quad(3, 4).unwrap();
        let mut simd_nodes = SimdNodes::new(&[DVec3::ZERO; 12], &lattice, &mut || Ok(())).unwrap();
        simd_nodes.set_radius(1.5);
        simd_nodes.attract_gaussian(6, DVec3::X, 0.5);
        for (node, place) in simd_nodes.positions().enumerate() {
            let (row, col) = (node as f64 / 4.0, (node % 4) as f64);
            let squared = (row.floor() - 1.0).powi(2) + (col - 2.0).powi(2);
            let expected = 0.5 * (-0.5 * squared / 1.5_f64.powi(2)).exp();
            assert!((place.x - expected).abs() < 1e-15 && place.y == 0.0);
        }
    }
}
