//! Conversion of Python arguments: any number-like object is accepted, and errors name the
//! argument.
//!
//! True and False are refused as numbers, because they indicate a mistaken argument.

use glam::DVec3;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::Numbers;
use super::errors::{bad_argument, is_about_input};

/// Expected value of a count, for error messages.
const COUNT: &str = "an integer from 0";

/// A non-negative integer.
pub(super) fn count<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<T> {
    extract_number(name, COUNT, value)
}

/// An optional non-negative integer.
pub(super) fn optional_count<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    value: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<T>> {
    value.map(|value| count(name, value)).transpose()
}

/// True or false.
pub(super) fn truth(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    extract(name, "True or False", value)
}

/// A real number.
pub(super) fn real(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    extract_number(name, "a number", value)
}

/// An optional real number.
pub(super) fn optional_real(name: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<f64>> {
    value.map(|value| real(name, value)).transpose()
}

/// Two non-negative integers, such as the shape of a grid, from any sequence.
pub(super) fn pair(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(usize, usize)> {
    let fail = || bad_argument(name, "two integers from 0", value);
    let [first, second] = two(value).ok_or_else(fail)?;
    let count = |value: Bound<'_, PyAny>| value.extract().map_err(|_| fail());
    Ok((count(first)?, count(second)?))
}

/// The first and last number of a range, or its default.
pub(super) fn range(
    name: &str,
    value: Option<&Bound<'_, PyAny>>,
    default: (f64, f64),
) -> PyResult<(f64, f64)> {
    let Some(value) = value else { return Ok(default) };
    let fail = || bad_argument(name, "two numbers, the first and the last", value);
    let [first, last] = two(value).ok_or_else(fail)?;
    let number = |value: Bound<'_, PyAny>| value.extract().map_err(|_| fail());
    Ok((number(first)?, number(last)?))
}

/// A finite point or direction: three numbers.
pub(super) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec3> {
    let numbers = Numbers::new(value, name, "three real numbers", &[&[Some(3)]])?;
    let numbers: &[f64] = numbers.as_slice()?;
    let vector = DVec3::from_slice(numbers);
    if vector.is_finite() { Ok(vector) } else { Err(bad_argument(name, "finite", value)) }
}

/// The items of a sequence of length two.
pub(super) fn two<'py>(value: &Bound<'py, PyAny>) -> Option<[Bound<'py, PyAny>; 2]> {
    let items: Vec<_> = value.try_iter().ok()?.take(3).collect::<PyResult<_>>().ok()?;
    items.try_into().ok()
}

fn extract_number<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    must: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<T> {
    if value.extract::<bool>().is_ok() {
        return Err(bad_argument(name, must, value));
    }
    extract(name, must, value)
}

fn extract<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    must: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<T> {
    value.extract().map_err(|error: T::Error| {
        let error: PyErr = error.into();
        if is_about_input(value.py(), &error) { bad_argument(name, must, value) } else { error }
    })
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

/// The items of a dict, by name; None counts as missing.
pub(super) struct Items<'py>(Bound<'py, PyDict>);

impl<'py> Items<'py> {
    /// The items of `data`, which must be a dict.
    pub(super) fn of(data: &Bound<'py, PyAny>, must: &str) -> PyResult<Self> {
        let dict = data.cast::<PyDict>().map_err(|_| bad_argument("data", must, data))?;
        Ok(Self(dict.clone()))
    }

    /// An item that may be missing.
    pub(super) fn get(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.0.get_item(name)?.filter(|item| !item.is_none()))
    }

    /// An item that must be there.
    pub(super) fn needed(&self, name: &str, must: &str) -> PyResult<Bound<'py, PyAny>> {
        self.get(name)?.ok_or_else(|| bad_argument("data", must, &self.0))
    }
}

/// Refuses an argument under its old name, with the new one.
///
/// Python reports a missing argument by its new name before this is called.
pub(super) fn refuse_old_name(
    old: &str,
    new: &str,
    value: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    match value {
        None => Ok(()),
        Some(_) => Err(PyTypeError::new_err(format!("argument '{old}': it is now '{new}'"))),
    }
}
