//! `neurbs.NurbsCurve`: splitting and joining.

use pyo3::prelude::*;

use super::arguments::{optional_real, real};
use super::call;
use super::curve::NurbsCurve;

#[pymethods]
impl NurbsCurve {
    /// Split the curve at a parameter. Both parts keep their parameters.
    ///
    /// Parameters
    /// ----------
    /// u : float
    ///     The parameter of the cut, strictly inside the domain.
    ///
    /// Returns
    /// -------
    /// before, after : NurbsCurve
    ///     Clamped.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the parameter does not lie strictly inside the domain.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> before, after = neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2).split(0.5)
    /// >>> after.control_points[0]
    /// array([1., 1., 0.])
    fn split(&self, u: &Bound<'_, PyAny>) -> PyResult<(Self, Self)> {
        let (py, at) = (u.py(), real("u", u)?);
        let (before, after) = call::run(py, None, |watcher| self.core().split(at, watcher))?;
        Ok((Self::new(py, before)?, Self::new(py, after)?))
    }

    /// The part between two parameters, which keeps its parameters.
    ///
    /// Parameters
    /// ----------
    /// first, last : float
    ///     The parameter range, increasing and inside the domain.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the range is empty or exceeds the domain.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsCurve([[0, 0], [1, 2], [2, 0]], degree=2).sub_curve(0.25, 0.75)
    /// NurbsCurve(3 control points, degree 2, domain [0.25, 0.75], polynomial, open)
    fn sub_curve(&self, first: &Bound<'_, PyAny>, last: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (from, to) = (real("first", first)?, real("last", last)?);
        self.derived(first.py(), |core, watcher| core.sub_curve(from, to, watcher))
    }

    /// Join this curve and another one that begins at its end.
    ///
    /// Parameters
    /// ----------
    /// other : NurbsCurve
    ///     A curve that begins where this one ends. Its parameters are shifted to follow this
    ///     domain.
    /// tolerance : float, default 0
    ///     Largest distance between the ends, in the points' unit. This curve's end is kept.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped, of the higher of both degrees.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the ends are farther apart than the tolerance.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> line = neurbs.NurbsCurve([[0, 0], [1, 0]], degree=1)
    /// >>> line.joined(neurbs.NurbsCurve([[1, 0], [2, 1], [3, 0]], degree=2))
    /// NurbsCurve(5 control points, degree 2, domain [0, 2], polynomial, open)
    #[pyo3(
        signature = (other, *, tolerance=None),
        text_signature = "($self, other, *, tolerance=0.0)"
    )]
    fn joined(
        &self,
        py: Python<'_>,
        other: &Self,
        tolerance: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let tolerance = optional_real("tolerance", tolerance)?.unwrap_or(0.0);
        self.derived(py, |core, watcher| core.joined(other.core(), tolerance, watcher))
    }
}
