//! A point of a surface with its normal, from one set of basis functions.

use glam::DVec3;

use super::basis::BasisDerivatives;
use super::surface::NurbsSurface;

impl NurbsSurface {
    /// [`NurbsSurface::point`] and [`NurbsSurface::normal`] at (u, v), at the cost of one of them.
    pub(crate) fn point_and_normal(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let rows = BasisDerivatives::<2>::at(self.knots_u(), u);
        let columns = BasisDerivatives::<2>::at(self.knots_v(), v);
        let firsts = (rows.first, columns.first);
        let sum = |i: usize, j: usize| self.contract(firsts, &rows.rows[i], &columns.rows[j]);
        let (value, by_u, by_v) = (sum(0, 0), sum(1, 0), sum(0, 1));
        let point = value.truncate() / value.w;
        let tangent = |d: glam::DVec4| (d.truncate() - d.w * point) / value.w;
        let normal = self.flats().normal(tangent(by_u), tangent(by_v));
        (point, normal.unwrap_or_else(|| self.normal(u, v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_point_and_normal() {
        let sphere = NurbsSurface::sphere(DVec3::X, 2.0).unwrap();
        for (u, v) in [(0.0, 0.0), (0.3, 0.1), (0.5, 1.0), (1.0, 0.7)] {
            let (point, normal) = sphere.point_and_normal(u, v);
            assert!(point.distance(sphere.point(u, v)) < 1e-15);
            assert!(normal.distance(sphere.normal(u, v)) < 1e-14);
        }
    }
}
