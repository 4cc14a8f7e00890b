//! Points and normals of a surface, at scattered parameters and on grids.

use glam::{DVec2, DVec3, DVec4};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::basis::{Basis, BasisDerivatives, Row, padded};
use super::frame::Frame;
use super::grid::{self, Columns, Isocurve};
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};

/// Points between two calls of the observer: a few milliseconds, of which the threads lose a few
/// microseconds in meeting.
const POINTS_PER_REPORT: usize = 1 << 20;

/// Points that a thread takes at a time: tens of microseconds of work.
pub(super) const POINTS_PER_TASK: usize = 1 << 10;

/// Steps towards the middle of the domain, as shares of it, at which a normal or curvature is
/// looked for where neither the derivatives nor their first change define it: near first.
pub(super) const DETOURS: [f64; 3] = [1e-5, 1e-4, 1e-2];

/// What to do with parameters outside the domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// Refuse them.
    #[default]
    Refuse,
    /// Continue the outermost patches beyond their borders.
    Extrapolate,
}

/// Calls a generic function with the order (degree + 1) that a degree asks for.
macro_rules! with_order {
    ($degree:expr, $self:ident.$method:ident($($argument:expr),*)) => {
        match $degree {
            1 => $self.$method::<2>($($argument),*),
            2 => $self.$method::<3>($($argument),*),
            3 => $self.$method::<4>($($argument),*),
            4 => $self.$method::<5>($($argument),*),
            5 => $self.$method::<6>($($argument),*),
            6 => $self.$method::<7>($($argument),*),
            7 => $self.$method::<8>($($argument),*),
            8 => $self.$method::<9>($($argument),*),
            _ => $self.$method::<10>($($argument),*),
        }
    };
}

impl NurbsSurface {
    /// The point at (u, v); outside the domain the outermost patch is continued.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let (rows, columns) = (padded(self.knots_u(), u), padded(self.knots_v(), v));
        let value = self.contract((rows.first, columns.first), &rows.values, &columns.values);
        value.truncate() / value.w
    }

    /// The unit normal at (u, v), the direction of `∂/∂u × ∂/∂v`.
    ///
    /// Where the tangents are parallel or one of them vanishes (a pole, a collapsed edge), it is
    /// the limit for a point that comes from the middle of the domain; zero if there is none.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        let frame = self.frame(u, v);
        let normal = self.flats().normal(frame.u, frame.v);
        normal.unwrap_or_else(|| self.limit_normal(u, v, &frame))
    }

    /// The points at scattered parameters, written to `out`.
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, nurbs::{NurbsSurface, Outside}, progress::Silent};
    /// let net = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::ONE];
    /// let surface = NurbsSurface::clamped(net, (2, 2), 1)?;
    /// let (uv, mut out) = ([DVec2::new(0.5, 0.5)], [DVec3::ZERO]);
    /// surface.evaluate(&uv, &mut out, Outside::Refuse, &mut Silent)?;
    /// assert_eq!(out[0], DVec3::new(0.5, 0.5, 0.25));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a parameter lies outside the domain (and that is refused) or `out`
    /// has another length than `uv`; [`Error::Interrupted`] if the observer stops it.
    pub fn evaluate(
        &self,
        uv: &[DVec2],
        out: &mut [DVec3],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        self.check_scattered(uv, out.len(), outside)?;
        in_blocks(uv.len(), observer, |from, to| {
            let tasks = uv[from..to].par_chunks(POINTS_PER_TASK);
            let tasks = tasks.zip(out[from..to].par_chunks_mut(POINTS_PER_TASK));
            let arch = Arch::new();
            let (degree_u, degree_v) = (self.knots_u().degree(), self.knots_v().degree());
            tasks.for_each(|(uv, out)| {
                if degree_u == degree_v {
                    with_order!(degree_u, self.scattered(arch, uv, out));
                } else {
                    self.scattered_mixed(uv, out);
                }
            });
        })
    }

    /// The unit normals at scattered parameters, written to `out`; see [`NurbsSurface::normal`].
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::evaluate`].
    pub fn normals(
        &self,
        uv: &[DVec2],
        out: &mut [DVec3],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        self.check_scattered(uv, out.len(), outside)?;
        in_blocks(uv.len(), observer, |from, to| {
            let tasks = uv[from..to].par_iter().zip(&mut out[from..to]);
            let tasks = tasks.with_min_len(POINTS_PER_TASK);
            tasks.for_each(|(at, out)| *out = self.normal(at.x, at.y));
        })
    }

    /// The points on the grid of all pairs of `u` and `v`, and the unit normals if asked for,
    /// written row by row, `v` fastest.
    ///
    /// Each row contracts the net once, so that a point costs O(degree) instead of O(degree²).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a parameter lies outside the domain (and that is refused) or an
    /// output has not `u.len() * v.len()` elements; [`Error::Interrupted`] if the observer stops
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
        match normals {
            None => with_order!(degree, self.grid_points(u, v, points, observer)),
            Some(normals) => {
                with_order!(degree, self.grid_normals(u, v, (points, normals), observer))
            }
        }
    }

    fn grid_points<const ORDER: usize>(
        &self,
        u: &[f64],
        v: &[f64],
        points: &mut [DVec3],
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (arch, columns) = (Arch::new(), Columns::<ORDER>::new(self.knots_v(), v));
        in_rows(u.len(), v.len(), observer, |from, to| {
            let rows = points[from * v.len()..to * v.len()].par_chunks_mut(v.len());
            let rows = rows.zip(&u[from..to]).with_min_len(POINTS_PER_TASK / v.len());
            rows.for_each_init(Isocurve::default, |net, (row, &u)| {
                arch.dispatch(grid::PointRow {
                    surface: self,
                    u,
                    columns: &columns,
                    net,
                    out: row,
                });
            });
        })
    }

    fn grid_normals<const ORDER: usize>(
        &self,
        u: &[f64],
        v: &[f64],
        (points, normals): (&mut [DVec3], &mut [DVec3]),
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let (arch, columns) = (Arch::new(), Columns::<ORDER>::new(self.knots_v(), v));
        in_rows(u.len(), v.len(), observer, |from, to| {
            let rows = points[from * v.len()..to * v.len()].par_chunks_mut(v.len());
            let normals = normals[from * v.len()..to * v.len()].par_chunks_mut(v.len());
            let rows = rows.zip(normals).zip(&u[from..to]);
            let rows = rows.with_min_len(POINTS_PER_TASK / v.len());
            rows.for_each_init(Isocurve::default, |net, (row, &u)| {
                let repair = |column: usize| self.normal(u, v[column]);
                let (points, normals) = row;
                let (surface, columns) = (self, &columns);
                arch.dispatch(grid::NormalRow {
                    surface,
                    u,
                    columns,
                    net,
                    points,
                    normals,
                    repair,
                });
            });
        })
    }

    /// Points at scattered parameters where both directions have the same order.
    fn scattered<const ORDER: usize>(&self, arch: Arch, uv: &[DVec2], out: &mut [DVec3]) {
        arch.dispatch(Scattered::<ORDER> { surface: self, uv, out });
    }

    /// Points at scattered parameters, of any degrees.
    fn scattered_mixed(&self, uv: &[DVec2], out: &mut [DVec3]) {
        for (at, out) in uv.iter().zip(out) {
            let (rows, columns) = (padded(self.knots_u(), at.x), padded(self.knots_v(), at.y));
            let firsts = (rows.first, columns.first);
            let value = self.contract(firsts, &rows.values, &columns.values);
            *out = value.truncate() / value.w;
        }
    }

    fn limit_normal(&self, u: f64, v: f64, frame: &Frame) -> DVec3 {
        let (to_u, to_v) = self.to_middle(u, v);
        let detour = |step: &f64| {
            let frame = self.frame(u + step * to_u, v + step * to_v);
            self.flats().normal(frame.u, frame.v)
        };
        let limit = frame.limit_normal((to_u, to_v));
        limit.or_else(|| DETOURS.iter().find_map(detour)).unwrap_or(DVec3::ZERO)
    }

    /// The way from (u, v) to the middle of the domain.
    pub(super) fn to_middle(&self, u: f64, v: f64) -> (f64, f64) {
        let middle = |knots: &KnotVector| f64::midpoint(knots.domain().0, knots.domain().1);
        (middle(self.knots_u()) - u, middle(self.knots_v()) - v)
    }

    /// The point at (u, v) with its first and second derivatives.
    pub(super) fn frame(&self, u: f64, v: f64) -> Frame {
        let rows = BasisDerivatives::<3>::at(self.knots_u(), u);
        let columns = BasisDerivatives::<3>::at(self.knots_v(), v);
        let firsts = (rows.first, columns.first);
        let orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        Frame::new(orders.map(|(i, j)| self.contract(firsts, &rows.rows[i], &columns.rows[j])))
    }

    /// The sum of the control points from these first ones, weighted by functions in u and v.
    pub(super) fn contract(&self, firsts: (usize, usize), rows: &Row, columns: &Row) -> DVec4 {
        let (degree_u, degree_v) = (self.knots_u().degree(), self.knots_v().degree());
        let along = |k: usize| {
            let start = (firsts.0 + k) * self.shape().1 + firsts.1;
            let net = self.homogeneous()[start..=start + degree_v].iter();
            let sum: DVec4 = net.zip(columns).map(|(point, b)| *b * *point).sum();
            rows[k] * sum
        };
        (0..=degree_u).map(along).sum()
    }

    pub(super) fn check_scattered(&self, uv: &[DVec2], out: usize, outside: Outside) -> Result<()> {
        check_length(out, uv.len())?;
        check_inside("u", self.knots_u(), outside, uv.par_iter().map(|at| at.x))?;
        check_inside("v", self.knots_v(), outside, uv.par_iter().map(|at| at.y))
    }

    pub(super) fn check_grid(&self, u: &[f64], v: &[f64], outside: Outside) -> Result<()> {
        check_inside("u", self.knots_u(), outside, u.par_iter().copied())?;
        check_inside("v", self.knots_v(), outside, v.par_iter().copied())
    }
}

/// A run of scattered parameters, to be evaluated with the widest instructions there are.
struct Scattered<'a, const ORDER: usize> {
    surface: &'a NurbsSurface,
    uv: &'a [DVec2],
    out: &'a mut [DVec3],
}

impl<const ORDER: usize> WithSimd for Scattered<'_, ORDER> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let net: &[[f64; 4]] = bytemuck::cast_slice(self.surface.homogeneous());
        let (knots_u, knots_v) = (self.surface.knots_u(), self.surface.knots_v());
        let cols = self.surface.shape().1;
        for (at, out) in self.uv.iter().zip(self.out) {
            let rows = Basis::<ORDER>::at(knots_u, at.x);
            let columns = Basis::<ORDER>::at(knots_v, at.y);
            let mut sum = [0.0; 4];
            for k in 0..ORDER {
                let points: &[[f64; 4]; ORDER] =
                    grid::window(net, (rows.first + k) * cols + columns.first);
                for (point, value) in points.iter().zip(&columns.values) {
                    let factor = rows.values[k] * value;
                    for c in 0..4 {
                        sum[c] += factor * point[c];
                    }
                }
            }
            let scale = sum[3].recip();
            *out = DVec3::new(sum[0] * scale, sum[1] * scale, sum[2] * scale);
        }
    }
}

/// Does `total` points in blocks from..to, with a report after each.
pub(super) fn in_blocks(
    total: usize,
    observer: &mut dyn Observer,
    mut work: impl FnMut(usize, usize),
) -> Result<()> {
    in_rows(total, 1, observer, &mut work)
}

/// Does `rows` rows of `width` points in blocks from..to, with a report after each.
pub(super) fn in_rows(
    rows: usize,
    width: usize,
    observer: &mut dyn Observer,
    mut work: impl FnMut(usize, usize),
) -> Result<()> {
    let total = rows * width;
    let block = POINTS_PER_REPORT.div_ceil(width.max(1));
    for from in (0..rows).step_by(block) {
        report(observer, from * width, total)?;
        work(from, rows.min(from + block));
    }
    report(observer, total, total)
}

fn report(observer: &mut dyn Observer, done: usize, total: usize) -> Result<()> {
    let (step, total) = (done as u64, total as u64);
    let stage = Stage::Tessellation;
    progress::report(observer, &Progress::of_stage(stage, step, total, 0))
}

pub(super) fn check_length(out: usize, needed: usize) -> Result<()> {
    if out == needed {
        return Ok(());
    }
    Err(Error::parameter("out", format!("of length {needed}, one for each parameter"), out))
}

pub(super) fn check_inside(
    name: &'static str,
    knots: &KnotVector,
    outside: Outside,
    parameters: impl IndexedParallelIterator<Item = f64>,
) -> Result<()> {
    let (start, end) = match outside {
        Outside::Refuse => knots.domain(),
        // Infinities would come back as NaN.
        Outside::Extrapolate => (f64::MIN, f64::MAX),
    };
    let parameters = parameters.with_min_len(POINTS_PER_TASK).enumerate();
    // Not `<` and `>`: NaN lies nowhere.
    let found = parameters.find_first(|(_, t)| !(start..=end).contains(t));
    found.map_or(Ok(()), |(index, t)| {
        let must = match outside {
            Outside::Refuse => format!("inside the domain [{start}, {end}]"),
            Outside::Extrapolate => "finite".to_string(),
        };
        Err(Error::parameter(name, must, format!("{t} at index {index}")))
    })
}
#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use super::*;
    use crate::progress::Silent;

    /// An eighth of the unit sphere, exact as a rational biquadratic patch; the edge v = 1
    /// collapses into the pole.
    fn octant() -> NurbsSurface {
        let s = FRAC_1_SQRT_2;
        let (arc_xy, weights) = ([DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y], [1.0, s, 1.0]);
        let rise = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let net = arc_xy.iter().flat_map(|p| rise.map(|(r, z)| r * *p + z * DVec3::Z)).collect();
        let weights = weights.iter().flat_map(|a| weights.map(|b| a * b)).collect();
        let knots = KnotVector::clamped_uniform(2, 3).unwrap();
        NurbsSurface::new(net, Some(weights), knots.clone(), knots).unwrap()
    }

    #[test]
    fn a_sphere_is_a_sphere_and_its_normal_its_radius() {
        let surface = octant();
        let steps: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
        let mut points = vec![DVec3::ZERO; 41 * 41];
        let mut normals = points.clone();
        let normals_out = Some(&mut normals[..]);
        surface
            .evaluate_grid(&steps, &steps, &mut points, normals_out, Outside::Refuse, &mut Silent)
            .unwrap();
        for (point, normal) in points.iter().zip(&normals) {
            assert!((point.length() - 1.0).abs() < 1e-15);
            // The pole included: there the normal is a limit.
            assert!(normal.distance(*point) < 1e-14, "{point} {normal}");
        }
    }

    #[test]
    fn grid_and_scattered_agree() {
        let surface = octant();
        let (u, v) = ([0.0, 0.3, 1.0], [0.0, 0.5, 0.75, 1.0]);
        let uv: Vec<DVec2> = u.iter().flat_map(|&u| v.map(|v| DVec2::new(u, v))).collect();
        let (mut grid, mut scattered) = (vec![DVec3::ZERO; 12], vec![DVec3::ZERO; 12]);
        surface.evaluate_grid(&u, &v, &mut grid, None, Outside::Refuse, &mut Silent).unwrap();
        surface.evaluate(&uv, &mut scattered, Outside::Refuse, &mut Silent).unwrap();
        for (a, b) in grid.iter().zip(&scattered) {
            assert!(a.distance(*b) < 1e-15);
        }
    }

    #[test]
    fn outside_and_mismatched_arguments_are_refused() {
        let surface = octant();
        let mut out = [DVec3::ZERO; 2];
        let mut evaluate = |uv: &[DVec2]| {
            let done = surface.evaluate(uv, &mut out, Outside::Refuse, &mut Silent);
            done.map_err(|error| error.to_string())
        };
        let message = evaluate(&[DVec2::ZERO, DVec2::new(0.5, 1.5)]).unwrap_err();
        assert_eq!(message, "v must be inside the domain [0, 1], got 1.5 at index 1");
        assert!(evaluate(&[DVec2::ZERO, DVec2::NAN]).unwrap_err().contains("NaN at index 1"));
        assert!(evaluate(&[DVec2::ZERO; 3]).unwrap_err().contains("of length 3"));
    }

    #[test]
    fn a_net_in_one_point_has_no_normal_but_no_nan_either() {
        let surface = NurbsSurface::clamped(vec![DVec3::ONE; 16], (4, 4), 3).unwrap();
        assert_eq!(surface.normal(0.3, 0.3), DVec3::ZERO);
    }
}
