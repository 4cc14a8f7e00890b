//! Least-squares approximation of a grid of points by a B-spline surface (The NURBS Book, section
//! 9.4).

use glam::{DVec3, DVec4};

use super::banded::{BandedMatrix, CyclicBandedMatrix};
use super::basis::{MAX_ORDER, padded};
use super::curve_family::CurveFamily;
use super::interpolate::{MAX_STABLE_DEGREE, by_directions, check_counts, singular, wrapped_rows};
use super::knot_vector::KnotVector;
use super::parametrization::GridOptions;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::{InterruptCheck, Observer};

impl NurbsSurface {
    /// Approximates a grid of points by a surface with a smaller net, by least squares first in u
    /// and then in v.
    ///
    /// The knots follow the density of the points (The NURBS Book, section 9.4.1). In closed
    /// directions `net` is the number of distinct control points.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{GridOptions, NurbsSurface}, progress::Silent};
    /// let grid: Vec<DVec3> = (0..400)
    ///     .map(|i| (f64::from(i / 20) / 19.0, f64::from(i % 20) / 19.0))
    ///     .map(|(x, y)| DVec3::new(x, y, x * y))
    ///     .collect();
    /// let options = GridOptions::default();
    /// let near = NurbsSurface::approximate(&grid, (20, 20), (6, 5), &options, &mut Silent)?;
    /// assert_eq!(near.shape(), (6, 5));
    /// assert!(near.point(0.5, 0.5).distance(DVec3::new(0.5, 0.5, 0.25)) < 1e-3);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - Those of [`NurbsSurface::grid_parameters`].
    /// - [`Error::Parameter`](crate::Error::Parameter) if a side of the net has at most `degree`
    ///   control points or more control points than the grid has points.
    /// - [`Error::Parameter`](crate::Error::Parameter) if rounding would change control points by
    ///   1e-6 of their size. The normal equations square the condition of the basis, which grows
    ///   exponentially with the degree, so this begins at degrees of about 18.
    /// - [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn approximate(
        grid: &[DVec3],
        shape: (usize, usize),
        net: (usize, usize),
        options: &GridOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let GridOptions { degree, closed, .. } = *options;
        let sides = [(net.0, degree.0, closed.0), (net.1, degree.1, closed.1)];
        by_directions(
            grid,
            shape,
            options,
            observer,
            |d, points, width, parameters, check_interrupt| {
                approximate_family(&points, width, parameters, sides[d], check_interrupt)
            },
        )
    }
}

/// Approximates rows of points at these parameters by splines with `count` distinct control points.
fn approximate_family(
    points: &[DVec4],
    width: usize,
    parameters: &[f64],
    (count, degree, closed): (usize, usize, bool),
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<CurveFamily> {
    check_counts(degree, count, parameters.len())?;
    // Interpolates the parameters linearly at a fractional index.
    let place = |at: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to count")]
        let (i, share) = (at as usize, at.fract());
        let next = parameters.get(i + 1).copied().unwrap_or(1.0);
        parameters[i] + share * (next - parameters[i])
    };
    let per_span = |spans: usize| parameters.len() as f64 / spans as f64;
    let knots = if closed {
        let inner = (1..count).map(|j| place(j as f64 * per_span(count)));
        let breaks: Vec<f64> = [0.0].into_iter().chain(inner).chain([1.0]).collect();
        KnotVector::periodic(degree, &breaks)?
    } else {
        let spans = count - degree;
        let inner = (1..spans).map(|j| place(j as f64 * per_span(spans) - 1.0));
        KnotVector::clamped(degree, (0.0, 1.0), inner)?
    };
    let mut sums = vec![DVec4::ZERO; count * width];
    let mut entries = Vec::with_capacity(parameters.len() * (degree + 1) * (degree + 1));
    for (row, parameter) in points.chunks(width).zip(parameters) {
        check_interrupt()?;
        let basis = padded::<MAX_ORDER>(&knots, *parameter);
        for k in 0..=degree {
            let (i, value) = ((basis.first + k) % count, basis.values[k]);
            for (sum, point) in sums[i * width..][..width].iter_mut().zip(row) {
                *sum += value * *point;
            }
            let other = (0..=degree).map(|l| (i, basis.first + l, value * basis.values[l]));
            entries.extend(other);
        }
    }
    let solved = if closed {
        let mut matrix = CyclicBandedMatrix::new(count, degree);
        for (i, j, value) in entries {
            matrix.add(i, j, value);
        }
        matrix.solve(&mut sums, width, check_interrupt)?
    } else {
        let mut matrix = BandedMatrix::new(count, degree.min(count - 1));
        for (i, j, value) in entries {
            matrix.add(i, j, value);
        }
        matrix.solve(&mut sums, width, check_interrupt)?
    };
    if !solved {
        return Err(singular(degree));
    }
    if degree > MAX_STABLE_DEGREE {
        check_rounding(&mut sums, degree)?;
    }
    let points =
        if closed { wrapped_rows(&sums, width, degree, 0, check_interrupt)? } else { sums };
    Ok(CurveFamily { knots, points, width })
}

/// Largest relative rounding error of control points of high degree.
const MAX_ROUNDING: f64 = 1e-6;

/// Checks that rounding has not spoiled a solution, and corrects its weights.
///
/// All points have weight 1, so those of an exact solution are 1, too.
fn check_rounding(solution: &mut [DVec4], degree: usize) -> Result<()> {
    let error = solution.iter().map(|point| (point.w - 1.0).abs()).fold(0.0, f64::max);
    if error > MAX_ROUNDING {
        let must = format!(
            "lower: rounding would change control points by {error:.0e} of their size, at most \
             {MAX_ROUNDING:.0e} is allowed"
        );
        return Err(Error::parameter("degree", must, degree));
    }
    for point in solution {
        point.w = 1.0;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::interpolate::tests::grid;
    use super::*;
    use crate::nurbs::Parametrization;
    use crate::progress::Silent;

    #[test]
    fn approximation_reproduces_a_cubic_and_closed_directions() {
        for closed in [(false, false), (true, true)] {
            let options = GridOptions {
                parametrization: Parametrization::Uniform,
                closed,
                ..GridOptions::default()
            };
            let near =
                NurbsSurface::approximate(&grid(60, 60), (60, 60), (30, 30), &options, &mut Silent);
            let same =
                NurbsSurface::approximate(&grid(40, 40), (40, 40), (40, 40), &options, &mut Silent);
            assert_eq!((near.unwrap().closed(), same.unwrap().closed()), (closed, closed));
        }
        // Every net reproduces a bicubic polynomial.
        let options =
            GridOptions { parametrization: Parametrization::Uniform, ..GridOptions::default() };
        let height = |x: f64, y: f64| 1.0 + x * y * y - x * x * x;
        let cubic: Vec<DVec3> = (0..900)
            .map(|k| (f64::from(k / 30) / 29.0, f64::from(k % 30) / 29.0))
            .map(|(x, y)| DVec3::new(x, y, height(x, y)))
            .collect();
        let surface =
            NurbsSurface::approximate(&cubic, (30, 30), (7, 5), &options, &mut Silent).unwrap();
        assert_eq!(surface.shape(), (7, 5));
        let p = surface.point(0.37, 0.81);
        assert!(p.distance(DVec3::new(0.37, 0.81, height(0.37, 0.81))) < 1e-13);
    }

    #[test]
    fn degrees_that_rounding_would_spoil_are_refused() {
        let approximate = |degree: usize| {
            let options = GridOptions { degree: (degree, degree), ..GridOptions::default() };
            let net = (degree + 2, degree + 2);
            NurbsSurface::approximate(&grid(60, 60), (60, 60), net, &options, &mut Silent)
        };
        assert!(approximate(12).is_ok());
        let refused = approximate(25).unwrap_err().to_string();
        assert!(refused.starts_with("degree must be lower: rounding"), "{refused}");
    }
}
