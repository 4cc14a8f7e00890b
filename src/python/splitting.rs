//! `neurbs.NurbsSurface`: splitting, isocurves and joining.

use pyo3::prelude::*;

use super::arguments::{choice, optional_real};
use super::call;
use super::curve::NurbsCurve;
use super::errors::NeurbsError;
use super::surface::NurbsSurface;
use crate::nurbs::Direction;

/// The direction that has an argument, which must be exactly one.
fn one_direction(
    u: Option<&Bound<'_, PyAny>>,
    v: Option<&Bound<'_, PyAny>>,
) -> PyResult<(Direction, f64)> {
    match (optional_real("u", u)?, optional_real("v", v)?) {
        (Some(u), None) => Ok((Direction::U, u)),
        (None, Some(v)) => Ok((Direction::V, v)),
        _ => Err(NeurbsError::new_err("one of u and v must be given, got both or neither")),
    }
}

/// The name of a direction.
fn name(direction: Direction) -> &'static str {
    match direction {
        Direction::U => "u",
        Direction::V => "v",
    }
}

#[pymethods]
impl NurbsSurface {
    /// Split the surface at a parameter. Both parts keep their parameters.
    ///
    /// Parameters
    /// ----------
    /// u, v : float, optional
    ///     The parameter of the cut, strictly inside the domain; exactly one of them.
    ///
    /// Returns
    /// -------
    /// before, after : NurbsSurface
    ///     Clamped in the direction of the cut.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the parameter is not strictly inside the domain, or not exactly one is given.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.joined : The inverse operation.
    ///
    /// Notes
    /// -----
    /// Knot insertion up to the multiplicity at which the surface interpolates its net.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> before, after = neurbs.NurbsSurface.sphere([0, 0, 0], 1).split(u=0.25)
    /// >>> before.domain, after.domain
    /// (((0.0, 0.25), (0.0, 1.0)), ((0.25, 1.0), (0.0, 1.0)))
    #[pyo3(signature = (*, u=None, v=None))]
    fn split(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Self, Self)> {
        let (direction, at) = one_direction(u, v)?;
        let (before, after) =
            call::run(py, None, |watcher| self.core().split(direction, at, watcher))?;
        Ok((Self::new(py, before)?, Self::new(py, after)?))
    }

    /// The part over a rectangle of the domain, which keeps its parameters.
    ///
    /// Parameters
    /// ----------
    /// u, v : (float, float), optional
    ///     Parameter ranges inside the domain; by default the whole domain.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Clamped.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a range is empty or exceeds the domain.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.split : Both parts on the sides of a parameter.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> plane.sub_surface(u=(0.25, 0.5))
    /// NurbsSurface(net 2 × 2, degree (1, 1), domain [0.25, 0.5] × [0, 1], polynomial, open)
    #[pyo3(signature = (*, u=None, v=None))]
    fn sub_surface(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (u, v) = self.ranges(u, v)?;
        self.derived(py, |core, watcher| core.sub_surface(u, v, watcher))
    }

    /// Decompose the surface into Bézier patches, one per pair of knot spans.
    ///
    /// Returns
    /// -------
    /// list of list of NurbsSurface
    ///     Row by row. A point has the same u and v on its patch as on the surface.
    ///
    /// Notes
    /// -----
    /// Every inner knot is inserted up to the multiplicity of the degree (*The NURBS Book*, section
    /// 5.3).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> patches = neurbs.NurbsSurface.sphere([0, 0, 0], 1).bezier_patches()
    /// >>> len(patches), len(patches[0])
    /// (4, 2)
    /// >>> patches[3][1]
    /// NurbsSurface(net 3 × 3, degree (2, 2), domain [0.75, 1] × [0.5, 1], rational, open)
    fn bezier_patches(&self, py: Python<'_>) -> PyResult<Vec<Vec<Self>>> {
        let patches = call::run(py, None, |watcher| self.core().bezier_patches(watcher))?;
        let row = |row: Vec<_>| {
            // Creating the Python objects takes longer than the decomposition.
            py.check_signals()?;
            row.into_iter().map(|core| Self::new(py, core)).collect()
        };
        patches.into_iter().map(row).collect()
    }

    /// The curve at a fixed parameter; at the ends of the domain it is a boundary.
    ///
    /// Parameters
    /// ----------
    /// u, v : float, optional
    ///     The fixed parameter, inside the domain; exactly one of them.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     A curve in the other parameter.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the parameter lies outside the domain, or not exactly one is given.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> equator = neurbs.NurbsSurface.sphere([0, 0, 0], 1).isocurve(v=0.5)
    /// >>> equator
    /// NurbsCurve(9 control points, degree 2, domain [0, 1], rational, closed)
    /// >>> round(equator.length(), 6)
    /// 6.283185
    #[pyo3(signature = (*, u=None, v=None))]
    fn isocurve(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<NurbsCurve> {
        let (direction, at) = one_direction(u, v)?;
        NurbsCurve::new(py, self.core().isocurve(direction, at)?)
    }

    /// Join this surface and another one that begins at its end.
    ///
    /// Parameters
    /// ----------
    /// other : NurbsSurface
    ///     A surface that begins where this one ends. Its parameters are shifted to follow this
    ///     domain.
    /// direction : {"u", "v"}, default "u"
    ///     The direction in which the surfaces follow each other.
    /// tolerance : float, default 0
    ///     Largest distance between the common edges, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     With the union of both degrees and knots. The common edge is that of this surface and
    ///     has a knot of multiplicity ``degree``.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the edges are farther apart than the tolerance, or their domains differ.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.split : The inverse operation.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> next = neurbs.NurbsSurface.plane([1, 0, 0], [1, 0, 1], [0, 1, 0])
    /// >>> plane.joined(next)
    /// NurbsSurface(net 3 × 2, degree (1, 1), domain [0, 2] × [0, 1], polynomial, open)
    #[pyo3(
        signature = (other, direction=None, *, tolerance=None),
        text_signature = "($self, other, direction='u', *, tolerance=0.0)"
    )]
    fn joined(
        &self,
        py: Python<'_>,
        other: &Self,
        direction: Option<&Bound<'_, PyAny>>,
        tolerance: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let tolerance = optional_real("tolerance", tolerance)?.unwrap_or(0.0);
        let all = [Direction::U, Direction::V];
        let named = |direction| choice("direction", &all, name, direction);
        let direction = direction.map_or(Ok(Direction::U), named)?;
        self.derived(py, |core, watcher| core.joined(direction, other.core(), tolerance, watcher))
    }
}
