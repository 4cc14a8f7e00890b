//! Points of a surface with their normals, from one set of basis functions.

use glam::{DVec2, DVec3, DVec4};
use pulp::Arch;

use super::scattered::{BLOCK, homogeneous};
use super::surface::NurbsSurface;

impl NurbsSurface {
    /// [`NurbsSurface::point`] and [`NurbsSurface::normal`] at parameters inside the domain, at the
    /// cost of one of them.
    pub(crate) fn vertices(&self, uv: &[DVec2], points: &mut [DVec3], normals: &mut [DVec3]) {
        let arch = Arch::new();
        let out = points.chunks_mut(BLOCK).zip(normals.chunks_mut(BLOCK));
        for (uv, (points, normals)) in uv.chunks(BLOCK).zip(out) {
            let sums = homogeneous::<3>(self, arch, uv);
            for (k, at) in uv.iter().enumerate() {
                let [value, by_u, by_v] = sums[k].map(DVec4::from);
                let point = value.truncate() / value.w;
                let tangent = |d: DVec4| (d.truncate() - d.w * point) / value.w;
                let normal = self.flats().normal(tangent(by_u), tangent(by_v));
                points[k] = point;
                normals[k] = normal.unwrap_or_else(|| self.normal(at.x, at.y));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agree_with_points_and_normals() {
        let sphere = NurbsSurface::sphere(DVec3::X, 2.0).unwrap();
        let uv = [(0.0, 0.0), (0.3, 0.1), (0.5, 1.0), (1.0, 0.7)].map(DVec2::from);
        let (mut points, mut normals) = ([DVec3::ZERO; 4], [DVec3::ZERO; 4]);
        sphere.vertices(&uv, &mut points, &mut normals);
        for (k, at) in uv.iter().enumerate() {
            assert!(points[k].distance(sphere.point(at.x, at.y)) < 1e-15);
            assert!(normals[k].distance(sphere.normal(at.x, at.y)) < 1e-14);
        }
    }
}
