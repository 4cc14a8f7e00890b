//! Quadrilaterals that become squares.

use glam::DVec2;

/// Steps of Newton's method for a place in a quadrilateral; it is nearly a parallelogram.
const STEPS: usize = 8;

/// Four corners, counter-clockwise; the first becomes the origin, the second (1, 0).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quadrilateral(pub(crate) [DVec2; 4]);

impl Quadrilateral {
    /// Mean lengths of the sides along x and along y.
    pub(crate) fn lengths(&self) -> (f64, f64) {
        let [a, b, c, d] = self.0;
        (0.5 * (a.distance(b) + d.distance(c)), 0.5 * (a.distance(d) + b.distance(c)))
    }

    /// Negative if the corners are in clockwise order.
    pub(crate) fn area(&self) -> f64 {
        let [a, b, c, d] = self.0;
        0.5 * (c - a).perp_dot(d - b)
    }

    pub(crate) fn aspect(&self) -> f64 {
        let (along, across) = self.lengths();
        along / across
    }

    /// The same with its long sides along x.
    pub(crate) fn lengthwise(self) -> Self {
        let [a, b, c, d] = self.0;
        if self.aspect() < 1.0 { Self([b, c, d, a]) } else { self }
    }

    /// Where the bilinear map brings a place in the unit square.
    pub(super) fn place(&self, uv: DVec2) -> DVec2 {
        let [a, b, c, d] = self.0;
        a.lerp(b, uv.x).lerp(d.lerp(c, uv.x), uv.y)
    }

    /// The place in the unit square that the bilinear map brings here.
    pub(crate) fn inverse(&self, place: DVec2) -> DVec2 {
        let [a, b, c, d] = self.0;
        let (along, across, twist) = (b - a, d - a, a - b + c - d);
        let mut uv = DVec2::splat(0.5);
        for _ in 0..STEPS {
            let rest = place - (a + uv.x * along + uv.y * across + uv.x * uv.y * twist);
            let (du, dv) = (along + uv.y * twist, across + uv.x * twist);
            let det = du.perp_dot(dv);
            if det == 0.0 {
                break;
            }
            uv += DVec2::new(rest.perp_dot(dv), du.perp_dot(rest)) / det;
        }
        uv
    }
}
