//! The class `neurbs.PartialSums`.

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::arguments::{real, two, vector};
use super::arrays::Numbers;
use super::call;
use super::errors::bad_argument;
use super::pickling::{Reduced, reduced_to_bytes};
use super::surface::NurbsSurface;
use super::surface_arguments::{closed, degrees, knot_vectors};
use crate::fit::{self, FitOptions};

/// Sums over points at known parameters, from which a surface is solved: a least-squares fit, or a
/// part of one.
///
/// Sums over parts of a cloud are added: points in several files, processes or machines give the
/// same surface as together, up to rounding.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct PartialSums(fit::PartialSums);

#[pymethods]
impl PartialSums {
    /// Sum points at parameters.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     At least one finite point.
    /// uv : array_like of shape (n, 2)
    ///     Their parameters.
    /// knots : (array_like, array_like)
    ///     Knots of the surface in u and v.
    /// degree : int or (int, int), default 3
    ///     Degrees in u and v.
    /// closed : bool or (bool, bool), default False
    ///     Directions in which the surface closes smoothly; their knots must be periodic.
    /// origin : array_like of shape (3,), default (0, 0, 0)
    ///     A place near the points: coordinates keep most digits relative to it. Sums that are
    ///     added need the same one.
    /// weights : array_like of shape (n,), optional
    ///     Weight of each squared distance, at least 0.
    ///
    /// Returns
    /// -------
    /// PartialSums
    ///     The sums, of a size that does not depend on the number of points.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If an array has the wrong shape, or a value is out of its range.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs, numpy as np
    /// >>> uv = np.random.default_rng(0).random((400, 2))
    /// >>> points = np.column_stack([uv, uv[:, 0] * uv[:, 1]])
    /// >>> knots = neurbs.NurbsSurface.fit(points, uv, net=(6, 5)).knots
    /// >>> halves = [neurbs.PartialSums.of(points[i::2], uv[i::2], knots) for i in (0, 1)]
    /// >>> surface = (halves[0] + halves[1]).solve(1e-9)
    /// >>> bool(surface.closest_points(points).distances.max() < 1e-6)
    /// True
    #[staticmethod]
    #[pyo3(
        signature = (points, uv, knots, *, degree=None, closed=None, origin=None, weights=None),
        text_signature = "(points, uv, knots, *, degree=3, closed=False, origin=(0, 0, 0), \
                          weights=None)"
    )]
    fn of(
        points: &Bound<'_, PyAny>,
        uv: &Bound<'_, PyAny>,
        knots: &Bound<'_, PyAny>,
        degree: Option<&Bound<'_, PyAny>>,
        closed: Option<&Bound<'_, PyAny>>,
        origin: Option<&Bound<'_, PyAny>>,
        weights: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = points.py();
        let (knots_u, knots_v) = knot_vectors(knots, degrees(degree)?)?;
        let options = FitOptions { knots_u, knots_v, closed: self::closed(closed)?, fairness: 0.0 };
        let origin = origin.map(|origin| vector(origin, "origin")).transpose()?;
        let points = Numbers::points(points, "points")?;
        let uv = Numbers::parameters(uv)?;
        let weights = weights.map(|weights| Numbers::sequence(weights, "weights")).transpose()?;
        let weights = weights.as_ref().map(Numbers::as_slice).transpose()?;
        let (points, uv) = (points.as_slice()?, uv.as_slice()?);
        let sums = call::without_gil(py, || {
            fit::PartialSums::of(points, uv, weights, origin.unwrap_or_default(), &options)
        });
        Ok(Self(sums??))
    }

    /// The sums over the points of both.
    fn __add__(&self, other: &Self) -> PyResult<Self> {
        let mut sums = self.0.clone();
        sums.merge(&other.0)?;
        Ok(Self(sums))
    }

    /// Number of points.
    #[getter]
    fn points(&self) -> u64 {
        self.0.count()
    }

    /// Solve for the surface with the least squared distances.
    ///
    /// Parameters
    /// ----------
    /// fairness : float
    ///     Weight of the fairness energy: 1 makes it as important as all points together.
    /// lengths : (float, float), optional
    ///     Lengths of the domain in space along u and v. With them the energy sums squared third
    ///     derivatives, and the surface does not depend on the parts, up to rounding. Without, it
    ///     is a thin plate's, and neighbors in each part give the lengths.
    ///
    /// Returns
    /// -------
    /// NurbsSurface
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the points do not determine the net, or an argument is out of its range.
    /// NeurbsMemoryError
    ///     If there is too little memory for the equations.
    #[pyo3(signature = (fairness, lengths=None))]
    fn solve(
        &self,
        py: Python<'_>,
        fairness: &Bound<'_, PyAny>,
        lengths: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<NurbsSurface> {
        let fairness = real("fairness", fairness)?;
        let pair = |value: &Bound<'_, PyAny>| {
            let refused = || bad_argument("lengths", "two positive numbers", value);
            let [u, v] = two(value).ok_or_else(refused)?;
            Ok::<_, PyErr>((real("lengths", &u)?, real("lengths", &v)?))
        };
        let lengths = lengths.map(pair).transpose()?;
        let surface = call::without_gil(py, || match lengths {
            Some(lengths) => self.0.solve_over(fairness, lengths),
            None => self.0.solve(fairness),
        });
        NurbsSurface::new(py, surface??)
    }

    /// Return the sum of the weighted squared distances from the points to a surface.
    ///
    /// Parameters
    /// ----------
    /// surface : NurbsSurface
    ///     A polynomial surface with the knots of the sums. Distances are those at the points'
    ///     parameters.
    ///
    /// Returns
    /// -------
    /// float
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the knots differ, or the surface is rational.
    fn squared_distance(&self, surface: &Bound<'_, NurbsSurface>) -> PyResult<f64> {
        Ok(self.0.squared_distance(surface.get().core())?)
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.0.to_bytes())
    }

    #[staticmethod]
    fn from_bytes(state: &[u8]) -> PyResult<Self> {
        Ok(Self(fit::PartialSums::from_bytes(state)?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced_to_bytes(slf)
    }

    fn __repr__(&self) -> String {
        format!("PartialSums({} points)", self.0.count())
    }
}
