//! The functions `neurbs.clean` and `neurbs.components`, and the class `neurbs.EvenSample`.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use numpy::ndarray::{Ix1, IxDyn};
use numpy::{PyArray1, PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::arrays::{self, Numbers};
use super::pickling::{Reduced, read_only, reduced, reduced_to_bytes};
use super::{arguments, call};
use crate::cloud::{self, Fate};

/// The result of :func:`clean`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Cleaning {
    /// Indices of the kept points, ascending, int64 of shape (k,).
    #[pyo3(get)]
    kept: Py<PyArray1<i64>>,
    /// Indices of points at the position of a kept point, int64.
    #[pyo3(get)]
    duplicates: Py<PyArray1<i64>>,
    /// Indices of points far from the surface formed by their neighbors, int64.
    #[pyo3(get)]
    outliers: Py<PyArray1<i64>>,
    /// Number of points that each kept point represents, float64 of shape (k,): weights for a fit.
    #[pyo3(get)]
    weights: Py<PyArrayDyn<f64>>,
    /// Median distance of the kept points to their third-nearest neighbor, in the points' unit.
    #[pyo3(get)]
    spacing: f64,
}

#[pymethods]
impl Cleaning {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        py: Python<'_>,
        kept: Py<PyArray1<i64>>,
        duplicates: Py<PyArray1<i64>>,
        outliers: Py<PyArray1<i64>>,
        weights: Py<PyArrayDyn<f64>>,
        spacing: f64,
    ) -> PyResult<Self> {
        let [kept, duplicates, outliers] = [kept, duplicates, outliers].map(|of| read_only(py, of));
        let weights = read_only(py, weights)?;
        Ok(Self { kept: kept?, duplicates: duplicates?, outliers: outliers?, weights, spacing })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["kept", "duplicates", "outliers", "weights", "spacing"])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let [kept, duplicates, outliers] =
            [&self.kept, &self.duplicates, &self.outliers].map(|of| of.bind(py).len());
        format!("Cleaning({kept} kept, {duplicates} duplicates, {outliers} outliers)")
    }
}

/// Find duplicates and gross outliers.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     Finite points, at least four distinct, not all on one line.
/// progress : callable, optional
///     Called about 25 times a second with a `Progress`. An exception it raises ends the job.
///
/// Returns
/// -------
/// Cleaning
///     With ``kept``, ``duplicates``, ``outliers`` (indices), ``weights`` and ``spacing``.
///
/// Raises
/// ------
/// NeurbsError
///     If the points do not form a surface.
///
/// Notes
/// -----
/// The spacing at a point is the distance to its third-nearest neighbor. A duplicate lies within a
/// ten-thousandth of the typical spacing from an earlier point. An outlier has more than twice the
/// typical spacing, and one of these holds:
///
/// - its spacing is more than twice that of its surroundings, and it lies steeply above their
///   plane;
/// - it fills a volume with its neighbors;
/// - its spacing is more than four times the radius of the cloud.
///
/// Up to 32 points, only the last counts. Scan lines, contour lines and tenfold changes of density
/// are not mistaken for outliers. O(n log n).
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
    })
}

/// The connected components of a cloud, returned by :func:`components`.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Components {
    /// Component number of each point, int64 of shape (n,); 0 is the largest component. -1 for
    /// points in groups too small to be a component.
    #[pyo3(get)]
    labels: Py<PyArray1<i64>>,
    /// Number of points of each component, descending.
    #[pyo3(get)]
    sizes: Vec<usize>,
    /// Smallest distance between two components, in the points' unit; infinite for one component.
    #[pyo3(get)]
    gap: f64,
}

#[pymethods]
impl Components {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        py: Python<'_>,
        labels: Py<PyArray1<i64>>,
        sizes: Vec<usize>,
        gap: f64,
    ) -> PyResult<Self> {
        Ok(Self { labels: read_only(py, labels)?, sizes, gap })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["labels", "sizes", "gap"])
    }

    fn __repr__(&self) -> String {
        format!("Components(sizes={:?}, gap={:.4})", self.sizes, self.gap)
    }
}

/// Find the connected components of a cloud.
///
/// Points are connected if their distance is small compared with the local spacing. Scan lines,
/// contour lines and ship tracks form one component although the lines are far apart.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     Points without outliers; see `clean`.
/// progress : callable, optional
///     Called about 25 times a second with a `Progress`. An exception it raises ends the job.
///
/// Returns
/// -------
/// Components
///     With ``labels``, ``sizes`` and ``gap``.
///
/// Raises
/// ------
/// NeurbsError
///     If the points do not form a surface.
///
/// Examples
/// --------
/// >>> import neurbs, numpy as np
/// >>> sheet = np.random.default_rng(0).random((500, 3)) * [1, 1, 0]
/// >>> neurbs.components(np.vstack([sheet, sheet[:100] + [0, 0, 2]])).sizes
/// [500, 100]
#[pyfunction]
#[pyo3(signature = (points, *, progress=None))]
pub(super) fn components(
    points: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Components> {
    let py = points.py();
    let numbers = Numbers::points(points, "points")?;
    let points: &[DVec3] = numbers.as_slice()?;
    let found = call::run(py, progress, |watcher| {
        cloud::checked_bounds(points, watcher)?;
        cloud::components(points, watcher)
    })?;
    let number = |label: u32| if label == cloud::Components::STRAY { -1 } else { label.into() };
    let labels: Vec<i64> = found.labels.iter().map(|&label| number(label)).collect();
    Ok(Components { labels: integers(py, &labels)?, sizes: found.sizes, gap: found.gap })
}

/// Measure the distance from each point to the nearest point of a cloud.
///
/// Parameters
/// ----------
/// cloud : array_like of shape (m, 3) or (m, 2)
///     Finite points.
/// points : array_like of shape (n, 3) or (n, 2)
///     Finite points.
///
/// Returns
/// -------
/// ndarray of shape (n,)
///     float64, in the points' unit; infinite for an empty cloud.
#[pyfunction]
pub(super) fn cloud_distances<'py>(
    cloud: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let py = points.py();
    let (cloud, points) = (Numbers::points(cloud, "cloud")?, Numbers::points(points, "points")?);
    let (cloud, points): (&[DVec3], &[DVec3]) = (cloud.as_slice()?, points.as_slice()?);
    let distances = call::run(py, None, |watcher| {
        cloud::check_finite(cloud)?;
        cloud::check_finite(points)?;
        cloud::KdTree::over(cloud, watcher)?.distances(points, watcher)
    })?;
    Ok(PyArray1::from_vec(py, distances))
}

/// EvenSample(most)
/// --
///
/// An even spatial subsample of a stream of points of any length.
///
/// Space is divided into cubes; the point with the lowest hash in each cube is kept. The result
/// does not depend on the order of the points or their division into chunks. Samples of the parts of
/// a stream merge to that of the stream.
///
/// Parameters
/// ----------
/// most : int
///     Largest number of points to keep. Memory is proportional to it.
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

    /// Add the next points of the stream.
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

    /// Add the sample of the points that follow in the stream.
    ///
    /// Parameters
    /// ----------
    /// next : EvenSample
    ///     A sample that keeps as many points. It stays as it is.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If it keeps another number of points.
    fn merge(&self, py: Python<'_>, next: &Self) -> PyResult<()> {
        call::run(py, None, |_| {
            let next = next.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
            self.0.lock().unwrap_or_else(PoisonError::into_inner).merge(&next)
        })
    }

    /// Number of points in the stream so far.
    #[getter]
    fn seen(&self) -> u64 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).seen()
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.0.lock().unwrap_or_else(PoisonError::into_inner).to_bytes())
    }

    #[staticmethod]
    fn from_bytes(state: &[u8]) -> PyResult<Self> {
        Ok(Self(Mutex::new(cloud::EvenSample::from_bytes(state)?)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced_to_bytes(slf)
    }

    fn __repr__(&self) -> String {
        let sample = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (kept, seen) = (sample.indices().len(), sample.seen());
        format!("EvenSample({kept} of {seen} points)")
    }

    /// The points kept so far, in the order of the stream, float64 of shape (k, 3).
    #[getter]
    fn points(&self, py: Python<'_>) -> PyResult<Py<PyArrayDyn<f64>>> {
        let points = self.0.lock().unwrap_or_else(PoisonError::into_inner).points();
        vectors(py, &[points.len()], &points)
    }

    /// Their indices in the stream, int64 of shape (k,).
    #[getter]
    fn indices(&self, py: Python<'_>) -> PyResult<Py<PyArray1<i64>>> {
        let indices = self.0.lock().unwrap_or_else(PoisonError::into_inner).indices();
        integers(py, &indices.iter().map(|&index| index.cast_signed()).collect::<Vec<i64>>())
    }
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
