//! The class `neurbs.Epoch`, and node positions as an array.

use glam::DVec3;
use numpy::ndarray::{Ix2, Ix3};
use pyo3::prelude::*;

use super::arrays;
use super::pickling::{Reduced, reduced};
use crate::numeric::Short;
use crate::progress::Epoch as CoreEpoch;

/// The state of a map after an epoch of training.
///
/// Attributes
/// ----------
/// step : int
///     Steps done: presentations of online training, epochs of batch training.
/// error : float
///     Mean distance from points to their nearest nodes, in the points' unit.
/// radius : float
///     Radius of the neighborhood, in cells.
/// change : float
///     Largest move of a node, in the points' unit.
/// lattice : ndarray of shape (rows, cols, 3) or (nodes, 3)
///     The node positions, read-only.
#[pyclass(frozen, get_all, module = "neurbs")]
pub(super) struct Epoch {
    step: u64,
    error: f64,
    radius: f64,
    change: f64,
    lattice: Py<PyAny>,
}

impl Epoch {
    /// Converts an epoch of the core. Positions have shape (nodes, 3), because it has no grid
    /// shape.
    pub(super) fn of_core(py: Python<'_>, epoch: &CoreEpoch<'_>) -> PyResult<Self> {
        let CoreEpoch { step, error, radius, change, lattice } = *epoch;
        let lattice = codebook(py, &[lattice.len()], lattice)?.unbind();
        Ok(Self { step, error, radius, change, lattice })
    }
}

#[pymethods]
impl Epoch {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        step: u64,
        error: f64,
        radius: f64,
        change: f64,
        lattice: Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        // Unpickled arrays are writeable.
        lattice.call_method1("setflags", (false,))?;
        Ok(Self { step, error, radius, change, lattice: lattice.unbind() })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["step", "error", "radius", "change", "lattice"])
    }

    fn __repr__(&self) -> String {
        let Self { step, error, radius, change, .. } = self;
        let [error, radius, change] = [error, radius, change].map(|value| Short(*value));
        format!("Epoch(step {step}, error {error}, radius {radius}, change {change})")
    }
}

/// Node positions as a read-only array of this shape and three columns.
pub(super) fn codebook<'py>(
    py: Python<'py>,
    shape: &[usize],
    nodes: &[DVec3],
) -> PyResult<Bound<'py, PyAny>> {
    let numbers = bytemuck::cast_slice(nodes);
    match *shape {
        [rows, cols] => {
            arrays::view(py, &arrays::constant::<f64, Ix3>(py, &[rows, cols, 3], numbers)?)
        }
        _ => arrays::view(py, &arrays::constant::<f64, Ix2>(py, &[nodes.len(), 3], numbers)?),
    }
}
