//! Second derivatives of a patch, estimated from its control net or its points.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::{DVec2, DVec4};

/// Second derivatives of the surface over the unit square: of its height above the plane that the
/// diagonals of the net span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bending {
    pub uu: f64,
    pub uv: f64,
    pub vv: f64,
}

impl Bending {
    /// Estimates them from a net of degrees p and q as the mean of its second differences.
    ///
    /// The four lanes of a point are one register; the last lane is ignored.
    #[inline(always)]
    pub(crate) fn of(points: &[DVec4], (p, q): (usize, usize)) -> Self {
        let width = q + 1;
        let row = |i: usize| &points[i * width..][..width];
        // A sum of second differences telescopes to the difference of the first differences at both
        // ends.
        let (first, second, last_but_one, last) = (row(0), row(1), row(p - 1), row(p));
        let mut uu = DVec4::ZERO;
        for j in 0..width {
            uu += (last[j] - last_but_one[j]) - (second[j] - first[j]);
        }
        let mut vv = DVec4::ZERO;
        for row in points.chunks_exact(width) {
            vv += (row[q] - row[q - 1]) - (row[1] - row[0]);
        }
        let (uu, vv) = (uu * p as f64 / width as f64, vv * q as f64 / (p + 1) as f64);
        let twist = (last[q] - last[0]) - (first[q] - first[0]);
        let diagonals = [last[q] - first[0], first[q] - last[0]].map(DVec4::truncate);
        let normal = diagonals[0].cross(diagonals[1]).normalize_or_zero().extend(0.0);
        Self { uu: normal.dot(uu), uv: normal.dot(twist), vv: normal.dot(vv) }
    }

    /// Estimates them from evenly spaced points of the surface, as many as a net of these degrees
    /// has.
    ///
    /// For a parabola, control points lie n : n - 1 times as far from its chord as points do.
    #[inline(always)]
    pub(crate) fn through(points: &[DVec4], (p, q): (usize, usize)) -> Self {
        let Self { uu, uv, vv } = Self::of(points, (p, q));
        let more = |n: usize| n as f64 / (n - 1) as f64;
        Self { uu: more(p) * uu, uv, vv: more(q) * vv }
    }

    /// Estimates the largest distance between the surface and two triangles over the unit square.
    #[inline(always)]
    pub(crate) fn sag_of_square(&self) -> f64 {
        let diagonal = self.sag(DVec2::ONE).min(self.sag(DVec2::new(1.0, -1.0)));
        diagonal.max(self.sag(DVec2::X)).max(self.sag(DVec2::Y))
    }

    /// Estimates the largest distance between the surface and the chord over this step in the unit
    /// square.
    #[inline(always)]
    pub(crate) fn sag(&self, step: DVec2) -> f64 {
        let Self { uu, uv, vv } = self;
        (uu * step.x * step.x + 2.0 * uv * step.x * step.y + vv * step.y * step.y).abs() / 8.0
    }
}

/// Projects a homogeneous point into space; the result is in the first three lanes.
#[inline(always)]
pub(crate) fn in_space(h: DVec4) -> DVec4 {
    (h.w.recip() * h.truncate()).extend(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_derivatives_of_a_paraboloid_are_exact() {
        let height = |x: f64, y: f64| 3.0 * x * (1.0 - x) - 0.5 * y * (1.0 - y);
        for (p, q) in [(2, 2), (3, 2), (2, 3), (3, 3)] {
            let places = (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j)));
            let places = places.map(|(i, j)| (i as f64 / p as f64, j as f64 / q as f64));
            let point = |(x, y)| DVec4::new(x, y, height(x, y), 0.0);
            let points: Vec<DVec4> = places.map(point).collect();
            let Bending { uu, uv, vv } = Bending::through(&points, (p, q));
            assert!((uu + 6.0).abs() < 1e-14 && uv == 0.0 && (vv - 1.0).abs() < 1e-14);
        }
    }
}
