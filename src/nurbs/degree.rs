//! Exact degree elevation, and degree reduction within a tolerance.

use glam::DVec4;

use super::banded::BandedMatrix;
use super::curve_family::CurveFamily;
use super::knot_multiset::difference;
use super::knot_vector::{KnotVector, MAX_DEGREE};
use super::work_blocks::collect_in_steps;
use crate::error::{Error, Result};
use crate::memory;
use crate::progress::InterruptCheck;

impl CurveFamily {
    /// Raises the degree by `times`; the result is clamped. Costs O(degree) refinements for each
    /// degree.
    pub(super) fn elevated(
        &self,
        times: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let degree = self.knots.degree().saturating_add(times);
        if degree > MAX_DEGREE {
            let must = format!("at most {MAX_DEGREE} after elevation");
            return Err(Error::parameter("degree", must, degree));
        }
        (0..times).try_fold(self.clamped(check_interrupt)?, |family, _| {
            family.elevated_once(check_interrupt)
        })
    }

    /// Raises the degree by 1; the multiplicity of each distinct knot grows by 1.
    ///
    /// A control point of degree p + 1 is the mean of p + 1 control points of degree p. Each of
    /// those belongs to the new knots without every (p + 1)-th one, a refinement of the old knots
    /// (H. Prautzsch, *Degree elevation of B-spline curves*, 1984). Knot insertion uses convex
    /// combinations only, so rounding errors do not grow.
    fn elevated_once(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let (p, (start, end)) = (self.knots.degree(), self.knots.domain());
        let breaks = self.knots.breaks();
        let inner = breaks[1..breaks.len() - 1].iter();
        let inner = inner.flat_map(|&v| std::iter::repeat_n(v, self.knots.multiplicity(v) + 1));
        let raised = KnotVector::clamped(p + 1, (start, end), inner)?;
        let rows = raised.control_points();
        memory::check_net(rows, self.width)?;
        let mut points = collect_in_steps((rows, self.width), check_interrupt, |rows| {
            std::iter::repeat_n(DVec4::ZERO, rows.len() * self.width)
        })?;
        let new = raised.as_slice();
        for omitted in 0..=p {
            let kept = |i: &usize| i % (p + 1) != omitted;
            let inside = p + 2..new.len() - p - 2;
            let kept_knots: Vec<f64> = inside.filter(kept).map(|i| new[i]).collect();
            let refined =
                self.refined(&difference(&kept_knots, self.knots.inner()), check_interrupt)?;
            // One of the knots i + 1 to i + p + 1 is omitted. The index of the last remaining one,
            // relative to the clamped start, is that of the control point.
            let mut source = 0;
            for (i, row) in points.chunks_mut(self.width).enumerate() {
                check_interrupt()?;
                if i > 0 && kept(&(i + p + 1)) {
                    source += 1;
                }
                for (sum, point) in row.iter_mut().zip(refined.row(source)) {
                    *sum += *point;
                }
            }
        }
        for row in points.chunks_mut(self.width) {
            check_interrupt()?;
            for point in row {
                *point /= (p + 1) as f64;
            }
        }
        Ok(Self { knots: raised, points, width: self.width })
    }

    /// Lowers the degree by `times`; the result is clamped. How far it is from the original is not
    /// limited.
    ///
    /// The control points are a least-squares fit with both ends fixed. The multiplicity of each
    /// inner knot decreases by 1, to at least 1.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree would be 0 or a weight would not stay positive.
    pub(super) fn reduced(
        &self,
        times: usize,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        let degree = self.knots.degree();
        if times >= degree {
            let must = format!("less than the degree, {degree}");
            return Err(Error::parameter("degree reduction", must, times));
        }
        let reduced = (0..times).try_fold(self.clamped(check_interrupt)?, |family, _| {
            family.reduced_once(check_interrupt)
        })?;
        let min_weight = reduced.points.iter().map(|point| point.w).fold(f64::INFINITY, f64::min);
        if min_weight <= 0.0 {
            let must = format!(
                "smaller: weights must stay positive, but one would become {min_weight:.2e} (insert \
                 knots first, or fit a surface of the lower degree)"
            );
            return Err(Error::parameter("degree reduction", must, times));
        }
        Ok(reduced)
    }

    fn reduced_once(&self, check_interrupt: &mut InterruptCheck<'_>) -> Result<Self> {
        let degree = self.knots.degree() - 1;
        let breaks = self.knots.breaks();
        let inner = breaks[1..breaks.len() - 1].iter();
        let inner = inner.flat_map(|&value| {
            std::iter::repeat_n(value, (self.knots.multiplicity(value) - 1).max(1))
        });
        let knots = KnotVector::clamped(degree, self.knots.domain(), inner)?;
        let count = knots.control_points();
        // The elevation matrix: curves with one coordinate 1 and all others 0, four to a vector.
        let width = count.div_ceil(4);
        memory::check_net(count, width)?;
        let mut elevation = vec![DVec4::ZERO; count * width];
        for i in 0..count {
            elevation[i * width + i / 4][i % 4] = 1.0;
        }
        let elevation = Self { knots: knots.clone(), points: elevation, width }
            .elevated_once(check_interrupt)?;
        let new = difference(elevation.knots.inner(), self.knots.inner());
        let target = self.refined(&new, check_interrupt)?;
        let coefficient = |row: usize, i: usize| elevation.row(row)[i / 4][i % 4];

        let half_bandwidth = (degree + 1).min(count - 1);
        let mut matrix = BandedMatrix::new(count, half_bandwidth);
        let mut points = vec![DVec4::ZERO; count * self.width];
        for (end, row) in [(0, 0), (count - 1, target.rows() - 1)] {
            matrix.add(end, end, 1.0);
            points[end * self.width..][..self.width].copy_from_slice(target.row(row));
        }
        for row in 0..target.rows() {
            check_interrupt()?;
            for i in (1..count - 1).filter(|&i| coefficient(row, i) != 0.0) {
                for j in i.saturating_sub(half_bandwidth)..count.min(i + half_bandwidth + 1) {
                    matrix.add(i, j, coefficient(row, i) * coefficient(row, j));
                }
                let sums = points[i * self.width..].iter_mut();
                for (sum, point) in sums.zip(target.row(row)) {
                    *sum += coefficient(row, i) * *point;
                }
            }
        }
        let solved = matrix.solve(&mut points, self.width, check_interrupt)?;
        assert!(solved, "elevation is injective, so its normal equations are regular");
        Ok(Self { knots, points, width: self.width })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_elevated_to_a_cubic_and_reduced_again() {
        let knots = KnotVector::clamped(2, (0.0, 1.0), []).unwrap();
        let points = [0.0, 3.0, 0.0].map(|y| DVec4::new(0.0, y, 0.0, 1.0)).to_vec();
        let cubic = CurveFamily { knots, points, width: 1 }.elevated(1, &mut || Ok(())).unwrap();
        let heights: Vec<f64> = cubic.points.iter().map(|point| point.y).collect();
        assert_eq!(heights, [0.0, 2.0, 2.0, 0.0]);
        let parabola = cubic.reduced(1, &mut || Ok(())).unwrap();
        assert!((parabola.points[1].y - 3.0).abs() < 1e-14);
        // Steeply changing weights have no positive weights of a lower degree.
        let weights = [1.0, 0.1, 0.1, 1.0].map(DVec4::splat).to_vec();
        let steep = CurveFamily { points: weights, ..cubic };
        let refused = steep.reduced(1, &mut || Ok(())).unwrap_err().to_string();
        assert!(refused.contains("weights must stay positive, but one would become -3.5"));
    }
}
