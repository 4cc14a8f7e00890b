//! Interpolation of ordered points by surfaces and curves (The NURBS Book, section 9.2).

use glam::{DVec3, DVec4};

use super::banded::{BandedMatrix, CyclicBandedMatrix};
use super::basis::{MAX_ORDER, padded};
use super::curve::NurbsCurve;
use super::curve_family::CurveFamily;
use super::direction::transposed_rows;
use super::knot_vector::KnotVector;
use super::parametrization::{
    GridOptions, GridParameters, Parametrization, check_points, row_parameters, shifted_if_even,
};
use super::surface::NurbsSurface;
use super::work_blocks::{collect_in_steps, interrupt_check, row_ranges};
use crate::error::{Error, Result};
use crate::progress::{InterruptCheck, Observer};

/// Degree up to which elimination without pivoting loses no digits that matter.
pub(super) const MAX_STABLE_DEGREE: usize = 9;

/// Steps of iterative refinement, at most; each one gains a digit or more.
const MAX_REFINEMENTS: usize = 15;

impl NurbsSurface {
    /// Builds the surface through a grid of points, given row by row, v fastest. It has as many
    /// control points as the grid has points (The NURBS Book, A9.4). Solves banded systems in
    /// O(points · degree).
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
    /// The condition of the systems grows exponentially with the degree. Between evenly spaced
    /// points, rounding moves the surface by about 1e-14 of its size at degree 9, 1e-7 at degree
    /// 20 and 1e-4 at degree 25. At the points themselves it stays below 1e-11.
    ///
    /// # Errors
    ///
    /// Those of [`NurbsSurface::grid_parameters`]; [`Error::Parameter`] if the grid has at most
    /// `degree` rows or columns.
    pub fn interpolate(
        grid: &[DVec3],
        shape: (usize, usize),
        options: &GridOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let GridOptions { degree, closed, .. } = *options;
        let (degree, closed) = ([degree.0, degree.1], [closed.0, closed.1]);
        by_directions(
            grid,
            shape,
            options,
            observer,
            |d, points, width, parameters, check_interrupt| {
                interpolate_family(points, width, parameters, degree[d], closed[d], check_interrupt)
            },
        )
    }
}

/// Applies `solve` to the columns of a grid and then to the rows of the result.
///
/// The arguments of `solve` are the direction (0 or 1), the points of the curves, their number, and
/// their parameters.
pub(super) fn by_directions(
    grid: &[DVec3],
    shape: (usize, usize),
    options: &GridOptions,
    observer: &mut dyn Observer,
    solve: impl Fn(usize, Vec<DVec4>, usize, &[f64], &mut InterruptCheck<'_>) -> Result<CurveFamily>,
) -> Result<NurbsSurface> {
    let check_interrupt = &mut interrupt_check(observer);
    let GridParameters { u, v } = GridParameters::new(grid, shape, options, check_interrupt)?;
    let points = homogeneous(grid, check_interrupt)?;
    let along = solve(0, points, shape.1, &u, check_interrupt)?;
    let (rows, knots_u) = (along.rows(), along.knots.clone());
    let across = transposed_rows(along, check_interrupt)?;
    let across = solve(1, across, rows, &v, check_interrupt)?;
    let knots = [knots_u, across.knots.clone()];
    NurbsSurface::from_homogeneous(
        transposed_rows(across, check_interrupt)?,
        false,
        knots,
        check_interrupt,
    )
}

/// Appends the weight 1 to each point.
fn homogeneous(points: &[DVec3], check_interrupt: &mut InterruptCheck<'_>) -> Result<Vec<DVec4>> {
    collect_in_steps((points.len(), 1), check_interrupt, |part| {
        points[part].iter().map(|point| point.extend(1.0))
    })
}

impl NurbsCurve {
    /// Builds the curve through points, in their order (The NURBS Book, A9.1).
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
    /// [`Error::Parameter`] if there are at most `degree` points, or neighboring points coincide;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn interpolate(
        points: &[DVec3],
        degree: usize,
        parametrization: Parametrization,
        closed: bool,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let check_interrupt = &mut interrupt_check(observer);
        check_points("points", points, check_interrupt)?;
        check_counts(degree, points.len(), points.len())?;
        let parameters =
            row_parameters("points", points, 1, parametrization, closed, check_interrupt)?;
        let parameters = shifted_if_even(parameters, degree, closed);
        let points = homogeneous(points, check_interrupt)?;
        let family = interpolate_family(points, 1, &parameters, degree, closed, check_interrupt)?;
        Self::from_homogeneous(family.points, false, family.knots, check_interrupt)
    }
}

/// Interpolates rows of points at these parameters by a family of splines.
pub(super) fn interpolate_family(
    mut points: Vec<DVec4>,
    width: usize,
    parameters: &[f64],
    degree: usize,
    closed: bool,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<CurveFamily> {
    let count = parameters.len();
    check_counts(degree, count, count)?;
    let mean = |parameters: &[f64]| parameters.iter().sum::<f64>() / parameters.len() as f64;
    let (solved, knots) = if closed {
        let knots = if degree % 2 == 1 {
            KnotVector::periodic(degree, &[parameters, &[1.0]].concat())?
        } else {
            let between = parameters.windows(2).map(mean);
            let breaks: Vec<f64> = [0.0].into_iter().chain(between).chain([1.0]).collect();
            KnotVector::periodic(degree, &breaks)?
        };
        // Shifts the largest function of each parameter to the diagonal.
        let shift = degree / 2;
        let mut matrix = CyclicBandedMatrix::new(count, degree);
        collocate(&knots, parameters, check_interrupt, |i, j, value| {
            matrix.add(i, j + count - shift, value);
        })?;
        let solved = matrix.solve(&mut points, width, check_interrupt)?;
        points = wrapped_rows(&points, width, degree, count - shift, check_interrupt)?;
        (solved, knots)
    } else {
        let inner = (1..count - degree).map(|j| mean(&parameters[j..j + degree]));
        let knots = KnotVector::clamped(degree, (0.0, 1.0), inner)?;
        (solve_open(&knots, parameters, &mut points, width, check_interrupt)?, knots)
    };
    if !solved {
        return Err(singular(degree));
    }
    Ok(CurveFamily { knots, points, width })
}

/// Solves the open system in place; returns whether it is regular.
///
/// At high degrees iterative refinement recovers the digits that elimination loses.
fn solve_open(
    knots: &KnotVector,
    parameters: &[f64],
    points: &mut [DVec4],
    width: usize,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<bool> {
    let (count, degree) = (parameters.len(), knots.degree());
    let solve = |rows: &mut [DVec4], check_interrupt: &mut InterruptCheck<'_>| {
        let mut matrix = BandedMatrix::new(count, degree.min(count - 1));
        collocate(knots, parameters, check_interrupt, |i, j, value| matrix.add(i, j, value))?;
        matrix.solve(rows, width, check_interrupt)
    };
    if degree <= MAX_STABLE_DEGREE {
        return solve(points, check_interrupt);
    }
    let given = points.to_vec();
    let (mut regular, mut error) = (solve(points, check_interrupt)?, f64::INFINITY);
    for _ in 0..MAX_REFINEMENTS {
        let mut residual = given.clone();
        collocate(knots, parameters, check_interrupt, |i, j, value| {
            let sums = residual[i * width..][..width].iter_mut();
            sums.zip(&points[j * width..]).for_each(|(sum, point)| *sum -= value * *point);
        })?;
        let remaining = residual.iter().map(|r| r.abs().max_element()).fold(0.0, f64::max);
        if !regular || remaining >= error {
            break;
        }
        error = remaining;
        regular = solve(&mut residual, check_interrupt)?;
        points.iter_mut().zip(&residual).for_each(|(point, change)| *point += *change);
    }
    // The basis functions sum to 1, so weights of 1 stay 1.
    if given.iter().all(|point| point.w == 1.0) {
        for point in points {
            point.w = 1.0;
        }
    }
    Ok(regular)
}

/// Calls `add` for each nonzero entry of the collocation matrix: row (parameter), column (basis
/// function) and value.
fn collocate(
    knots: &KnotVector,
    parameters: &[f64],
    check_interrupt: &mut InterruptCheck<'_>,
    mut add: impl FnMut(usize, usize, f64),
) -> Result<()> {
    for range in row_ranges(parameters.len(), 1) {
        check_interrupt()?;
        for i in range {
            let basis = padded::<MAX_ORDER>(knots, parameters[i]);
            let functions = basis.values[..=knots.degree()].iter().enumerate();
            for (k, value) in functions.filter(|(_, value)| **value != 0.0) {
                add(i, basis.first + k, *value);
            }
        }
    }
    Ok(())
}

/// Returns all rows in cyclic order from `start` on, with the first `degree` of them repeated.
pub(super) fn wrapped_rows(
    points: &[DVec4],
    width: usize,
    degree: usize,
    start: usize,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<DVec4>> {
    let count = points.len() / width;
    let row = |i: usize| &points[(i + start) % count * width..][..width];
    collect_in_steps((count + degree, width), check_interrupt, |rows| rows.flat_map(row).copied())
}

/// Checks that `control_points` exceeds the degree and is at most `points`.
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

/// The error for a singular system.
pub(super) fn singular(degree: usize) -> Error {
    let must = format!("dense enough that every span of degree {degree} contains some");
    Error::parameter("points", must, "a singular system: use fewer control points")
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
    fn interpolation_passes_through_its_points_open_and_closed() {
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
    fn error_messages_name_the_cause() {
        let options = GridOptions::default();
        let message = |grid: &[DVec3], shape| {
            NurbsSurface::interpolate(grid, shape, &options, &mut Silent).unwrap_err().to_string()
        };
        let good = grid(5, 5);
        assert!(message(&good, (5, 4)).contains("5 × 4 points, at least 2 × 2, got 25"));
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
