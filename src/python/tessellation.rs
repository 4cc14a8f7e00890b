//! The method `NurbsSurface.tessellate` and the function `neurbs.tessellate`.

use pyo3::prelude::*;

use super::arguments;
use super::errors::bad_argument;
use super::mesh::TriangleMesh;
use super::surface::NurbsSurface;
use crate::mesh::{TessellateOptions, UniformGrid};
use crate::nurbs;

#[pymethods]
impl NurbsSurface {
    /// Triangulate the surface within a certified tolerance, with few triangles, or on a uniform
    /// grid.
    ///
    /// The mesh is conforming: no vertex lies inside an edge, and every inner edge belongs to two
    /// triangles. Closed directions are welded and a pole is one vertex. Creases (knots repeated as
    /// often as the degree) lie on edges. The result does not depend on the number of threads.
    ///
    /// Parameters
    /// ----------
    /// tolerance : float, optional
    ///     Largest distance between the surface and its triangles, in the points' unit. By default
    ///     1e-3 of the diagonal of the control net's bounding box.
    /// shape : (int, int), optional
    ///     Numbers of vertices along u and v of a uniform grid, at least 2 each, instead of a
    ///     tolerance.
    /// relative : bool, default False
    ///     Whether `tolerance` is a share of the diagonal of the control net's bounding box.
    /// max_angle : float, optional
    ///     Largest angle between the surface's normals at the ends of an edge, in radians.
    /// max_edge : float, optional
    ///     Largest length of an edge, in the points' unit.
    /// max_aspect : float, optional
    ///     Largest aspect ratio of a piece of the surface that becomes two triangles, at least 4.
    ///     Triangles near a pole may be narrower.
    /// split_seams : bool, default False
    ///     Whether to duplicate the vertices at the seams of closed directions.
    /// max_triangles : int, default 100_000_000
    ///     Largest number of triangles.
    /// progress : callable, optional
    ///     Called from time to time with a `Progress`. An exception it raises ends the call.
    ///
    /// Returns
    /// -------
    /// TriangleMesh
    ///     With `max_deviation`, the certified bound of the distance, unless it is a uniform grid.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a limit is out of range or would need more than `max_triangles` triangles (the
    ///     message says how many), or if limits and a shape are both given.
    /// KeyboardInterrupt
    ///     On Ctrl-C.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 1)
    /// >>> mesh = sphere.tessellate(0.01)
    /// >>> mesh.max_deviation <= 0.01, mesh.euler_characteristic()
    /// (True, 2)
    /// >>> sphere.tessellate(shape=(5, 9))
    /// TriangleMesh(45 vertices, 64 triangles, grid 5 × 9)
    #[pyo3(
        signature = (
            tolerance=None, *, shape=None, relative=false, max_angle=None, max_edge=None,
            max_aspect=None, split_seams=false, max_triangles=None, progress=None
        ),
        text_signature = "(self, tolerance=None, *, shape=None, relative=False, max_angle=None, \
                          max_edge=None, max_aspect=None, split_seams=False, \
                          max_triangles=100_000_000, progress=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn tessellate(
        &self,
        py: Python<'_>,
        tolerance: Option<&Bound<'_, PyAny>>,
        shape: Option<&Bound<'_, PyAny>>,
        relative: bool,
        max_angle: Option<&Bound<'_, PyAny>>,
        max_edge: Option<&Bound<'_, PyAny>>,
        max_aspect: Option<&Bound<'_, PyAny>>,
        split_seams: bool,
        max_triangles: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<TriangleMesh> {
        let Some(shape) = shape else {
            let limits = [tolerance, max_angle, max_edge, max_aspect];
            let options = options(limits, (relative, split_seams), max_triangles)?;
            return TriangleMesh::adaptive(py, self.core(), &options, progress);
        };
        let limits = [tolerance, max_angle, max_edge, max_aspect, max_triangles];
        if limits.iter().any(Option::is_some) || relative || split_seams {
            return Err(bad_argument("shape", "None if a limit is given", shape));
        }
        let (n_u, n_v) = arguments::pair("shape", shape)?;
        TriangleMesh::of_surface(py, self.core(), UniformGrid::new(n_u, n_v)?, progress)
    }
}

/// Triangulate several surfaces within one tolerance.
///
/// Parameters
/// ----------
/// surfaces : iterable of NurbsSurface
///     The surfaces.
/// tolerance : float, optional
///     Largest distance between a surface and its triangles, in the points' unit. By default 1e-3
///     of the diagonal of the bounding box of all control nets.
/// relative : bool, default False
///     Whether `tolerance` is a share of this diagonal.
/// max_angle, max_edge, max_aspect, split_seams, max_triangles, progress
///     As in :meth:`NurbsSurface.tessellate`, for each surface.
///
/// Returns
/// -------
/// list of TriangleMesh
///     One for each surface.
///
/// Raises
/// ------
/// NeurbsError
///     As in :meth:`NurbsSurface.tessellate`.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> spheres = [neurbs.NurbsSurface.sphere([0, 0, 0], radius) for radius in (1, 10)]
/// >>> small, large = neurbs.tessellate(spheres, 0.01)
/// >>> len(small.triangles) < len(large.triangles)
/// True
#[pyfunction]
#[pyo3(
    signature = (
        surfaces, tolerance=None, *, relative=false, max_angle=None, max_edge=None,
        max_aspect=None, split_seams=false, max_triangles=None, progress=None
    ),
    text_signature = "(surfaces, tolerance=None, *, relative=False, max_angle=None, \
                      max_edge=None, max_aspect=None, split_seams=False, \
                      max_triangles=100_000_000, progress=None)"
)]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
pub(super) fn tessellate(
    py: Python<'_>,
    surfaces: &Bound<'_, PyAny>,
    tolerance: Option<&Bound<'_, PyAny>>,
    relative: bool,
    max_angle: Option<&Bound<'_, PyAny>>,
    max_edge: Option<&Bound<'_, PyAny>>,
    max_aspect: Option<&Bound<'_, PyAny>>,
    split_seams: bool,
    max_triangles: Option<&Bound<'_, PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<TriangleMesh>> {
    let refused = || bad_argument("surfaces", "an iterable of NurbsSurface", surfaces);
    let surface = |item: PyResult<Bound<'_, PyAny>>| -> PyResult<Py<NurbsSurface>> {
        Ok(item?.cast::<NurbsSurface>().map_err(|_| refused())?.clone().unbind())
    };
    let surfaces: Vec<Py<NurbsSurface>> =
        surfaces.try_iter().map_err(|_| refused())?.map(surface).collect::<PyResult<_>>()?;
    let cores: Vec<&nurbs::NurbsSurface> =
        surfaces.iter().map(|surface| surface.get().core()).collect();
    let limits = [tolerance, max_angle, max_edge, max_aspect];
    let options = options(limits, (relative, split_seams), max_triangles)?.of_surfaces(&cores)?;
    let mesh = |surface: &nurbs::NurbsSurface| {
        let progress = progress.as_ref().map(|progress| progress.clone_ref(py));
        TriangleMesh::adaptive(py, surface, &options, progress)
    };
    cores.into_iter().map(mesh).collect()
}

/// Tessellation options from Python's arguments.
pub(super) fn options(
    [tolerance, max_angle, max_edge, max_aspect]: [Option<&Bound<'_, PyAny>>; 4],
    (relative, split_seams): (bool, bool),
    max_triangles: Option<&Bound<'_, PyAny>>,
) -> PyResult<TessellateOptions> {
    let defaults = TessellateOptions::default();
    let most = arguments::optional_count("max_triangles", max_triangles)?;
    Ok(TessellateOptions {
        tolerance: arguments::optional_real("tolerance", tolerance)?,
        relative,
        max_angle: arguments::optional_real("max_angle", max_angle)?,
        max_edge: arguments::optional_real("max_edge", max_edge)?,
        max_aspect: arguments::optional_real("max_aspect", max_aspect)?,
        split_seams,
        max_triangles: most.unwrap_or(defaults.max_triangles),
    })
}
