//! Evaluation on a grid, a few rows at a time.
//!
//! A row of equal u contracts the net once to the control points of its isocurve; a point then
//! costs O(degree) instead of O(degree²). No loop fuses multiplication and addition: results are the
//! same on every machine.

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::basis::with_order;
use super::basis_block::{BLOCK, Columns, Numbers, ROWS};
use super::isocurve::Isocurve;
use super::parameter_checks::{Outside, check_length};
use super::partials::Flats;
use super::surface::NurbsSurface;
use super::work_blocks::{POINTS_PER_TASK, in_rows, share};
use crate::error::Result;
use crate::progress::Observer;

impl NurbsSurface {
    /// The points on the grid of all pairs of `u` and `v`, and the unit normals if asked for,
    /// written row by row, `v` fastest.
    ///
    /// Each row contracts the net once, so that a point costs O(degree) instead of O(degree²).
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
        (points, mut normals): (&mut [DVec3], Option<&mut [DVec3]>),
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (arch, columns) = (Arch::new(), Columns::<ORDER>::blocks(self.knots_v(), v));
        let (surface, columns, width) = (self, &columns, v.len());
        in_rows(u.len(), width, observer, |from, to| {
            // Few but long rows go to all threads, too.
            let rows = ROWS.min((to - from).div_ceil(rayon::current_num_threads()));
            let at_once = POINTS_PER_TASK / (rows * width);
            let tiles = points[from * width..to * width]
                .chunks_mut(rows * width)
                .zip(u[from..to].chunks(rows));
            let Some(normals) = normals.as_deref_mut() else {
                return share(tiles, at_once, |nets, (points, u)| {
                    arch.dispatch(PointTile(Tile { surface, u, width, columns, nets, points }));
                });
            };
            let normals = normals[from * width..to * width].chunks_mut(rows * width);
            share(tiles.zip(normals), at_once, |nets, ((points, u), normals)| {
                let repair = |row: usize, column: usize| self.normal(u[row], v[column]);
                let tile = Tile { surface, u, width, columns, nets, points };
                arch.dispatch(NormalTile { tile, normals, repair });
            });
        })
    }
}

/// Up to `ROWS` neighbouring rows of a grid.
struct Tile<'a, const ORDER: usize> {
    surface: &'a NurbsSurface,
    /// The parameters of the rows.
    u: &'a [f64],
    /// Points in a row.
    width: usize,
    columns: &'a [Columns<ORDER>],
    /// Room for the control points of the rows.
    nets: &'a mut [Isocurve; ROWS],
    points: &'a mut [DVec3],
}

/// The points of a tile.
struct PointTile<'a, const ORDER: usize>(Tile<'a, ORDER>);

impl<const ORDER: usize> WithSimd for PointTile<'_, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Tile { surface, u, width, columns, nets, points } = self.0;
        for (net, &u) in nets.iter_mut().zip(u) {
            net.contract::<1>(surface, u);
        }
        let values = nets[..u.len()].iter().map(|net| &net.values[..]);
        let mut sums = [[Numbers::ONES; 4]; ROWS];
        for (block, columns) in columns.iter().enumerate() {
            columns.values(simd, &values, &mut sums);
            for (row, sums) in points.chunks_mut(width).zip(&sums) {
                let [Numbers(x), Numbers(y), Numbers(z), Numbers(w)] = sums;
                if surface.weights().is_some() {
                    interleave(row, block, |i| {
                        let scale = w[i].recip();
                        DVec3::new(x[i] * scale, y[i] * scale, z[i] * scale)
                    });
                } else {
                    // The sums of weights are 1 up to rounding.
                    interleave(row, block, |i| DVec3::new(x[i], y[i], z[i]));
                }
            }
        }
    }
}

/// Fills a block of a row with the points of its columns.
#[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
#[inline(always)]
fn interleave(row: &mut [DVec3], block: usize, point: impl Fn(usize) -> DVec3) {
    let out = &mut row[block * BLOCK..];
    // Loops, as closures would be compiled for the oldest processor; one of known length has no
    // loose ends.
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

/// The points and normals of a tile.
struct NormalTile<'a, F: Fn(usize, usize) -> DVec3, const ORDER: usize> {
    tile: Tile<'a, ORDER>,
    normals: &'a mut [DVec3],
    /// Finds the normal in a row and column whose tangents give none.
    repair: F,
}

impl<F: Fn(usize, usize) -> DVec3, const ORDER: usize> WithSimd for NormalTile<'_, F, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { tile: Tile { surface, u, width, columns, nets, points }, normals, repair } =
            self;
        for (net, &u) in nets.iter_mut().zip(u) {
            net.contract::<2>(surface, u);
        }
        let nets = &nets[..u.len()];
        let values = nets.iter().map(|net| &net.values[..]);
        let slopes = nets.iter().map(|net| &net.slopes[..]);
        let [mut value, mut by_u, mut by_v] = [[[Numbers::ONES; 4]; ROWS]; 3];
        let mut clearness = Numbers::ONES;
        for (block, columns) in columns.iter().enumerate() {
            columns.values(simd, &values, &mut value);
            columns.values(simd, &slopes, &mut by_u);
            columns.slopes(simd, &values, &mut by_v);
            let rows = points.chunks_mut(width).zip(normals.chunks_mut(width)).enumerate();
            for (row, (points, normals)) in rows {
                let (value, by_u) = (&mut value[row], &mut by_u[row]);
                normalize(value, by_u, &by_v[row], surface.flats(), &mut clearness);
                let [Numbers(x), Numbers(y), Numbers(z), _] = value;
                interleave(points, block, |i| DVec3::new(x[i], y[i], z[i]));
                let [Numbers(x), Numbers(y), Numbers(z), _] = by_u;
                interleave(normals, block, |i| DVec3::new(x[i], y[i], z[i]));
                // Not `<=`: NaN is not clear.
                let clear = |clearness: f64| clearness > 0.0;
                let first = block * BLOCK;
                let columns = BLOCK.min(width - first);
                // Without branches first: nearly all normals are clear.
                if clearness.0[..columns].iter().fold(true, |all, &one| all & clear(one)) {
                    continue;
                }
                for column in (0..columns).filter(|&column| !clear(clearness.0[column])) {
                    normals[first + column] = repair(row, first + column);
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
    [Numbers(x), Numbers(y), Numbers(z), Numbers(w)]: &mut [Numbers; 4],
    [Numbers(ux), Numbers(uy), Numbers(uz), Numbers(uw)]: &mut [Numbers; 4],
    [Numbers(vx), Numbers(vy), Numbers(vz), Numbers(vw)]: &[Numbers; 4],
    flats: Flats,
    Numbers(clearness): &mut Numbers,
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
