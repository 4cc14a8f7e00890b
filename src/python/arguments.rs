//! Numbers from Python: whatever behaves like one, with an error that names the argument.

use pyo3::prelude::*;

use super::errors::bad_argument;

/// A number that counts something, from 0.
pub(super) fn count<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<T> {
    value.extract().map_err(|_| bad_argument(name, "an integer from 0", value))
}

/// Two counts, as in the shape of a grid.
pub(super) fn pair(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(usize, usize)> {
    value.extract().map_err(|_| bad_argument(name, "two integers from 0", value))
}

/// A count that may be left out.
pub(super) fn optional_count<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    value: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<T>> {
    value.map(|value| count(name, value)).transpose()
}

/// A real number that may be left out.
pub(super) fn optional_real(name: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<f64>> {
    let number = |value: &Bound<'_, PyAny>| {
        value.extract().map_err(|_| bad_argument(name, "a number", value))
    };
    value.map(number).transpose()
}

/// One of several named choices.
pub(super) fn choice<T: Copy>(
    name: &str,
    all: &[T],
    name_of: fn(T) -> &'static str,
    value: &Bound<'_, PyAny>,
) -> PyResult<T> {
    let wanted = value.extract::<String>().unwrap_or_default();
    let found = all.iter().copied().find(|&one| name_of(one) == wanted);
    found.ok_or_else(|| {
        let names: Vec<String> = all.iter().map(|&one| format!("'{}'", name_of(one))).collect();
        bad_argument(name, &names.join(" or "), value)
    })
}
