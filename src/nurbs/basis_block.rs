//! The basis functions along a row of a grid, and the sums that they weight.
//!
//! Columns that lie in one span share their control points: groups of them are computed side by
//! side, in the widest registers that [`pulp`] finds at run time.

use pulp::Simd;

use super::basis::{Basis, window};
use super::isocurve::Point;
use super::knot_vector::KnotVector;

/// Columns that are computed side by side: as many numbers as the widest registers hold.
const LANES: usize = 8;

/// Columns that take each step together: few enough for the numbers of all rows of a tile to stay
/// in the first level of the cache, enough to make the ends of loops rare.
pub(super) const BLOCK: usize = 32;

/// Rows that share their columns' basis functions while those are in registers.
pub(super) const ROWS: usize = 4;

/// One number for each column of a group, where a register can be loaded at once.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Lanes([f64; LANES]);

/// One number for each column of a block, and room for the last group's missing columns.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Numbers(pub [f64; BLOCK + LANES]);

impl Numbers {
    pub(super) const ONES: Self = Self([1.0; BLOCK + LANES]);
}

/// Homogeneous points of a block of columns, in each row of a tile.
pub(super) type TilePoints = [[Numbers; 4]; ROWS];

/// The values or derivatives of the basis functions at a group of columns.
type Functions<const ORDER: usize> = [Lanes; ORDER];

/// The basis functions at up to `BLOCK` columns of a grid.
pub(super) struct Columns<const ORDER: usize> {
    groups: Vec<Group>,
    values: Vec<Functions<ORDER>>,
    slopes: Vec<Functions<ORDER>>,
}

/// Up to `LANES` neighbouring columns in one span. Missing ones are computed like the last, and
/// overwritten by the next group.
struct Group {
    /// The first control point that the functions belong to.
    first: usize,
    /// The first column.
    start: usize,
}

impl<const ORDER: usize> Columns<ORDER> {
    /// Those of a grid, block by block.
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
        Self { groups, values, slopes }
    }

    /// Control points of each row of a tile, weighted by the basis functions and added up.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    pub(super) fn values<'a, S: Simd>(
        &self,
        simd: S,
        rows: &(impl Iterator<Item = &'a [Point]> + Clone),
        out: &mut TilePoints,
    ) {
        combine(simd, &self.groups, &self.values, rows, out);
    }

    /// The same, weighted by the derivatives of the basis functions.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    pub(super) fn slopes<'a, S: Simd>(
        &self,
        simd: S,
        rows: &(impl Iterator<Item = &'a [Point]> + Clone),
        out: &mut TilePoints,
    ) {
        combine(simd, &self.groups, &self.slopes, rows, out);
    }
}

/// Weights control points by functions, for as many columns at a time as a register holds.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn combine<'a, S: Simd, const ORDER: usize>(
    simd: S,
    groups: &[Group],
    functions: &[Functions<ORDER>],
    rows: &(impl Iterator<Item = &'a [Point]> + Clone),
    out: &mut TilePoints,
) {
    for (&Group { first, start }, functions) in groups.iter().zip(functions) {
        for part in 0..LANES / S::F64_LANES {
            // Held in registers while the rows pass.
            let mut held = [simd.splat_f64s(0.0); ORDER];
            for (held, function) in held.iter_mut().zip(functions) {
                *held = S::as_simd_f64s(&function.0).0[part];
            }
            for (row, out) in rows.clone().zip(&mut *out) {
                let net: &[Point; ORDER] = window(row, first);
                for (c, Numbers(out)) in out.iter_mut().enumerate() {
                    let mut sum = simd.mul_f64s(simd.splat_f64s(net[0][c]), held[0]);
                    for k in 1..ORDER {
                        let term = simd.mul_f64s(simd.splat_f64s(net[k][c]), held[k]);
                        sum = simd.add_f64s(sum, term);
                    }
                    S::as_mut_simd_f64s(&mut out[start..][..LANES]).0[part] = sum;
                }
            }
        }
    }
}
