//! The inner loops of evaluation on a grid: one row at a time.
//!
//! A row of equal u contracts the net once to the control points of its isocurve; a point then
//! costs O(degree) instead of O(degree²). Columns that lie in one span share their control points;
//! over them, and over blocks of points, run plain loops that the compiler turns into the widest
//! instructions that [`pulp`] finds at run time. No loop fuses multiplication and addition: results
//! are the same on every machine.

use glam::{DVec3, DVec4};
use pulp::{Simd, WithSimd};

use super::basis::{Basis, BasisDerivatives};
use super::frame::{Flats, Frame};
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;

/// A homogeneous point as an array, in a form that the compiler vectorizes.
type Lanes = [f64; 4];

/// Points that are computed side by side: few enough for all their numbers to stay in the first
/// level of the cache, enough to make the ends of loops rare.
const BLOCK: usize = 128;

/// Numbers of one kind for the points of a block.
type Numbers = [f64; BLOCK];

/// The control points of an isocurve, and their derivatives by the other parameter.
#[derive(Default)]
pub(super) struct Isocurve {
    values: Vec<Lanes>,
    slopes: Vec<Lanes>,
    bends: Vec<Lanes>,
}

impl Isocurve {
    /// That of `u`, with `ROWS - 1` derivatives.
    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn contract<const ROWS: usize>(&mut self, surface: &NurbsSurface, u: f64) {
        let basis = BasisDerivatives::<ROWS>::at(surface.knots_u(), u);
        let cols = surface.shape().1;
        let order = surface.knots_u().degree() + 1;
        let net: &[Lanes] = bytemuck::cast_slice(surface.homogeneous());
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

/// The basis functions at the columns of a grid.
pub(super) struct Columns<const ORDER: usize> {
    /// For each block of columns its parts that lie in one span: (first control point, columns).
    blocks: Vec<Vec<(usize, std::ops::Range<usize>)>>,
    /// For each of the functions its values at all columns.
    values: [Vec<f64>; ORDER],
    /// And its derivatives.
    slopes: [Vec<f64>; ORDER],
}

impl<const ORDER: usize> Columns<ORDER> {
    pub(super) fn new(knots: &KnotVector, v: &[f64]) -> Self {
        let bases: Vec<Basis<ORDER>> = v.iter().map(|&v| Basis::at(knots, v)).collect();
        let block = |(number, bases): (usize, &[Basis<ORDER>])| {
            let mut end = number * BLOCK;
            let part = |part: &[Basis<ORDER>]| {
                let start = end;
                end += part.len();
                (part[0].first, start..end)
            };
            bases.chunk_by(|a, b| a.first == b.first).map(part).collect()
        };
        let blocks = bases.chunks(BLOCK).enumerate().map(block).collect();
        let values = std::array::from_fn(|k| bases.iter().map(|basis| basis.values[k]).collect());
        let slopes = std::array::from_fn(|k| bases.iter().map(|basis| basis.slopes[k]).collect());
        Self { blocks, values, slopes }
    }
}

/// Homogeneous points of a block's columns: sums of control points, weighted by basis functions.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn combine<const ORDER: usize>(
    points: &[Lanes],
    (first, columns): &(usize, std::ops::Range<usize>),
    functions: &[Vec<f64>; ORDER],
    out: &mut [Numbers; 4],
) {
    let net: &[Lanes; ORDER] = window(points, *first);
    let functions: [&[f64]; ORDER] = std::array::from_fn(|k| &functions[k][columns.clone()]);
    let (from, count) = (columns.start % BLOCK, columns.len());
    for (c, out) in out.iter_mut().enumerate() {
        let factors: [f64; ORDER] = std::array::from_fn(|k| net[k][c]);
        for (i, out) in out[from..from + count].iter_mut().enumerate() {
            let mut sum = 0.0;
            for k in 0..ORDER {
                sum += factors[k] * functions[k][i];
            }
            *out = sum;
        }
    }
}

/// The `ORDER` control points from `first`.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
pub(super) fn window<const ORDER: usize>(points: &[Lanes], first: usize) -> &[Lanes; ORDER] {
    points[first..].first_chunk().expect("basis functions belong to control points")
}

/// The points of a row of a grid.
pub(super) struct PointRow<'a, const ORDER: usize> {
    pub surface: &'a NurbsSurface,
    pub u: f64,
    pub columns: &'a Columns<ORDER>,
    /// Room for the control points of the row.
    pub net: &'a mut Isocurve,
    pub out: &'a mut [DVec3],
}

impl<const ORDER: usize> WithSimd for PointRow<'_, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { surface, u, columns, net, out } = self;
        net.contract::<1>(surface, u);
        let rational = surface.weights().is_some();
        let mut block = [[0.0; BLOCK]; 4];
        for (out, parts) in out.chunks_mut(BLOCK).zip(&columns.blocks) {
            for part in parts {
                combine(&net.values, part, &columns.values, &mut block);
            }
            let [x, y, z, w] = &mut block;
            if rational {
                for i in 0..BLOCK {
                    let scale = w[i].recip();
                    x[i] *= scale;
                    y[i] *= scale;
                    z[i] *= scale;
                }
            }
            interleave(out, [x, y, z]);
        }
    }
}

/// Writes coordinates as points.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn interleave(out: &mut [DVec3], [x, y, z]: [&Numbers; 3]) {
    for (out, ((x, y), z)) in out.iter_mut().zip(x.iter().zip(y).zip(z)) {
        *out = DVec3::new(*x, *y, *z);
    }
}

/// The points and normals of a row of a grid.
pub(super) struct NormalRow<'a, F: Fn(usize) -> DVec3, const ORDER: usize> {
    pub surface: &'a NurbsSurface,
    pub u: f64,
    pub columns: &'a Columns<ORDER>,
    /// Room for the control points of the row.
    pub net: &'a mut Isocurve,
    pub points: &'a mut [DVec3],
    pub normals: &'a mut [DVec3],
    /// Finds the normal of a column whose tangents give none.
    pub repair: F,
}

impl<F: Fn(usize) -> DVec3, const ORDER: usize> WithSimd for NormalRow<'_, F, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { surface, u, columns, net, points, normals, repair } = self;
        net.contract::<2>(surface, u);
        let flats = surface.flats();
        let [mut value, mut by_u, mut by_v] = [[[0.0; BLOCK]; 4]; 3];
        let outputs = points.chunks_mut(BLOCK).zip(normals.chunks_mut(BLOCK));
        for (number, ((points, normals), parts)) in outputs.zip(&columns.blocks).enumerate() {
            for part in parts {
                combine(&net.values, part, &columns.values, &mut value);
                combine(&net.slopes, part, &columns.values, &mut by_u);
                combine(&net.values, part, &columns.slopes, &mut by_v);
            }
            let mut clearness = [0.0; BLOCK];
            normalize(&mut value, &mut by_u, &by_v, flats, &mut clearness);
            interleave(points, [&value[0], &value[1], &value[2]]);
            interleave(normals, [&by_u[0], &by_u[1], &by_u[2]]);
            for (column, normal) in normals.iter_mut().enumerate() {
                // Not `<=`: NaN is not clear.
                let clear = clearness[column] > 1.0;
                if !clear {
                    *normal = repair(number * BLOCK + column);
                }
            }
        }
    }
}

/// From homogeneous values and derivatives to points, in place of the values, and unit normals, in
/// place of the derivatives by u; `clearness` becomes larger than 1 where a normal is more than
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
        let sum = |points: &[Lanes], derivative: usize| {
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
