//! Evaluation on a grid, one row at a time.
//!
//! A row of equal u contracts the net once to the control points of its isocurve; a point then
//! costs O(degree) instead of O(degree²). Columns that lie in one span share their control points:
//! groups of them are computed side by side, by plain loops that the compiler turns into the widest
//! instructions that [`pulp`] finds at run time. No loop fuses multiplication and addition: results
//! are the same on every machine.

use glam::{DVec3, DVec4};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::basis::{Basis, BasisDerivatives, window, with_order};
use super::batch::{Outside, POINTS_PER_TASK, check_length, in_rows};
use super::frame::{Flats, Frame};
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::progress::Observer;

/// A homogeneous point.
type Point = [f64; 4];

/// Columns that are computed side by side: as many numbers as registers commonly hold.
const LANES: usize = 4;

/// One number for each column of a group.
type Lanes = [f64; LANES];

/// Columns that take each step together: few enough for all their numbers to stay in the first
/// level of the cache, enough to make the ends of loops rare.
const BLOCK: usize = 64;

/// One number for each column of a block, and room for the last group's missing columns.
type Numbers = [f64; BLOCK + LANES];

impl NurbsSurface {
    /// The points on the grid of all pairs of `u` and `v`, and the unit normals if asked for,
    /// written row by row, `v` fastest.
    ///
    /// Each row contracts the net once, so that a point costs O(degree) instead of O(degree²).
    ///
    /// # Errors
    ///
    /// [`crate::Error::Parameter`] if a parameter lies outside the domain (and that is refused) or an
    /// output has not `u.len() * v.len()` elements; [`crate::Error::Interrupted`] if the observer stops
    /// it.
    pub fn evaluate_grid(
        &self,
        u: &[f64],
        v: &[f64],
        points: &mut [DVec3],
        normals: Option<&mut [DVec3]>,
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let total = u.len() * v.len();
        check_length(points.len(), total)?;
        check_length(normals.as_ref().map_or(total, |n| n.len()), total)?;
        self.check_grid(u, v, outside)?;
        if total == 0 {
            return Ok(());
        }
        let degree = self.knots_v().degree();
        with_order!(degree, ORDER => self.grid_rows::<ORDER>(u, v, (points, normals), observer))
    }

    fn grid_rows<const ORDER: usize>(
        &self,
        u: &[f64],
        v: &[f64],
        (points, normals): (&mut [DVec3], Option<&mut [DVec3]>),
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (arch, columns) = (Arch::new(), Columns::<ORDER>::blocks(self.knots_v(), v));
        let least = POINTS_PER_TASK / v.len();
        let (surface, columns) = (self, &columns);
        let Some(normals) = normals else {
            return in_rows(u.len(), v.len(), observer, |from, to| {
                let points = points[from * v.len()..to * v.len()].par_chunks_mut(v.len());
                let rows = points.zip(&u[from..to]).with_min_len(least);
                rows.for_each_init(Isocurve::default, |net, (points, &u)| {
                    arch.dispatch(PointRow(Row { surface, u, columns, net, points }));
                });
            });
        };
        in_rows(u.len(), v.len(), observer, |from, to| {
            let points = points[from * v.len()..to * v.len()].par_chunks_mut(v.len());
            let normals = normals[from * v.len()..to * v.len()].par_chunks_mut(v.len());
            let rows = points.zip(normals).zip(&u[from..to]).with_min_len(least);
            rows.for_each_init(Isocurve::default, |net, ((points, normals), &u)| {
                let repair = |column: usize| self.normal(u, v[column]);
                let row = Row { surface, u, columns, net, points };
                arch.dispatch(NormalRow { row, normals, repair });
            });
        })
    }
}

/// The control points of an isocurve, and their derivatives by the other parameter.
#[derive(Default)]
pub(super) struct Isocurve {
    values: Vec<Point>,
    slopes: Vec<Point>,
    bends: Vec<Point>,
}

impl Isocurve {
    /// That of `u`, with `ROWS - 1` derivatives.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn contract<const ROWS: usize>(&mut self, surface: &NurbsSurface, u: f64) {
        let basis = BasisDerivatives::<ROWS>::at(surface.knots_u(), u);
        let cols = surface.shape().1;
        let order = surface.knots_u().degree() + 1;
        let net: &[Point] = bytemuck::cast_slice(surface.homogeneous());
        let net = &net[basis.first * cols..][..order * cols];
        let targets = [&mut self.values, &mut self.slopes, &mut self.bends];
        for (target, factors) in targets.into_iter().zip(&basis.rows) {
            target.clear();
            target.resize(cols, [0.0; 4]);
            for (row, factor) in net.chunks_exact(cols).zip(factors) {
                let (target, row) = (target.as_flattened_mut(), row.as_flattened());
                for (sum, control) in target.iter_mut().zip(row) {
                    *sum += factor * control;
                }
            }
        }
    }
}

/// The basis functions at up to `BLOCK` columns of a grid.
struct Columns<const ORDER: usize> {
    groups: Vec<Group>,
    /// For each group the values of its functions.
    values: Vec<[Lanes; ORDER]>,
    /// And their derivatives.
    slopes: Vec<[Lanes; ORDER]>,
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
    fn blocks(knots: &KnotVector, v: &[f64]) -> Vec<Self> {
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
                std::array::from_fn(|k| std::array::from_fn(|i| lane(i)[k]))
            };
            values.push(lanes(|basis| &basis.values));
            slopes.push(lanes(|basis| &basis.slopes));
            groups.push(Group { first: group[0].first, start });
            start += group.len();
        }
        Self { groups, values, slopes }
    }
}

/// Homogeneous points of a block of columns: sums of control points, weighted by basis functions.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn combine<const ORDER: usize>(
    points: &[Point],
    groups: &[Group],
    functions: &[[Lanes; ORDER]],
    out: &mut [Numbers; 4],
) {
    for (group, functions) in groups.iter().zip(functions) {
        let net: &[Point; ORDER] = window(points, group.first);
        for (c, out) in out.iter_mut().enumerate() {
            let mut sums = functions[0].map(|value| net[0][c] * value);
            for k in 1..ORDER {
                for lane in 0..LANES {
                    sums[lane] += net[k][c] * functions[k][lane];
                }
            }
            out[group.start..][..LANES].copy_from_slice(&sums);
        }
    }
}

/// A row of a grid.
struct Row<'a, const ORDER: usize> {
    surface: &'a NurbsSurface,
    u: f64,
    columns: &'a [Columns<ORDER>],
    /// Room for the control points of the row.
    net: &'a mut Isocurve,
    points: &'a mut [DVec3],
}

/// The points of a row.
struct PointRow<'a, const ORDER: usize>(Row<'a, ORDER>);

impl<const ORDER: usize> WithSimd for PointRow<'_, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Row { surface, u, columns, net, points } = self.0;
        net.contract::<1>(surface, u);
        let mut block = [[1.0; BLOCK + LANES]; 4];
        for (points, columns) in points.chunks_mut(BLOCK).zip(columns) {
            combine(&net.values, &columns.groups, &columns.values, &mut block);
            let [x, y, z, w] = &mut block;
            if surface.weights().is_some() {
                *w = w.map(f64::recip);
            } else {
                // In place of sums that are 1 up to rounding.
                *w = [1.0; BLOCK + LANES];
            }
            interleave(points, |i| DVec3::new(x[i] * w[i], y[i] * w[i], z[i] * w[i]));
        }
    }
}

/// Fills part of a row with the points of a block's columns.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn interleave(out: &mut [DVec3], point: impl Fn(usize) -> DVec3) {
    let fill = |out: &mut [DVec3]| out.iter_mut().enumerate().for_each(|(i, p)| *p = point(i));
    // A loop of known length has no loose ends.
    match out.first_chunk_mut::<BLOCK>() {
        Some(full) => fill(full),
        None => fill(out),
    }
}

/// The points and normals of a row.
struct NormalRow<'a, F: Fn(usize) -> DVec3, const ORDER: usize> {
    row: Row<'a, ORDER>,
    normals: &'a mut [DVec3],
    /// Finds the normal of a column whose tangents give none.
    repair: F,
}

impl<F: Fn(usize) -> DVec3, const ORDER: usize> WithSimd for NormalRow<'_, F, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { row: Row { surface, u, columns, net, points }, normals, repair } = self;
        net.contract::<2>(surface, u);
        let [mut value, mut by_u, mut by_v] = [[[1.0; BLOCK + LANES]; 4]; 3];
        let mut clearness = [0.0; BLOCK + LANES];
        let blocks = points.chunks_mut(BLOCK).zip(normals.chunks_mut(BLOCK)).zip(columns);
        for (number, ((points, normals), columns)) in blocks.enumerate() {
            let Columns { groups, values, slopes } = columns;
            combine(&net.values, groups, values, &mut value);
            combine(&net.slopes, groups, values, &mut by_u);
            combine(&net.values, groups, slopes, &mut by_v);
            normalize(&mut value, &mut by_u, &by_v, surface.flats(), &mut clearness);
            let [[x, y, z, _], [nx, ny, nz, _]] = [&value, &by_u];
            interleave(points, |i| DVec3::new(x[i], y[i], z[i]));
            interleave(normals, |i| DVec3::new(nx[i], ny[i], nz[i]));
            for (column, normal) in normals.iter_mut().enumerate() {
                // Not `<=`: NaN is not clear.
                let clear = clearness[column] > 0.0;
                if !clear {
                    *normal = repair(number * BLOCK + column);
                }
            }
        }
    }
}

/// From homogeneous values and derivatives to points, in place of the values, and unit normals, in
/// place of the derivatives by u; `clearness` becomes positive where a normal is more than
/// rounding. Columns that a block does not have become anything, and nobody asks for them.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn normalize(
    [x, y, z, w]: &mut [Numbers; 4],
    [ux, uy, uz, uw]: &mut [Numbers; 4],
    [vx, vy, vz, vw]: &[Numbers; 4],
    flats: Flats,
    clearness: &mut Numbers,
) {
    for i in 0..BLOCK {
        let scale = w[i].recip();
        let (px, py, pz) = (x[i] * scale, y[i] * scale, z[i] * scale);
        let tangent = |a: f64, b: f64, c: f64, w: f64| {
            ((a - w * px) * scale, (b - w * py) * scale, (c - w * pz) * scale)
        };
        let (a, b, c) = tangent(ux[i], uy[i], uz[i], uw[i]);
        let (d, e, f) = tangent(vx[i], vy[i], vz[i], vw[i]);
        let (nx, ny, nz) = (b * f - c * e, c * d - a * f, a * e - b * d);
        let square = nx * nx + ny * ny + nz * nz;
        clearness[i] = flats.clearness(a * a + b * b + c * c, d * d + e * e + f * f, square);
        let length = square.sqrt().recip();
        (x[i], y[i], z[i]) = (px, py, pz);
        (ux[i], uy[i], uz[i]) = (nx * length, ny * length, nz * length);
    }
}

/// Points with first and second derivatives of a row, one after the other, handed to `take` with
/// the number of their column.
pub(super) fn frames(
    surface: &NurbsSurface,
    u: f64,
    columns: &[BasisDerivatives<3>],
    net: &mut Isocurve,
    mut take: impl FnMut(usize, &Frame),
) {
    net.contract::<3>(surface, u);
    let order = surface.knots_v().degree() + 1;
    for (column, basis) in columns.iter().enumerate() {
        let sum = |points: &[Point], derivative: usize| {
            let points = points[basis.first..][..order].iter().zip(&basis.rows[derivative]);
            points.map(|(point, factor)| *factor * DVec4::from(*point)).sum::<DVec4>()
        };
        let frame = Frame::new([
            sum(&net.values, 0),
            sum(&net.slopes, 0),
            sum(&net.values, 1),
            sum(&net.bends, 0),
            sum(&net.slopes, 1),
            sum(&net.values, 2),
        ]);
        take(column, &frame);
    }
}
