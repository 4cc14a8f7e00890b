//! `neurbs.NurbsCurve`: what can be done to a curve without moving it, and its length.

use pyo3::prelude::*;

use super::arguments::{optional_count, optional_real, real};
use super::arrays::Numbers;
use super::call::{self, Watcher};
use super::curve::NurbsCurve;
use super::knots::values;
use super::moves::{ACCURACY, affine};
use crate::error::Result;
use crate::nurbs;

impl NurbsCurve {
    /// Makes a curve of another one, without the GIL.
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
    /// The same curve with more knots.
    ///
    /// Parameters
    /// ----------
    /// knots : array_like of shape (n,)
    ///     New knots strictly inside the domain; one that is named twice is inserted twice.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a knot lies outside the domain, or would stand more often than the degree.
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

    /// The curve with fewer knots, no point of which moves further than a tolerance.
    ///
    /// Parameters
    /// ----------
    /// knots : array_like of shape (n,), optional
    ///     Inner knots that may go, each once for each time it is named; by default all.
    /// tolerance : float
    ///     The furthest that a point may move, in the points' unit.
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
        let (knots, tolerance) = (values(knots, "knots")?, real("tolerance", tolerance)?);
        self.derived(py, |core, watcher| core.remove_knots(knots.as_deref(), tolerance, watcher))
    }

    /// The same curve with a higher degree.
    ///
    /// Parameters
    /// ----------
    /// times : int, default 1
    ///     How much higher; the degree may not pass 9.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the degree would pass 9.
    ///
    /// Notes
    /// -----
    /// As :meth:`NurbsSurface.elevate_degree`.
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

    /// A curve of a lower degree, no point of which moves further than a tolerance.
    ///
    /// Parameters
    /// ----------
    /// times : int, default 1
    ///     How much lower.
    /// tolerance : float
    ///     The furthest that a point may move, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped; its ends are where they were.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the degree would be 0, a weight would not stay positive, or the tolerance cannot be
    ///     held: the message says what can.
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

    /// The same curve with clamped knots: it begins and ends at its outermost control points.
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

    /// The same curve with another range of its parameter.
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

    /// The same curve run through backwards, on the same domain.
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

    /// The curve moved by an affine map.
    ///
    /// Parameters
    /// ----------
    /// matrix : array_like of shape (3, 4) or (4, 4)
    ///     The map of column vectors (x, y, z, 1).
    ///
    /// Returns
    /// -------
    /// NurbsCurve
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
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 2]], degree=1)
    /// >>> line.transformed([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5]]).evaluate([1])
    /// array([[1., 2., 5.]])
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        let map = affine(matrix)?;
        self.derived(matrix.py(), |core, _| core.transformed(&map))
    }

    /// The length of the curve.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Share of the length by which it may be wrong, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///     In the points' unit.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the accuracy is not between 1e-14 and 1.
    ///
    /// Notes
    /// -----
    /// Gauss-Legendre quadrature of the speed on each span, which is halved until it agrees with
    /// itself.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.NurbsCurve.arc([0, 0, 0], [1, 0, 0], [0, 1, 0]).length(), 6)
    /// 6.283185
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn length(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(ACCURACY);
        call::run(py, None, |watcher| self.core().length(accuracy, watcher))
    }
}
