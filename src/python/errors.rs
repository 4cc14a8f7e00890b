//! The one place where the crate's errors become Python's.

use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;

use crate::error::Error;

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
            error => NeurbsError::new_err(error.to_string()),
        }
    }
}

/// `{name} must be {must}, got {repr}` for an argument that is not even of the right kind.
pub(super) fn bad_argument(name: &str, must: &str, got: &Bound<'_, PyAny>) -> PyErr {
    let got = got.repr().map_or_else(|_| "?".to_string(), |text| text.to_string());
    NeurbsError::new_err(format!("{name} must be {must}, got {got}"))
}
