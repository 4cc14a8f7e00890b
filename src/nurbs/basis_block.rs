//! Basis functions at a block of columns of a grid, and their weighted sums of control points.
//!
//! Columns in one span share their control points. Groups of them are computed side by side in the
//! widest registers that [`pulp`] finds at run time.

use pulp::Simd;

use super::basis::{Basis, order_of};
use super::control_net::HomogeneousPoint;
use super::knot_vector::KnotVector;

/// Columns in a group: as many numbers as the widest register contains.
const LANES: usize = 8;

/// Columns in a block: few enough for the values of all rows of a tile to stay in the L1 cache,
/// enough to make partial blocks rare.
pub(super) const BLOCK: usize = 32;

/// Rows of a tile; they share the basis functions while those are in registers.
pub(super) const ROWS: usize = 4;

/// One number for each column of a group, aligned for register loads.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Lanes([f64; LANES]);

/// One number for each column of a block, with padding for an incomplete last group.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct BlockValues(pub [f64; BLOCK + LANES]);

impl BlockValues {
    /// All ones, the initial content of buffers.
    pub(super) const ONES: Self = Self([1.0; BLOCK + LANES]);
}

/// Homogeneous points of a block of columns, for each row of a tile.
pub(super) type TilePoints = [[BlockValues; 4]; ROWS];

/// The values or derivatives of the basis functions at a group of columns.
type Functions<const ORDER: usize> = [Lanes; ORDER];

/// The basis functions at up to `BLOCK` columns of a grid.
pub(super) struct BasisBlock<const ORDER: usize> {
    groups: Vec<Group>,
    values: Vec<Functions<ORDER>>,
    slopes: Vec<Functions<ORDER>>,
    degree: usize,
}

/// Up to `LANES` neighboring columns in one span. An incomplete group repeats its last column; the
/// next group overwrites the extra results.
struct Group {
    /// Index of the first control point with a nonzero basis function.
    first: usize,
    /// Index of the first column.
    start: usize,
}

impl<const ORDER: usize> BasisBlock<ORDER> {
    /// Returns the blocks of a grid with these parameters.
    pub(super) fn blocks(knots: &KnotVector, v: &[f64]) -> Vec<Self> {
        v.chunks(BLOCK).map(|v| Self::new(knots, v)).collect()
    }

    fn new(knots: &KnotVector, v: &[f64]) -> Self {
        let bases: Vec<Basis<ORDER>> = v.iter().map(|&v| Basis::at(knots, v)).collect();
        let spans = bases.chunk_by(|a, b| a.first == b.first);
        let (mut groups, mut values, mut slopes) = (vec![], vec![], vec![]);
        let mut start = 0;
        for group in spans.flat_map(|span| span.chunks(LANES)) {
            let lanes = |functions: fn(&Basis<ORDER>) -> &[f64; ORDER]| {
                let lane = |lane: usize| functions(&group[lane.min(group.len() - 1)]);
                std::array::from_fn(|k| Lanes(std::array::from_fn(|i| lane(i)[k])))
            };
            values.push(lanes(|basis| &basis.values));
            slopes.push(lanes(|basis| &basis.slopes));
            groups.push(Group { first: group[0].first, start });
            start += group.len();
        }
        Self { groups, values, slopes, degree: knots.degree() }
    }

    /// Sums the control points of each row of a tile, weighted by the basis functions.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn values<'a, S: Simd>(
        &self,
        simd: S,
        rows: &(impl Iterator<Item = &'a [HomogeneousPoint]> + Clone),
        out: &mut TilePoints,
    ) {
        combine(simd, self, &self.values, rows, out);
    }

    /// Sums the control points of each row of a tile, weighted by the derivatives of the basis
    /// functions.
    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    pub(super) fn slopes<'a, S: Simd>(
        &self,
        simd: S,
        rows: &(impl Iterator<Item = &'a [HomogeneousPoint]> + Clone),
        out: &mut TilePoints,
    ) {
        combine(simd, self, &self.slopes, rows, out);
    }
}

/// Sums control points weighted by `functions` of a block, one register of columns at a time.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn combine<'a, S: Simd, const ORDER: usize>(
    simd: S,
    block: &BasisBlock<ORDER>,
    functions: &[Functions<ORDER>],
    rows: &(impl Iterator<Item = &'a [HomogeneousPoint]> + Clone),
    out: &mut TilePoints,
) {
    let order = order_of::<ORDER>(block.degree);
    for (&Group { first, start }, functions) in block.groups.iter().zip(functions) {
        for part in 0..LANES / S::F64_LANES {
            // The functions stay in registers while the rows are processed.
            let mut held = [simd.splat_f64s(0.0); ORDER];
            for (held, function) in held.iter_mut().zip(functions) {
                *held = S::as_simd_f64s(&function.0).0[part];
            }
            for (row, out) in rows.clone().zip(&mut *out) {
                let net = &row[first..][..order];
                for (c, BlockValues(out)) in out.iter_mut().enumerate() {
                    let mut sum = simd.mul_f64s(simd.splat_f64s(net[0][c]), held[0]);
                    for k in 1..order {
                        let term = simd.mul_f64s(simd.splat_f64s(net[k][c]), held[k]);
                        sum = simd.add_f64s(sum, term);
                    }
                    S::as_mut_simd_f64s(&mut out[start..][..LANES]).0[part] = sum;
                }
            }
        }
    }
}
