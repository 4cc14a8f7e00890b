//! The length and the sag of curves, by their control points.

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec4;

use super::lanes::larger;

/// The largest chord length and the largest sag of some curves, squared.
#[derive(Default)]
pub(super) struct CurveExtent {
    /// The largest squared length of a chord.
    pub length_squared: f64,
    /// The largest squared distance of a control point from the line of its curve's chord.
    pub sag_squared: f64,
}

impl CurveExtent {
    /// Includes the curve whose control points start at `start` and are `stride` apart.
    #[inline(always)]
    pub(super) fn add(&mut self, points: &[DVec4], (start, stride): (usize, usize), degree: usize) {
        let a = points[start];
        let chord = points[start + degree * stride] - a;
        let length = chord.length_squared();
        let along = chord / length.sqrt().max(f64::MIN_POSITIVE);
        self.length_squared = self.length_squared.max(length);
        for k in 1..degree {
            let away = points[start + k * stride] - a;
            let sag = (away - away.dot(along) * along).length_squared();
            self.sag_squared = larger(self.sag_squared, sag);
        }
    }
}
