//! Writing of plain-text files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use super::call::{self, WatchedFile};
use super::mesh::TriangleMesh;
use super::surface::NurbsSurface;
use crate::error::{Error, Result};
use crate::export;

/// Bytes between two looks at Ctrl-C: a few milliseconds of writing.
const BUFFER: usize = 1 << 20;

type Buffered<'a> = BufWriter<WatchedFile<'a>>;

/// The exception for an error of the operating system, with the file's name; its class follows from
/// the error's number.
fn named_error(py: Python<'_>, error: std::io::Error, path: &Path) -> PyErr {
    let Some(number) = error.raw_os_error() else {
        return error.into();
    };
    let exception = || -> PyResult<Bound<'_, PyAny>> {
        let message = py.import("os")?.call_method1("strerror", (number,))?;
        py.get_type::<PyOSError>().call1((number, message, path))
    };
    exception().map_or_else(|error| error, PyErr::from_value)
}

/// Creates a file and writes it; errors name its path.
fn write_file(
    py: Python<'_>,
    path: &Path,
    write: impl FnOnce(&mut Buffered<'_>) -> Result<()> + Send,
) -> PyResult<()> {
    let named = |error: std::io::Error| named_error(py, error, path);
    let file = File::create(path).map_err(named)?;
    let written = call::run(py, None, |watcher| {
        let mut out = BufWriter::with_capacity(BUFFER, WatchedFile::new(file, watcher));
        match write(&mut out).and_then(|()| Ok(out.flush()?)) {
            Err(Error::Io(error)) => Ok(Err(error)),
            other => other.map(Ok),
        }
    });
    written?.map_err(named)
}

/// Write a surface as a STEP file (AP214, one advanced face).
///
/// Parameters
/// ----------
/// surface : NurbsSurface
/// path : str or path-like
///     An existing file is overwritten. Coordinates are written as millimetres.
#[pyfunction]
pub(super) fn write_step(py: Python<'_>, surface: &NurbsSurface, path: PathBuf) -> PyResult<()> {
    write_file(py, &path, |out| export::write_step(surface.core(), out))
}

/// Write a surface as an IGES file (one entity 128).
///
/// Parameters
/// ----------
/// surface : NurbsSurface
/// path : str or path-like
///     An existing file is overwritten. Coordinates are written as millimetres.
#[pyfunction]
pub(super) fn write_iges(py: Python<'_>, surface: &NurbsSurface, path: PathBuf) -> PyResult<()> {
    write_file(py, &path, |out| export::write_iges(surface.core(), out))
}

/// Write a mesh as a Wavefront OBJ file, with all digits.
///
/// Parameters
/// ----------
/// mesh : TriangleMesh
/// path : str or path-like
///     An existing file is overwritten.
#[pyfunction]
pub(super) fn write_obj(py: Python<'_>, mesh: &TriangleMesh, path: PathBuf) -> PyResult<()> {
    let arrays = mesh.arrays(py)?;
    let view = arrays.view()?;
    write_file(py, &path, |out| export::write_obj(view, out))
}
