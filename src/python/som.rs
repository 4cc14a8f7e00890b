//! A map and its training, for `neurbs.SelfOrganizingMap`.

use std::ops::ControlFlow;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use glam::DVec3;
use numpy::IntoPyArray;
use numpy::ndarray::{Ix2, Ix3, IxDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::arrays::{self, Numbers};
use super::call::{self, Callbacks, Watcher};
use super::errors::NeurbsError;
use super::lattice::Lattice;
use super::som_options;
use crate::error::{Error, Result};
use crate::progress::{Epoch as CoreEpoch, Observer, Progress};
use crate::som::{self, SelfOrganizingMap, StoppedBy};

/// A map at any stage of its training; the public class is :class:`neurbs.SelfOrganizingMap`.
#[pyclass(frozen, module = "neurbs._core")]
pub(super) struct Map(Mutex<SelfOrganizingMap>);

impl Map {
    pub(super) fn of_core(map: SelfOrganizingMap) -> Self {
        Self(Mutex::new(map))
    }

    fn lock(&self) -> MutexGuard<'_, SelfOrganizingMap> {
        // A map is replaced as a whole, and so never half changed.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a long job work on the map without the GIL, and keeps what it has learned however the
    /// job ends. Callbacks of the job see the map as it was before.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        callbacks: Callbacks,
        job: impl FnOnce(&mut SelfOrganizingMap, &mut Watcher) -> Result<T> + Send,
    ) -> PyResult<T> {
        let mut map = self.lock().clone();
        let result = call::run_watched(py, callbacks, |watcher| job(&mut map, watcher));
        *self.lock() = map;
        result
    }

    /// Lets a long job look at the map without the GIL.
    fn ask<T: Send>(
        &self,
        py: Python<'_>,
        job: impl FnOnce(&SelfOrganizingMap, &mut Watcher) -> Result<T> + Send,
    ) -> PyResult<T> {
        let map = self.lock().clone();
        call::run(py, None, |watcher| job(&map, watcher))
    }

    /// The shape of one value for each node.
    fn shape(&self) -> Vec<usize> {
        let map = self.lock();
        let (rows, cols) = map.lattice.shape();
        if map.lattice.is_grid() { vec![rows, cols] } else { vec![rows] }
    }
}

#[pymethods]
impl Map {
    /// A map at its start; `chunks`: for points that come in chunks, of which these are the first.
    #[new]
    #[pyo3(signature = (points, lattice, options, *, chunks = false))]
    fn new(
        points: &Bound<'_, PyAny>,
        lattice: &Lattice,
        options: &Bound<'_, PyDict>,
        chunks: bool,
    ) -> PyResult<Self> {
        let options = som_options::options(options)?;
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let lattice = lattice.0.clone();
        let start = |_: &mut Watcher| {
            if chunks {
                SelfOrganizingMap::for_chunks(slice, lattice, &options)
            } else {
                SelfOrganizingMap::new(slice, lattice, &options)
            }
        };
        call::run(points.py(), None, start).map(Self::of_core)
    }

    /// Train until a criterion ends it, or for some seconds; says whether it has ended.
    #[pyo3(signature = (points, *, progress = None, observer = None, seconds = None))]
    fn train(
        &self,
        points: &Bound<'_, PyAny>,
        progress: Option<Py<PyAny>>,
        observer: Option<Py<PyAny>>,
        seconds: Option<f64>,
    ) -> PyResult<bool> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        self.work(points.py(), Callbacks { progress, observer }, |map, watcher| {
            let end = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
            let end = end.map(|duration| Instant::now() + duration);
            let mut limited = Limited { watcher, end, over: false };
            match map.train(slice, &mut limited) {
                Err(Error::Interrupted) if limited.over => Ok(false),
                result => result.map(|()| true),
            }
        })
    }

    /// Present points of online training, each once.
    fn present(&self, points: &Bound<'_, PyAny>) -> PyResult<()> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let job = |map: &mut SelfOrganizingMap, w: &mut Watcher| map.present(slice, w);
        self.work(points.py(), Callbacks::default(), job)
    }

    /// What batch training wants to know of points.
    fn sums(&self, points: &Bound<'_, PyAny>) -> PyResult<BatchSums> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let sums = self.ask(points.py(), |map, watcher| map.sums(slice, watcher))?;
        Ok(BatchSums(sums))
    }

    /// End an epoch of batch training.
    fn learn(&self, py: Python<'_>, sums: &BatchSums) -> PyResult<()> {
        self.work(py, Callbacks::default(), |map, watcher| map.learn(&sums.0, watcher))
    }

    /// Learn a distribution: `sampler(count)` returns points.
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
        let result = self.work(py, Callbacks { progress, observer }, |map, watcher| {
            map.train_on_distribution(&mut draw, watcher)
        });
        raised.map_or(result, Err)
    }

    fn predict<'py>(&self, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let winners = self.ask(points.py(), |map, watcher| map.predict(slice, watcher))?;
        Ok(signed(winners)?.into_pyarray(points.py()).into_any())
    }

    fn quantization_error(&self, points: &Bound<'_, PyAny>) -> PyResult<f64> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        self.ask(points.py(), |map, watcher| map.quantization_error(slice, watcher))
    }

    fn topographic_error(&self, points: &Bound<'_, PyAny>) -> PyResult<f64> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        self.ask(points.py(), |map, watcher| map.topographic_error(slice, watcher))
    }

    fn hits<'py>(&self, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let hits = self.ask(points.py(), |map, watcher| map.hits(slice, watcher))?;
        let hits = signed(hits)?.into_pyarray(points.py());
        hits.call_method1("reshape", (self.shape(),))
    }

    fn u_matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = self.lock().u_matrix();
        values.into_pyarray(py).call_method1("reshape", (self.shape(),))
    }

    fn fold_overs(&self) -> Option<usize> {
        self.lock().fold_overs()
    }

    #[pyo3(signature = (points, extrapolation, out = None))]
    fn parametrize<'py>(
        &self,
        points: &Bound<'py, PyAny>,
        extrapolation: f64,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = points.py();
        let numbers = Numbers::points(points, "points")?;
        let slice: &[DVec3] = numbers.as_slice()?;
        let array = arrays::output(py, out, &[slice.len(), 2])?;
        let uv = self.ask(py, |map, watcher| map.parametrize(slice, extrapolation, watcher))?;
        arrays::writable::<f64, IxDyn>(&array)?
            .as_slice_mut()?
            .copy_from_slice(bytemuck::cast_slice(&uv));
        Ok(array.into_any())
    }

    /// The nodes' positions, read-only.
    #[getter]
    fn codebook<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        codebook(py, &self.shape(), &self.lock().codebook())
    }

    #[getter]
    fn lattice(&self) -> Lattice {
        Lattice(self.lock().lattice.clone())
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.lock().steps
    }

    #[getter]
    fn ordered_at(&self) -> u64 {
        self.lock().ordered_at
    }

    #[getter]
    fn stopped_by(&self) -> &'static str {
        self.lock().stopped_by.name()
    }

    #[getter]
    fn converged(&self) -> bool {
        matches!(self.lock().stopped_by, StoppedBy::Reached | StoppedBy::Settled)
    }

    #[getter]
    fn reached(&self) -> usize {
        self.lock().reached
    }

    #[getter]
    fn change(&self) -> Option<f64> {
        self.lock().change
    }

    #[getter]
    fn error(&self) -> Option<f64> {
        self.lock().error
    }

    #[getter]
    fn radius(&self) -> f64 {
        self.lock().radius()
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.lock().to_bytes())
    }

    #[staticmethod]
    fn from_bytes(state: &[u8]) -> PyResult<Self> {
        Ok(Self::of_core(SelfOrganizingMap::from_bytes(state)?))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((slf.get_type().getattr("from_bytes")?, (slf.get().to_bytes(slf.py()),)))
    }
}

/// Sums over points for each node of a map: a part of an epoch of batch training.
///
/// Sums over the same points are the same bits in any order and by any split.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct BatchSums(som::BatchSums);

#[pymethods]
impl BatchSums {
    /// These sums and those over other points, for the same state of the same map.
    fn __add__(&self, other: &Self) -> PyResult<Self> {
        let mut sums = self.0.clone();
        sums.merge(&other.0)?;
        Ok(Self(sums))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __hash__(&self) -> u64 {
        self.0.points()
    }

    /// Number of points.
    #[getter]
    fn points(&self) -> u64 {
        self.0.points()
    }

    /// Mean distance from the points to their nearest nodes.
    #[getter]
    fn mean_distance(&self) -> f64 {
        self.0.mean_distance()
    }

    /// How many points each node is the nearest of.
    #[getter]
    fn hits(&self) -> Vec<u64> {
        self.0.hits()
    }
}

/// What an epoch of training has made of the lattice.
///
/// Attributes
/// ----------
/// step : int
///     Steps made: presentations of online training, epochs of batch training.
/// error : float
///     Mean distance from points to their nearest nodes, in the points' unit.
/// radius : float
///     How far on the lattice the neighbourhood reached, in cells.
/// change : float
///     Largest move of a node, in the points' unit.
/// lattice : ndarray of shape (rows, cols, 3) or (nodes, 3)
///     The nodes' positions, read-only.
#[pyclass(frozen, get_all, module = "neurbs")]
pub(super) struct Epoch {
    step: u64,
    error: f64,
    radius: f64,
    change: f64,
    lattice: Py<PyAny>,
}

impl Epoch {
    /// For Python; positions come as (nodes, 3), since an epoch knows no rows.
    pub(super) fn of_core(py: Python<'_>, epoch: &CoreEpoch<'_>) -> PyResult<Self> {
        let CoreEpoch { step, error, radius, change, lattice } = *epoch;
        let lattice = codebook(py, &[lattice.len()], lattice)?.unbind();
        Ok(Self { step, error, radius, change, lattice })
    }
}

/// An observer that ends the job when its time is over.
struct Limited<'a> {
    watcher: &'a mut Watcher,
    end: Option<Instant>,
    over: bool,
}

impl Observer for Limited<'_> {
    fn observe(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.watcher.observe(progress)
    }

    fn learned(&mut self, epoch: &CoreEpoch<'_>) -> ControlFlow<()> {
        self.watcher.learned(epoch)?;
        // At the end of an epoch nothing that was begun is lost.
        self.over = self.end.is_some_and(|end| Instant::now() >= end);
        if self.over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Positions as a read-only array of this shape, and 3.
fn codebook<'py>(py: Python<'py>, shape: &[usize], nodes: &[DVec3]) -> PyResult<Bound<'py, PyAny>> {
    let numbers = bytemuck::cast_slice(nodes);
    match *shape {
        [rows, cols] => {
            arrays::view(py, &arrays::constant::<f64, Ix3>(py, &[rows, cols, 3], numbers)?)
        }
        _ => arrays::view(py, &arrays::constant::<f64, Ix2>(py, &[nodes.len(), 3], numbers)?),
    }
}

/// Counts as NumPy counts.
fn signed<T>(counts: Vec<T>) -> PyResult<Vec<i64>>
where
    i64: TryFrom<T>,
{
    let signed: std::result::Result<Vec<i64>, _> = counts.into_iter().map(i64::try_from).collect();
    signed.map_err(|_| NeurbsError::new_err("counts must be less than 2^63"))
}
