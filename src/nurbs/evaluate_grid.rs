//! Evaluation of points and normals on a grid of parameters.
//!
//! For each row of equal u, the net is contracted once to the control points of the isocurve. A
//! point then costs O(degree) instead of O(degree²). No loop uses fused multiply-add, so results
//! are the same on every machine.

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::basis::with_order;
use super::basis_block::{BLOCK, BasisBlock, BlockValues, ROWS};
use super::isocurve::Isocurve;
use super::parameter_checks::{Outside, check_length};
use super::partials::TangentThresholds;
use super::surface::NurbsSurface;
use super::work_blocks::{POINTS_PER_TASK, for_row_blocks};
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

impl NurbsSurface {
    /// Computes the points, and optionally the unit normals, on the grid of all pairs of `u` and
    /// `v`. The results are written row by row, `v` fastest.
    ///
    /// The net is contracted once for each row, so a point costs O(degree) instead of O(degree²).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsSurface, Outside}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, DVec3::Y)?;
    /// let (u, v) = ([0.0, 1.0], [0.0, 0.5, 1.0]);
    /// let (mut points, mut normals) = ([DVec3::ZERO; 6], [DVec3::ZERO; 6]);
    /// let out = Some(&mut normals[..]);
    /// plane.evaluate_grid(&u, &v, &mut points, out, Outside::Refuse, &mut Silent)?;
    /// assert_eq!((points[4], normals[4]), (DVec3::new(1.0, 0.5, 0.0), DVec3::Z));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`crate::Error::Parameter`] if a parameter is outside the domain and `outside` refuses
    ///   that, or an output does not have `u.len() * v.len()` elements.
    /// - [`crate::Error::Interrupted`] if the observer stops it.
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
        (points, mut normals): (&mut [DVec3], Option<&mut [DVec3]>),
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (arch, columns) = (Arch::new(), BasisBlock::<ORDER>::blocks(self.knots_v(), v));
        let (surface, columns, width) = (self, &columns, v.len());
        for_row_blocks(u.len(), width, observer, |from, to| {
            // With few rows, tiles are smaller, so that all threads have work.
            let rows = ROWS.min((to - from).div_ceil(worker_pool::num_threads()));
            let batch_size = POINTS_PER_TASK / (rows * width);
            let tiles = points[from * width..to * width]
                .chunks_mut(rows * width)
                .zip(u[from..to].chunks(rows));
            let Some(normals) = normals.as_deref_mut() else {
                return worker_pool::for_each_task(tiles, batch_size, |isocurves, (points, u)| {
                    arch.dispatch(PointTile(Tile {
                        surface,
                        u,
                        width,
                        columns,
                        isocurves,
                        points,
                    }));
                });
            };
            let normals = normals[from * width..to * width].chunks_mut(rows * width);
            worker_pool::for_each_task(
                tiles.zip(normals),
                batch_size,
                |isocurves, ((points, u), normals)| {
                    let degenerate_normal =
                        |row: usize, column: usize| self.normal(u[row], v[column]);
                    let tile = Tile { surface, u, width, columns, isocurves, points };
                    arch.dispatch(NormalTile { tile, normals, degenerate_normal });
                },
            );
        })
    }
}

/// Up to `ROWS` neighboring rows of a grid.
struct Tile<'a, const ORDER: usize> {
    surface: &'a NurbsSurface,
    /// The parameters of the rows.
    u: &'a [f64],
    /// Points in a row.
    width: usize,
    columns: &'a [BasisBlock<ORDER>],
    /// Buffers for the control points of the isocurves.
    isocurves: &'a mut [Isocurve; ROWS],
    points: &'a mut [DVec3],
}

/// Computes the points of a tile.
struct PointTile<'a, const ORDER: usize>(Tile<'a, ORDER>);

impl<const ORDER: usize> WithSimd for PointTile<'_, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Tile { surface, u, width, columns, isocurves, points } = self.0;
        for (net, &u) in isocurves.iter_mut().zip(u) {
            net.contract::<1>(surface, u);
        }
        let values = isocurves[..u.len()].iter().map(|net| &net.values[..]);
        let mut sums = [[BlockValues::ONES; 4]; ROWS];
        for (block, columns) in columns.iter().enumerate() {
            columns.values(simd, &values, &mut sums);
            for (row, sums) in points.chunks_mut(width).zip(&sums) {
                let [BlockValues(x), BlockValues(y), BlockValues(z), BlockValues(w)] = sums;
                if surface.weights().is_some() {
                    interleave(row, block, |i| {
                        let scale = w[i].recip();
                        DVec3::new(x[i] * scale, y[i] * scale, z[i] * scale)
                    });
                } else {
                    // The weights sum to 1 up to rounding.
                    interleave(row, block, |i| DVec3::new(x[i], y[i], z[i]));
                }
            }
        }
    }
}

/// Writes one block of a row: the points of its columns.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn interleave(row: &mut [DVec3], block: usize, point: impl Fn(usize) -> DVec3) {
    let out = &mut row[block * BLOCK..];
    // Loops instead of iterator closures, which would be compiled without SIMD. A loop of known
    // length has no remainder.
    if let Some(full) = out.first_chunk_mut::<BLOCK>() {
        for (i, out) in full.iter_mut().enumerate() {
            *out = point(i);
        }
    } else {
        for (i, out) in out.iter_mut().enumerate() {
            *out = point(i);
        }
    }
}

/// Computes the points and normals of a tile.
struct NormalTile<'a, F: Fn(usize, usize) -> DVec3, const ORDER: usize> {
    tile: Tile<'a, ORDER>,
    normals: &'a mut [DVec3],
    /// Returns the normal at a row and column where the tangents do not define it.
    degenerate_normal: F,
}

impl<F: Fn(usize, usize) -> DVec3, const ORDER: usize> WithSimd for NormalTile<'_, F, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            tile: Tile { surface, u, width, columns, isocurves, points },
            normals,
            degenerate_normal,
        } = self;
        for (net, &u) in isocurves.iter_mut().zip(u) {
            net.contract::<2>(surface, u);
        }
        let isocurves = &isocurves[..u.len()];
        let values = isocurves.iter().map(|net| &net.values[..]);
        let slopes = isocurves.iter().map(|net| &net.slopes[..]);
        let [mut value, mut by_u, mut by_v] = [[[BlockValues::ONES; 4]; ROWS]; 3];
        let mut normal_margin = BlockValues::ONES;
        for (block, columns) in columns.iter().enumerate() {
            columns.values(simd, &values, &mut value);
            columns.values(simd, &slopes, &mut by_u);
            columns.slopes(simd, &values, &mut by_v);
            let rows = points.chunks_mut(width).zip(normals.chunks_mut(width)).enumerate();
            for (row, (points, normals)) in rows {
                let (value, by_u) = (&mut value[row], &mut by_u[row]);
                normalize(
                    value,
                    by_u,
                    &by_v[row],
                    surface.tangent_thresholds(),
                    &mut normal_margin,
                );
                let [BlockValues(x), BlockValues(y), BlockValues(z), _] = value;
                interleave(points, block, |i| DVec3::new(x[i], y[i], z[i]));
                let [BlockValues(x), BlockValues(y), BlockValues(z), _] = by_u;
                interleave(normals, block, |i| DVec3::new(x[i], y[i], z[i]));
                // Not `<=`: NaN counts as degenerate.
                let clear = |normal_margin: f64| normal_margin > 0.0;
                let first = block * BLOCK;
                let columns = BLOCK.min(width - first);
                // First a test without branches: most blocks have no degenerate normals.
                if normal_margin.0[..columns].iter().fold(true, |all, &one| all & clear(one)) {
                    continue;
                }
                for column in (0..columns).filter(|&column| !clear(normal_margin.0[column])) {
                    normals[first + column] = degenerate_normal(row, first + column);
                }
            }
        }
    }
}

/// Turns homogeneous values into points, and derivatives by u into unit normals, in place.
///
/// `normal_margin` becomes positive where the tangents define the normal. Entries of missing
/// columns are meaningless and never read.
#[expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]
#[inline(always)]
fn normalize(
    [BlockValues(x), BlockValues(y), BlockValues(z), BlockValues(w)]: &mut [BlockValues; 4],
    [BlockValues(ux), BlockValues(uy), BlockValues(uz), BlockValues(uw)]: &mut [BlockValues; 4],
    [BlockValues(vx), BlockValues(vy), BlockValues(vz), BlockValues(vw)]: &[BlockValues; 4],
    tangent_thresholds: TangentThresholds,
    BlockValues(normal_margin): &mut BlockValues,
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
        normal_margin[i] =
            tangent_thresholds.normal_margin(a * a + b * b + c * c, d * d + e * e + f * f, square);
        let length = square.sqrt().recip();
        (x[i], y[i], z[i]) = (px, py, pz);
        (ux[i], uy[i], uz[i]) = (nx * length, ny * length, nz * length);
    }
}
