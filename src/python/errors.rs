//! Conversion of the crate's errors to Python exceptions.

use std::any::Any;

use pyo3::create_exception;
use pyo3::exceptions::{
    PyKeyboardInterrupt, PyMemoryError, PyOverflowError, PyTypeError, PyValueError,
};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{IntoPyDict, PyType};

use crate::error::Error;

/// Largest number of characters of an argument shown in an error message.
const MAX_SHOWN_CHARS: usize = 60;

create_exception!(
    neurbs,
    NeurbsError,
    PyValueError,
    "Invalid input. The message gives the requirement, the value received, and what to do."
);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        match error {
            Error::Io(error) => error.into(),
            // A job is interrupted by Ctrl-C, unless a callback raised an exception.
            Error::Interrupted => PyKeyboardInterrupt::new_err(()),
            error @ Error::Memory { .. } => Python::attach(|py| memory_error(py, &error)),
            Error::Parameter { name, .. } => argument_error(name, error.to_string()),
            error => NeurbsError::new_err(error.to_string()),
        }
    }
}

/// Whether an exception is about the input: TypeError, ValueError or OverflowError, and not Ctrl-C,
/// lack of memory or a bug.
pub(super) fn is_about_input(py: Python<'_>, error: &PyErr) -> bool {
    error.is_instance_of::<PyTypeError>(py)
        || error.is_instance_of::<PyValueError>(py)
        || error.is_instance_of::<PyOverflowError>(py)
}

/// The class of errors about memory, both a `NeurbsError` and a `MemoryError`.
pub(super) fn memory_error_class(py: Python<'_>) -> PyResult<&Bound<'_, PyType>> {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let class = CLASS.get_or_try_init(py, || {
        let bases = (py.get_type::<NeurbsError>(), py.get_type::<PyMemoryError>());
        let body = [
            ("__module__", "neurbs"),
            ("__doc__", "A call needs more memory than is available: the message says how much."),
        ];
        let class =
            py.get_type::<PyType>().call1(("NeurbsMemoryError", bases, body.into_py_dict(py)?))?;
        PyResult::Ok(class.cast_into::<PyType>()?.unbind())
    })?;
    Ok(class.bind(py))
}

/// A `NeurbsMemoryError` with this message.
pub(super) fn memory_error(py: Python<'_>, message: &impl ToString) -> PyErr {
    memory_error_class(py)
        .map_or_else(|error| error, |class| PyErr::from_type(class.clone(), message.to_string()))
}

/// The error for a panic: a defect of this library.
pub(super) fn defect(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    NeurbsError::new_err(format!(
        "neurbs itself has failed: {text}. Report this, with the call and its data"
    ))
}

/// A `NeurbsError` about the value of an argument, which has its name as attribute `argument`.
pub(super) fn argument_error(name: &str, message: String) -> PyErr {
    Python::attach(|py| {
        let error = NeurbsError::new_err(message);
        error.value(py).setattr("argument", name).map_or_else(|failed| failed, |()| error)
    })
}

/// The error `{name} must be {must}, got {repr}`.
pub(super) fn bad_argument(name: &str, must: &str, got: &Bound<'_, PyAny>) -> PyErr {
    let got = got.repr().map_or_else(|_| "?".to_string(), |text| text.to_string());
    let end = got.char_indices().nth(MAX_SHOWN_CHARS).map(|(end, _)| end);
    let got = end.map_or(got.clone(), |end| format!("{}…", &got[..end]));
    argument_error(name, format!("{name} must be {must}, got {got}"))
}
