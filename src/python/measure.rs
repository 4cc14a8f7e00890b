//! `neurbs.NurbsSurface`: bounding box and area.

use pyo3::prelude::*;

use super::arguments::optional_real;
use super::arrays;
use super::call;
use super::evaluation::Array;
use super::surface::NurbsSurface;

/// Default relative error of an area or a length.
pub(super) const DEFAULT_ACCURACY: f64 = 1e-9;

#[pymethods]
impl NurbsSurface {
    /// The axis-aligned bounding box of the surface.
    ///
    /// Parameters
    /// ----------
    /// tight : bool, default True
    ///     Whether to compute the exact box, to 1e-10 of the size. Otherwise return the box of the
    ///     control net, which is larger and faster to compute.
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
    /// Branch and bound: Bézier patches are halved until no net exceeds the farthest known point.
    /// The net of a patch bounds the patch.
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
    ///     Largest relative error, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///     Area in the square of the points' unit.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the accuracy is not from 1e-14 to 1.
    ///
    /// Notes
    /// -----
    /// Gauss-Legendre quadrature of the length of ∂/∂u × ∂/∂v on each Bézier patch, with 12 × 12
    /// points. The difference to 8 × 8 points estimates the error. Pieces with the largest
    /// estimates are quartered until their sum is within the accuracy.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.NurbsSurface.sphere([0, 0, 0], 1).area(), 6)
    /// 12.566371
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn area(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(DEFAULT_ACCURACY);
        call::run(py, None, |watcher| self.core().area(accuracy, watcher))
    }
}
