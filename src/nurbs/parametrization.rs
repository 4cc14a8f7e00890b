//! The parameters of ordered points.

use glam::DVec3;

use super::surface::NurbsSurface;
use super::work_blocks::{in_steps, listening, steps};
use crate::error::{Error, Result};
use crate::progress::{Listen, Observer};

/// How the points of a grid get their parameters (The NURBS Book, section 9.2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parametrization {
    /// Evenly spaced.
    Uniform,
    /// In proportion to the distance of neighbours, averaged over the rows or columns.
    #[default]
    ChordLength,
    /// In proportion to the root of that distance: calmer where distances vary much.
    Centripetal,
}

/// What a grid of points is to become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridOptions {
    /// The degrees in u and v; 3 by default.
    pub degree: (usize, usize),
    /// How points get their parameters; by default from chord lengths.
    pub parametrization: Parametrization,
    /// Directions in which the surface closes smoothly behind the last row or column, which is
    /// not the first one again; none by default.
    pub closed: (bool, bool),
}

impl Default for GridOptions {
    fn default() -> Self {
        let parametrization = Parametrization::ChordLength;
        Self { degree: (3, 3), parametrization, closed: (false, false) }
    }
}

impl NurbsSurface {
    /// The parameters of the rows and columns of a grid, on `[0, 1]`: those at which
    /// [`NurbsSurface::interpolate`] meets them.
    ///
    /// In a closed direction of even degree the first row lies half a step inside the domain, as
    /// there is no spline whose knots and data are at the same places.
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
    /// [`Error::Parameter`] if the grid has another length than its shape, fewer than 2 rows or
    /// columns, a point that is not finite, or neighbouring rows or columns that coincide;
    /// [`Error::Interrupted`] if the observer stops it.
    pub fn grid_parameters(
        grid: &[DVec3],
        shape: (usize, usize),
        options: &GridOptions,
        observer: &mut dyn Observer,
    ) -> Result<(Vec<f64>, Vec<f64>)> {
        let Sites { u, v } = Sites::new(grid, shape, options, &mut listening(observer))?;
        Ok((u, v))
    }
}

/// Parameters of the rows and columns of a grid.
pub(super) struct Sites {
    pub u: Vec<f64>,
    pub v: Vec<f64>,
}

impl Sites {
    pub(super) fn new(
        grid: &[DVec3],
        (rows, cols): (usize, usize),
        options: &GridOptions,
        listen: &mut Listen<'_>,
    ) -> Result<Self> {
        if grid.len() != rows * cols || rows < 2 || cols < 2 {
            let must = format!("at least 2 × 2 points, {rows} × {cols} of them");
            return Err(Error::parameter("grid", must, grid.len()));
        }
        check_points("grid", grid, listen)?;
        let turned = in_steps((cols, rows), listen, |columns| {
            columns.flat_map(|j| grid.iter().skip(j).step_by(cols).copied())
        })?;
        let GridOptions { degree, parametrization, closed } = *options;
        let u = sites("rows of the grid", grid, cols, parametrization, closed.0, listen)?;
        let v = sites("columns of the grid", &turned, rows, parametrization, closed.1, listen)?;
        Ok(Self { u: shifted(u, degree.0, closed.0), v: shifted(v, degree.1, closed.1) })
    }
}

pub(super) fn check_points(
    name: &'static str,
    points: &[DVec3],
    listen: &mut Listen<'_>,
) -> Result<()> {
    for mut range in steps(points.len(), 1) {
        listen()?;
        if let Some(i) = range.find(|&i| !points[i].is_finite()) {
            return Err(Error::parameter(name, "finite", format!("{} at index {i}", points[i])));
        }
    }
    Ok(())
}

/// Parameters from 0 on for rows of points of this width: to 1, or in a closed direction to where
/// one more step reaches 1.
pub(super) fn sites(
    name: &'static str,
    points: &[DVec3],
    width: usize,
    parametrization: Parametrization,
    closed: bool,
    listen: &mut Listen<'_>,
) -> Result<Vec<f64>> {
    let rows = points.len() / width;
    let count = rows - usize::from(!closed);
    let place = |row: usize, column: usize| points[row % rows * width + column];
    let measure = |row: usize, column: usize| {
        let distance = place(row, column).distance(place(row + 1, column));
        match parametrization {
            Parametrization::Uniform => 1.0,
            Parametrization::ChordLength => distance,
            Parametrization::Centripetal => distance.sqrt(),
        }
    };
    let mut totals = vec![0.0; width];
    for range in steps(count, width) {
        listen()?;
        for row in range {
            totals.iter_mut().enumerate().for_each(|(j, total)| *total += measure(row, j));
        }
    }
    let mut means = vec![0.0; count];
    for range in steps(count, width) {
        listen()?;
        for row in range {
            // Columns that collapse in one point have no say.
            let columns = (0..width).filter(|&j| totals[j] > 0.0);
            means[row] = columns.map(|j| measure(row, j) / totals[j]).sum();
        }
    }
    let total: f64 = means.iter().sum();
    let mut sites = vec![0.0];
    for mean in &means[..rows - 1] {
        sites.push(sites[sites.len() - 1] + mean / total);
    }
    if !closed {
        sites[rows - 1] = 1.0;
    }
    let last = [closed.then_some(1.0)].into_iter().flatten();
    let all: Vec<f64> = sites.iter().copied().chain(last).collect();
    let stuck = |pair: &[f64]| pair[0] >= pair[1] || pair[1].is_nan();
    match all.windows(2).position(stuck) {
        None => Ok(sites),
        Some(i) => {
            let got = format!("number {} equal to the next", i % rows);
            Err(Error::parameter(name, "different from their neighbours", got))
        }
    }
}

/// In a closed direction of even degree, the parameters moved so that 0 lies between two of them.
pub(super) fn shifted(mut sites: Vec<f64>, degree: usize, closed: bool) -> Vec<f64> {
    if closed && degree.is_multiple_of(2) {
        let half = (1.0 - sites[sites.len() - 1]) / 2.0;
        for site in &mut sites {
            *site += half;
        }
    }
    sites
}
