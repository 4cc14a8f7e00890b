//! Control points of parts of Bézier curves and patches (de Casteljau's algorithm).

#![expect(clippy::inline_always, reason = "must be inlined into the SIMD-dispatched function")]

use glam::DVec4;

use crate::nurbs::halve;

/// Replaces the control points of a curve by those of its part over the interval `(from, to)`.
///
/// The points of the curve start at `start` and are `stride` apart.
#[inline(always)]
pub(super) fn restrict(
    of: &mut [DVec4],
    (start, stride): (usize, usize),
    degree: usize,
    (from, to): (f64, f64),
) {
    if from != 0.0 {
        for level in 1..=degree {
            for k in 0..=degree - level {
                let at = start + k * stride;
                of[at] = (1.0 - from) * of[at] + from * of[at + stride];
            }
        }
    }
    if to != 1.0 {
        let share = (to - from) / (1.0 - from);
        for level in 1..=degree {
            for k in (level..=degree).rev() {
                let at = start + k * stride;
                of[at] = (1.0 - share) * of[at - stride] + share * of[at];
            }
        }
    }
}

/// Replaces the control points of a curve by those of both its halves, which lie closer to it.
#[inline(always)]
pub(super) fn split_curve(curve: &mut Vec<DVec4>) {
    let count = curve.len();
    curve.extend_from_within(..);
    let (first, second) = curve.split_at_mut(count);
    halve(first, second, count - 1, 1, 0..1);
}

/// Replaces `out` by the control points of the four quarters of a patch of degrees p and q.
#[inline(always)]
pub(super) fn quarters(net: &[DVec4], (p, q): (usize, usize), out: &mut Vec<DVec4>) {
    out.clear();
    (0..4).for_each(|_| out.extend_from_slice(net));
    let size = net.len();
    let (first, second) = out.split_at_mut(2 * size);
    halve(&mut first[..size], &mut second[..size], p, q + 1, 0..=q);
    for half in [first, second] {
        half.copy_within(..size, size);
        let (first, second) = half.split_at_mut(size);
        halve(first, second, q, 1, (0..=p).map(|row| row * (q + 1)));
    }
}
