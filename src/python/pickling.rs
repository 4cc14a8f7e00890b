//! Pickles and copies of results: a class gives its attributes and is made from them again.

use numpy::ndarray::Dimension;
use numpy::{Element, PyArray};
use pyo3::PyClass;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// The value of `__reduce__`: a function and its arguments.
pub(super) type Reduced<'py> = (Bound<'py, PyAny>, Bound<'py, PyTuple>);

/// Reduces an object to these attributes, the arguments of the static method `_of_parts` of its
/// class.
pub(super) fn reduced<'py, T: PyClass>(
    object: &Bound<'py, T>,
    attributes: &[&str],
) -> PyResult<Reduced<'py>> {
    let object = object.as_any();
    let parts =
        attributes.iter().map(|name| object.getattr(*name)).collect::<PyResult<Vec<_>>>()?;
    let maker = object.get_type().getattr(intern!(object.py(), "_of_parts"))?;
    Ok((maker, PyTuple::new(object.py(), parts)?))
}

/// Reduces an object to its bytes, the argument of the static method `from_bytes` of its class.
pub(super) fn reduced_to_bytes<'py, T: PyClass>(object: &Bound<'py, T>) -> PyResult<Reduced<'py>> {
    let (py, object) = (object.py(), object.as_any());
    let bytes = object.call_method0(intern!(py, "to_bytes"))?;
    Ok((object.get_type().getattr(intern!(py, "from_bytes"))?, PyTuple::new(py, [bytes])?))
}

/// Makes an array read-only: unpickled arrays are writeable.
pub(super) fn read_only<T: Element, D: Dimension>(
    py: Python<'_>,
    array: Py<PyArray<T, D>>,
) -> PyResult<Py<PyArray<T, D>>> {
    array.bind(py).call_method1(intern!(py, "setflags"), (false,))?;
    Ok(array)
}
