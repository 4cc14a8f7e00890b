//! NumPy arrays as slices of the core's types, and back.
//!
//! A C-contiguous float64 array of shape (n, 3) is used as `&[DVec3]` without a copy. Other
//! array-likes (lists, float32, integers, other memory orders) are converted once by NumPy. Results
//! are written into arrays that NumPy allocated.

use bytemuck::Pod;
use numpy::ndarray::{Dimension, IxDyn};
use numpy::{
    Element, PyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyReadwriteArray, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyMemoryError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::errors::{argument_error, is_about_input, memory_error};

/// Real numbers from Python, as float64 in C order.
pub(super) struct Numbers<'py>(PyReadonlyArrayDyn<'py, f64>);

impl<'py> Numbers<'py> {
    /// Takes an array of real numbers with one of these shapes (`None`: any extent). Converts it if
    /// necessary.
    ///
    /// `name` and `expected` appear in the error message.
    pub(super) fn new(
        value: &Bound<'py, PyAny>,
        name: &str,
        expected: &str,
        shapes: &[&[Option<usize>]],
    ) -> PyResult<Self> {
        Self::converted(value, (name, expected), Some(shapes))
    }

    /// Converts an array of real numbers; without `shapes` it may have any shape.
    fn converted(
        value: &Bound<'py, PyAny>,
        (name, expected): (&str, &str),
        shapes: Option<&[&[Option<usize>]]>,
    ) -> PyResult<Self> {
        let fail =
            |got: String| argument_error(name, format!("{name} must be {expected}, got {got}"));
        let numpy = value.py().import("numpy")?;
        // Masked values must not be used as numbers. `numpy.ma` is only looked up if it is loaded
        // already, because importing it takes as long as a small fit. While another thread imports
        // it, it has no such function yet, and there are no masked arrays.
        let loaded = value.py().import("sys")?.getattr("modules")?;
        let module = loaded.call_method1("get", ("numpy.ma",))?;
        let masked = match module.getattr_opt("is_masked")? {
            Some(is_masked) => is_masked.call1((value,))?.is_truthy()?,
            None => false,
        };
        if masked {
            return Err(fail("a masked array: fill or remove the masked values".into()));
        }
        if value.hasattr("nnz")? {
            return Err(fail("a sparse array: pass its toarray()".into()));
        }
        let array = numpy.call_method1("asarray", (value,)).map_err(|error| {
            if is_about_input(value.py(), &error) {
                fail(error.value(value.py()).to_string())
            } else {
                error
            }
        })?;
        let array: Bound<'py, PyUntypedArray> = array.cast_into()?;
        if !matches!(array.dtype().kind(), b'f' | b'i' | b'u') {
            return Err(fail(format!("dtype {}", array.dtype())));
        }
        let fits = |shape: &&[Option<usize>]| {
            let extents = shape.iter().zip(array.shape());
            shape.len() == array.ndim()
                && extents.into_iter().all(|(want, is)| want.is_none_or(|n| n == *is))
        };
        if shapes.is_some_and(|shapes| !shapes.iter().any(fits)) {
            return Err(fail(format!("shape {}", array.as_any().getattr("shape")?)));
        }
        let requirements = ("float64", ["C_CONTIGUOUS", "ALIGNED"]);
        let array: Bound<'py, PyArrayDyn<f64>> =
            numpy.call_method1("require", (array, requirements.0, requirements.1))?.cast_into()?;
        Ok(Self(array.try_readonly().map_err(|error| fail(error.to_string()))?))
    }

    /// Points of shape (n, 3), or (n, 2) with z = 0.
    pub(super) fn points(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        let expected = "real numbers of shape (n, 3), or (n, 2) in the plane z = 0";
        let numbers = Self::new(value, name, expected, &[&[None, Some(3)], &[None, Some(2)]])?;
        if numbers.shape()[1] == 3 {
            return Ok(numbers);
        }
        let numpy = value.py().import("numpy")?;
        let zeros = numpy.call_method1("zeros", ((numbers.shape()[0], 1),))?;
        let columns = numpy.call_method1("hstack", ((numbers.0.as_any(), zeros),))?;
        Self::points(&columns, name)
    }

    /// Surface parameters of shape (n, 2).
    pub(super) fn parameters(value: &Bound<'py, PyAny>) -> PyResult<Self> {
        Self::new(value, "uv", "real numbers of shape (n, 2)", &[&[None, Some(2)]])
    }

    /// Real numbers of any shape.
    pub(super) fn of_any_shape(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        Self::converted(value, (name, "real numbers"), None)
    }

    /// Two arrays of real numbers of any shape, broadcast to a common one.
    pub(super) fn broadcast(
        values: [&Bound<'py, PyAny>; 2],
        names: [&str; 2],
    ) -> PyResult<[Self; 2]> {
        let take = |k: usize, value: &Bound<'py, PyAny>| Self::of_any_shape(value, names[k]);
        let (first, second) = (take(0, values[0])?, take(1, values[1])?);
        if first.shape() == second.shape() {
            return Ok([first, second]);
        }
        let (a, b) = (first.0.as_any(), second.0.as_any());
        let arrays = values[0].py().import("numpy")?.call_method1("broadcast_arrays", (a, b));
        let Ok(arrays) = arrays else {
            let ([x, y], a, b) = (names, a.getattr("shape")?, b.getattr("shape")?);
            let message = format!("{x} and {y} must have shapes that broadcast, got {a} and {b}");
            return Err(argument_error(y, message));
        };
        Ok([take(0, &arrays.get_item(0)?)?, take(1, &arrays.get_item(1)?)?])
    }

    /// Surface parameters of shape (n, 2), or (2,) for one place.
    pub(super) fn places(value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let expected = "real numbers of shape (n, 2), or (2,) for one place";
        Self::new(value, "uv", expected, &[&[None, Some(2)], &[Some(2)]])
    }

    /// Numbers of shape (n,), or one number.
    pub(super) fn one_or_more(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        Self::new(value, name, "real numbers of shape (n,), or one number", &[&[None], &[]])
    }

    /// Numbers of shape (n,).
    pub(super) fn sequence(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        Self::new(value, name, "real numbers of shape (n,)", &[&[None]])
    }

    /// The shape of the array.
    pub(super) fn shape(&self) -> &[usize] {
        self.0.shape()
    }

    /// The numbers as elements of the core's types: `f64`, `DVec2` or `DVec3`.
    pub(super) fn as_slice<T: Pod>(&self) -> PyResult<&[T]> {
        Ok(bytemuck::cast_slice(self.0.as_slice()?))
    }
}

/// Convert points to the array format of the core.
///
/// Parameters
/// ----------
/// points : array_like of shape (n, 3) or (n, 2)
///     Real numbers; z is 0 if there are two columns.
///
/// Returns
/// -------
/// ndarray of shape (n, 3)
///     C-contiguous float64: `points` itself if possible, otherwise a converted copy.
///
/// Raises
/// ------
/// NeurbsError
///     If `points` are not real numbers of one of these shapes.
#[pyfunction]
pub(super) fn as_points<'py>(points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    Ok(Numbers::points(points, "points")?.0.as_any().cast::<PyArrayDyn<f64>>()?.clone())
}

/// Largest array, in bytes, for which zeroing is faster than a call of `numpy.empty`.
const MAX_ZEROED_BYTES: usize = 1 << 13;

/// A new array allocated by NumPy, with arbitrary values.
pub(super) fn empty<'py, T: Element, D: Dimension>(
    py: Python<'py>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    if let Some(dimensions) = D::from_dimension(&IxDyn(shape))
        && shape
            .iter()
            .try_fold(size_of::<T>(), |size, n| size.checked_mul(*n))
            .is_some_and(|size| size <= MAX_ZEROED_BYTES)
    {
        return Ok(PyArray::zeros(py, dimensions, false));
    }
    let shape = pyo3::types::PyTuple::new(py, shape)?;
    let array = EMPTY.import(py, "numpy", "empty")?.call1((shape, T::get_dtype(py)));
    let array = array.map_err(|error| {
        if error.is_instance_of::<PyMemoryError>(py) {
            memory_error(py, error.value(py))
        } else {
            error
        }
    });
    Ok(array?.cast_into()?)
}

/// Bytes moved at a time.
const CHUNK_BYTES: usize = 1 << 23;

/// The items as a new array of this shape, allocated by NumPy. They are moved in chunks, from the
/// end, to avoid having all of them in memory twice.
pub(super) fn moved<'py, I: Pod, T: Pod + Element, D: Dimension>(
    py: Python<'py>,
    shape: &[usize],
    mut items: Vec<I>,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    let array = empty::<T, D>(py, shape)?;
    {
        let mut array = writable(&array)?;
        let mut rest = array.as_slice_mut()?;
        while !items.is_empty() {
            let kept = items.len().saturating_sub(CHUNK_BYTES / size_of::<I>());
            let chunk: &[T] = bytemuck::cast_slice(&items[kept..]);
            let (before, end) = rest.split_at_mut(rest.len() - chunk.len());
            end.copy_from_slice(chunk);
            rest = before;
            items.truncate(kept);
            items.shrink_to_fit();
        }
    }
    Ok(array)
}

/// As [`output_of`], for float64.
pub(super) fn output<'py>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    output_of(py, out, shape)
}

/// These numbers, in the caller's `out` or in a new array.
pub(super) fn filled<'py>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    values: &[f64],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = output(py, out, &[values.len()])?;
    writable(&array)?.as_slice_mut()?.copy_from_slice(values);
    Ok(array)
}

/// The array for a result: the caller's `out`, which must have this shape and dtype, or a new
/// array.
pub(super) fn output_of<'py, T: Element>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let Some(out) = out else {
        return empty(py, shape);
    };
    let fail = |got: String| {
        let dtype = T::get_dtype(py);
        let must = format!("a writeable, C-contiguous {dtype} array of shape {shape:?}");
        argument_error("out", format!("out must be {must}, got {got}"))
    };
    let Ok(array) = out.cast::<PyArrayDyn<T>>() else {
        let got = out.getattr("dtype").map_or_else(
            |_| out.get_type().to_string(),
            |dtype| format!("an array of dtype {dtype}"),
        );
        return Err(fail(got));
    };
    if !out.getattr("flags")?.getattr("aligned")?.is_truthy()? {
        return Err(fail("an array that is not aligned".into()));
    }
    if array.shape() != shape || !array.is_c_contiguous() {
        return Err(fail(format!("shape {:?} with strides {:?}", array.shape(), array.strides())));
    }
    Ok(array.clone())
}

/// Mutable access to an output array. Refused if an input of the same call shares its memory.
pub(super) fn writable<'py, T: Element, D: Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    array.try_readwrite().map_err(|error| {
        let message = format!("out must be writeable and share no memory with inputs: {error}");
        argument_error("out", message)
    })
}

/// A read-only array of these values, for a property.
pub(super) fn constant<T: Element + Copy, D: Dimension>(
    py: Python<'_>,
    shape: &[usize],
    values: &[T],
) -> PyResult<Py<PyArray<T, D>>> {
    let array = empty::<T, D>(py, shape)?;
    writable(&array)?.as_slice_mut()?.copy_from_slice(values);
    freeze(&array)
}

/// Makes an array permanently read-only.
fn freeze<T: Element, D: Dimension>(
    array: &Bound<'_, PyArray<T, D>>,
) -> PyResult<Py<PyArray<T, D>>> {
    writable(array)?.make_nonwriteable();
    Ok(array.clone().unbind())
}

/// A view of a stored array. It is read-only and cannot be made writeable.
pub(super) fn view<'py, T: Element, D: Dimension>(
    py: Python<'py>,
    array: &Py<PyArray<T, D>>,
) -> PyResult<Bound<'py, PyAny>> {
    array.bind(py).call_method0(intern!(py, "view"))
}
