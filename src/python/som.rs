//! The class behind `neurbs.SelfOrganizingMap`: a map and its training.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use numpy::ndarray::IxDyn;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::arguments;
use super::arrays::{self, Numbers};
use super::batch_sums::BatchSums;
use super::call::{self, Callbacks, Watcher};
use super::epoch::codebook;
use super::lattice::Lattice;
use super::som_options;
use crate::cloud::Bounds;
use crate::error::{Error, Result};
use crate::progress::{Epoch as CoreEpoch, Observer, Progress};
use crate::som::{SelfOrganizingMap, StoppedBy};

/// A map at any stage of its training; the public class is :class:`neurbs.SelfOrganizingMap`.
#[pyclass(frozen, module = "neurbs._core")]
pub(super) struct Map(Mutex<Arc<SelfOrganizingMap>>);

impl Map {
    pub(super) fn of_core(map: SelfOrganizingMap) -> Self {
        Self(Mutex::new(Arc::new(map)))
    }

    /// The current map.
    fn snapshot(&self) -> Arc<SelfOrganizingMap> {
        Arc::clone(&self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, Arc<SelfOrganizingMap>> {
        // A map is only replaced as a whole, so it is valid even if a thread panicked.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs a long job that changes a copy of the map, without the GIL, and stores the copy when
    /// the job ends, interrupted or not. Callbacks see the map as it was before.
    fn update<T: Send>(
        &self,
        py: Python<'_>,
        callbacks: Callbacks,
        job: impl FnOnce(&mut SelfOrganizingMap, &mut Watcher) -> Result<T> + Send,
    ) -> PyResult<T> {
        let mut map = self.snapshot();
        let result =
            call::run_watched(py, callbacks, |watcher| job(Arc::make_mut(&mut map), watcher));
        *self.lock() = map;
        result
    }

    /// Runs a long job that reads the map, without the GIL.
    fn query<T: Send>(
        &self,
        py: Python<'_>,
        job: impl FnOnce(&SelfOrganizingMap, &mut Watcher) -> Result<T> + Send,
    ) -> PyResult<T> {
        let map = self.snapshot();
        call::run(py, None, |watcher| job(&map, watcher))
    }

    /// The array shape of one value per node.
    fn shape(&self) -> Vec<usize> {
        let map = self.snapshot();
        let (rows, cols) = map.lattice.shape();
        if map.lattice.is_grid() { vec![rows, cols] } else { vec![rows] }
    }
}

#[pymethods]
impl Map {
    /// Create an untrained map. With `chunks`, the points are the first of several chunks. With
    /// `whole`, they are those at the start indices of a cloud, of which `whole` has the lowest and
    /// the highest coordinates and the number of points.
    #[new]
    #[pyo3(signature = (points, lattice, options, *, chunks = false, whole = None))]
    fn new(
        points: &Bound<'_, PyAny>,
        lattice: &Lattice,
        options: &Bound<'_, PyDict>,
        chunks: bool,
        whole: Option<([f64; 3], [f64; 3], u64)>,
    ) -> PyResult<Self> {
        let options = som_options::options(options)?;
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let lattice = lattice.0.clone();
        let start = |watcher: &mut Watcher| match whole {
            Some((min, max, count)) => {
                let bounds = Bounds { min: min.into(), max: max.into() };
                SelfOrganizingMap::for_parts(&bounds, slice, count, lattice, &options, watcher)
            }
            None if chunks => SelfOrganizingMap::for_chunks(slice, lattice, &options, watcher),
            None => SelfOrganizingMap::new(slice, lattice, &options, watcher),
        };
        call::run(points.py(), None, start).map(Self::of_core)
    }

    /// Train until a stop criterion is met or some seconds have passed; return whether it has
    /// ended.
    #[pyo3(signature = (points, *, progress = None, observer = None, seconds = None))]
    fn train(
        &self,
        points: &Bound<'_, PyAny>,
        progress: Option<Py<PyAny>>,
        observer: Option<Py<PyAny>>,
        seconds: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        let seconds = arguments::optional_real("checkpoint_seconds", seconds)?;
        if let Some(seconds) = seconds.filter(|seconds| seconds.is_nan() || *seconds < 0.0) {
            return Err(Error::parameter("checkpoint_seconds", "at least 0", seconds).into());
        }
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        self.update(points.py(), Callbacks { progress, observer }, |map, watcher| {
            let end = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
            let end = end.map(|duration| Instant::now() + duration);
            let mut limited = TimeLimit { watcher, end, expired: false };
            match map.train(slice, &mut limited) {
                Err(Error::Interrupted) if limited.expired => Ok(false),
                result => result.map(|()| true),
            }
        })
    }

    /// Present points in online training, each once.
    fn present(&self, points: &Bound<'_, PyAny>) -> PyResult<()> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let job = |map: &mut SelfOrganizingMap, w: &mut Watcher| map.present(slice, w);
        self.update(points.py(), Callbacks::default(), job)
    }

    /// Sum the points of each node, for an epoch of batch training or a part of it.
    fn sums(&self, points: &Bound<'_, PyAny>) -> PyResult<BatchSums> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let sums = self.query(points.py(), |map, watcher| map.sums(slice, watcher))?;
        Ok(BatchSums(sums))
    }

    /// End an epoch of batch training.
    fn learn(&self, py: Python<'_>, sums: &BatchSums) -> PyResult<()> {
        self.update(py, Callbacks::default(), |map, watcher| map.learn(&sums.0, watcher))
    }

    /// End an epoch of a training on a whole cloud; return whether the training has ended.
    #[pyo3(signature = (sums, *, observer = None))]
    fn train_epoch(
        &self,
        py: Python<'_>,
        sums: &BatchSums,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<bool> {
        let callbacks = Callbacks { progress: None, observer };
        self.update(py, callbacks, |map, watcher| map.train_epoch(&sums.0, watcher))
    }

    /// Learn a distribution; `sampler(count)` returns `count` points.
    #[pyo3(signature = (sampler, *, progress = None, observer = None))]
    fn train_on_distribution(
        &self,
        py: Python<'_>,
        sampler: Py<PyAny>,
        progress: Option<Py<PyAny>>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let mut raised = None;
        let mut draw = |count: usize| {
            let points = Python::attach(|py| -> PyResult<Vec<DVec3>> {
                let points = sampler.bind(py).call1((count,))?;
                Ok(Numbers::points(&points, "the sampler's points")?.as_slice()?.to_vec())
            });
            points.map_err(|error| {
                raised = Some(error);
                Error::Interrupted
            })
        };
        let result = self.update(py, Callbacks { progress, observer }, |map, watcher| {
            map.train_on_distribution(&mut draw, watcher)
        });
        raised.map_or(result, Err)
    }

    #[pyo3(signature = (points, out = None))]
    fn predict<'py>(
        &self,
        points: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = points.py();
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let array = arrays::output_of::<i64>(py, out, &[slice.len()])?;
        let mut writable = arrays::writable::<i64, IxDyn>(&array)?;
        let mut left = writable.as_slice_mut()?;
        self.query(py, |map, watcher| {
            map.winners(slice, watcher, |piece| {
                let (now, later) = std::mem::take(&mut left).split_at_mut(piece.len());
                for (out, &node) in now.iter_mut().zip(piece) {
                    *out = i64::try_from(node).unwrap_or(i64::MAX);
                }
                left = later;
            })
        })?;
        Ok(array.into_any())
    }

    fn quantization_error(&self, points: &Bound<'_, PyAny>) -> PyResult<f64> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        self.query(points.py(), |map, watcher| map.quantization_error(slice, watcher))
    }

    fn topographic_error(&self, points: &Bound<'_, PyAny>) -> PyResult<f64> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        self.query(points.py(), |map, watcher| map.topographic_error(slice, watcher))
    }

    fn hits<'py>(&self, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let hits = self.query(points.py(), |map, watcher| map.hits(slice, watcher))?;
        let hits: Vec<i64> = hits.into_iter().map(u64::cast_signed).collect();
        let hits = hits.into_pyarray(points.py());
        hits.call_method1("reshape", (self.shape(),))
    }

    fn u_matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.query(py, |map, watcher| map.u_matrix(watcher))?;
        values.into_pyarray(py).call_method1("reshape", (self.shape(),))
    }

    fn fold_overs(&self, py: Python<'_>) -> PyResult<Option<usize>> {
        self.query(py, |map, watcher| map.fold_overs(watcher))
    }

    #[pyo3(signature = (points, extrapolation, out = None))]
    fn parametrize<'py>(
        &self,
        points: &Bound<'py, PyAny>,
        extrapolation: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = points.py();
        let extrapolation = arguments::real("extrapolation", extrapolation)?;
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let array = arrays::output(py, out, &[slice.len(), 2])?;
        let mut writable = arrays::writable::<f64, IxDyn>(&array)?;
        let mut left: &mut [DVec2] = bytemuck::cast_slice_mut(writable.as_slice_mut()?);
        self.query(py, |map, watcher| {
            map.parameters(slice, extrapolation, watcher, |piece| {
                let (now, later) = std::mem::take(&mut left).split_at_mut(piece.len());
                now.copy_from_slice(piece);
                left = later;
            })
        })?;
        Ok(array.into_any())
    }

    /// The node positions, read-only.
    #[getter]
    fn codebook<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        codebook(py, &self.shape(), &self.snapshot().codebook())
    }

    #[getter]
    fn lattice(&self) -> Lattice {
        Lattice(self.snapshot().lattice.clone())
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.snapshot().steps
    }

    #[getter]
    fn ordered_at(&self) -> u64 {
        self.snapshot().ordered_at
    }

    #[getter]
    fn stopped_by(&self) -> &'static str {
        self.snapshot().stopped_by.name()
    }

    #[getter]
    fn converged(&self) -> bool {
        matches!(self.snapshot().stopped_by, StoppedBy::Reached | StoppedBy::Settled)
    }

    #[getter]
    fn reached(&self) -> usize {
        self.snapshot().reached
    }

    #[getter]
    fn change(&self) -> Option<f64> {
        self.snapshot().change
    }

    #[getter]
    fn error(&self) -> Option<f64> {
        self.snapshot().error
    }

    #[getter]
    fn radius(&self) -> f64 {
        self.snapshot().radius()
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let map = self.snapshot();
        Ok(PyBytes::new(py, &call::without_gil(py, || map.to_bytes())?))
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, state: &[u8]) -> PyResult<Self> {
        Ok(Self::of_core(call::without_gil(py, || SelfOrganizingMap::from_bytes(state))??))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((slf.get_type().getattr("from_bytes")?, (slf.get().to_bytes(slf.py())?,)))
    }
}

/// Indices of the points, of `count` in all, that a map starts from.
#[pyfunction]
pub(super) fn start_indices(py: Python<'_>, count: u64) -> Bound<'_, PyArray1<i64>> {
    let indices = SelfOrganizingMap::start_indices(count).into_iter();
    indices.map(u64::cast_signed).collect::<Vec<i64>>().into_pyarray(py)
}

/// An observer that ends the job after an epoch when the time is over.
struct TimeLimit<'a> {
    watcher: &'a mut Watcher,
    end: Option<Instant>,
    expired: bool,
}

impl Observer for TimeLimit<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.watcher.observe(progress)
    }

    fn observe_epoch(&mut self, epoch: &CoreEpoch<'_>) -> ControlFlow<()> {
        self.watcher.observe_epoch(epoch)?;
        // Stop only after whole epochs, so that no work is lost.
        self.expired = self.end.is_some_and(|end| Instant::now() >= end);
        if self.expired { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
