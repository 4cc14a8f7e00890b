//! Surfaces that come closest to a grid of points.

use glam::{DVec3, DVec4};

use super::banded::{Banded, Cyclic};
use super::basis::padded;
use super::curve_family::Strip;
use super::interpolate::{by_strips, check_counts, singular, wrapped};
use super::knot_vector::KnotVector;
use super::parametrization::GridOptions;
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::progress::{Listen, Observer};

impl NurbsSurface {
    /// The surface with a smaller net that comes closest to a grid of points, in the sense of least
    /// squares in u and then in v. Knots follow the density of the points (The NURBS Book, section
    /// 9.4.1). In closed directions `net` counts the different control points.
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
    /// Those of [`NurbsSurface::grid_parameters`], and
    /// [`Error::Parameter`](crate::Error::Parameter) if a side of the net has not more control points
    /// than the degree, or more than the grid has points;
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn approximate(
        grid: &[DVec3],
        shape: (usize, usize),
        net: (usize, usize),
        options: &GridOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let GridOptions { degree, closed, .. } = *options;
        let sides = [(net.0, degree.0, closed.0), (net.1, degree.1, closed.1)];
        by_strips(grid, shape, options, observer, |d, points, width, sites, listen| {
            approximate_strip(&points, width, sites, sides[d], listen)
        })
    }
}

/// Splines with `count` different control points nearest to rows of points at these parameters.
fn approximate_strip(
    points: &[DVec4],
    width: usize,
    sites: &[f64],
    (count, degree, closed): (usize, usize, bool),
    listen: &mut Listen<'_>,
) -> Result<Strip> {
    check_counts(degree, count, sites.len())?;
    // The parameter at a fractional place among the sites.
    let place = |at: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to count")]
        let (i, share) = (at as usize, at.fract());
        let next = sites.get(i + 1).copied().unwrap_or(1.0);
        sites[i] + share * (next - sites[i])
    };
    let per_span = |spans: usize| sites.len() as f64 / spans as f64;
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
    let mut entries = Vec::with_capacity(sites.len() * (degree + 1) * (degree + 1));
    for (row, site) in points.chunks(width).zip(sites) {
        listen()?;
        let basis = padded(&knots, *site);
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
        let mut matrix = Cyclic::new(count, degree);
        for (i, j, value) in entries {
            matrix.add(i, j, value);
        }
        matrix.solve(&mut sums, width, listen)?
    } else {
        let mut matrix = Banded::new(count, degree.min(count - 1));
        for (i, j, value) in entries {
            matrix.add(i, j, value);
        }
        matrix.solve(&mut sums, width, listen)?
    };
    if !solved {
        return Err(singular(degree));
    }
    let points = if closed { wrapped(&sums, width, degree, 0, listen)? } else { sums };
    Ok(Strip { knots, points, width })
}

#[cfg(test)]
mod tests {
    use super::super::interpolate::tests::grid;
    use super::*;
    use crate::nurbs::Parametrization;
    use crate::progress::Silent;

    #[test]
    fn approximation_finds_a_surface_that_is_there() {
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
        // A bicubic polynomial is met by any net.
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
}
