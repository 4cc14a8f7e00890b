//! The nodes in online training: one array for each coordinate, so that search and update run in
//! vector registers.

use std::ops::Range;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::lattice::Lattice;
use super::smoothing::gaussian;
use crate::error::Result;
use crate::progress::Listen;

/// Nodes compared side by side. A multiple of the widest vector registers' eight `f64`.
const LANES: usize = 16;

/// Nodes of which only the least distance is kept; the node itself is looked up in the best block.
const BLOCK: usize = 64;

/// Positions of nodes. The widest vector instructions of the processor are chosen at run time; they
/// compute the same bits, since none of them fuses a product with a sum.
pub(super) struct Field {
    count: usize,
    /// Padded to a multiple of [`BLOCK`] with places infinitely far away.
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    arch: Arch,
    /// Weights by distance along rows or columns, those of the rows and columns around the winner,
    /// and the share of its way that each node moves.
    profile: Vec<f64>,
    along: Vec<f64>,
    across: Vec<f64>,
    shares: Vec<f64>,
}

impl Field {
    pub(super) fn new(nodes: &[DVec3], lattice: &Lattice, listen: &mut Listen<'_>) -> Result<Self> {
        let mut padded = |coordinate: fn(&DVec3) -> f64| -> Result<Vec<f64>> {
            listen()?;
            let size = nodes.len().next_multiple_of(BLOCK);
            let mut values = Vec::with_capacity(size);
            values.extend(nodes.iter().map(coordinate));
            values.resize(size, f64::INFINITY);
            Ok(values)
        };
        let (rows, cols) = lattice.shape();
        Ok(Self {
            count: nodes.len(),
            x: padded(|p| p.x)?,
            y: padded(|p| p.y)?,
            z: padded(|p| p.z)?,
            arch: Arch::new(),
            profile: vec![0.0; rows.max(cols)],
            along: vec![0.0; rows],
            across: vec![0.0; cols],
            shares: vec![0.0; nodes.len()],
        })
    }

    /// The node nearest to `point`, the one with the lowest number among equals, and the square of
    /// its distance.
    pub(super) fn nearest(&self, point: DVec3) -> (usize, f64) {
        self.arch.dispatch(Nearest { x: &self.x, y: &self.y, z: &self.z, point })
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

    /// Moves all nodes of a quadrilateral grid by a Gaussian share of their way to `point`: `gain`
    /// times a weight for the row and one for the column.
    pub(super) fn attract_gaussian(
        &mut self,
        lattice: &Lattice,
        winner: usize,
        point: DVec3,
        gain: f64,
        radius: f64,
    ) {
        let (_, cols) = lattice.shape();
        let (winner_row, winner_col) = (winner / cols, winner % cols);
        gaussian(radius, &mut self.profile);
        for (row, weight) in self.along.iter_mut().enumerate() {
            *weight = gain * self.profile[lattice.row_distance(row, winner_row)];
        }
        for (col, weight) in self.across.iter_mut().enumerate() {
            *weight = self.profile[lattice.col_distance(col, winner_col)];
        }
        let pull = Pull {
            coordinates: [&mut self.x, &mut self.y, &mut self.z],
            shares: &mut self.shares,
            along: &self.along,
            across: &self.across,
            point,
        };
        self.arch.dispatch(pull);
    }

    /// Where the nodes are now.
    pub(super) fn positions(&self) -> impl Iterator<Item = DVec3> {
        (0..self.count).map(|i| DVec3::new(self.x[i], self.y[i], self.z[i]))
    }
}

/// The search for the nearest node, in registers of any width.
struct Nearest<'a> {
    x: &'a [f64],
    y: &'a [f64],
    z: &'a [f64],
    point: DVec3,
}

impl WithSimd for Nearest<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "becomes part of the code for the chosen registers")]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { x, y, z, point } = self;
        let squared = |x: f64, y: f64, z: f64| {
            let (dx, dy, dz) = (x - point.x, y - point.y, z - point.z);
            dx * dx + dy * dy + dz * dz
        };
        let (mut best, mut first) = (f64::INFINITY, 0);
        let blocks = x.chunks_exact(BLOCK).zip(y.chunks_exact(BLOCK)).zip(z.chunks_exact(BLOCK));
        for (number, ((xs, ys), zs)) in blocks.enumerate() {
            let mut least = [f64::INFINITY; LANES];
            let lanes = xs.chunks_exact(LANES).zip(ys.chunks_exact(LANES));
            for ((xs, ys), zs) in lanes.zip(zs.chunks_exact(LANES)) {
                for lane in 0..LANES {
                    let distance = squared(xs[lane], ys[lane], zs[lane]);
                    least[lane] = if distance < least[lane] { distance } else { least[lane] };
                }
            }
            let least = least.iter().fold(f64::INFINITY, |a, &b| if b < a { b } else { a });
            if least < best {
                (best, first) = (least, number * BLOCK);
            }
        }
        let winner = (first..first + BLOCK).find(|&i| squared(x[i], y[i], z[i]) == best);
        (winner.unwrap_or(first), best)
    }
}

/// The move of all nodes of a grid towards a point.
struct Pull<'a> {
    coordinates: [&'a mut [f64]; 3],
    shares: &'a mut [f64],
    along: &'a [f64],
    across: &'a [f64],
    point: DVec3,
}

impl WithSimd for Pull<'_> {
    type Output = ();

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "becomes part of the code for the chosen registers")]
    fn with_simd<S: Simd>(self, _: S) {
        for (shares, &weight) in self.shares.chunks_exact_mut(self.across.len()).zip(self.along) {
            for (share, across) in shares.iter_mut().zip(self.across) {
                *share = weight * across;
            }
        }
        for (values, target) in self.coordinates.into_iter().zip(self.point.to_array()) {
            for (value, &share) in values.iter_mut().zip(&*self.shares) {
                *value += share * (target - *value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    #[test]
    fn nearest_is_the_first_of_the_least() {
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
            let field = Field::new(&nodes, &lattice, &mut || Ok(())).unwrap();
            for _ in 0..200 {
                let p = sample();
                let least = nodes.iter().map(|w| w.distance_squared(p)).fold(f64::MAX, f64::min);
                let first = nodes.iter().position(|w| w.distance_squared(p) == least);
                assert_eq!(field.nearest(p), (first.unwrap(), least));
            }
        }
    }

    #[test]
    fn a_gaussian_pulls_by_distance() {
        let lattice = Lattice::quad(3, 4).unwrap();
        let mut field = Field::new(&[DVec3::ZERO; 12], &lattice, &mut || Ok(())).unwrap();
        field.attract_gaussian(&lattice, 6, DVec3::X, 0.5, 1.5);
        for (node, place) in field.positions().enumerate() {
            let (row, col) = (node as f64 / 4.0, (node % 4) as f64);
            let squared = (row.floor() - 1.0).powi(2) + (col - 2.0).powi(2);
            let expected = 0.5 * (-0.5 * squared / 1.5_f64.powi(2)).exp();
            assert!((place.x - expected).abs() < 1e-15 && place.y == 0.0);
        }
    }
}
