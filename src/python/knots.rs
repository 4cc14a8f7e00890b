//! `neurbs.NurbsSurface`: knots and degrees, which change without changing the shape.

use pyo3::prelude::*;

use super::arguments::{count, range, real};
use super::arrays::Numbers;
use super::call::{self, Watcher};
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::nurbs::{self, Direction};

/// An optional sequence of numbers.
pub(super) fn optional_values(
    knots: Option<&Bound<'_, PyAny>>,
    name: &str,
) -> PyResult<Option<Vec<f64>>> {
    let list = |knots| Ok::<_, PyErr>(Numbers::sequence(knots, name)?.as_slice()?.to_vec());
    knots.map(list).transpose()
}

/// Applies `f` in each direction that has an argument, first in u, then in v.
pub(super) fn by_direction<T>(
    surface: &nurbs::NurbsSurface,
    (u, v): (Option<T>, Option<T>),
    mut f: impl FnMut(&nurbs::NurbsSurface, Direction, T) -> Result<nurbs::NurbsSurface>,
) -> Result<nurbs::NurbsSurface> {
    let first = u.map(|u| f(surface, Direction::U, u)).transpose()?;
    match v {
        Some(v) => f(first.as_ref().unwrap_or(surface), Direction::V, v),
        None => Ok(first.unwrap_or_else(|| surface.clone())),
    }
}

impl NurbsSurface {
    /// Computes a new surface from this one, without the GIL.
    pub(super) fn derived(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&nurbs::NurbsSurface, &mut Watcher) -> Result<nurbs::NurbsSurface> + Send,
    ) -> PyResult<Self> {
        let core = call::run(py, None, |watcher| f(self.core(), watcher))?;
        Self::new(py, core)
    }

    /// Parameter ranges in u and v, by default the whole domain.
    pub(super) fn ranges(
        &self,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<((f64, f64), (f64, f64))> {
        let (knots_u, knots_v) = (self.core().knots_u(), self.core().knots_v());
        Ok((range("u", u, knots_u.domain())?, range("v", v, knots_v.domain())?))
    }
}

#[pymethods]
impl NurbsSurface {
    /// Insert knots. The shape does not change.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,), optional
    ///     New knots in the domain, in any order; repeat a knot to insert it several times. Knots
    ///     at the ends of the domain are possible where it is not clamped.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With one more row or column of control points per knot.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a knot lies outside the domain, or its multiplicity would exceed the degree.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.remove_knots : The inverse operation.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A5.4. Points move by at most 1e-13 of the surface's size.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0]).insert_knots(u=[0.5])
    /// NurbsSurface(net 3 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
    #[pyo3(signature = (u=None, v=None))]
    fn insert_knots(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let knots = (optional_values(u, "u")?, optional_values(v, "v")?);
        self.derived(py, |core, watcher| {
            by_direction(core, knots, |surface, direction, knots| {
                surface.insert_knots(direction, &knots, watcher)
            })
        })
    }

    /// Remove knots, as far as a tolerance allows.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,), optional
    ///     Inner knots to remove, each as often as it is listed. Without ``u`` and ``v``, all inner
    ///     knots.
    /// tolerance : float
    ///     Largest distance by which a point of the surface may move, in the points' unit. Knots
    ///     with the least effect are removed first.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Clamped, with as few of these knots as the tolerance allows.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the tolerance is negative or not finite.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.insert_knots : The inverse operation, exact.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A5.8. The result is compared with the original over the original knots,
    /// where the distance between the control points bounds that between the surfaces.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> fine = plane.insert_knots(u=[0.2, 0.5], v=[0.7])
    /// >>> fine.remove_knots(tolerance=1e-12) == plane
    /// True
    #[pyo3(signature = (u=None, v=None, *, tolerance))]
    fn remove_knots(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
        tolerance: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let tolerance = real("tolerance", tolerance)?;
        let (u, v) = (optional_values(u, "u")?, optional_values(v, "v")?);
        let all = u.is_none() && v.is_none();
        // Each direction may move a point, so both share the tolerance.
        let share = if all || (u.is_some() && v.is_some()) { tolerance / 2.0 } else { tolerance };
        let knots = if all { (Some(None), Some(None)) } else { (u.map(Some), v.map(Some)) };
        self.derived(py, |core, watcher| {
            by_direction(core, knots, |surface, direction, knots: Option<Vec<f64>>| {
                surface.remove_knots(direction, knots.as_deref(), share, watcher)
            })
        })
    }

    /// Raise the degrees. The shape does not change.
    ///
    /// Parameters
    /// ----------
    /// u, v : int, default 0
    ///     Numbers of degrees to add. No degree may exceed 25.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Clamped in the raised directions. The multiplicity of each knot grows by the same
    ///     number.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a degree would exceed 25.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.reduce_degree : The inverse operation.
    ///
    /// Notes
    /// -----
    /// Only convex combinations of control points, so that rounding errors do not grow [1]_. Points
    /// move by at most 1e-13 of the surface's size.
    ///
    /// References
    /// ----------
    /// .. [1] H. Prautzsch, "Degree elevation of B-spline curves", Computer Aided Geometric Design
    ///    1 (1984), 193-198.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0]).elevate_degree(u=2)
    /// NurbsSurface(net 4 × 2, degree (3, 1), domain [0, 1] × [0, 1], polynomial, open)
    #[pyo3(
        signature = (u=None, v=None),
        text_signature = "($self, u=0, v=0)"
    )]
    fn elevate_degree(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (u, v) = times(u, v)?;
        self.derived(py, |core, watcher| core.elevate_degree(u, v, watcher))
    }

    /// Lower the degrees within a tolerance.
    ///
    /// Parameters
    /// ----------
    /// u, v : int, default 0
    ///     Numbers of degrees to remove.
    /// tolerance : float
    ///     Largest distance by which a point of the surface may move, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Clamped in the lowered directions, with the same corners.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a degree would be 0, a weight would not stay positive, or the tolerance is too small.
    ///     The message gives the smallest possible tolerance.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.elevate_degree : The inverse operation, exact.
    ///
    /// Notes
    /// -----
    /// Least squares on the control points, one degree at a time. The distance from the original is
    /// measured by branch and bound over Bézier patches, at the same parameters, to 0.1 %.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> plane.elevate_degree(u=2, v=1).reduce_degree(u=2, v=1, tolerance=1e-12)
    /// NurbsSurface(net 2 × 2, degree (1, 1), domain [0, 1] × [0, 1], polynomial, open)
    #[pyo3(
        signature = (u=None, v=None, *, tolerance),
        text_signature = "($self, u=0, v=0, *, tolerance)"
    )]
    fn reduce_degree(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
        tolerance: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (tolerance, (u, v)) = (real("tolerance", tolerance)?, times(u, v)?);
        self.derived(py, |core, watcher| core.reduce_degree(u, v, tolerance, watcher))
    }

    /// Clamp the knots, so that the surface ends at the outermost rows and columns of its net. The
    /// shape does not change.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     On the same domain. A clamped surface is returned unchanged.
    ///
    /// Notes
    /// -----
    /// The first and last parameters are inserted as knots up to multiplicity ``degree + 1``.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> net = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]], [[2, 0, 0], [2, 1, 0]]]
    /// >>> loose = neurbs.NurbsSurface(net, degree=(2, 1), knots=(range(6), [0, 0, 1, 1]))
    /// >>> loose.clamped().knots[0]
    /// array([2., 2., 2., 3., 3., 3.])
    fn clamped(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, |core, watcher| core.clamp(watcher))
    }
}

/// Numbers of degrees in u and v, 0 by default.
fn times(u: Option<&Bound<'_, PyAny>>, v: Option<&Bound<'_, PyAny>>) -> PyResult<(usize, usize)> {
    let times = |name, value: Option<_>| value.map_or(Ok(0), |value| count(name, value));
    Ok((times("u", u)?, times("v", v)?))
}
