//! The function `neurbs.trim`, and the faces of a reconstruction.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments::{optional_real, truth};
use super::arrays::Numbers;
use super::errors::bad_argument;
use super::reconstruct::{trim_report, trimming};
use super::shell::Shell;
use super::surface::NurbsSurface;
use super::{call, diagnostics};
use crate::pipeline::Trimmed;
use crate::trim as loops;
use crate::{brep, nurbs};

/// Trim a surface where points on it end: loops around the regions with points and around holes.
///
/// Parameters
/// ----------
/// surface : NurbsSurface
///     The surface.
/// uv : array_like of shape (n, 2)
///     Parameters of points on the surface.
/// holes : bool, default True
///     Whether holes are left open; otherwise only the outer border is trimmed.
/// border : float, optional
///     How far the border lies outside of the outermost points, over the expected distance, from 0
///     (through the points) to 4; by default 1.
///
/// Returns
/// -------
/// Shell
///     One face for each region with points. The whole surface if there are too few points for a
///     region.
///
/// Raises
/// ------
/// NeurbsError
///     If a parameter is outside of the domain or not finite, or `border` is out of its range.
///
/// Warns
/// -----
/// UntrimmedWarning
///     If there are too few points for loops.
/// TrimDoubtfulWarning
///     If the loops are doubtful: the points are clumped, or there are very many holes.
///
/// Notes
/// -----
/// Points' parameters are triangulated in the lengths of the surface. Triangles with circumcircles
/// that a random scatter hardly has are outside. The borders of the rest become smooth curves with
/// corners, moved outward by the depth of the border points. Loops are proved to be simple and
/// disjoint.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> import numpy as np
/// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
/// >>> uv = np.random.default_rng(0).random((3000, 2))
/// >>> disc = uv[np.linalg.norm(uv - 0.5, axis=1) < 0.4]
/// >>> shell = neurbs.trim(plane, disc)
/// >>> abs(shell.area() / (0.16 * np.pi) - 1) < 0.02
/// True
#[pyfunction]
#[pyo3(
    signature = (surface, uv, *, holes=None, border=None),
    text_signature = "(surface, uv, *, holes=True, border=None)"
)]
pub(super) fn trim(
    surface: &Bound<'_, PyAny>,
    uv: &Bound<'_, PyAny>,
    holes: Option<&Bound<'_, PyAny>>,
    border: Option<&Bound<'_, PyAny>>,
) -> PyResult<Shell> {
    let py = uv.py();
    let surface = Arc::new(core_of(surface)?);
    let numbers = Numbers::parameters(uv)?;
    let uv: &[glam::DVec2] = numbers.as_slice()?;
    let holes = holes.map_or(Ok(true), |value| truth("holes", value))?;
    let options = loops::TrimOptions { holes, border: optional_real("border", border)? };
    let found = call::run(py, None, |watcher| loops::trim(&surface, uv, &options, watcher))?;
    diagnostics::warn(py, found.diagnostic().as_slice())?;
    Ok(brep::Shell::new(found.faces, None)?.into())
}

/// Trim a surface as a reconstruction does, whose fit divided coordinates by a scale: the shell, the
/// arguments of its `TrimReport`, findings.
#[pyfunction]
pub(super) fn trimmed<'py>(
    surface: &Bound<'py, PyAny>,
    uv: &Bound<'py, PyAny>,
    trim: &Bound<'py, PyAny>,
    scale: (f64, f64, f64),
) -> PyResult<(Shell, Option<Bound<'py, PyDict>>, Bound<'py, PyTuple>)> {
    let py = uv.py();
    let (surface, trimming) = (core_of(surface)?, trimming(trim)?);
    let numbers = Numbers::parameters(uv)?;
    let uv: &[glam::DVec2] = numbers.as_slice()?;
    let found =
        call::run(py, None, |watcher| Trimmed::of(&surface, scale.into(), uv, trimming, watcher))?;
    let report = found.report.as_ref().map(|report| trim_report(py, report)).transpose()?;
    Ok((found.shell.into(), report, diagnostics::findings(py, &found.diagnostics)?))
}

fn core_of(surface: &Bound<'_, PyAny>) -> PyResult<nurbs::NurbsSurface> {
    match surface.cast::<NurbsSurface>() {
        Ok(surface) => Ok(surface.get().core().clone()),
        Err(_) => Err(bad_argument("surface", "a NurbsSurface", surface)),
    }
}
