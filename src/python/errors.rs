//! Conversion of the crate's errors to Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{
    PyKeyboardInterrupt, PyMemoryError, PyOverflowError, PyTypeError, PyValueError,
};
use pyo3::prelude::*;

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
            error @ Error::Memory { .. } => PyMemoryError::new_err(error.to_string()),
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
