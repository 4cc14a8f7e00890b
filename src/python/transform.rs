//! `neurbs.NurbsSurface`: reversed, transposed and transformed surfaces, and other domains.

use glam::{DAffine3, DVec3};
use pyo3::prelude::*;

use super::arrays::Numbers;
use super::errors::NeurbsError;
use super::knots::by_direction;
use super::surface::NurbsSurface;

/// An affine map from the rows of its matrix.
pub(super) fn affine(matrix: &Bound<'_, PyAny>) -> PyResult<DAffine3> {
    let shapes: &[&[_]] = &[&[Some(3), Some(4)], &[Some(4), Some(4)]];
    let expected = "real numbers of shape (3, 4) or (4, 4)";
    let numbers = Numbers::new(matrix, "matrix", expected, shapes)?;
    let rows: &[[f64; 4]] = numbers.as_slice()?;
    if rows.get(3).is_some_and(|row| *row != [0.0, 0.0, 0.0, 1.0]) {
        let got = format!("{:?}", rows[3]);
        return Err(NeurbsError::new_err(format!("matrix must end in [0, 0, 0, 1], got {got}")));
    }
    let column = |j: usize| DVec3::new(rows[0][j], rows[1][j], rows[2][j]);
    Ok(DAffine3::from_cols(column(0), column(1), column(2), column(3)))
}

#[pymethods]
impl NurbsSurface {
    /// The same surface in reverse direction, over the same domain.
    ///
    /// Parameters
    /// ----------
    /// u, v : bool, default False
    ///     The directions to reverse. Each one flips the normals.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     The point at ``first + t`` was at ``last - t``.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    /// >>> inside_out = sphere.reversed(u=True)
    /// >>> np.allclose(inside_out.normals([[0.3, 0.5]]), -sphere.normals([[0.7, 0.5]]))
    /// True
    #[pyo3(signature = (u=false, v=false))]
    fn reversed(&self, py: Python<'_>, u: bool, v: bool) -> PyResult<Self> {
        self.derived(py, |core, watcher| {
            by_direction(core, (u.then_some(()), v.then_some(())), |surface, direction, ()| {
                surface.reversed(direction, watcher)
            })
        })
    }

    /// The same surface with u and v exchanged. The normals are flipped.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     The point at (v, u) was at (u, v).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1).transposed()
    /// NurbsSurface(net 2 × 9, degree (1, 2), domain [0, 1] × [0, 1], rational, closed in v)
    fn transposed(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, |core, watcher| core.transposed(watcher))
    }

    /// Transform the surface by an affine map.
    ///
    /// Parameters
    /// ----------
    /// matrix : array_like of shape (3, 4) or (4, 4)
    ///     The matrix applied to column vectors (x, y, z, 1).
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With the same weights and knots.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the matrix has another shape, its last row is not [0, 0, 0, 1], or a number is not
    ///     finite.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> plane.transformed([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 5]]).evaluate([[1, 1]])
    /// array([[2., 2., 5.]])
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        let map = affine(matrix)?;
        self.derived(matrix.py(), |core, _| core.transformed(&map))
    }

    /// The same surface over other parameter ranges.
    ///
    /// Parameters
    /// ----------
    /// u, v : (float, float), optional
    ///     The new first and last parameters; unchanged by default.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With the same net.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a range is empty or not finite.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> plane.with_domain(u=(0, 360)).evaluate([[90, 0]])
    /// array([[0.25, 0.  , 0.  ]])
    #[pyo3(signature = (*, u=None, v=None))]
    fn with_domain(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (u, v) = self.ranges(u, v)?;
        self.derived(py, |core, _| core.with_domain(u, v))
    }
}
