//! How far a side of the surface lies from the edge that stands for it.

#![expect(clippy::inline_always, reason = "must become part of what SIMD dispatch compiles")]

use glam::{DVec2, DVec3, DVec4};

use super::bernstein::restrict;
use super::certify::Part;
use super::triangle::larger;
use crate::nurbs::halve;

/// A segment, to be measured from.
pub(super) struct Chord {
    start: DVec3,
    along: DVec3,
    /// One by the square of its length.
    scale: f64,
}

impl Chord {
    #[inline(always)]
    pub(super) fn new(a: DVec3, b: DVec3) -> Self {
        let along = b - a;
        Self { start: a, along, scale: 1.0 / along.length_squared().max(f64::MIN_POSITIVE) }
    }

    /// The square of a point's distance.
    #[inline(always)]
    pub(super) fn squared(&self, point: DVec3) -> f64 {
        let away = point - self.start;
        let share = (self.scale * away.dot(self.along)).clamp(0.0, 1.0);
        (away - share * self.along).length_squared()
    }

    /// The square of an upper bound of the distance of the surface over a segment of a side of a part's
    /// unit square; if it is above the square `limit`, one that is found with a closer look.
    #[inline(always)]
    pub(super) fn furthest(
        &self,
        part: &Part<'_>,
        (from, to): (DVec2, DVec2),
        curve: &mut Vec<DVec4>,
        limit: f64,
    ) -> f64 {
        let net = part.net;
        let side = net.side((from, to));
        let (low, high) = (from.min(to), from.max(to));
        let (low, high) = if low.x == high.x { (low.y, high.y) } else { (low.x, high.x) };
        if (low, high) == (0.0, 1.0) {
            let found = self.most(net.on_side(side, part.is_whole()));
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
            net.line(side, k, curve);
            restrict(curve, (0, 1), side.degree, (low, high));
            let mut found = self.most(curve.iter());
            if found > limit {
                closer(curve);
                found = self.most(curve.iter());
            }
            most = larger(most, found);
        }
        most
    }

    /// The square of the largest distance of some homogeneous points. They are too few to be worth the
    /// way into registers.
    #[inline(always)]
    fn most<'a>(&self, points: impl Iterator<Item = &'a DVec4>) -> f64 {
        let mut most = 0.0;
        for h in points {
            most = larger(most, self.squared(h.w.recip() * h.truncate()));
        }
        most
    }
}

/// Replaces the control points of a curve by those of its halves, which lie closer to it.
#[inline(always)]
fn closer(curve: &mut Vec<DVec4>) {
    let count = curve.len();
    curve.extend_from_within(..);
    let (first, second) = curve.split_at_mut(count);
    halve(first, second, count - 1, 1, 0..1);
}

#[cfg(test)]
mod tests {
    use super::super::bernstein::polynomials;
    use super::super::net::Net;
    use super::*;

    #[test]
    fn bounds_are_above_the_distances_and_close() {
        let point = |k: usize| {
            let k = k as f64;
            DVec4::new(k + (1.3 * k).sin(), (2.9 * k).cos(), (0.7 * k * k).sin(), 1.0)
        };
        // Three patches along v, of degree 2; along u one of degree 3.
        let points: Vec<DVec4> = (0..4 * 7).map(point).collect();
        let net = Net { points: &points, patches: (1, 3), degrees: (3, 2) };
        let chord = Chord::new(DVec3::ZERO, 30.0 * DVec3::X);
        for (x, y) in [(0.0, (0.0, 1.0)), (1.0, (0.0, 1.0)), (0.0, (0.25, 0.5)), (1.0, (0.9, 0.4))]
        {
            let ends = (DVec2::new(x, y.0), DVec2::new(x, y.1));
            let bound = chord.furthest(&Part::whole(net), ends, &mut vec![], 0.0).sqrt();
            let mut most = 0.0_f64;
            for k in 0..=300 {
                let at = 3.0 * (y.0 + f64::from(k) / 300.0 * (y.1 - y.0));
                let patch = (0..3).rfind(|&patch| patch as f64 <= at).unwrap_or(0);
                let first = if x == 0.0 { 0 } else { 21 } + 2 * patch;
                let shares = polynomials(2, at - patch as f64);
                let h: DVec4 =
                    points[first..=first + 2].iter().zip(shares).map(|(h, b)| b * *h).sum();
                most = most.max(chord.squared(h.truncate()).sqrt());
            }
            assert!(most <= bound + 1e-12 && bound < 1.2 * most, "{most} {bound}");
        }
    }
}
