//! `neurbs.NurbsSurface`: other directions, places and domains, and what it measures.

use glam::{DAffine3, DVec3};
use pyo3::prelude::*;

use super::arguments::optional_real;
use super::arrays::{self, Numbers};
use super::call;
use super::errors::NeurbsError;
use super::evaluation::Array;
use super::knots::step;
use super::surface::NurbsSurface;

/// The share of an area or a length by which it may be wrong.
pub(super) const ACCURACY: f64 = 1e-9;

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
    /// The same surface run through backwards in some directions, on the same domain.
    ///
    /// Parameters
    /// ----------
    /// u, v : bool, default False
    ///     Which ones. Each turns the normals over.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     At ``first + t`` is the point that was at ``last - t``.
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
            step(core, (u.then_some(()), v.then_some(())), |surface, direction, ()| {
                surface.reversed(direction, watcher)
            })
        })
    }

    /// The same surface with u and v exchanged, which turns the normals over.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     At (v, u) is the point that was at (u, v).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 1], 1).transposed()
    /// NurbsSurface(net 2 × 9, degree (1, 2), domain [0, 1] × [0, 1], rational, closed in v)
    fn transposed(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, |core, watcher| core.transposed(watcher))
    }

    /// The surface moved by an affine map.
    ///
    /// Parameters
    /// ----------
    /// matrix : array_like of shape (3, 4) or (4, 4)
    ///     The map of column vectors (x, y, z, 1).
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With the same weights and knots.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the matrix has another shape, a last row that is not [0, 0, 0, 1] or numbers that
    ///     are not finite.
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

    /// The same surface with other ranges of its parameters.
    ///
    /// Parameters
    /// ----------
    /// u, v : (float, float), optional
    ///     The new first and last parameters; by default the old ones.
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

    /// The smallest box with sides along the axes that holds the surface.
    ///
    /// Parameters
    /// ----------
    /// tight : bool, default True
    ///     Whether the surface touches all its sides, up to 1e-10 of the size; otherwise it is the
    ///     box of the net, which is larger and costs less.
    /// out : (ndarray, ndarray) of shape (3,) each, optional
    ///     Where to write the results: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// low, high : ndarray of shape (3,)
    ///     Smallest and largest coordinates, in the points' unit.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If an array has the wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// Bézier patches that may reach farthest are halved until none may reach farther than the
    /// farthest point that is known: the net of a patch bounds it.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> torus = neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)
    /// >>> low, high = torus.bounding_box()
    /// >>> high.round(9)
    /// array([4., 4., 1.])
    #[pyo3(signature = (*, tight=true, out=None))]
    fn bounding_box<'py>(
        &self,
        py: Python<'py>,
        tight: bool,
        out: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let core = self.core();
        let (low, high) = if tight {
            call::run(py, None, |watcher| core.bounding_box(watcher))?
        } else {
            core.net_box()
        };
        let (out_low, out_high) = out.unzip();
        Ok((
            arrays::filled(py, out_low.as_ref(), low.as_ref())?,
            arrays::filled(py, out_high.as_ref(), high.as_ref())?,
        ))
    }

    /// The area of the surface.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Share of the area by which it may be wrong, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///     In the square of the points' unit.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the accuracy is not between 1e-14 and 1.
    ///
    /// Notes
    /// -----
    /// Gauss-Legendre quadrature of the length of ∂/∂u × ∂/∂v on each Bézier patch, with 12 × 12
    /// points and, as a check, 8 × 8. The pieces where the two differ most are quartered until all
    /// differences together are within the accuracy.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.NurbsSurface.sphere([0, 0, 0], 1).area(), 6)
    /// 12.566371
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn area(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(ACCURACY);
        call::run(py, None, |watcher| self.core().area(accuracy, watcher))
    }
}
