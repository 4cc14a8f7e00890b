//! The one place where the crate's errors become Python's.

use pyo3::create_exception;
use pyo3::exceptions::{
    PyKeyboardInterrupt, PyMemoryError, PyOverflowError, PyTypeError, PyValueError,
};
use pyo3::prelude::*;

use crate::error::Error;

/// Characters of an argument that an error message repeats.
const LONGEST_SHOWN: usize = 60;

create_exception!(
    neurbs,
    NeurbsError,
    PyValueError,
    "Bad input: the message says what must hold, what came, and what to do."
);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        match error {
            Error::Io(error) => error.into(),
            // Only Ctrl-C stops a job without an exception of its own.
            Error::Interrupted => PyKeyboardInterrupt::new_err(()),
            error @ Error::Memory { .. } => PyMemoryError::new_err(error.to_string()),
            Error::Parameter { name, .. } => argument_error(name, error.to_string()),
            error => NeurbsError::new_err(error.to_string()),
        }
    }
}

/// Whether Python raised this because it was given something unfit, and not because of Ctrl-C, a
/// lack of memory or a fault in somebody's code.
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

/// `{name} must be {must}, got {repr}` for an argument that is not even of the right kind.
pub(super) fn bad_argument(name: &str, must: &str, got: &Bound<'_, PyAny>) -> PyErr {
    let got = got.repr().map_or_else(|_| "?".to_string(), |text| text.to_string());
    let end = got.char_indices().nth(LONGEST_SHOWN).map(|(end, _)| end);
    let got = end.map_or(got.clone(), |end| format!("{}…", &got[..end]));
    argument_error(name, format!("{name} must be {must}, got {got}"))
}
