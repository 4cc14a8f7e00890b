//! Planes whose map from (u, v) to space is affine: curves on them are exact.

use glam::DVec3;

use crate::error::Result;
use crate::nurbs::{NurbsCurve, NurbsSurface};

/// Rounding of a point on a surface, as a fraction of the largest coordinate.
const ROUNDING: f64 = 1e-14;

/// The rounding of points on a surface.
pub(super) fn rounding(surface: &NurbsSurface) -> f64 {
    let (low, high) = surface.net_box();
    ROUNDING * low.abs().max(high.abs()).max_element()
}

/// The map of a parallelogram: a point and the derivatives by u and v.
pub(super) struct AffineMap {
    place: [f64; 2],
    point: DVec3,
    by_u: DVec3,
    by_v: DVec3,
}

impl AffineMap {
    /// The map of a surface, if it is a parallelogram without weights.
    pub(super) fn of(surface: &NurbsSurface) -> Option<Self> {
        let &[a, b, c, d] = surface.control_points() else { return None };
        let (u, v) = (surface.knots_u().domain(), surface.knots_v().domain());
        if surface.weights().is_some() || (a - b - c + d).length() > rounding(surface) {
            return None;
        }
        let (by_u, by_v) = ((c - a) / (u.1 - u.0), (b - a) / (v.1 - v.0));
        let is_regular = by_u.cross(by_v).length_squared() > 0.0;
        is_regular.then_some(Self { place: [u.0, v.0], point: a, by_u, by_v })
    }

    /// The curve in space over a curve in (u, v).
    pub(super) fn in_space(&self, curve: &NurbsCurve) -> Result<NurbsCurve> {
        let [u, v] = self.place;
        mapped(curve, |p| self.point + (p.x - u) * self.by_u + (p.y - v) * self.by_v)
    }

    /// The curve in (u, v) nearest to a curve in space.
    pub(super) fn in_parameters(&self, curve: &NurbsCurve) -> Result<NurbsCurve> {
        let normal = self.by_u.cross(self.by_v);
        let (to_u, to_v) = (self.by_v.cross(normal), normal.cross(self.by_u));
        let (to_u, to_v) = (to_u / to_u.dot(self.by_u), to_v / to_v.dot(self.by_v));
        let [u, v] = self.place;
        mapped(curve, |p| {
            let away = p - self.point;
            DVec3::new(u + away.dot(to_u), v + away.dot(to_v), 0.0)
        })
    }
}

/// A curve with mapped control points. For affine maps it is the mapped curve.
fn mapped(curve: &NurbsCurve, map: impl Fn(DVec3) -> DVec3) -> Result<NurbsCurve> {
    let points = curve.control_points().iter().map(|&point| map(point)).collect();
    NurbsCurve::new(points, curve.weights().map(<[f64]>::to_vec), curve.knots().clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_on_parallelograms_are_exact_in_both_directions() {
        let (x, y) = (DVec3::new(2.0, 1.0, 0.5), DVec3::new(-1.0, 3.0, 4.0));
        let plane = NurbsSurface::plane(DVec3::ONE, x, y).unwrap();
        let map = AffineMap::of(&plane).unwrap();
        let center = DVec3::new(0.5, 0.4, 0.0);
        let circle = NurbsCurve::arc(center, 0.3 * DVec3::X, 0.2 * DVec3::Y, 6.0).unwrap();
        let in_space = map.in_space(&circle).unwrap();
        let back = map.in_parameters(&in_space).unwrap();
        for k in 0..=20 {
            let at = f64::from(k) / 20.0;
            let uv = circle.point(at);
            assert!(in_space.point(at).distance(plane.point(uv.x, uv.y)) < 1e-14);
            assert!(back.point(at).distance(uv) < 1e-14);
        }
        let bent = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        assert!(AffineMap::of(&NurbsSurface::clamped(bent, (2, 2), 1).unwrap()).is_none());
    }
}
