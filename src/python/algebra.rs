//! `neurbs.NurbsSurface`: what can be done to a surface without moving it, and what it measures.

use glam::{DAffine3, DVec3};
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::call;
use super::curve::NurbsCurve;
use super::errors::NeurbsError;
use super::evaluation::Array;
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::nurbs::{self, Direction};

/// Applies one step in each direction for which there is an argument.
fn step<T>(
    surface: &nurbs::NurbsSurface,
    (u, v): (Option<T>, Option<T>),
    f: impl Fn(&nurbs::NurbsSurface, Direction, T) -> Result<nurbs::NurbsSurface>,
) -> Result<nurbs::NurbsSurface> {
    let mut surface = surface.clone();
    if let Some(u) = u {
        surface = f(&surface, Direction::U, u)?;
    }
    if let Some(v) = v {
        surface = f(&surface, Direction::V, v)?;
    }
    Ok(surface)
}

/// Knots from Python.
pub(super) fn values(knots: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Option<Vec<f64>>> {
    let list = |knots| Ok::<_, PyErr>(Numbers::sequence(knots, name)?.as_slice()?.to_vec());
    knots.map(list).transpose()
}

/// The one direction for which there is an argument.
fn one(u: Option<f64>, v: Option<f64>) -> PyResult<(Direction, f64)> {
    match (u, v) {
        (Some(u), None) => Ok((Direction::U, u)),
        (None, Some(v)) => Ok((Direction::V, v)),
        _ => Err(NeurbsError::new_err("one of u and v must be given, got both or neither")),
    }
}

/// A direction by its name.
fn named(direction: &str) -> PyResult<Direction> {
    match direction {
        "u" => Ok(Direction::U),
        "v" => Ok(Direction::V),
        other => {
            Err(NeurbsError::new_err(format!("direction must be \"u\" or \"v\", got {other:?}")))
        }
    }
}

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

/// A vector as an array.
fn vector(py: Python<'_>, vector: DVec3) -> PyResult<Array<'_>> {
    let array = arrays::output(py, None, &[3])?;
    arrays::writable(&array)?.as_slice_mut()?.copy_from_slice(&vector.to_array());
    Ok(array)
}

impl NurbsSurface {
    /// Makes a surface of another one, without the GIL.
    fn derived(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&nurbs::NurbsSurface) -> Result<nurbs::NurbsSurface> + Send,
    ) -> PyResult<Self> {
        let core = call::run(py, None, |_| f(self.core()))?;
        Self::new(py, core)
    }
}

#[pymethods]
impl NurbsSurface {
    /// The same surface with more knots.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like, optional
    ///     New knots strictly inside the domain; one that is named twice is inserted twice.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a knot lies outside the domain, or would stand more often than the degree.
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
        self.derived(py, |core| {
            step(core, knots, |surface, direction, knots| surface.insert_knots(direction, &knots))
        })
    }

    /// The surface with fewer knots, no point of which moves further than a tolerance.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like, optional
    ///     Inner knots that may go, each once for each time it is named; without either of them
    ///     all inner knots.
    /// tolerance : float
    ///     The furthest that a point may move, in the points' unit. Knots that are missed least
    ///     go first.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the tolerance is negative or not finite.
    #[pyo3(signature = (u=None, v=None, *, tolerance))]
    fn remove_knots(
        &self,
        py: Python<'_>,
        u: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
        tolerance: f64,
    ) -> PyResult<Self> {
        let (u, v) = (values(u, "u")?, values(v, "v")?);
        let all = u.is_none() && v.is_none();
        // Both directions may move a point: each gets its share.
        let share = if all || (u.is_some() && v.is_some()) { tolerance / 2.0 } else { tolerance };
        let knots = if all { (Some(None), Some(None)) } else { (u.map(Some), v.map(Some)) };
        self.derived(py, |core| {
            step(core, knots, |surface, direction, knots: Option<Vec<f64>>| {
                surface.remove_knots(direction, knots.as_deref(), share)
            })
        })
    }

    /// The same surface with higher degrees, clamped.
    ///
    /// Parameters
    /// ----------
    /// u, v : int, default 0
    ///     How much higher; no degree may pass 9.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a degree would pass 9.
    #[pyo3(signature = (u=0, v=0))]
    fn elevate_degree(&self, py: Python<'_>, u: usize, v: usize) -> PyResult<Self> {
        self.derived(py, |core| core.elevate_degree(u, v))
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
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a degree would be 0, or the tolerance cannot be held: the message says what can.
    #[pyo3(signature = (u=0, v=0, *, tolerance))]
    fn reduce_degree(&self, py: Python<'_>, u: usize, v: usize, tolerance: f64) -> PyResult<Self> {
        self.derived(py, |core| core.reduce_degree(u, v, tolerance))
    }

    /// The same surface with clamped knots: its net begins and ends where it does.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    fn clamped(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, nurbs::NurbsSurface::clamp)
    }

    /// The parts before and after a parameter, which keep their parameters.
    ///
    /// Parameters
    /// ----------
    /// u, v : float, optional
    ///     Where to cut, strictly inside the domain; exactly one of them.
    ///
    /// Returns
    /// -------
    /// before, after : NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the parameter does not lie strictly inside the domain.
    #[pyo3(signature = (*, u=None, v=None))]
    fn split(&self, py: Python<'_>, u: Option<f64>, v: Option<f64>) -> PyResult<(Self, Self)> {
        let (direction, at) = one(u, v)?;
        let (before, after) = self.core().split(direction, at)?;
        Ok((Self::new(py, before)?, Self::new(py, after)?))
    }

    /// The part over a rectangle of the domain, which keeps its parameters.
    ///
    /// Parameters
    /// ----------
    /// u, v : (float, float), optional
    ///     Ranges of parameters; by default the whole.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a range is empty or leaves the domain.
    #[pyo3(signature = (*, u=None, v=None))]
    fn sub_surface(
        &self,
        py: Python<'_>,
        u: Option<(f64, f64)>,
        v: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        self.derived(py, |core| {
            let u = u.unwrap_or(core.knots_u().domain());
            core.sub_surface(u, v.unwrap_or(core.knots_v().domain()))
        })
    }

    /// The surface as Bézier patches, one for each pair of knot spans.
    ///
    /// Returns
    /// -------
    /// list of list of NurbsSurface
    ///     Row by row; each patch keeps its parameters.
    fn bezier_patches(&self, py: Python<'_>) -> PyResult<Vec<Vec<Self>>> {
        let patches = call::run(py, None, |_| self.core().bezier_patches())?;
        let row = |row: Vec<_>| row.into_iter().map(|core| Self::new(py, core)).collect();
        patches.into_iter().map(row).collect()
    }

    /// The curve of points with one parameter fixed.
    ///
    /// Parameters
    /// ----------
    /// u, v : float, optional
    ///     The fixed parameter, inside the domain; exactly one of them.
    ///
    /// Returns
    /// -------
    /// NurbsCurve
    ///     It runs in the other parameter.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the parameter lies outside the domain.
    #[pyo3(signature = (*, u=None, v=None))]
    fn isocurve(&self, py: Python<'_>, u: Option<f64>, v: Option<f64>) -> PyResult<NurbsCurve> {
        let (direction, at) = one(u, v)?;
        NurbsCurve::new(py, self.core().isocurve(direction, at)?)
    }

    /// The same surface run through backwards in some directions.
    ///
    /// Parameters
    /// ----------
    /// u, v : bool, default False
    ///     Which ones. Each turns the normals over.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    #[pyo3(signature = (u=false, v=false))]
    fn reversed(&self, py: Python<'_>, u: bool, v: bool) -> PyResult<Self> {
        self.derived(py, |core| {
            step(core, (u.then_some(()), v.then_some(())), |surface, direction, ()| {
                surface.reversed(direction)
            })
        })
    }

    /// The same surface with u and v exchanged, which turns the normals over.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    fn transposed(&self, py: Python<'_>) -> PyResult<Self> {
        self.derived(py, nurbs::NurbsSurface::transposed)
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
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the matrix has another shape, or a last row that is not [0, 0, 0, 1].
    fn transformed(&self, matrix: &Bound<'_, PyAny>) -> PyResult<Self> {
        let map = affine(matrix)?;
        self.derived(matrix.py(), |core| core.transformed(&map))
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
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a range is empty or not finite.
    #[pyo3(signature = (*, u=None, v=None))]
    fn with_domain(
        &self,
        py: Python<'_>,
        u: Option<(f64, f64)>,
        v: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        self.derived(py, |core| {
            let u = u.unwrap_or(core.knots_u().domain());
            core.with_domain(u, v.unwrap_or(core.knots_v().domain()))
        })
    }

    /// This surface and the one that follows it, as one.
    ///
    /// Parameters
    /// ----------
    /// other : NurbsSurface
    ///     Begins where this one ends. Its parameters are moved behind the domain of this one.
    /// direction : {"u", "v"}, default "u"
    ///     The direction in which it follows.
    /// tolerance : float, default 0
    ///     How far the edges may be apart, in the points' unit.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///     Degrees and knots are the union of both.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the edges are further apart than the tolerance, or the domains along the edge differ.
    #[pyo3(signature = (other, direction="u", *, tolerance=0.0))]
    fn joined(
        &self,
        py: Python<'_>,
        other: &Self,
        direction: &str,
        tolerance: f64,
    ) -> PyResult<Self> {
        let direction = named(direction)?;
        self.derived(py, |core| core.joined(direction, other.core(), tolerance))
    }

    /// The smallest box with sides along the axes that holds the surface.
    ///
    /// Parameters
    /// ----------
    /// tight : bool, default True
    ///     Whether the surface touches all its sides, up to 1e-10 of the size; otherwise it is the
    ///     box of the net, which is larger and costs less.
    ///
    /// Returns
    /// -------
    /// low, high : ndarray of shape (3,)
    #[pyo3(signature = (*, tight=true))]
    fn bounding_box<'py>(
        &self,
        py: Python<'py>,
        tight: bool,
    ) -> PyResult<(Array<'py>, Array<'py>)> {
        let core = self.core();
        let (low, high) =
            if tight { call::run(py, None, |_| core.bounding_box())? } else { core.net_box() };
        Ok((vector(py, low)?, vector(py, high)?))
    }

    /// The area of the surface.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Share of the area by which it may be wrong, from 1e-14.
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
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.NurbsSurface.sphere([0, 0, 0], 1).area(), 6)
    /// 12.566371
    #[pyo3(signature = (*, accuracy=1e-9))]
    fn area(&self, py: Python<'_>, accuracy: f64) -> PyResult<f64> {
        call::run(py, None, |_| self.core().area(accuracy))
    }
}
