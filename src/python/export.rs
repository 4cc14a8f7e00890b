//! Functions that write STEP, IGES and OBJ files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::choice;
use super::call::{self, WatchedFile};
use super::mesh::TriangleMesh;
use super::shell::Shell;
use crate::brep::{self, LengthUnit};
use crate::error::{Error, Result};
use crate::export::{self, StepOptions};

/// Bytes written between two checks for Ctrl-C, a few milliseconds.
const BUFFER_BYTES: usize = 1 << 20;

type Buffered<'a> = BufWriter<WatchedFile<'a>>;

/// The `OSError` for an error of the operating system, with the file's name. Its class follows from
/// the error number.
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

/// Creates and writes a file. Errors name its path.
fn write_file(
    py: Python<'_>,
    path: &Path,
    write: impl FnOnce(&mut Buffered<'_>) -> Result<()> + Send,
) -> PyResult<()> {
    let named = |error: std::io::Error| named_error(py, error, path);
    let file = File::create(path).map_err(named)?;
    let written = call::run(py, None, |watcher| {
        let mut out = BufWriter::with_capacity(BUFFER_BYTES, WatchedFile::new(file, watcher));
        match write(&mut out).and_then(|()| Ok(out.flush()?)) {
            Err(Error::Io(error)) => Ok(Err(error)),
            other => other.map(Ok),
        }
    });
    written?.map_err(named)
}

/// The symbols of the length units, each with its length in millimeters.
pub(super) fn length_units(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let units = PyDict::new(py);
    for unit in LengthUnit::ALL {
        units.set_item(unit.symbol(), unit.in_millimeters())?;
    }
    Ok(units)
}

fn length_unit(value: Option<&Bound<'_, PyAny>>) -> PyResult<LengthUnit> {
    let named = |value| choice("unit", &LengthUnit::ALL, LengthUnit::symbol, value);
    value.map_or(Ok(LengthUnit::default()), named)
}

/// The shells of a sequence.
fn shells_of(shells: Vec<Py<Shell>>) -> Vec<brep::Shell> {
    shells.iter().map(|shell| shell.get().core().clone()).collect()
}

/// Write shells as a STEP file (AP214): solids where they are closed, else surfaces.
///
/// Parameters
/// ----------
/// shells : list of Shell
/// path : str or path-like
///     An existing file is overwritten.
/// unit : {"mm", "cm", "m", "in", "ft"}, default "mm"
///     Unit of the coordinates, which are not converted.
/// pcurves : bool, default True
///     Whether the edges of trimmed faces have curves in (u, v), too.
#[pyfunction]
#[pyo3(signature = (shells, path, unit = None, *, pcurves = true))]
pub(super) fn write_step(
    py: Python<'_>,
    shells: Vec<Py<Shell>>,
    path: PathBuf,
    unit: Option<&Bound<'_, PyAny>>,
    pcurves: bool,
) -> PyResult<()> {
    let options = StepOptions { unit: length_unit(unit)?, pcurves };
    let shells = shells_of(shells);
    write_file(py, &path, |out| export::write_step(&shells, &options, out))
}

/// Write shells as an IGES file: solids (entity 186) where they are closed, else surfaces.
///
/// Parameters
/// ----------
/// shells : list of Shell
/// path : str or path-like
///     An existing file is overwritten.
/// unit : {"mm", "cm", "m", "in", "ft"}, default "mm"
///     Unit of the coordinates, which are not converted.
#[pyfunction]
#[pyo3(signature = (shells, path, unit = None))]
pub(super) fn write_iges(
    py: Python<'_>,
    shells: Vec<Py<Shell>>,
    path: PathBuf,
    unit: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    let (unit, shells) = (length_unit(unit)?, shells_of(shells));
    write_file(py, &path, |out| export::write_iges(&shells, unit, out))
}

/// Write shells as a free-form Wavefront OBJ file (`cstype bspline`), with loops and all digits.
///
/// Parameters
/// ----------
/// shells : list of Shell
/// path : str or path-like
///     An existing file is overwritten.
#[pyfunction]
pub(super) fn write_obj_shells(
    py: Python<'_>,
    shells: Vec<Py<Shell>>,
    path: PathBuf,
) -> PyResult<()> {
    let shells = shells_of(shells);
    write_file(py, &path, |out| export::write_obj_shells(&shells, out))
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
