//! Surfaces from a grid of ordered points (section 5 of the paper).

use glam::DVec3;

use super::knot_vector::{MAX_DEGREE, check_degree};
use super::parametrization::{GridOptions, Parametrization};
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::progress::Silent;

/// How a grid of ordered points becomes a surface: "either interpolation or approximation can be
/// executed by the standard NURBS surface or Bézier-surface method" (section 5 of the paper).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OrderedSurface {
    /// The points are the control net of a clamped B-spline surface, which approximates them.
    #[default]
    ControlNet,
    /// A clamped B-spline surface interpolates the points, with centripetal parameters and averaged
    /// knots (The NURBS Book, section 9.2).
    Interpolate,
    /// The points are the control net of one Bézier surface; each degree is one less than the
    /// number of rows or columns.
    Bezier,
}

impl OrderedSurface {
    /// All variants.
    pub const ALL: [Self; 3] = [Self::ControlNet, Self::Interpolate, Self::Bezier];

    /// The name in Python and on the command line.
    ///
    /// ```
    /// use neurbs::nurbs::OrderedSurface;
    /// assert_eq!(OrderedSurface::ControlNet.name(), "control-net");
    /// ```
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ControlNet => "control-net",
            Self::Interpolate => "interpolate",
            Self::Bezier => "bezier",
        }
    }

    /// Checks that a grid of this shape can become a surface of this kind.
    ///
    /// ```
    /// use neurbs::nurbs::OrderedSurface;
    /// assert!(OrderedSurface::Bezier.check_shape((26, 10)).is_ok());
    /// assert!(OrderedSurface::Bezier.check_shape((27, 10)).is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a side has fewer than 2 points, or a side of a Bézier surface has
    /// more than `MAX_DEGREE + 1`.
    pub fn check_shape(self, (rows, cols): (usize, usize)) -> Result<()> {
        let max_points = if self == Self::Bezier { MAX_DEGREE + 1 } else { usize::MAX };
        if (2..=max_points).contains(&rows) && (2..=max_points).contains(&cols) {
            return Ok(());
        }
        let must = if self == Self::Bezier {
            format!(
                "from 2 to {max_points} rows and columns for surface='bezier', whose degrees are one less"
            )
        } else {
            "at least 2 rows and columns".to_string()
        };
        Err(Error::parameter("grid", must, format!("({rows}, {cols})")))
    }

    /// Builds the surface of a grid of points, given row by row.
    ///
    /// `degree` is lowered if the grid has too few rows or columns. A Bézier surface ignores it.
    ///
    /// ```
    /// use neurbs::{DVec3, nurbs::OrderedSurface};
    /// let grid: Vec<DVec3> = (0..20)
    ///     .map(|i| DVec3::new(f64::from(i / 5), f64::from(i % 5), f64::from(i * i % 3)))
    ///     .collect();
    /// for kind in OrderedSurface::ALL {
    ///     let surface = kind.through(grid.clone(), (4, 5), 3)?;
    ///     assert_eq!(surface.shape(), (4, 5));
    ///     assert!(surface.point(0.0, 1.0).distance(grid[4]) < 1e-14);
    /// }
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - Those of [`Self::check_shape`].
    /// - [`Error::Parameter`] if the degree is out of range, or neighboring rows or columns to
    ///   interpolate coincide.
    /// - [`Error::Net`] if the number of points does not match the shape, or a point is not finite.
    pub fn through(
        self,
        points: Vec<DVec3>,
        shape: (usize, usize),
        degree: usize,
    ) -> Result<NurbsSurface> {
        self.check_shape(shape)?;
        check_degree(degree)?;
        match self {
            Self::ControlNet => NurbsSurface::clamped(points, shape, degree),
            Self::Interpolate => {
                let degree = (degree.min(shape.0 - 1), degree.min(shape.1 - 1));
                let parametrization = Parametrization::Centripetal;
                let options = GridOptions { degree, parametrization, ..GridOptions::default() };
                NurbsSurface::interpolate(&points, shape, &options, &mut Silent)
            }
            Self::Bezier => NurbsSurface::bezier(points, None, shape),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(rows: usize, cols: usize) -> Vec<DVec3> {
        let place = |i: usize| DVec3::new((i / cols) as f64, (i % cols) as f64, (i * i % 7) as f64);
        (0..rows * cols).map(place).collect()
    }

    #[test]
    fn an_interpolating_surface_passes_through_its_points() {
        let points = grid(6, 2);
        let surface = OrderedSurface::Interpolate.through(points.clone(), (6, 2), 3).unwrap();
        assert_eq!((surface.knots_u().degree(), surface.knots_v().degree()), (3, 1));
        let options = GridOptions {
            degree: (3, 1),
            parametrization: Parametrization::Centripetal,
            ..GridOptions::default()
        };
        let (u, v) = NurbsSurface::grid_parameters(&points, (6, 2), &options, &mut Silent).unwrap();
        for (i, point) in points.iter().enumerate() {
            assert!(surface.point(u[i / 2], v[i % 2]).distance(*point) < 1e-13);
        }
    }

    #[test]
    fn a_bezier_surface_has_26_rows_at_most() {
        let surface = OrderedSurface::Bezier.through(grid(26, 3), (26, 3), 3).unwrap();
        assert_eq!((surface.knots_u().degree(), surface.knots_v().degree()), (25, 2));
        let error = OrderedSurface::Bezier.through(grid(27, 3), (27, 3), 3).unwrap_err();
        assert_eq!(
            error.to_string(),
            "grid must be from 2 to 26 rows and columns for surface='bezier', whose degrees are \
             one less, got (27, 3)"
        );
        assert!(OrderedSurface::ControlNet.through(grid(1, 3), (1, 3), 3).is_err());
    }
}
