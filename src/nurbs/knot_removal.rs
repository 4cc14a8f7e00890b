//! Knot removal within a tolerance.

use super::control_net::distance_bound;
use super::curve_family::CurveFamily;
use super::knot_multiset::difference;
use super::knot_vector::KnotVector;
use crate::error::Result;
use crate::progress::InterruptCheck;

impl CurveFamily {
    /// Removes as many of these knots (`None`: of all inner knots) as `tolerance` allows. Knots
    /// whose removal causes the smallest error go first.
    ///
    /// The error is measured against the original curves, not against the previous step. The result
    /// is refined to the original knots again, and the distance of the control points bounds the
    /// distance of the curves. Costs O(knots² · rows · width).
    pub(super) fn with_knots_removed(
        &self,
        knots: Option<&[f64]>,
        tolerance: f64,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let original = self.clamped(check_interrupt)?;
        let mut candidates = knots.unwrap_or(original.knots.inner()).to_vec();
        candidates.retain(|value| original.knots.inner().contains(value));
        let mut error = |family: &Self| -> Result<f64> {
            check_interrupt()?;
            // Control points of a rational curve must have positive weights.
            if family.points.iter().any(|point| point.w <= 0.0) {
                return Ok(f64::INFINITY);
            }
            let new = difference(original.knots.inner(), family.knots.inner());
            Ok(distance_bound(&original.points, &family.refined(&new, check_interrupt)?.points))
        };
        let cost = |&value: &f64| Ok((error(&original.without_knot(value)?)?, value));
        let mut costs = candidates.iter().map(cost).collect::<Result<Vec<_>>>()?;
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut family = original.clone();
        for (_, value) in costs.into_iter().take_while(|(cost, _)| *cost <= tolerance) {
            if !family.knots.inner().contains(&value) {
                continue;
            }
            let trial = family.without_knot(value)?;
            if error(&trial)? <= tolerance {
                family = trial;
            }
        }
        Ok(family)
    }

    /// Removes one knot of this value (The NURBS Book, A5.8).
    ///
    /// The control points before its insertion are computed from both sides, always from the side
    /// with the larger divisor. So rounding errors grow little even for a knot near the end of the
    /// domain.
    fn without_knot(&self, value: f64) -> Result<Self> {
        let (p, width, t) = (self.knots.degree(), self.width, self.knots.as_slice());
        let times = self.knots.multiplicity(value);
        let at = self.knots.span(value);
        let share = |i: usize| (value - t[i]) / (t[i + p + 1] - t[i]);
        let mut points = self.points.clone();
        // Solves row i = share · x + (1 - share) · row `known` for x.
        let mut solve_row = |i: usize, known: usize, share: f64| {
            for c in 0..width {
                let known = points[known * width + c];
                points[i * width + c] = (points[i * width + c] - (1.0 - share) * known) / share;
            }
        };
        let (mut i, mut j) = (at - p, at - times);
        while i < j {
            let (from_left, from_right) = (share(i), 1.0 - share(j));
            if from_left >= from_right {
                solve_row(i, i - 1, from_left);
                i += 1;
            } else {
                solve_row(j, j + 1, from_right);
                j -= 1;
            }
        }
        // Both sides compute the row where they meet; one copy is removed.
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
    fn inserted_knots_are_removed_and_required_knots_stay() {
        let knots = KnotVector::clamped(3, (0.0, 1.0), [0.3, 0.6]).unwrap();
        let heights = [0.0, 1.0, -1.0, 2.0, 0.5, 0.0];
        let points = heights.map(|y| DVec4::new(y * y, y, 1.0, 1.0)).to_vec();
        let family = CurveFamily { knots, points, width: 1 };
        let refined = family.refined(&[0.1, 0.3, 0.3, 0.45], &mut || Ok(())).unwrap();
        let back = refined.with_knots_removed(None, 1e-12, &mut || Ok(())).unwrap();
        assert_eq!(back.knots, family.knots);
        assert!(distance_bound(&family.points, &back.points) < 1e-14);
        let only = refined.with_knots_removed(Some(&[0.1]), 1e-12, &mut || Ok(())).unwrap();
        assert_eq!(only.knots.inner(), [0.3, 0.3, 0.3, 0.45, 0.6]);
        let weights = [1.0, 0.1, 5.0, 0.1, 1.0, 2.0];
        let rational = family.points.iter().zip(weights).map(|(point, w)| w * *point).collect();
        let rational = CurveFamily { points: rational, ..family.clone() };
        let fewer = rational.with_knots_removed(None, 1e3, &mut || Ok(())).unwrap();
        assert!(fewer.points.iter().all(|point| point.w > 0.0));
        // A large tolerance removes all knots.
        let all = refined.with_knots_removed(None, 1e3, &mut || Ok(())).unwrap();
        assert!(all.knots.inner().is_empty());
    }
}
