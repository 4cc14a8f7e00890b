//! The class `neurbs.BatchSums`.

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::pickling::{Reduced, reduced_to_bytes};
use crate::numeric::Short;
use crate::som;

/// Sums over the points of each node of a map: a batch epoch or a part of it.
///
/// Sums over the same points have the same bits in any order and for any split.
#[pyclass(frozen, module = "neurbs")]
pub(super) struct BatchSums(pub(super) som::BatchSums);

#[pymethods]
impl BatchSums {
    /// The merged sums, for the same state of the same map.
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

    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.0.to_bytes())
    }

    #[staticmethod]
    fn from_bytes(state: &[u8]) -> PyResult<Self> {
        Ok(Self(som::BatchSums::from_bytes(state)?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced_to_bytes(slf)
    }

    fn __repr__(&self) -> String {
        let (points, mean) = (self.0.points(), Short(self.0.mean_distance()));
        format!("BatchSums({points} points, mean distance {mean})")
    }

    /// Number of points.
    #[getter]
    fn points(&self) -> u64 {
        self.0.points()
    }

    /// Mean distance from the points to their nearest nodes, in the points' unit.
    #[getter]
    fn mean_distance(&self) -> f64 {
        self.0.mean_distance()
    }

    /// Number of points nearest to each node.
    #[getter]
    fn hits(&self) -> Vec<u64> {
        self.0.hits()
    }
}
