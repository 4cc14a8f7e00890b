//! Gaussian, mean and principal curvatures of a surface.

use glam::{DVec2, DVec3};

use super::basis::BasisDerivatives;
use super::evaluate::INWARD_STEPS;
use super::isocurve::{self, Isocurve};
use super::parameter_checks::{Outside, check_length};
use super::partials::Partials;
use super::surface::NurbsSurface;
use super::work_blocks::{POINTS_PER_TASK, for_row_blocks};
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

/// A point is umbilic if half of the difference of its principal curvatures is at most this
/// fraction of their mean. Every direction is then principal.
const UMBILIC_TOLERANCE: f64 = 1e-7;

/// Cost of one curvature, in point evaluations; progress reports use it.
pub(super) const CURVATURE_COST: usize = 8;

/// Curvatures in the task of a thread.
pub(super) const CURVATURES_PER_TASK: usize = POINTS_PER_TASK / CURVATURE_COST;

/// The curvatures of a surface at a point.
///
/// Curvatures are positive where the surface bends towards its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// The point itself.
    pub point: DVec3,
    /// The unit normal.
    pub normal: DVec3,
    /// Gaussian curvature, the product of the principal curvatures, in 1 / unit².
    pub gaussian: f64,
    /// Mean curvature, half of the sum of the principal curvatures, in 1 / unit.
    pub mean: f64,
    /// The principal curvatures, the largest first, in 1 / unit.
    pub principal: [f64; 2],
    /// The principal directions, orthogonal unit tangents; the second is `normal × first`. At an
    /// umbilic point the first runs along u.
    pub directions: [DVec3; 2],
}

/// Output slices for curvatures, with one element for each parameter.
pub struct CurvatureSlices<'a> {
    /// See [`Curvature::point`].
    pub points: &'a mut [DVec3],
    /// See [`Curvature::normal`].
    pub normals: &'a mut [DVec3],
    /// See [`Curvature::gaussian`].
    pub gaussian: &'a mut [f64],
    /// See [`Curvature::mean`].
    pub mean: &'a mut [f64],
    /// See [`Curvature::principal`].
    pub principal: &'a mut [[f64; 2]],
    /// See [`Curvature::directions`].
    pub directions: &'a mut [[DVec3; 2]],
}

impl<'a> CurvatureSlices<'a> {
    fn check(&self, needed: usize) -> Result<()> {
        let vectors = [self.points.len(), self.normals.len(), self.directions.len()];
        let numbers = [self.gaussian.len(), self.mean.len(), self.principal.len()];
        let mut lengths = vectors.into_iter().chain(numbers);
        lengths.try_for_each(|length| check_length(length, needed))
    }

    /// Chunks of the elements from..to.
    fn chunks(
        &mut self,
        from: usize,
        to: usize,
        size: usize,
    ) -> impl Iterator<Item = CurvatureSlices<'_>> + Send + use<'_, 'a> {
        let points = self.points[from..to].chunks_mut(size);
        let vectors = points.zip(self.normals[from..to].chunks_mut(size));
        let numbers = self.gaussian[from..to].chunks_mut(size);
        let numbers = numbers.zip(self.mean[from..to].chunks_mut(size));
        let pairs = self.principal[from..to].chunks_mut(size);
        let pairs = pairs.zip(self.directions[from..to].chunks_mut(size));
        vectors.zip(numbers).zip(pairs).map(
            |(((points, normals), (gaussian, mean)), (principal, directions))| CurvatureSlices {
                points,
                normals,
                gaussian,
                mean,
                principal,
                directions,
            },
        )
    }

    fn set(&mut self, index: usize, curvature: &Curvature) {
        (self.points[index], self.normals[index]) = (curvature.point, curvature.normal);
        (self.gaussian[index], self.mean[index]) = (curvature.gaussian, curvature.mean);
        self.principal[index] = curvature.principal;
        self.directions[index] = curvature.directions;
    }
}

impl Curvature {
    /// Computes the curvatures from partial derivatives and a unit normal (M. do Carmo,
    /// *Differential Geometry of Curves and Surfaces*, section 3.3).
    ///
    /// In an orthonormal basis of the tangent plane, whose first vector is along u, the second
    /// fundamental form is a symmetric 2 × 2 matrix.
    fn new(partials: &Partials, normal: DVec3) -> Self {
        let length = partials.u.length();
        let along = partials.u / length;
        let across = normal.cross(along);
        // v = a along + b across, so d/dacross = (d/dv - a / length d/du) / b.
        let (a, b) = (partials.v.dot(along), partials.v.dot(across));
        let [l, m, n] = [partials.uu, partials.uv, partials.vv].map(|second| second.dot(normal));
        let ratio = a / length;
        let xx = l / (length * length);
        let xy = (m - ratio * l) / (length * b);
        let yy = (n - 2.0 * ratio * m + ratio * ratio * l) / (b * b);
        let mean = f64::midpoint(xx, yy);
        let half = f64::midpoint(xx, -yy);
        let spread = half.hypot(xy);
        let (cos, sin) = if spread <= UMBILIC_TOLERANCE * mean.abs() {
            (1.0, 0.0)
        } else {
            // Half of the angle of (half, xy), without cancellation.
            let (x, y) = if half >= 0.0 {
                (spread + half, xy)
            } else {
                (xy.abs(), (spread - half) * xy.signum())
            };
            let length = x.hypot(y);
            (x / length, y / length)
        };
        let direction = cos * along + sin * across;
        Self {
            point: partials.point,
            normal,
            gaussian: xx * yy - xy * xy,
            mean,
            principal: [mean + spread, mean - spread],
            directions: [direction, normal.cross(direction)],
        }
    }
}

impl NurbsSurface {
    /// Returns the curvatures at (u, v).
    ///
    /// Where the parametrization is degenerate (a pole, a collapsed edge), returns the curvatures a
    /// small step closer to the center of the domain. All are zero if there is no normal there
    /// either.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0)?;
    /// let curvature = sphere.curvature(0.3, 0.4);
    /// assert!((curvature.gaussian - 0.25).abs() < 1e-14);
    /// assert!((curvature.mean + 0.5).abs() < 1e-14); // the normal points outwards
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn curvature(&self, u: f64, v: f64) -> Curvature {
        self.curvature_of(&self.partials(u, v), u, v)
    }

    fn curvature_of(&self, partials: &Partials, u: f64, v: f64) -> Curvature {
        if let Some(normal) = self.tangent_thresholds().normal(partials.u, partials.v) {
            return Curvature::new(partials, normal);
        }
        let (to_u, to_v) = self.toward_center(u, v);
        // The smallest step is too close to a pole for second derivatives.
        let beside = INWARD_STEPS[1..].iter().find_map(|step| {
            let near = self.partials(u + step * to_u, v + step * to_v);
            let normal = self.tangent_thresholds().normal(near.u, near.v)?;
            Some(Curvature::new(&near, normal))
        });
        let normal = self.normal(u, v);
        Curvature { point: partials.point, normal, ..beside.unwrap_or_default() }
    }

    /// Computes points, normals and curvatures at scattered parameters.
    ///
    /// ```
    /// use neurbs::nurbs::{CurvatureSlices, NurbsSurface, Outside};
    /// use neurbs::{DVec2, DVec3, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0)?;
    /// let (mut points, mut normals) = ([DVec3::ZERO], [DVec3::ZERO]);
    /// let (mut gaussian, mut mean) = ([0.0], [0.0]);
    /// let (mut principal, mut directions) = ([[0.0; 2]], [[DVec3::ZERO; 2]]);
    /// let out = CurvatureSlices {
    ///     points: &mut points,
    ///     normals: &mut normals,
    ///     gaussian: &mut gaussian,
    ///     mean: &mut mean,
    ///     principal: &mut principal,
    ///     directions: &mut directions,
    /// };
    /// sphere.curvatures(&[DVec2::new(0.3, 0.4)], out, Outside::Refuse, &mut Silent)?;
    /// assert!((gaussian[0] - 0.25).abs() < 1e-14 && (mean[0] + 0.5).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::evaluate`](NurbsSurface::evaluate).
    pub fn curvatures(
        &self,
        uv: &[DVec2],
        mut out: CurvatureSlices<'_>,
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        out.check(uv.len())?;
        self.check_scattered(uv, uv.len(), outside)?;
        for_row_blocks(uv.len(), CURVATURE_COST, observer, |from, to| {
            let tasks = uv[from..to].chunks(CURVATURES_PER_TASK);
            let tasks = tasks.zip(out.chunks(from, to, CURVATURES_PER_TASK));
            worker_pool::for_each_task(tasks, 1, |(): &mut (), (uv, mut out)| {
                for (index, at) in uv.iter().enumerate() {
                    out.set(index, &self.curvature(at.x, at.y));
                }
            });
        })
    }

    /// Computes points, normals and curvatures on the grid of all pairs of `u` and `v`, row by row,
    /// `v` fastest.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{CurvatureSlices, NurbsSurface, Outside}, progress::Silent};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 2.0)?;
    /// let (mut points, mut normals) = ([DVec3::ZERO], [DVec3::ZERO]);
    /// let (mut gaussian, mut mean) = ([0.0], [0.0]);
    /// let (mut principal, mut directions) = ([[0.0; 2]], [[DVec3::ZERO; 2]]);
    /// let out = CurvatureSlices {
    ///     points: &mut points,
    ///     normals: &mut normals,
    ///     gaussian: &mut gaussian,
    ///     mean: &mut mean,
    ///     principal: &mut principal,
    ///     directions: &mut directions,
    /// };
    /// sphere.curvature_grid(&[0.3], &[0.4], out, Outside::Refuse, &mut Silent)?;
    /// assert!((gaussian[0] - 0.25).abs() < 1e-14 && (mean[0] + 0.5).abs() < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::evaluate_grid`](NurbsSurface::evaluate_grid).
    pub fn curvature_grid(
        &self,
        u: &[f64],
        v: &[f64],
        mut out: CurvatureSlices<'_>,
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        out.check(u.len() * v.len())?;
        self.check_grid(u, v, outside)?;
        if v.is_empty() {
            return Ok(());
        }
        let columns: Vec<BasisDerivatives<3>> =
            v.iter().map(|&v| BasisDerivatives::at(self.knots_v(), v)).collect();
        for_row_blocks(u.len(), CURVATURE_COST * v.len(), observer, |from, to| {
            let rows = out.chunks(from * v.len(), to * v.len(), v.len()).zip(&u[from..to]);
            worker_pool::for_each_task(rows, 1, |net: &mut Isocurve, (mut row, &u)| {
                isocurve::partials_along(self, u, &columns, net, |column, partials| {
                    row.set(column, &self.curvature_of(partials, u, v[column]));
                });
            });
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn torus_curvatures_match_the_closed_form() {
        let (major, minor) = (3.0, 1.0);
        let torus = NurbsSurface::torus(DVec3::ZERO, major, minor).unwrap();
        for u in [0.0, 0.1, 0.33, 0.5, 0.9] {
            for v in [0.0, 0.2, 0.25, 0.61, 1.0] {
                let c = torus.curvature(u, v);
                let axis = c.point.truncate().length();
                let cos = (axis - major) / minor;
                let (k1, k2) = (1.0 / minor, cos / axis);
                assert!((c.gaussian - k1 * k2).abs() < 1e-13);
                assert!((c.mean + f64::midpoint(k1, k2)).abs() < 1e-13, "{c:?}");
                assert!((c.principal[0] + k2).abs() < 1e-13 && (c.principal[1] + k1).abs() < 1e-13);
                // The direction of the weaker bend is tangent to the circle around the axis.
                let round = DVec3::Z.cross(c.point).normalize();
                assert!((c.directions[0].dot(round).abs() - 1.0).abs() < 1e-12);
                assert!(c.directions[1].distance(c.normal.cross(c.directions[0])) < 1e-14);
            }
        }
    }

    #[test]
    fn saddle_curvatures_match_its_height_field() {
        // z = x y over [-1, 1]², whose tangents are not orthogonal.
        let net = [(-1, -1), (-1, 1), (1, -1), (1, 1)]
            .map(|(x, y)| DVec3::new(x.into(), y.into(), (x * y).into()));
        let surface = NurbsSurface::clamped(net.to_vec(), (2, 2), 1).unwrap();
        for (u, v) in [(0.5, 0.5), (0.2, 0.9), (1.0, 0.0)] {
            let c = surface.curvature(u, v);
            let (x, y) = (c.point.x, c.point.y);
            let g = 1.0 + x * x + y * y;
            assert!((c.gaussian + 1.0 / (g * g)).abs() < 1e-14);
            assert!((c.mean + x * y / g.powf(1.5)).abs() < 1e-14);
            let forms = surface.fundamental_forms(u, v);
            let det = |m: [[f64; 2]; 2]| m[0][0] * m[1][1] - m[0][1] * m[1][0];
            assert!((det(forms.second) / det(forms.first) - c.gaussian).abs() < 1e-14);
            // Along a principal direction the normal curvature is the principal curvature.
            for (direction, principal) in c.directions.iter().zip(c.principal) {
                let (t, f) = (forms.second, forms.first);
                let tangent = surface.partials(u, v);
                let (a, b) = (direction.dot(tangent.u), direction.dot(tangent.v));
                let du = (a * f[1][1] - b * f[0][1]) / det(f);
                let dv = (b * f[0][0] - a * f[0][1]) / det(f);
                let bend = t[0][0] * du * du + 2.0 * t[0][1] * du * dv + t[1][1] * dv * dv;
                assert!((bend - principal).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn grid_and_scattered_agree_even_at_the_poles() {
        let sphere = NurbsSurface::sphere(DVec3::ONE, 2.0).unwrap();
        let (u, v) = ([0.0, 0.3, 1.0], [0.0, 0.5, 1.0]);
        let uv: Vec<DVec2> = u.iter().flat_map(|&u| v.map(|v| DVec2::new(u, v))).collect();
        let run = |grid: bool| {
            let (mut points, mut normals) = (vec![DVec3::ZERO; 9], vec![DVec3::ZERO; 9]);
            let (mut gaussian, mut mean) = (vec![0.0; 9], vec![0.0; 9]);
            let (mut principal, mut directions) = (vec![[0.0; 2]; 9], vec![[DVec3::ZERO; 2]; 9]);
            let out = CurvatureSlices {
                points: &mut points,
                normals: &mut normals,
                gaussian: &mut gaussian,
                mean: &mut mean,
                principal: &mut principal,
                directions: &mut directions,
            };
            if grid {
                sphere.curvature_grid(&u, &v, out, Outside::Refuse, &mut Silent).unwrap();
            } else {
                sphere.curvatures(&uv, out, Outside::Refuse, &mut Silent).unwrap();
            }
            (points, normals, gaussian, mean)
        };
        let (grid, scattered) = (run(true), run(false));
        for i in 0..9 {
            assert!(grid.0[i].distance(scattered.0[i]) < 1e-14);
            assert!(grid.1[i].distance((grid.0[i] - DVec3::ONE) / 2.0) < 1e-14);
            // At the poles, second derivatives are taken a small step away.
            let accuracy = if i % 3 == 1 { 1e-14 } else { 1e-6 };
            assert!((grid.2[i] - 0.25).abs() < accuracy && (grid.3[i] + 0.5).abs() < accuracy);
            assert!((grid.2[i] - scattered.2[i]).abs() < accuracy);
        }
    }
}
