//! Points and normals of a surface at single and at scattered parameters.

use glam::{DVec2, DVec3, DVec4};
use pulp::Arch;

use super::basis::{BasisDerivatives, padded, with_capacity};
use super::evaluate_scattered::{BLOCK, homogeneous};
use super::knot_vector::KnotVector;
use super::parameter_checks::Outside;
use super::partials::Partials;
use super::surface::NurbsSurface;
use super::work_blocks::{POINTS_PER_TASK, for_blocks};
use crate::error::Result;
use crate::progress::Observer;
use crate::worker_pool;

/// Steps towards the center of the domain, as fractions of the way, for degenerate points. There
/// neither the first nor the second derivatives define the normal or the curvature, so it is taken
/// from the first step that does.
pub(super) const INWARD_STEPS: [f64; 3] = [1e-5, 1e-4, 1e-2];

impl NurbsSurface {
    /// Returns the point at (u, v); outside the domain the outermost patch is extrapolated.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// assert!((sphere.point(0.3, 0.4).length() - 1.0).abs() < 1e-15);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let value = with_capacity!(self.max_degree(), CAPACITY => {
            let rows = padded::<CAPACITY>(self.knots_u(), u);
            let columns = padded::<CAPACITY>(self.knots_v(), v);
            self.contract((rows.first, columns.first), &rows.values, &columns.values)
        });
        value.truncate() / value.w
    }

    /// Returns the unit normal at (u, v), the direction of `∂/∂u × ∂/∂v`.
    ///
    /// Where the tangents are parallel or one of them vanishes (a pole, a collapsed edge), returns
    /// the limit from the center of the domain; zero if there is none.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::NurbsSurface};
    /// let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0)?;
    /// // At the pole it is a limit.
    /// assert!(sphere.normal(0.3, 1.0).distance(sphere.point(0.3, 1.0)) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        let partials = self.partials(u, v);
        let normal = self.tangent_thresholds().normal(partials.u, partials.v);
        normal.unwrap_or_else(|| self.limit_normal(u, v, &partials))
    }

    /// Computes the points at scattered parameters.
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
    /// - [`crate::Error::Parameter`] if a parameter is outside the domain and `outside` refuses
    ///   that, or the length of `out` differs from that of `uv`.
    /// - [`crate::Error::Interrupted`] if the observer stops it.
    pub fn evaluate(
        &self,
        uv: &[DVec2],
        out: &mut [DVec3],
        outside: Outside,
        observer: &mut dyn Observer,
    ) -> Result<()> {
        self.check_scattered(uv, out.len(), outside)?;
        self.for_each_scattered(uv, out, observer, |out, _, [value]: [DVec4; 1]| {
            *out = value.truncate() * value.w.recip();
        })
    }

    /// Computes the unit normals at scattered parameters; see [`NurbsSurface::normal`].
    ///
    /// ```
    /// use neurbs::{DVec2, DVec3, nurbs::{NurbsSurface, Outside}, progress::Silent};
    /// let plane = NurbsSurface::plane(DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y)?;
    /// let (uv, mut out) = ([DVec2::new(0.5, 0.5)], [DVec3::ZERO]);
    /// plane.normals(&uv, &mut out, Outside::Refuse, &mut Silent)?;
    /// assert_eq!(out[0], DVec3::Z);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
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
        self.for_each_scattered(uv, out, observer, |out, at, [value, by_u, by_v]: [DVec4; 3]| {
            let point = value.truncate() * value.w.recip();
            let tangent = |d: DVec4| (d.truncate() - d.w * point) * value.w.recip();
            let normal = self.tangent_thresholds().normal(tangent(by_u), tangent(by_v));
            *out = normal.unwrap_or_else(|| self.normal(at.x, at.y));
        })
    }

    /// Computes points and unit normals at parameters inside the domain, at the cost of one of
    /// them. See [`NurbsSurface::point`] and [`NurbsSurface::normal`].
    pub(crate) fn points_and_normals(
        &self,
        uv: &[DVec2],
        points: &mut [DVec3],
        normals: &mut [DVec3],
    ) {
        let arch = Arch::new();
        let out = points.chunks_mut(BLOCK).zip(normals.chunks_mut(BLOCK));
        for (uv, (points, normals)) in uv.chunks(BLOCK).zip(out) {
            let sums = homogeneous::<3>(self, arch, uv);
            for (k, at) in uv.iter().enumerate() {
                let [value, by_u, by_v] = sums[k].map(DVec4::from);
                let point = value.truncate() / value.w;
                let tangent = |d: DVec4| (d.truncate() - d.w * point) / value.w;
                let normal = self.tangent_thresholds().normal(tangent(by_u), tangent(by_v));
                points[k] = point;
                normals[k] = normal.unwrap_or_else(|| self.normal(at.x, at.y));
            }
        }
    }

    /// Calls `f` for each parameter with its homogeneous point, and with its derivatives by u and v
    /// if `SUMS` is 3.
    fn for_each_scattered<const SUMS: usize>(
        &self,
        uv: &[DVec2],
        out: &mut [DVec3],
        observer: &mut dyn Observer,
        f: impl Fn(&mut DVec3, DVec2, [DVec4; SUMS]) + Sync,
    ) -> Result<()> {
        let arch = Arch::new();
        for_blocks(uv.len(), observer, |from, to| {
            let tasks = uv[from..to].chunks(POINTS_PER_TASK);
            let tasks = tasks.zip(out[from..to].chunks_mut(POINTS_PER_TASK));
            worker_pool::for_each_task(tasks, 1, |(): &mut (), (uv, out)| {
                for (uv, out) in uv.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
                    let sums = homogeneous::<SUMS>(self, arch, uv);
                    for ((out, at), sums) in out.iter_mut().zip(uv).zip(sums) {
                        f(out, *at, sums.map(DVec4::from));
                    }
                }
            });
        })
    }

    fn limit_normal(&self, u: f64, v: f64, partials: &Partials) -> DVec3 {
        let (to_u, to_v) = self.toward_center(u, v);
        let inward = |step: &f64| {
            let partials = self.partials(u + step * to_u, v + step * to_v);
            self.tangent_thresholds().normal(partials.u, partials.v)
        };
        let limit = partials.limit_normal((to_u, to_v));
        limit.or_else(|| INWARD_STEPS.iter().find_map(inward)).unwrap_or(DVec3::ZERO)
    }

    /// Returns the vector from (u, v) to the center of the domain.
    pub(super) fn toward_center(&self, u: f64, v: f64) -> (f64, f64) {
        let middle = |knots: &KnotVector| f64::midpoint(knots.domain().0, knots.domain().1);
        (middle(self.knots_u()) - u, middle(self.knots_v()) - v)
    }

    /// Evaluates the point at (u, v) and the tangents in u and v.
    pub(crate) fn tangents(&self, u: f64, v: f64) -> [DVec3; 3] {
        let partials = self.partials(u, v);
        [partials.point, partials.u, partials.v]
    }

    /// Evaluates the point at (u, v) with its first and second derivatives.
    pub(super) fn partials(&self, u: f64, v: f64) -> Partials {
        with_capacity!(self.max_degree(), CAPACITY => self.partials_within::<CAPACITY>(u, v))
    }

    /// The same for degrees below `CAPACITY`.
    fn partials_within<const CAPACITY: usize>(&self, u: f64, v: f64) -> Partials {
        let rows = BasisDerivatives::<3, CAPACITY>::at(self.knots_u(), u);
        let columns = BasisDerivatives::<3, CAPACITY>::at(self.knots_v(), v);
        let firsts = (rows.first, columns.first);
        let orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        Partials::new(orders.map(|(i, j)| self.contract(firsts, &rows.rows[i], &columns.rows[j])))
    }

    /// The larger degree.
    fn max_degree(&self) -> usize {
        self.knots_u().degree().max(self.knots_v().degree())
    }

    /// Sums the control points from these first indices on, weighted by functions in u and v.
    pub(super) fn contract(&self, firsts: (usize, usize), rows: &[f64], columns: &[f64]) -> DVec4 {
        let (degree_u, degree_v) = (self.knots_u().degree(), self.knots_v().degree());
        let along = |k: usize| {
            let start = (firsts.0 + k) * self.shape().1 + firsts.1;
            let net = self.homogeneous()[start..=start + degree_v].iter();
            let sum: DVec4 = net.zip(columns).map(|(point, b)| *b * *point).sum();
            rows[k] * sum
        };
        (0..=degree_u).map(along).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use super::*;
    use crate::progress::Silent;

    /// Builds an eighth of the unit sphere as a rational biquadratic patch. The edge v = 1
    /// collapses to the pole.
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
    fn points_and_normals_of_an_octant_are_exact() {
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
            // At the pole the normal is a limit.
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
    fn a_net_in_one_point_has_a_zero_normal() {
        let surface = NurbsSurface::clamped(vec![DVec3::ONE; 16], (4, 4), 3).unwrap();
        assert_eq!(surface.normal(0.3, 0.3), DVec3::ZERO);
    }

    #[test]
    fn points_and_normals_agree_with_single_evaluation() {
        let sphere = NurbsSurface::sphere(DVec3::X, 2.0).unwrap();
        let uv = [(0.0, 0.0), (0.3, 0.1), (0.5, 1.0), (1.0, 0.7)].map(DVec2::from);
        let (mut points, mut normals) = ([DVec3::ZERO; 4], [DVec3::ZERO; 4]);
        sphere.points_and_normals(&uv, &mut points, &mut normals);
        for (k, at) in uv.iter().enumerate() {
            assert!(points[k].distance(sphere.point(at.x, at.y)) < 1e-15);
            assert!(normals[k].distance(sphere.normal(at.x, at.y)) < 1e-14);
        }
    }
}
