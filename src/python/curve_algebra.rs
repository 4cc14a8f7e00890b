//! `neurbs.NurbsCurve`: knots, degree, domain, direction, transformations and length.

use pyo3::prelude::*;

use super::arguments::{optional_count, optional_real, real};
use super::arrays::Numbers;
use super::call::{self, Watcher};
use super::curve::NurbsCurve;
use super::knots::optional_values;
use super::measure::DEFAULT_ACCURACY;
use super::transform::affine;
use crate::error::Result;
use crate::nurbs;

impl NurbsCurve {
    /// Computes a new curve from this one, without the GIL.
    pub(super) fn derived(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&nurbs::NurbsCurve, &mut Watcher) -> Result<nurbs::NurbsCurve> + Send,
    ) -> PyResult<Self> {
        let core = call::run(py, None, |watcher| f(self.core(), watcher))?;
        Self::new(py, core)
    }
}

#[pymethods]
impl NurbsCurve {
    /// Insert knots. The shape does not change.
    ///
    /// Parameters
    /// ----------
    /// knots : array_like of shape (n,)
    ///     New knots in the domain; repeat a knot to insert it several times. Knots at the ends of
    ///     the domain are possible where it is not clamped.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a knot lies outside the domain, or its multiplicity would exceed the degree.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A5.4.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2).insert_knots([0.25, 0.5])
    /// NurbsCurve(5 control points, degree 2, domain [0, 1], polynomial, open)
    fn insert_knots(&self, knots: &Bound<'_, PyAny>) -> PyResult<Self> {
        let numbers = Numbers::sequence(knots, "knots")?;
        let new = numbers.as_slice()?;
        self.derived(knots.py(), |core, watcher| core.insert_knots(new, watcher))
    }

    /// Remove knots, as far as a tolerance allows.
    ///
    /// Parameters
    /// ----------
    /// knots : array_like of shape (n,), optional
    ///     Inner knots to remove, each as often as it is listed; by default all.
    /// tolerance : float
    ///     Largest distance by which a point of the curve may move, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped, with as few of these knots as the tolerance allows.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the tolerance is negative or not finite.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A5.8.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> curve = neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2)
    /// >>> curve.insert_knots([0.3, 0.7]).remove_knots(tolerance=1e-12)
    /// NurbsCurve(3 control points, degree 2, domain [0, 1], polynomial, open)
    #[pyo3(signature = (knots=None, *, tolerance))]
    fn remove_knots(
        &self,
        py: Python<'_>,
        knots: Option<&Bound<'_, PyAny>>,
        tolerance: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (knots, tolerance) = (optional_values(knots, "knots")?, real("tolerance", tolerance)?);
        self.derived(py, |core, watcher| core.remove_knots(knots.as_deref(), tolerance, watcher))
    }

    /// Raise the degree. The shape does not change.
    ///
    /// Parameters
    /// ----------
    /// times : int, default 1
    ///     Number of degrees to add. The result may not exceed 25.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the degree would exceed 25.
    ///
    /// Notes
    /// -----
    /// As in :meth:`NurbsSurface.elevate_degree`.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1).elevate_degree(2).degree
    /// 3
    #[pyo3(signature = (times=None), text_signature = "($self, times=1)")]
    fn elevate_degree(&self, py: Python<'_>, times: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let times = optional_count("times", times)?.unwrap_or(1);
        self.derived(py, |core, watcher| core.elevate_degree(times, watcher))
    }

    /// Lower the degree within a tolerance.
    ///
    /// Parameters
    /// ----------
    /// times : int, default 1
    ///     Number of degrees to remove.
    /// tolerance : float
    ///     Largest distance by which a point of the curve may move, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped, with the same end points.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the degree would be 0, a weight would not stay positive, or the tolerance is too
    ///     small. The message gives the smallest possible tolerance.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1)
    /// >>> line.elevate_degree(3).reduce_degree(3, tolerance=1e-12).degree
    /// 1
    #[pyo3(signature = (times=None, *, tolerance), text_signature = "($self, times=1, *, tolerance)")]
    fn reduce_degree(
        &self,
        py: Python<'_>,
        times: Option<&Bound<'_, PyAny>>,
        tolerance: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let times = optional_count("times", times)?.unwrap_or(1);
        let tolerance = real("tolerance", tolerance)?;
        self.derived(py, |core, watcher| core.reduce_degree(times, tolerance, watcher))
    }

    /// Clamp the knots, so that the curve ends at its first and last control points. The shape does
    /// not change.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> loose = neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2, knots=range(6))
    /// >>> loose.clamped().knots
    /// array([2., 2., 2., 3., 3., 3.])
    fn clamped(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, |core, watcher| core.clamp(watcher))
    }

    /// The same curve over another parameter domain.
    ///
    /// Parameters
    /// ----------
    /// first, last : float
    ///     The new first and last parameters.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the range is empty or not finite.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1).with_domain(0, 360).evaluate([90])
    /// array([[0.25, 0.5 , 0.  ]])
    fn with_domain(&self, first: &Bound<'_, PyAny>, last: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (from, to) = (real("first", first)?, real("last", last)?);
        self.derived(first.py(), |core, _| core.with_domain(from, to))
    }

    /// The same curve in reverse direction, over the same domain.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1).reversed().evaluate([0])
    /// array([[1., 2., 0.]])
    fn reversed(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, |core, watcher| core.reversed(watcher))
    }

    /// Transform the curve by an affine map.
    ///
    /// Parameters
    /// ----------
    /// matrix : array_like of shape (3, 4) or (4, 4)
    ///     The matrix applied to column vectors (x, y, z, 1).
    ///
    /// Returns
    /// -------
    /// NurbsCurve
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
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1)
    /// >>> line.transformed([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5]]).evaluate([1])
    /// array([[1., 2., 5.]])
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        let map = affine(matrix)?;
        self.derived(matrix.py(), |core, _| core.transformed(&map))
    }

    /// The arc length of the curve.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Largest relative error, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///     Length in the points' unit.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the accuracy is not from 1e-14 to 1.
    ///
    /// Notes
    /// -----
    /// Gauss-Legendre quadrature of the speed. Each span is halved until two estimates agree.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0]).length(), 6)
    /// 6.283185
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn length(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(DEFAULT_ACCURACY);
        call::run(py, None, |watcher| self.core().length(accuracy, watcher))
    }
}
