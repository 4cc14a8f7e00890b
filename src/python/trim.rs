//! The function `neurbs.trim`.

use std::sync::Arc;

use pyo3::prelude::*;

use super::arguments::{optional_real, truth};
use super::arrays::Numbers;
use super::errors::bad_argument;
use super::shell::Shell;
use super::surface::NurbsSurface;
use super::{call, diagnostics};
use crate::brep;
use crate::trim as loops;

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
    let Ok(surface) = surface.cast::<NurbsSurface>() else {
        return Err(bad_argument("surface", "a NurbsSurface", surface));
    };
    let surface = Arc::new(surface.get().core().clone());
    let numbers = Numbers::parameters(uv)?;
    let uv: &[glam::DVec2] = numbers.as_slice()?;
    let holes = holes.map_or(Ok(true), |value| truth("holes", value))?;
    let options = loops::TrimOptions { holes, border: optional_real("border", border)? };
    let found = call::run(py, None, |watcher| loops::trim(&surface, uv, &options, watcher))?;
    diagnostics::warn(py, found.diagnostic().as_slice())?;
    Ok(brep::Shell::new(found.faces, None)?.into())
}
