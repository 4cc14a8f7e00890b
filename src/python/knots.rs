//! `neurbs.NurbsSurface`: knots and degrees, which change without moving the surface.

use pyo3::prelude::*;

use super::arguments::{count, range, real};
use super::arrays::Numbers;
use super::call::{self, Watcher};
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::nurbs::{self, Direction};

/// Knots from Python.
pub(super) fn values(knots: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Option<Vec<f64>>> {
    let list = |knots| Ok::<_, PyErr>(Numbers::sequence(knots, name)?.as_slice()?.to_vec());
    knots.map(list).transpose()
}

/// Applies one step in each direction for which there is an argument.
pub(super) fn step<T>(
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
    /// Makes a surface of another one, without the GIL.
    pub(super) fn derived(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&nurbs::NurbsSurface, &mut Watcher) -> Result<nurbs::NurbsSurface> + Send,
    ) -> PyResult<Self> {
        let core = call::run(py, None, |watcher| f(self.core(), watcher))?;
        Self::new(py, core)
    }

    /// Ranges of the parameters, by default the whole domain.
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
    /// The same surface with more knots.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,), optional
    ///     New knots strictly inside the domain, in any order; one that is named twice is inserted
    ///     twice.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With one row (column) of control points more for each knot.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a knot lies outside the domain, or would stand more often than the degree.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.remove_knots : The way back.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A5.4. No point moves by more than 1e-13 of the size.
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
        let knots = (values(u, "u")?, values(v, "v")?);
        self.derived(py, |core, watcher| {
            step(core, knots, |surface, direction, knots| {
                surface.insert_knots(direction, &knots, watcher)
            })
        })
    }

    /// The surface with fewer knots, no point of which moves further than a tolerance.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,), optional
    ///     Inner knots that may go, each once for each time it is named; without either of them
    ///     all inner knots.
    /// tolerance : float
    ///     The furthest that a point may move, in the points' unit. Knots that are missed least
    ///     go first.
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
    /// NurbsSurface.insert_knots : The way back, exact.
    ///
    /// Notes
    /// -----
    /// *The NURBS Book*, A5.8; what is left is compared with the original over the original knots,
    /// where the distance of the control points bounds that of the surfaces.
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
        let (u, v) = (values(u, "u")?, values(v, "v")?);
        let all = u.is_none() && v.is_none();
        // Both directions may move a point: each gets its share.
        let share = if all || (u.is_some() && v.is_some()) { tolerance / 2.0 } else { tolerance };
        let knots = if all { (Some(None), Some(None)) } else { (u.map(Some), v.map(Some)) };
        self.derived(py, |core, watcher| {
            step(core, knots, |surface, direction, knots: Option<Vec<f64>>| {
                surface.remove_knots(direction, knots.as_deref(), share, watcher)
            })
        })
    }

    /// The same surface with higher degrees.
    ///
    /// Parameters
    /// ----------
    /// u, v : int, default 0
    ///     How much higher; no degree may pass 9.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Clamped in the directions that are raised; every knot stands as much more often.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a degree would pass 9.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.reduce_degree : The way back.
    ///
    /// Notes
    /// -----
    /// By convex mixtures of control points alone, so that rounding does not grow [1]_: no point
    /// moves by more than 1e-13 of the size.
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

    /// A surface of lower degrees, no point of which moves further than a tolerance.
    ///
    /// Parameters
    /// ----------
    /// u, v : int, default 0
    ///     How much lower.
    /// tolerance : float
    ///     The furthest that a point may move, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Clamped in the directions that are lowered; its corners are where they were.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a degree would be 0, a weight would not stay positive, or the tolerance cannot be
    ///     held: the message says what can.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.elevate_degree : The way back, exact.
    ///
    /// Notes
    /// -----
    /// Least squares on the control points, one degree after the other; the result is raised again
    /// to be compared with the original.
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

    /// The same surface with clamped knots: its net begins and ends where it does.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     On the same domain; the surface itself if it is clamped already.
    ///
    /// Notes
    /// -----
    /// The first and last parameters are inserted as knots until they stand ``degree + 1`` times.
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

/// By how many degrees in u and v.
fn times(u: Option<&Bound<'_, PyAny>>, v: Option<&Bound<'_, PyAny>>) -> PyResult<(usize, usize)> {
    let times = |name, value: Option<_>| value.map_or(Ok(0), |value| count(name, value));
    Ok((times("u", u)?, times("v", v)?))
}
