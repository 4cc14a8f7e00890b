//! Degree elevation, exact, and degree reduction within a tolerance.

use glam::DVec4;

use super::banded::Banded;
use super::control_net::deviation;
use super::curve_family::Strip;
use super::knot_multiset::difference;
use super::knot_vector::{KnotVector, MAX_DEGREE};
use super::work_blocks::in_steps;
use crate::error::{Error, Result};
use crate::progress::Listen;

impl Strip {
    /// The same curves with a degree higher by `times`, clamped; O(degree) refinements each.
    pub(super) fn elevated(&self, times: usize, listen: &mut Listen<'_>) -> Result<Self> {
        let degree = self.knots.degree().saturating_add(times);
        if degree > MAX_DEGREE {
            let must = format!("at most {MAX_DEGREE} after elevation");
            return Err(Error::parameter("degree", must, degree));
        }
        (0..times).try_fold(self.clamped(listen)?, |strip, _| strip.elevated_once(listen))
    }

    /// Every distinct knot stands once more. A control point of degree p + 1 is the mean of p + 1
    /// control points of degree p, each over the new knots without every (p + 1)-th of them, which
    /// are refinements of the old ones (H. Prautzsch, *Degree elevation of B-spline curves*, 1984).
    /// So all is done by knot insertion, whose mixtures are convex: rounding does not grow.
    fn elevated_once(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let (p, (start, end)) = (self.knots.degree(), self.knots.domain());
        let breaks = self.knots.breaks();
        let inner = breaks[1..breaks.len() - 1].iter();
        let inner = inner.flat_map(|&v| std::iter::repeat_n(v, self.knots.multiplicity(v) + 1));
        let raised = KnotVector::clamped(p + 1, (start, end), inner)?;
        let rows = raised.control_points();
        let mut points = in_steps((rows, self.width), listen, |rows| {
            std::iter::repeat_n(DVec4::ZERO, rows.len() * self.width)
        })?;
        let new = raised.as_slice();
        for left_out in 0..=p {
            let kept = |i: &usize| i % (p + 1) != left_out;
            let inside = p + 2..new.len() - p - 2;
            let wanted: Vec<f64> = inside.filter(kept).map(|i| new[i]).collect();
            let part = self.refined(&difference(&wanted, self.knots.inner()), listen)?;
            // Of the knots i + 1 to i + p + 1 one is left out; the last of the others names the
            // control point, by its number behind the clamped start.
            let mut source = 0;
            for (i, row) in points.chunks_mut(self.width).enumerate() {
                listen()?;
                if i > 0 && kept(&(i + p + 1)) {
                    source += 1;
                }
                for (sum, point) in row.iter_mut().zip(part.row(source)) {
                    *sum += *point;
                }
            }
        }
        for row in points.chunks_mut(self.width) {
            listen()?;
            for point in row {
                *point /= (p + 1) as f64;
            }
        }
        Ok(Self { knots: raised, points, width: self.width })
    }

    /// Curves with a degree lower by `times`, clamped, that stay within `tolerance` of these: by
    /// least squares on the control points, with both ends where they were. Knots lose one of
    /// their repetitions, as far as they have one.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if the degree would be 0, a weight would not stay positive, or the
    /// tolerance cannot be held.
    pub(super) fn reduced(
        &self,
        times: usize,
        tolerance: f64,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        let degree = self.knots.degree();
        if times >= degree {
            let must = format!("less than the degree, {degree}");
            return Err(Error::parameter("degrees to take away", must, times));
        }
        let original = self.clamped(listen)?;
        let reduced =
            (0..times).try_fold(original.copied(listen)?, |strip, _| strip.reduced_once(listen))?;
        let least = reduced.points.iter().map(|point| point.w).fold(f64::INFINITY, f64::min);
        if least <= 0.0 {
            let must = format!(
                "fewer, as weights must stay positive and one would become {least:.2e} (insert \
                 knots first, or fit a surface of the lower degree)"
            );
            return Err(Error::parameter("degrees to take away", must, times));
        }
        let back = reduced.elevated(times, listen)?;
        let new = difference(back.knots.inner(), original.knots.inner());
        let original = original.refined(&new, listen)?;
        let moved = deviation(&original.points, &back.points);
        // Not `>`: NaN holds no tolerance.
        if moved <= tolerance {
            return Ok(reduced);
        }
        let must = format!("at least {moved:e} for this reduction of the degree");
        Err(Error::parameter("tolerance", must, tolerance))
    }

    fn reduced_once(&self, listen: &mut Listen<'_>) -> Result<Self> {
        let degree = self.knots.degree() - 1;
        let breaks = self.knots.breaks();
        let inner = breaks[1..breaks.len() - 1].iter();
        let inner = inner.flat_map(|&value| {
            std::iter::repeat_n(value, (self.knots.multiplicity(value) - 1).max(1))
        });
        let knots = KnotVector::clamped(degree, self.knots.domain(), inner)?;
        let count = knots.control_points();
        // What each control point of the lower degree contributes to those of the higher: curves
        // with one coordinate 1 and all others 0, four to a vector.
        let width = count.div_ceil(4);
        let mut units = vec![DVec4::ZERO; count * width];
        for i in 0..count {
            units[i * width + i / 4][i % 4] = 1.0;
        }
        let units = Self { knots: knots.clone(), points: units, width }.elevated_once(listen)?;
        let new = difference(units.knots.inner(), self.knots.inner());
        let target = self.refined(&new, listen)?;
        let share = |row: usize, i: usize| units.row(row)[i / 4][i % 4];

        let reach = (degree + 1).min(count - 1);
        let mut matrix = Banded::new(count, reach);
        let mut points = vec![DVec4::ZERO; count * self.width];
        for (end, row) in [(0, 0), (count - 1, target.rows() - 1)] {
            matrix.add(end, end, 1.0);
            points[end * self.width..][..self.width].copy_from_slice(target.row(row));
        }
        for row in 0..target.rows() {
            listen()?;
            for i in (1..count - 1).filter(|&i| share(row, i) != 0.0) {
                for j in i.saturating_sub(reach)..count.min(i + reach + 1) {
                    matrix.add(i, j, share(row, i) * share(row, j));
                }
                let sums = points[i * self.width..].iter_mut();
                for (sum, point) in sums.zip(target.row(row)) {
                    *sum += share(row, i) * *point;
                }
            }
        }
        let solved = matrix.solve(&mut points, self.width, listen)?;
        assert!(solved, "elevation loses nothing, so its normal equations are regular");
        Ok(Self { knots, points, width: self.width })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_a_cubic_with_known_control_points() {
        let knots = KnotVector::clamped(2, (0.0, 1.0), []).unwrap();
        let points = [0.0, 3.0, 0.0].map(|y| DVec4::new(0.0, y, 0.0, 1.0)).to_vec();
        let cubic = Strip { knots, points, width: 1 }.elevated(1, &mut || Ok(())).unwrap();
        let heights: Vec<f64> = cubic.points.iter().map(|point| point.y).collect();
        assert_eq!(heights, [0.0, 2.0, 2.0, 0.0]);
        let parabola = cubic.reduced(1, 1e-12, &mut || Ok(())).unwrap();
        assert!((parabola.points[1].y - 3.0).abs() < 1e-14);
        // Weights that fall and rise steeply have no positive ones of a lower degree.
        let weights = [1.0, 0.1, 0.1, 1.0].map(DVec4::splat).to_vec();
        let steep = Strip { points: weights, ..cubic };
        let refused = steep.reduced(1, 1e3, &mut || Ok(())).unwrap_err().to_string();
        assert!(refused.contains("weights must stay positive and one would become -3.5"));
        let refused = parabola.reduced(1, 0.1, &mut || Ok(())).unwrap_err();
        assert!(refused.to_string().starts_with("tolerance must"));
    }
}
