//! The deviation of a boundary curve of a cell from the triangle edge (chord) that replaces it.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec2, DVec3, DVec4};

use super::de_casteljau::{restrict, split_curve};
use super::lanes::larger;
use super::surface_part::SurfacePart;

/// A segment with precomputed terms of distances to it.
pub(super) struct Chord {
    start: DVec3,
    along: DVec3,
    /// The inverse of its squared length.
    scale: f64,
}

impl Chord {
    /// The segment from a to b.
    #[inline(always)]
    pub(super) fn new(a: DVec3, b: DVec3) -> Self {
        let along = b - a;
        Self { start: a, along, scale: 1.0 / along.length_squared().max(f64::MIN_POSITIVE) }
    }

    /// The squared distance of a point.
    #[inline(always)]
    pub(super) fn distance_squared(&self, point: DVec3) -> f64 {
        let away = point - self.start;
        let share = (self.scale * away.dot(self.along)).clamp(0.0, 1.0);
        (away - share * self.along).length_squared()
    }

    /// A squared upper bound of the distance of the surface over a segment on a side of `part`.
    ///
    /// The segment goes from `from` to `to` in the unit square of the part. The first bound is by
    /// the control points. If it exceeds `limit`, which is squared as well, the curves are halved
    /// once.
    #[inline(always)]
    pub(super) fn deviation_squared(
        &self,
        part: &SurfacePart<'_>,
        (from, to): (DVec2, DVec2),
        curve: &mut Vec<DVec4>,
        limit: f64,
    ) -> f64 {
        let net = part.net;
        let side = net.side((from, to));
        let (low, high) = (from.min(to), from.max(to));
        let (low, high) = if low.x == high.x { (low.y, high.y) } else { (low.x, high.x) };
        if (low, high) == (0.0, 1.0) {
            let found = self.max_distance_squared(net.on_side(side, part.is_whole()));
            if found <= limit {
                return found;
            }
        }
        let mut most = 0.0;
        for k in 0..side.patches {
            let (mut low, mut high) = (low, high);
            if side.patches > 1 {
                let inside = |at: f64| (at * side.patches as f64 - k as f64).clamp(0.0, 1.0);
                (low, high) = (inside(low), inside(high));
                if low >= high {
                    continue;
                }
            }
            net.side_of_patch(side, k, curve);
            restrict(curve, (0, 1), side.degree, (low, high));
            let mut found = self.max_distance_squared(curve.iter());
            if found > limit {
                split_curve(curve);
                found = self.max_distance_squared(curve.iter());
            }
            most = larger(most, found);
        }
        most
    }

    /// The largest squared distance of some homogeneous points, too few for SIMD to pay off.
    #[inline(always)]
    fn max_distance_squared<'a>(&self, points: impl Iterator<Item = &'a DVec4>) -> f64 {
        let mut most = 0.0;
        for h in points {
            most = larger(most, self.distance_squared(h.w.recip() * h.truncate()));
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::super::bernstein::polynomials;
    use super::super::net::Net;
    use super::*;

    #[test]
    fn bounds_are_above_the_distances_and_close_to_them() {
        let point = |k: usize| {
            let k = k as f64;
            DVec4::new(k + (1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin(), 1.0)
        };
        // One patch of degree 3 along u, three of degree 2 along v.
        let points: Vec<DVec4> = (0..4 * 7).map(point).collect();
        let net = Net { points: &points, patches: (1, 3), degrees: (3, 2) };
        let chord = Chord::new(DVec3::ZERO, 30.0 * DVec3::X);
        for (x, y) in [(0.0, (0.0, 1.0)), (1.0, (0.0, 1.0)), (0.0, (0.25, 0.5)), (1.0, (0.9, 0.4))]
        {
            let ends = (DVec2::new(x, y.0), DVec2::new(x, y.1));
            let bound =
                chord.deviation_squared(&SurfacePart::whole(net), ends, &mut vec![], 0.0).sqrt();
            let mut most = 0.0_f64;
            for k in 0..=300 {
                let at = 3.0 * (y.0 + f64::from(k) / 300.0 * (y.1 - y.0));
                let patch = (0..3).rfind(|&patch| patch as f64 <= at).unwrap_or(0);
                let first = if x == 0.0 { 0 } else { 21 } + 2 * patch;
                let mut basis = [0.0; 3];
                polynomials(2, at - patch as f64, &mut basis);
                let h: DVec4 =
                    points[first..=first + 2].iter().zip(basis).map(|(h, b)| b * *h).sum();
                most = most.max(chord.distance_squared(h.truncate()).sqrt());
            }
            assert!(most <= bound + 1e-12 && bound < 1.2 * most, "{most} {bound}");
        }
    }
}
