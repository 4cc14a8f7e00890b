//! Parameters of ordered points (The NURBS Book, section 9.2.1).

use glam::DVec3;

use super::control_net::transpose;
use super::surface::NurbsSurface;
use super::work_blocks::{interrupt_check, row_ranges};
use crate::error::{Error, Result};
use crate::progress::{InterruptCheck, Observer};

/// The ends of a closed polygon coincide if their distance is below this fraction of its length.
const COINCIDENCE: f64 = 1e-9;

/// The method that assigns parameters to the points of a grid (The NURBS Book, section 9.2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parametrization {
    /// Evenly spaced.
    Uniform,
    /// Proportional to the distance of neighbors, averaged over the rows or columns.
    #[default]
    ChordLength,
    /// Proportional to the square root of that distance: fewer oscillations where distances vary
    /// much.
    Centripetal,
}

/// Options for a surface from a grid of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridOptions {
    /// The degrees in u and v; 3 by default.
    pub degree: (usize, usize),
    /// The parametrization; chord length by default.
    pub parametrization: Parametrization,
    /// The directions in which the surface is smoothly closed; none by default. The last row or
    /// column must not repeat the first one.
    pub closed: (bool, bool),
}

impl Default for GridOptions {
    fn default() -> Self {
        let parametrization = Parametrization::ChordLength;
        Self { degree: (3, 3), parametrization, closed: (false, false) }
    }
}

impl NurbsSurface {
    /// Returns the parameters of the rows and columns of a grid, on `[0, 1]`: those at which
    /// [`NurbsSurface::interpolate`] passes through the points.
    ///
    /// In a closed direction of even degree the first row is half a step inside the domain. No
    /// periodic spline of even degree interpolates data at its knots.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::{GridOptions, NurbsSurface}, progress::Silent};
    /// let grid: Vec<DVec3> = [0.0, 1.0, 3.0, 4.0]
    ///     .iter()
    ///     .flat_map(|x| [DVec3::new(*x, 0.0, 0.0), DVec3::new(*x, 1.0, 0.0)])
    ///     .collect();
    /// let options = GridOptions { degree: (3, 1), ..GridOptions::default() };
    /// let (u, v) = NurbsSurface::grid_parameters(&grid, (4, 2), &options, &mut Silent)?;
    /// assert_eq!((u, v), (vec![0.0, 0.25, 0.75, 1.0], vec![0.0, 1.0]));
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`Error::Parameter`] if the length of the grid does not match its shape, or it has fewer
    ///   than 2 rows or columns.
    /// - [`Error::Parameter`] if a point is not finite, or neighboring rows or columns coincide.
    /// - [`Error::Interrupted`] if the observer stops it.
    pub fn grid_parameters(
        grid: &[DVec3],
        shape: (usize, usize),
        options: &GridOptions,
        observer: &mut dyn Observer,
    ) -> Result<(Vec<f64>, Vec<f64>)> {
        let GridParameters { u, v } =
            GridParameters::new(grid, shape, options, &mut interrupt_check(observer))?;
        Ok((u, v))
    }
}

/// The parameters of the rows and columns of a grid.
pub(super) struct GridParameters {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
}

impl GridParameters {
    /// Computes the parameters of a grid of points, row by row, with this shape.
    pub(super) fn new(
        grid: &[DVec3],
        (rows, cols): (usize, usize),
        options: &GridOptions,
        check_interrupt: &mut InterruptCheck<'_>,
    ) -> Result<Self> {
        if grid.len() != rows * cols || rows < 2 || cols < 2 {
            let must = format!("{rows} × {cols} points, at least 2 × 2");
            return Err(Error::parameter("grid", must, grid.len()));
        }
        check_points("grid", grid, check_interrupt)?;
        let transposed = transpose(grid, cols, check_interrupt)?;
        let GridOptions { degree, parametrization, closed } = *options;
        let u = row_parameters(
            "rows of the grid",
            grid,
            cols,
            parametrization,
            closed.0,
            check_interrupt,
        )?;
        let v = row_parameters(
            "columns of the grid",
            &transposed,
            rows,
            parametrization,
            closed.1,
            check_interrupt,
        )?;
        Ok(Self {
            u: shifted_if_even(u, degree.0, closed.0),
            v: shifted_if_even(v, degree.1, closed.1),
        })
    }
}

/// Checks that all points are finite; `name` is that of the argument.
pub(super) fn check_points(
    name: &'static str,
    points: &[DVec3],
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<()> {
    for mut range in row_ranges(points.len(), 1) {
        check_interrupt()?;
        if let Some(i) = range.find(|&i| !points[i].is_finite()) {
            return Err(Error::parameter(name, "finite", format!("{} at index {i}", points[i])));
        }
    }
    Ok(())
}

/// Returns parameters for rows of points of this width, starting at 0. In an open direction the
/// last one is 1; in a closed direction the next one would be 1.
pub(super) fn row_parameters(
    name: &'static str,
    points: &[DVec3],
    width: usize,
    parametrization: Parametrization,
    closed: bool,
    check_interrupt: &mut InterruptCheck<'_>,
) -> Result<Vec<f64>> {
    let rows = points.len() / width;
    let count = rows - usize::from(!closed);
    let point_at = |row: usize, column: usize| points[row % rows * width + column];
    if closed && repeats_first_row(points, width) {
        let got = "the first one again at the end: leave it out".to_string();
        return Err(Error::parameter(name, "listed once in a closed direction", got));
    }
    let step_length = |row: usize, column: usize| {
        let distance = point_at(row, column).distance(point_at(row + 1, column));
        match parametrization {
            Parametrization::Uniform => 1.0,
            Parametrization::ChordLength => distance,
            Parametrization::Centripetal => distance.sqrt(),
        }
    };
    let mut totals = vec![0.0; width];
    for range in row_ranges(count, width) {
        check_interrupt()?;
        for row in range {
            totals.iter_mut().enumerate().for_each(|(j, total)| *total += step_length(row, j));
        }
    }
    let mut means = vec![0.0; count];
    for range in row_ranges(count, width) {
        check_interrupt()?;
        for row in range {
            // Columns that collapse to one point are ignored.
            let columns = (0..width).filter(|&j| totals[j] > 0.0);
            means[row] = columns.map(|j| step_length(row, j) / totals[j]).sum();
        }
    }
    let total: f64 = means.iter().sum();
    let mut parameters = vec![0.0];
    for mean in &means[..rows - 1] {
        parameters.push(parameters[parameters.len() - 1] + mean / total);
    }
    if !closed {
        parameters[rows - 1] = 1.0;
    }
    let last = [closed.then_some(1.0)].into_iter().flatten();
    let all: Vec<f64> = parameters.iter().copied().chain(last).collect();
    let coincides = |pair: &[f64]| pair[0] >= pair[1] || pair[1].is_nan();
    match all.windows(2).position(coincides) {
        None => Ok(parameters),
        Some(i) => {
            let got = format!("number {} equal to the next", i % rows);
            Err(Error::parameter(name, "different from their neighbors", got))
        }
    }
}

/// Whether the last row of points equals the first up to rounding, in all columns.
fn repeats_first_row(points: &[DVec3], width: usize) -> bool {
    let rows = points.len() / width;
    let last = (rows - 1) * width;
    let mut is_point = true;
    let equal = (0..width).all(|j| {
        let steps = (1..rows).map(|i| points[i * width + j].distance(points[(i - 1) * width + j]));
        let length: f64 = steps.sum();
        is_point &= length == 0.0;
        points[last + j].distance(points[j]) <= COINCIDENCE * length
    });
    // Rows that are all the same have another error.
    equal && !is_point
}

/// In a closed direction of even degree, shifts the parameters so that 0 is halfway between two of
/// them.
pub(super) fn shifted_if_even(mut parameters: Vec<f64>, degree: usize, closed: bool) -> Vec<f64> {
    if closed && degree.is_multiple_of(2) {
        let half = (1.0 - parameters[parameters.len() - 1]) / 2.0;
        for parameter in &mut parameters {
            *parameter += half;
        }
    }
    parameters
}
