//! Knot removal within a tolerance.

use super::control_net::deviation;
use super::curve_family::Strip;
use super::knot_multiset::difference;
use super::knot_vector::KnotVector;
use crate::error::Result;
use crate::progress::Listen;

impl Strip {
    /// The same curves, within `tolerance`, with as few of these knots as that allows: the ones
    /// that are missed least go first. `None` stands for all inner knots.
    ///
    /// Each removal is judged by the whole way from the original, not by its own step: what is
    /// left is refined to the original knots again, and the distance of the control points, a
    /// bound of the distance of the curves, must hold the tolerance. O(knots² · rows · width).
    pub(super) fn simplified(
        &self,
        knots: Option<&[f64]>,
        tolerance: f64,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let original = self.clamped(listen)?;
        let mut candidates = knots.unwrap_or(original.knots.inner()).to_vec();
        candidates.retain(|value| original.knots.inner().contains(value));
        let mut moved = |strip: &Self| -> Result<f64> {
            listen()?;
            // Control points of a rational curve cannot lie at infinity, or beyond.
            if strip.points.iter().any(|point| point.w <= 0.0) {
                return Ok(f64::INFINITY);
            }
            let new = difference(original.knots.inner(), strip.knots.inner());
            Ok(deviation(&original.points, &strip.refined(&new, listen)?.points))
        };
        let cost = |&value: &f64| Ok((moved(&original.without(value)?)?, value));
        let mut costs = candidates.iter().map(cost).collect::<Result<Vec<_>>>()?;
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut strip = original.clone();
        for (_, value) in costs.into_iter().take_while(|(cost, _)| *cost <= tolerance) {
            if !strip.knots.inner().contains(&value) {
                continue;
            }
            let trial = strip.without(value)?;
            if moved(&trial)? <= tolerance {
                strip = trial;
            }
        }
        Ok(strip)
    }

    /// One of the knots of this value less (The NURBS Book, A5.8): the control points that its
    /// insertion mixed are found again from both sides, always from the one that divides by more,
    /// so that rounding grows little even for a knot near the domain's end.
    fn without(&self, value: f64) -> Result<Self> {
        let (p, width, t) = (self.knots.degree(), self.width, self.knots.as_slice());
        let times = self.knots.multiplicity(value);
        let at = self.knots.span(value);
        let share = |i: usize| (value - t[i]) / (t[i + p + 1] - t[i]);
        let mut points = self.points.clone();
        // Row i becomes what was mixed with row `known` to give it, by this share.
        let mut unmix = |i: usize, known: usize, share: f64| {
            for c in 0..width {
                let known = points[known * width + c];
                points[i * width + c] = (points[i * width + c] - (1.0 - share) * known) / share;
            }
        };
        let (mut i, mut j) = (at - p, at - times);
        while i < j {
            let (from_left, from_right) = (share(i), 1.0 - share(j));
            if from_left >= from_right {
                unmix(i, i - 1, from_left);
                i += 1;
            } else {
                unmix(j, j + 1, from_right);
                j -= 1;
            }
        }
        // One row more than is needed is left: the one where both sides meet.
        points.drain(i * width..(i + 1) * width);
        let mut knots = t.to_vec();
        knots.remove(at);
        Ok(Self { knots: KnotVector::new(p, knots)?, points, width })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;

    use super::*;

    #[test]
    fn what_was_inserted_is_removed_and_a_corner_stays() {
        let knots = KnotVector::clamped(3, (0.0, 1.0), [0.3, 0.6]).unwrap();
        let heights = [0.0, 1.0, -1.0, 2.0, 0.5, 0.0];
        let points = heights.map(|y| DVec4::new(y * y, y, 1.0, 1.0)).to_vec();
        let strip = Strip { knots, points, width: 1 };
        let refined = strip.refined(&[0.1, 0.3, 0.3, 0.45], &mut || Ok(())).unwrap();
        let back = refined.simplified(None, 1e-12, &mut || Ok(())).unwrap();
        assert_eq!(back.knots, strip.knots);
        assert!(deviation(&strip.points, &back.points) < 1e-14);
        let only = refined.simplified(Some(&[0.1]), 1e-12, &mut || Ok(())).unwrap();
        assert_eq!(only.knots.inner(), [0.3, 0.3, 0.3, 0.45, 0.6]);
        let weights = [1.0, 0.1, 5.0, 0.1, 1.0, 2.0];
        let rational = strip.points.iter().zip(weights).map(|(point, w)| w * *point).collect();
        let rational = Strip { points: rational, ..strip.clone() };
        let fewer = rational.simplified(None, 1e3, &mut || Ok(())).unwrap();
        assert!(fewer.points.iter().all(|point| point.w > 0.0));
        // With enough tolerance everything goes.
        let all = refined.simplified(None, 1e3, &mut || Ok(())).unwrap();
        assert!(all.knots.inner().is_empty());
    }
}
