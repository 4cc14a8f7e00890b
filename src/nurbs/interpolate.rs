//! Surfaces and curves through ordered points.

use glam::{DVec3, DVec4};

use super::banded::{Banded, Cyclic};
use super::basis::padded;
use super::curve::NurbsCurve;
use super::curve_family::Strip;
use super::direction::turned;
use super::knot_vector::KnotVector;
use super::parametrization::{GridOptions, Parametrization, Sites, check_points, shifted, sites};
use super::surface::NurbsSurface;
use super::work_blocks::{in_steps, listening, steps};
use crate::error::{Error, Result};
use crate::progress::{Listen, Observer};

impl NurbsSurface {
    /// The surface through a grid of points, row by row, v fastest, with as many control points as
    /// there are points (The NURBS Book, A9.4): banded systems, O(points · degree).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{GridOptions, NurbsSurface}, progress::Silent};
    /// let grid: Vec<DVec3> = (0..42)
    ///     .map(|i| DVec3::new(f64::from(i / 7), f64::from(i % 7), f64::from(i * i % 5)))
    ///     .collect();
    /// let options = GridOptions::default();
    /// let surface = NurbsSurface::interpolate(&grid, (6, 7), &options, &mut Silent)?;
    /// let (u, v) = NurbsSurface::grid_parameters(&grid, (6, 7), &options, &mut Silent)?;
    /// assert!(surface.point(u[2], v[5]).distance(grid[2 * 7 + 5]) < 1e-13);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::grid_parameters`], and [`Error::Parameter`] if there are not more
    /// rows or columns than the degree.
    pub fn interpolate(
        grid: &[DVec3],
        shape: (usize, usize),
        options: &GridOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let GridOptions { degree, closed, .. } = *options;
        let (degree, closed) = ([degree.0, degree.1], [closed.0, closed.1]);
        by_strips(grid, shape, options, observer, |d, points, width, sites, listen| {
            interpolate_strip(points, width, sites, degree[d], closed[d], listen)
        })
    }
}

/// The surface that `strip` makes of the columns of a grid, and then of the rows of what comes out:
/// it is given the direction, 0 or 1, the points of the curves, how many these are, and their
/// parameters.
pub(super) fn by_strips(
    grid: &[DVec3],
    shape: (usize, usize),
    options: &GridOptions,
    observer: &mut dyn Observer,
    strip: impl Fn(usize, Vec<DVec4>, usize, &[f64], &mut Listen<'_>) -> Result<Strip>,
) -> Result<NurbsSurface> {
    let listen = &mut listening(observer);
    let Sites { u, v } = Sites::new(grid, shape, options, listen)?;
    let points = homogeneous(grid, listen)?;
    let along = strip(0, points, shape.1, &u, listen)?;
    let (rows, knots_u) = (along.rows(), along.knots.clone());
    let across = turned(along, listen)?;
    let across = strip(1, across, rows, &v, listen)?;
    let knots = [knots_u, across.knots.clone()];
    NurbsSurface::from_homogeneous(turned(across, listen)?, false, knots, listen)
}

/// Points of weight 1.
fn homogeneous(points: &[DVec3], listen: &mut Listen<'_>) -> Result<Vec<DVec4>> {
    in_steps((points.len(), 1), listen, |part| points[part].iter().map(|point| point.extend(1.0)))
}

impl NurbsCurve {
    /// The curve through points, in their order (The NURBS Book, A9.1).
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{NurbsCurve, Parametrization}, progress::Silent};
    /// let points = [DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::X, DVec3::new(3.0, 1.0, 0.0)];
    /// let chord = Parametrization::ChordLength;
    /// let curve = NurbsCurve::interpolate(&points, 3, chord, false, &mut Silent)?;
    /// assert!(curve.point(1.0).distance(points[3]) < 1e-14);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if there are not more points than the degree, or neighbours coincide;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn interpolate(
        points: &[DVec3],
        degree: usize,
        parametrization: Parametrization,
        closed: bool,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let listen = &mut listening(observer);
        check_points("points", points, listen)?;
        check_counts(degree, points.len(), points.len())?;
        let sites = sites("points", points, 1, parametrization, closed, listen)?;
        let sites = shifted(sites, degree, closed);
        let points = homogeneous(points, listen)?;
        let strip = interpolate_strip(points, 1, &sites, degree, closed, listen)?;
        Self::from_homogeneous(strip.points, false, strip.knots, listen)
    }
}

/// Splines through rows of points at these parameters.
pub(super) fn interpolate_strip(
    mut points: Vec<DVec4>,
    width: usize,
    sites: &[f64],
    degree: usize,
    closed: bool,
    listen: &mut Listen<'_>,
) -> Result<Strip> {
    let count = sites.len();
    check_counts(degree, count, count)?;
    let mean = |sites: &[f64]| sites.iter().sum::<f64>() / sites.len() as f64;
    let (solved, knots) = if closed {
        let knots = if degree % 2 == 1 {
            KnotVector::periodic(degree, &[sites, &[1.0]].concat())?
        } else {
            let between = sites.windows(2).map(mean);
            let breaks: Vec<f64> = [0.0].into_iter().chain(between).chain([1.0]).collect();
            KnotVector::periodic(degree, &breaks)?
        };
        // The largest function at each parameter comes to the diagonal.
        let shift = degree / 2;
        let mut matrix = Cyclic::new(count, degree);
        collocate(&knots, sites, listen, |i, j, value| matrix.add(i, j + count - shift, value))?;
        let solved = matrix.solve(&mut points, width, listen)?;
        points = wrapped(&points, width, degree, count - shift, listen)?;
        (solved, knots)
    } else {
        let inner = (1..count - degree).map(|j| mean(&sites[j..j + degree]));
        let knots = KnotVector::clamped(degree, (0.0, 1.0), inner)?;
        let mut matrix = Banded::new(count, degree.min(count - 1));
        collocate(&knots, sites, listen, |i, j, value| matrix.add(i, j, value))?;
        (matrix.solve(&mut points, width, listen)?, knots)
    };
    if solved { Ok(Strip { knots, points, width }) } else { Err(singular(degree)) }
}

/// Hands over each parameter's basis functions that are not zero: its number, that of the function,
/// and the value.
fn collocate(
    knots: &KnotVector,
    sites: &[f64],
    listen: &mut Listen<'_>,
    mut add: impl FnMut(usize, usize, f64),
) -> Result<()> {
    for range in steps(sites.len(), 1) {
        listen()?;
        for i in range {
            let basis = padded(knots, sites[i]);
            let functions = basis.values[..=knots.degree()].iter().enumerate();
            for (k, value) in functions.filter(|(_, value)| **value != 0.0) {
                add(i, basis.first + k, *value);
            }
        }
    }
    Ok(())
}

/// The rows from `start` on, once round and `degree` more.
pub(super) fn wrapped(
    points: &[DVec4],
    width: usize,
    degree: usize,
    start: usize,
    listen: &mut Listen<'_>,
) -> Result<Vec<DVec4>> {
    let count = points.len() / width;
    let row = |i: usize| &points[(i + start) % count * width..][..width];
    in_steps((count + degree, width), listen, |rows| rows.flat_map(row).copied())
}

pub(super) fn check_counts(degree: usize, control_points: usize, points: usize) -> Result<()> {
    if control_points <= degree {
        let must = format!("more than the degree, {degree}");
        return Err(Error::parameter("number of points along a side", must, control_points));
    }
    if control_points > points {
        let must = format!("at most as large as the grid, {points} here");
        return Err(Error::parameter("net", must, control_points));
    }
    Ok(())
}

pub(super) fn singular(degree: usize) -> Error {
    let must = format!("spread so that each span of degree {degree} holds some");
    Error::parameter("points", must, "a system without a solution: use fewer control points")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::progress::Silent;

    fn ring(i: usize, rows: usize, j: usize, cols: usize) -> DVec3 {
        let turn = |i: usize, n: usize| {
            std::f64::consts::TAU * (i as f64 + 0.3 * (i % 2) as f64) / n as f64
        };
        let (a, b) = (turn(i, rows), turn(j, cols));
        DVec3::new((3.0 + b.cos()) * a.cos(), (3.0 + b.cos()) * a.sin(), b.sin())
    }

    pub(in crate::nurbs) fn grid(rows: usize, cols: usize) -> Vec<DVec3> {
        (0..rows * cols).map(|k| ring(k / cols, rows, k % cols, cols)).collect()
    }

    const KINDS: [Parametrization; 3] =
        [Parametrization::Uniform, Parametrization::ChordLength, Parametrization::Centripetal];

    #[test]
    fn interpolation_meets_its_points_open_and_closed() {
        for degree in 1..=5 {
            for parametrization in KINDS {
                for closed in [(false, false), (true, false), (true, true)] {
                    let options = GridOptions { degree: (degree, 3), parametrization, closed };
                    for shape in [(10, 8), (7, 12)] {
                        let grid = grid(shape.0, shape.1);
                        let surface =
                            NurbsSurface::interpolate(&grid, shape, &options, &mut Silent).unwrap();
                        let (u, v) =
                            NurbsSurface::grid_parameters(&grid, shape, &options, &mut Silent)
                                .unwrap();
                        for (k, point) in grid.iter().enumerate() {
                            let met = surface.point(u[k / shape.1], v[k % shape.1]);
                            assert!(met.distance(*point) < 1e-12, "{options:?} {met} {point}");
                        }
                        assert_eq!(surface.closed(), closed, "{options:?}");
                        if closed.0 && degree > 1 {
                            let (a, b) = (surface.normal(0.0, 0.3), surface.normal(1.0, 0.3));
                            assert!(a.distance(b) < 1e-10);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let options = GridOptions::default();
        let message = |grid: &[DVec3], shape| {
            NurbsSurface::interpolate(grid, shape, &options, &mut Silent).unwrap_err().to_string()
        };
        let good = grid(5, 5);
        assert!(message(&good, (5, 4)).contains("5 × 4 of them, got 25"));
        assert!(message(&good[..15], (3, 5)).contains("more than the degree, 3, got 3"));
        let mut twice = good.clone();
        twice.copy_within(5..10, 10);
        assert!(message(&twice, (5, 5)).contains("rows of the grid must be different"));
        twice[7].x = f64::NAN;
        assert!(message(&twice, (5, 5)).contains("at index 7"));
        let net =
            NurbsSurface::approximate(&good, (5, 5), (6, 5), &options, &mut Silent).unwrap_err();
        assert!(net.to_string().contains("at most as large as the grid, 5 here, got 6"));
        let none =
            NurbsCurve::interpolate(&[], 3, Parametrization::ChordLength, false, &mut Silent);
        assert!(none.unwrap_err().to_string().contains("more than the degree, 3, got 0"));
    }
}
