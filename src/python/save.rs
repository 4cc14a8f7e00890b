//! The methods `save` of classes.

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Calls `neurbs.save` with keyword arguments.
pub(super) fn save(
    thing: &Bound<'_, PyAny>,
    path: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<()> {
    let neurbs = thing.py().import("neurbs")?;
    neurbs.call_method("save", (thing, path), options).map(|_| ())
}
