//! `neurbs.NurbsCurve`: its parts, and one of two.

use pyo3::prelude::*;

use super::arguments::{optional_real, real};
use super::call;
use super::curve::NurbsCurve;

#[pymethods]
impl NurbsCurve {
    /// The parts before and after a parameter, which keep their parameters.
    ///
    /// Parameters
    /// ----------
    /// u : float
    ///     Where to cut, strictly inside the domain.
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
    ///     An increasing pair inside the domain.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the range is empty or leaves the domain.
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

    /// This curve and the one that follows it, as one.
    ///
    /// Parameters
    /// ----------
    /// other : NurbsCurve
    ///     Begins where this one ends. Its parameters are moved behind the domain of this one.
    /// tolerance : float, default 0
    ///     How far the ends may be apart, in the points' unit; this curve's end counts.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     Clamped, of the higher degree of both.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the ends are further apart than the tolerance.
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
