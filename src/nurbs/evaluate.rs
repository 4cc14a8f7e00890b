//! Points and normals of a surface, at scattered parameters and on grids.

use glam::{DVec2, DVec3, DVec4};
use rayon::prelude::*;

use super::basis::Basis;
use super::knot_vector::KnotVector;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::{self, Observer, Progress, Stage};

/// Points between two calls of the observer: a few milliseconds.
const POINTS_PER_REPORT: usize = 1 << 16;

/// Tangents whose cross product is under this share of the product of their lengths give no
/// direction for a normal: what is left is rounding.
const DEGENERATE: f64 = 1e-12;

/// Steps towards the middle of the domain, as shares of it, at which a normal is looked for where
/// the tangents give none: near first.
const NORMAL_DETOURS: [f64; 3] = [1e-6, 1e-4, 1e-2];

/// A point of the surface with its tangents, up to a common positive factor.
struct Tangents {
    point: DVec3,
    by_u: DVec3,
    by_v: DVec3,
}

impl Tangents {
    /// From homogeneous values and derivatives (The NURBS Book, equation 4.20).
    fn new(value: DVec4, by_u: DVec4, by_v: DVec4) -> Self {
        let point = value.truncate() / value.w;
        let tangent = |derivative: DVec4| derivative.truncate() - derivative.w * point;
        Self { point, by_u: tangent(by_u), by_v: tangent(by_v) }
    }

    fn normal(&self) -> Option<DVec3> {
        let cross = self.by_u.cross(self.by_v);
        let length = cross.length();
        (length > DEGENERATE * self.by_u.length() * self.by_v.length()).then(|| cross / length)
    }
}

impl NurbsSurface {
    /// The point at (u, v); outside the domain the outermost patch is continued.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        self.tangents(u, v).point
    }

    /// The unit normal at (u, v), the direction of `∂/∂u × ∂/∂v`.
    ///
    /// Where the tangents are parallel or vanish (a pole, coincident control points) it is the
    /// normal a small step towards the middle of the domain, and zero if there is none either.
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        self.tangents(u, v).normal().unwrap_or_else(|| self.nearby_normal(u, v))
    }

    /// The points at scattered parameters, written to `out`.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a parameter lies outside the domain or `out` has another length
    /// than `uv`; [`Error::Interrupted`] if the observer stops it.
    pub fn evaluate(
        &self,
        uv: &[DVec2],
        out: &mut [DVec3],
        observer: &mut dyn Observer,
    ) -> Result<()> {
        self.map_scattered(uv, out, observer, |at| self.point(at.x, at.y))
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
        observer: &mut dyn Observer,
    ) -> Result<()> {
        self.map_scattered(uv, out, observer, |at| self.normal(at.x, at.y))
    }

    /// The points on the grid of all pairs of `u` and `v`, and the unit normals if asked for,
    /// written row by row, `v` fastest.
    ///
    /// Each row contracts the net once, so that a point costs O(degree) instead of O(degree²).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a parameter lies outside the domain or an output has not
    /// `u.len() * v.len()` elements; [`Error::Interrupted`] if the observer stops it.
    pub fn evaluate_grid(
        &self,
        u: &[f64],
        v: &[f64],
        points: &mut [DVec3],
        mut normals: Option<&mut [DVec3]>,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        let total = u.len() * v.len();
        check_length(points.len(), total)?;
        check_length(normals.as_ref().map_or(total, |n| n.len()), total)?;
        check_inside("u", self.knots_u(), u.par_iter().copied())?;
        check_inside("v", self.knots_v(), v.par_iter().copied())?;
        if total == 0 {
            return Ok(());
        }
        let columns: Vec<Basis> = v.iter().map(|&v| Basis::at(self.knots_v(), v)).collect();
        let rows = POINTS_PER_REPORT.div_ceil(v.len());
        for (block, points) in points.chunks_mut(rows * v.len()).enumerate() {
            let from = block * rows;
            report(observer, from * v.len(), total)?;
            let lines = points.par_chunks_mut(v.len()).zip(&u[from..]);
            match &mut normals {
                None => lines.for_each_init(Vec::new, |net, (points, &u)| {
                    self.contract(u, net);
                    for (point, basis) in points.iter_mut().zip(&columns) {
                        let value = self.combine(basis, |j| net[j].0, &basis.values);
                        *point = value.truncate() / value.w;
                    }
                }),
                Some(normals) => {
                    let normals = normals[from * v.len()..].par_chunks_mut(v.len());
                    lines.zip(normals).for_each_init(Vec::new, |net, ((points, &u), normals)| {
                        self.contract(u, net);
                        let outputs = points.iter_mut().zip(normals).zip(columns.iter().zip(v));
                        for ((point, normal), (basis, &v)) in outputs {
                            let at = Tangents::new(
                                self.combine(basis, |j| net[j].0, &basis.values),
                                self.combine(basis, |j| net[j].1, &basis.values),
                                self.combine(basis, |j| net[j].0, &basis.slopes),
                            );
                            *point = at.point;
                            *normal = at.normal().unwrap_or_else(|| self.nearby_normal(u, v));
                        }
                    });
                }
            }
        }
        report(observer, total, total)
    }

    fn map_scattered(
        &self,
        uv: &[DVec2],
        out: &mut [DVec3],
        observer: &mut dyn Observer,
        f: impl Fn(DVec2) -> DVec3 + Sync,
    ) -> Result<()> {
        check_length(out.len(), uv.len())?;
        check_inside("u", self.knots_u(), uv.par_iter().map(|at| at.x))?;
        check_inside("v", self.knots_v(), uv.par_iter().map(|at| at.y))?;
        let blocks = uv.chunks(POINTS_PER_REPORT).zip(out.chunks_mut(POINTS_PER_REPORT));
        for (block, (uv, out)) in blocks.enumerate() {
            report(observer, block * POINTS_PER_REPORT, uv.len())?;
            uv.par_iter().zip(out).for_each(|(&at, out)| *out = f(at));
        }
        report(observer, uv.len(), uv.len())
    }

    fn nearby_normal(&self, u: f64, v: f64) -> DVec3 {
        let middle = |knots: &KnotVector| f64::midpoint(knots.domain().0, knots.domain().1);
        let (to_u, to_v) = (middle(self.knots_u()) - u, middle(self.knots_v()) - v);
        NORMAL_DETOURS
            .iter()
            .find_map(|step| self.tangents(u + step * to_u, v + step * to_v).normal())
            .unwrap_or(DVec3::ZERO)
    }

    fn tangents(&self, u: f64, v: f64) -> Tangents {
        let (rows, columns) = (Basis::at(self.knots_u(), u), Basis::at(self.knots_v(), v));
        let (mut value, mut by_u, mut by_v) = (DVec4::ZERO, DVec4::ZERO, DVec4::ZERO);
        for k in 0..=self.knots_u().degree() {
            let start = (rows.first + k) * self.shape().1;
            let row = |j: usize| self.homogeneous()[start + j];
            let along = self.combine(&columns, row, &columns.values);
            value += rows.values[k] * along;
            by_u += rows.slopes[k] * along;
            by_v += rows.values[k] * self.combine(&columns, row, &columns.slopes);
        }
        Tangents::new(value, by_u, by_v)
    }

    /// The net of the isocurve at `u`, and its derivative by u, written to `net`.
    fn contract(&self, u: f64, net: &mut Vec<(DVec4, DVec4)>) {
        let basis = Basis::at(self.knots_u(), u);
        net.clear();
        net.resize(self.shape().1, (DVec4::ZERO, DVec4::ZERO));
        for k in 0..=self.knots_u().degree() {
            let start = (basis.first + k) * net.len();
            for (sum, &control) in net.iter_mut().zip(&self.homogeneous()[start..]) {
                sum.0 += basis.values[k] * control;
                sum.1 += basis.slopes[k] * control;
            }
        }
    }

    /// The sum of a row's control points, weighted by basis functions in v.
    fn combine(&self, basis: &Basis, row: impl Fn(usize) -> DVec4, functions: &[f64]) -> DVec4 {
        (0..=self.knots_v().degree()).map(|k| functions[k] * row(basis.first + k)).sum()
    }
}

fn report(observer: &mut dyn Observer, done: usize, total: usize) -> Result<()> {
    let (step, total) = (done as u64, total as u64);
    let stage = Stage::Tessellation;
    progress::report(observer, &Progress::of_stage(stage, step, total, 0))
}

fn check_length(out: usize, needed: usize) -> Result<()> {
    if out == needed {
        return Ok(());
    }
    Err(Error::parameter("out", format!("of length {needed}, one for each parameter"), out))
}

fn check_inside(
    name: &'static str,
    knots: &KnotVector,
    parameters: impl IndexedParallelIterator<Item = f64>,
) -> Result<()> {
    let (start, end) = knots.domain();
    // Not `<` and `>`: NaN lies nowhere.
    let outside = parameters.enumerate().find_first(|(_, t)| !(start..=end).contains(t));
    outside.map_or(Ok(()), |(index, t)| {
        let must = format!("inside the domain [{start}, {end}]");
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
        surface.evaluate_grid(&steps, &steps, &mut points, normals_out, &mut Silent).unwrap();
        for (point, normal) in points.iter().zip(&normals) {
            assert!((point.length() - 1.0).abs() < 1e-15);
            // The pole included: there the normal is that of a step of 1e-6 aside.
            assert!(normal.distance(*point) < 2e-6, "{point} {normal}");
        }
    }

    #[test]
    fn grid_and_scattered_agree() {
        let surface = octant();
        let (u, v) = ([0.0, 0.3, 1.0], [0.0, 0.5, 0.75, 1.0]);
        let uv: Vec<DVec2> = u.iter().flat_map(|&u| v.map(|v| DVec2::new(u, v))).collect();
        let (mut grid, mut scattered) = (vec![DVec3::ZERO; 12], vec![DVec3::ZERO; 12]);
        surface.evaluate_grid(&u, &v, &mut grid, None, &mut Silent).unwrap();
        surface.evaluate(&uv, &mut scattered, &mut Silent).unwrap();
        for (a, b) in grid.iter().zip(&scattered) {
            assert!(a.distance(*b) < 1e-15);
        }
    }

    #[test]
    fn outside_and_mismatched_arguments_are_refused() {
        let surface = octant();
        let mut out = [DVec3::ZERO; 2];
        let mut evaluate = |uv: &[DVec2]| {
            surface.evaluate(uv, &mut out, &mut Silent).map_err(|error| error.to_string())
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
