//! What is done with points before anything is learned from them: `neurbs.clean`, `neurbs.pieces`,
//! `neurbs.detect_topology`, `neurbs.EvenSample`, and what could be wrong: `neurbs.inspect`.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use numpy::ndarray::{Ix1, IxDyn};
use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::surface::NurbsSurface;
use super::{arguments, call};
use crate::cloud::{self, Fate};
use crate::{topology, validate};

/// What :func:`clean` found.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Cleaning {
    /// Indices of the points that are kept, ascending, int64 of shape (k,).
    #[pyo3(get)]
    kept: Py<PyArray1<i64>>,
    /// Indices of points that lie where a kept one lies, int64.
    #[pyo3(get)]
    duplicates: Py<PyArray1<i64>>,
    /// Indices of points far from all surface that their neighbours could form, int64.
    #[pyo3(get)]
    outliers: Py<PyArray1<i64>>,
    /// How many points each kept one stands for, float64 of shape (k,): weights for a fit.
    #[pyo3(get)]
    weights: Py<PyArrayDyn<f64>>,
    /// Median of the kept points' mean distance to their 8 nearest, in the points' unit.
    #[pyo3(get)]
    spacing: f64,
    counts: [usize; 3],
}

#[pymethods]
impl Cleaning {
    fn __repr__(&self) -> String {
        let [kept, duplicates, outliers] = self.counts;
        format!("Cleaning({kept} kept, {duplicates} duplicates, {outliers} outliers)")
    }
}

/// Find duplicates and gross outliers.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     At least four distinct points, finite, not all on one line.
/// progress : callable, optional
///     Called some 25 times a second with a `Progress`. An exception that it raises ends the job.
///
/// Returns
/// -------
/// Cleaning
///     With ``kept``, ``duplicates``, ``outliers`` (indices), ``weights`` and ``spacing``.
///
/// Raises
/// ------
/// NeurbsError
///     If the points cannot be a surface.
///
/// Notes
/// -----
/// A point is a duplicate if an earlier one lies within a ten-thousandth of the typical spacing. It
/// is an outlier if it is 2.5 times as far from its 8 nearest as is usual there (or in the whole
/// cloud), off the plane that they lie in and off where they bend to, or 6 times as far in any case.
/// So scan lines, contour lines, and densities that vary tenfold stay whole. O(n log n).
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> points = np.random.default_rng(0).random((1000, 3)) * [1, 1, 0.01]
/// >>> neurbs.clean(np.vstack([points, points[:5], [[0.5, 0.5, 3]]]))
/// Cleaning(1000 kept, 5 duplicates, 1 outliers)
#[pyfunction]
#[pyo3(signature = (points, *, progress=None))]
pub(super) fn clean(points: &Bound<'_, PyAny>, progress: Option<Py<PyAny>>) -> PyResult<Cleaning> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let found = call::run(py, progress, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        cloud::clean(points, watcher)
    })?;
    let of = |wanted: Fate| {
        let pairs = (0_i64..).zip(&found.fates);
        let indices = pairs.filter(move |(_, fate)| **fate == wanted).map(|(index, _)| index);
        integers(py, &indices.collect::<Vec<i64>>())
    };
    let weights: Vec<f64> = if found.multiplicity.is_empty() {
        vec![1.0; found.kept.len()]
    } else {
        found.multiplicity.iter().map(|&count| f64::from(count)).collect()
    };
    Ok(Cleaning {
        kept: of(Fate::Kept)?,
        duplicates: of(Fate::Duplicate)?,
        outliers: of(Fate::Outlier)?,
        weights: reals(py, &[weights.len()], &weights)?,
        spacing: found.spacing,
        counts: [Fate::Kept, Fate::Duplicate, Fate::Outlier].map(|fate| found.count(fate)),
    })
}

/// The pieces that points fall into, found by :func:`pieces`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Pieces {
    /// For each point the number of its piece, int64 of shape (n,); 0 is the largest.
    #[pyo3(get)]
    labels: Py<PyArray1<i64>>,
    /// How many points each piece has, descending.
    #[pyo3(get)]
    sizes: Vec<usize>,
    /// The smallest distance between two pieces, in the points' unit; infinite if there is one.
    #[pyo3(get)]
    gap: f64,
    /// What to know about several pieces; None if there is one.
    #[pyo3(get)]
    warning: Option<String>,
}

#[pymethods]
impl Pieces {
    fn __repr__(&self) -> String {
        format!("Pieces(sizes={:?}, gap={:.4})", self.sizes, self.gap)
    }
}

/// Find the pieces that points fall into.
///
/// Points belong together when they are near one another as compared with the spacing there. Points
/// in lines (scan lines, contour lines, ship tracks) are one piece although the lines are far apart, also
/// where noise makes ropes of them.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     Points without outliers; see `clean`.
/// progress : callable, optional
///     Called some 25 times a second with a `Progress`.
///
/// Returns
/// -------
/// Pieces
///     With ``labels``, ``sizes``, ``gap`` and ``warning``.
///
/// Raises
/// ------
/// NeurbsError
///     If the points cannot be a surface.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> sheet = np.random.default_rng(0).random((500, 3)) * [1, 1, 0]
/// >>> neurbs.pieces(np.vstack([sheet, sheet[:100] + [0, 0, 2]])).sizes
/// [500, 100]
#[pyfunction]
#[pyo3(signature = (points, *, progress=None))]
pub(super) fn pieces(points: &Bound<'_, PyAny>, progress: Option<Py<PyAny>>) -> PyResult<Pieces> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let found = call::run(py, progress, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        cloud::pieces(points, watcher)
    })?;
    let labels: Vec<i64> = found.labels.iter().map(|&label| i64::from(label)).collect();
    let warning = found.warning();
    Ok(Pieces { labels: integers(py, &labels)?, sizes: found.sizes, gap: found.gap, warning })
}

/// The kind of surface that points lie on, found by :func:`detect_topology`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Topology {
    /// ``"sheet"``, ``"height"``, ``"tube"`` or ``"torus"``.
    #[pyo3(get)]
    kind: &'static str,
    /// Why.
    #[pyo3(get)]
    reason: String,
    /// What to know; None if there is nothing.
    #[pyo3(get)]
    warning: Option<String>,
    /// Of a height field: the direction of the heights, float64 of shape (3,); otherwise None.
    #[pyo3(get)]
    up: Option<Py<PyArrayDyn<f64>>>,
    chart: Option<topology::Chart>,
}

#[pymethods]
impl Topology {
    /// Points of a tube or torus, evenly chosen: float64 of shape (k, 3); otherwise None.
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Option<Py<PyArrayDyn<f64>>>> {
        let array = |chart: &topology::Chart| vectors(py, &[chart.points.len()], &chart.points);
        self.chart.as_ref().map(array).transpose()
    }

    /// Their places on it, float64 of shape (k, 2) in [0, 1]: u around a tube and v along it; u along
    /// a torus's ring and v around its section; otherwise None.
    #[getter]
    fn uv(&self, py: Python<'_>) -> PyResult<Option<Py<PyArrayDyn<f64>>>> {
        let array = |chart: &topology::Chart| {
            reals(py, &[chart.uv.len(), 2], bytemuck::cast_slice(&chart.uv))
        };
        self.chart.as_ref().map(array).transpose()
    }

    /// Lengths of a tube or torus along u and v in its middle; otherwise None.
    #[getter]
    fn lengths(&self) -> Option<(f64, f64)> {
        self.chart.as_ref().map(|chart| chart.lengths)
    }

    /// Nodes in order on a tube or torus, to start a map from.
    ///
    /// Parameters
    /// ----------
    /// rows, cols : int
    ///     Nodes along u and v.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (rows, cols, 3) or None
    ///     For ``SelfOrganizingMap(init=...)``; None for other kinds.
    fn lattice(
        &self,
        py: Python<'_>,
        rows: &Bound<'_, PyAny>,
        cols: &Bound<'_, PyAny>,
    ) -> PyResult<Option<Py<PyArrayDyn<f64>>>> {
        let shape: (usize, usize) =
            (arguments::count("rows", rows)?, arguments::count("cols", cols)?);
        let Some(chart) = &self.chart else { return Ok(None) };
        let nodes = py.detach(|| chart.lattice(shape));
        Ok(Some(vectors(py, &[shape.0, shape.1], &nodes)?))
    }

    fn __repr__(&self) -> String {
        format!("Topology({:?}: {})", self.kind, self.reason)
    }
}

/// Find out what kind of surface points lie on.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     Points without outliers; see `clean`.
/// progress : callable, optional
///     Called some 25 times a second with a `Progress`.
///
/// Returns
/// -------
/// Topology
///     With ``kind``, ``reason``, ``warning``; ``up`` of a height field; ``points``, ``uv``,
///     ``lengths`` and ``lattice()`` of a tube or torus.
///
/// Raises
/// ------
/// NeurbsError
///     If the points cannot be a surface.
///
/// Notes
/// -----
/// A height field has no steep slopes, and nothing lies above anything else; or it is a ground over
/// x and y, and what lies above or below others is high and rough, as trees are in a scan from the
/// air, of which ``warning`` tells. Tubes and tori have loops that cannot be shrunk, found by
/// persistent cohomology of landmarks; loops around holes are told by their lengths, which grow from
/// the rim outwards. Looks at 5,000 points at most for slopes, at 10,000 for loops, at 20,000 for
/// layers above one another and at 200,000 for a ground.
///
/// References
/// ----------
/// V. de Silva, D. Morozov, M. Vejdemo-Johansson, Persistent cohomology and circular coordinates,
/// Discrete & Computational Geometry 45 (2011).
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> turns, z = np.random.default_rng(0).random((2, 2000))
/// >>> angle = 2 * np.pi * turns
/// >>> points = np.column_stack([np.cos(angle), np.sin(angle), 3 * z])
/// >>> topology = neurbs.detect_topology(points)
/// >>> topology.kind
/// 'tube'
/// >>> topology.lattice(12, 8).shape
/// (12, 8, 3)
#[pyfunction]
#[pyo3(signature = (points, *, progress=None))]
pub(super) fn detect_topology(
    points: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Topology> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let found = call::run(py, progress, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        topology::detect(points, watcher)
    })?;
    let up = found.height.map(|height| reals(py, &[3], &height.up.to_array())).transpose()?;
    let (reason, warning, chart) = (found.reason, found.warning, found.chart);
    Ok(Topology { kind: found.kind.name(), reason, warning, up, chart })
}

/// EvenSample(most)
/// --
///
/// A few points, evenly over space, from a stream of any length.
///
/// Space is cut into cubes; of each the point with the lowest hash is kept. What is kept depends on
/// the points alone, neither on their order nor on how they were cut into chunks.
///
/// Parameters
/// ----------
/// most : int
///     How many points to keep at most; memory is for some of them.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> sample = neurbs.EvenSample(100)
/// >>> for seed in range(5):
/// ...     sample.extend(np.random.default_rng(seed).random((10_000, 3)))
/// >>> len(sample.points) <= 100
/// True
#[pyclass(frozen, module = "neurbs")]
pub(super) struct EvenSample(Mutex<cloud::EvenSample>);

#[pymethods]
impl EvenSample {
    #[new]
    fn new(most: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(Mutex::new(cloud::EvenSample::new(arguments::count("most", most)?))))
    }

    /// Look at the next points of the stream.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Finite points.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite, or the array has the wrong shape or dtype.
    fn extend(&self, points: &Bound<'_, PyAny>) -> PyResult<()> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        call::run(points.py(), None, |_| {
            cloud::check_finite(slice)?;
            self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(slice);
            Ok(())
        })
    }

    /// The points kept so far, in the order of the stream, float64 of shape (k, 3).
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Py<PyArrayDyn<f64>>> {
        let points = self.0.lock().unwrap_or_else(PoisonError::into_inner).points();
        vectors(py, &[points.len()], &points)
    }

    /// Their places in the stream, int64 of shape (k,).
    #[getter]
    fn indices(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i64>>> {
        let indices = self.0.lock().unwrap_or_else(PoisonError::into_inner).indices();
        integers(py, &indices.iter().map(|&index| index.cast_signed()).collect::<Vec<i64>>())
    }
}

/// Say in words what could be wrong with points, or with a surface through them.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     The points.
/// surface : NurbsSurface, optional
///     A surface through them.
/// progress : callable, optional
///     Called some 25 times a second with a `Progress`.
///
/// Returns
/// -------
/// list of str
///     Of the points: axes that look as if they had different units, pieces, two layers closer than
///     the spacing. Of the surface: where it folds over though the points do not, and how much of it
///     is far from every point.
///
/// Raises
/// ------
/// NeurbsError
///     If the points cannot be a surface.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> sheet = np.random.default_rng(0).random((500, 3)) * [1, 1, 0]
/// >>> neurbs.inspect(sheet)
/// []
/// >>> neurbs.inspect(sheet * [1, 1000, 1])[0][:42]
/// 'the points extend 0.9979 × 991.4789 × 0.00'
#[pyfunction]
#[pyo3(signature = (points, surface=None, *, progress=None))]
pub(super) fn inspect(
    points: &Bound<'_, PyAny>,
    surface: Option<&Bound<'_, NurbsSurface>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<String>> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let surface = surface.map(|surface| surface.get().core());
    call::run(py, progress, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        let mut words = Vec::new();
        words.extend(validate::uneven_extents(points).map(|found| found.to_string()));
        words.extend(cloud::pieces(points, watcher)?.warning());
        words.extend(validate::double_layer(points, watcher)?.map(|found| found.to_string()));
        if let Some(surface) = surface {
            words.extend(
                validate::fold_over(surface, points, watcher)?.map(|found| found.to_string()),
            );
            let excursion = validate::excursion(surface, points, watcher)?;
            words.extend((excursion.share > 0.0).then(|| excursion.to_string()));
        }
        Ok(words)
    })
}

fn integers(py: Python<'_>, values: &[i64]) -> PyResult<Py<PyArray1<i64>>> {
    arrays::constant::<i64, Ix1>(py, &[values.len()], values)
}

fn reals(py: Python<'_>, shape: &[usize], values: &[f64]) -> PyResult<Py<PyArrayDyn<f64>>> {
    arrays::constant::<f64, IxDyn>(py, shape, values)
}

fn vectors(py: Python<'_>, shape: &[usize], values: &[DVec3]) -> PyResult<Py<PyArrayDyn<f64>>> {
    let shape: Vec<usize> = shape.iter().copied().chain([3]).collect();
    reals(py, &shape, bytemuck::cast_slice(values))
}
