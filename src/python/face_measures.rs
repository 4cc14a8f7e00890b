//! `neurbs.Face` and `neurbs.Shell`: measures, queries and triangles.

use numpy::PyArray1;
use numpy::ndarray::Ix1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::optional_real;
use super::arrays::{self, Numbers};
use super::call;
use super::evaluation::Array;
use super::face::Face;
use super::face_points::FacePoints;
use super::measure::DEFAULT_ACCURACY;
use super::mesh::TriangleMesh;
use super::save::save;
use super::shell::Shell;
use super::tessellation::options;

/// Two corners of a box as arrays.
fn corners(
    py: Python<'_>,
    (low, high): (glam::DVec3, glam::DVec3),
) -> PyResult<(Array<'_>, Array<'_>)> {
    let corner = |point: glam::DVec3| arrays::filled(py, None, &point.to_array());
    Ok((corner(low)?, corner(high)?))
}

#[pymethods]
impl Face {
    /// Whether places in (u, v) are in the face; the border counts.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2)
    ///     Parameters of the surface.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n,)
    ///     bool.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter is not finite.
    ///
    /// Notes
    /// -----
    /// The winding number of the loops. It is exact: pieces of curves whose box has the place are
    /// halved.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
    /// >>> circle = neurbs.NurbsCurve.arc([0.5, 0.5, 0], [0.25, 0, 0], [0, 0.25, 0])
    /// >>> neurbs.Face(plane, [[circle]]).contains([[0.5, 0.5], [0.75, 0.5], [0.9, 0.5]])
    /// array([ True,  True, False])
    fn contains<'py>(&self, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let py = uv.py();
        let numbers = Numbers::parameters(uv)?;
        let uv: &[glam::DVec2] = numbers.as_slice()?;
        let found = call::run(py, None, |watcher| self.core().contains(uv, watcher))?;
        let array = arrays::empty::<bool, Ix1>(py, &[found.len()])?;
        arrays::writable(&array)?.as_slice_mut()?.copy_from_slice(&found);
        Ok(array)
    }

    /// The area, in the square of the points' unit.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Largest relative error, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the accuracy is not from 1e-14 to 1.
    ///
    /// Notes
    /// -----
    /// Gauss-Legendre quadrature; for trimmed faces along the loops, by Green's theorem.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
    /// >>> circle = neurbs.NurbsCurve.arc([0.5, 0.5, 0], [0.25, 0, 0], [0, 0.25, 0])
    /// >>> round(neurbs.Face(plane, [[circle]]).area(), 9)
    /// 3.141592654
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn area(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(DEFAULT_ACCURACY);
        call::run(py, None, |watcher| self.core().area(accuracy, watcher))
    }

    /// The axis-aligned bounding box.
    ///
    /// Returns
    /// -------
    /// low, high : ndarray of shape (3,)
    ///     Smallest and largest coordinates, in the points' unit.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
    /// >>> circle = neurbs.NurbsCurve.arc([0.5, 0.5, 0], [0.25, 0, 0], [0, 0.25, 0])
    /// >>> low, high = neurbs.Face(plane, [[circle]]).bounding_box()
    /// >>> (high - low).round(6)
    /// array([2., 2., 0.])
    fn bounding_box<'py>(&self, py: Python<'py>) -> PyResult<(Array<'py>, Array<'py>)> {
        corners(py, call::run(py, None, |watcher| self.core().bounding_box(watcher))?)
    }

    /// Project points onto the face: the closest points within its loops.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Points in space; z is 0 if there are two columns.
    ///
    /// Returns
    /// -------
    /// FacePoints
    ///     ``uv``, ``points`` and ``distances``; ``face_index`` is 0.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
    /// >>> circle = neurbs.NurbsCurve.arc([0.5, 0.5, 0], [0.25, 0, 0], [0, 0.25, 0])
    /// >>> neurbs.Face(plane, [[circle]]).closest_points([[2, 4, 0]]).distances.round(6)
    /// array([1.])
    fn closest_points(&self, points: &Bound<'_, PyAny>) -> PyResult<FacePoints> {
        let py = points.py();
        let numbers = Numbers::points(points, "points")?;
        let points: &[glam::DVec3] = numbers.as_slice()?;
        let found = call::run(py, None, |watcher| self.core().closest_points(points, watcher))?;
        FacePoints::new(py, &found)
    }

    /// Triangulate the face within a certified tolerance.
    ///
    /// Parameters
    /// ----------
    /// tolerance, relative, max_angle, max_edge, max_aspect, max_triangles, progress
    ///     As in :meth:`NurbsSurface.tessellate`.
    ///
    /// Returns
    /// -------
    /// TriangleMesh
    ///     With the face's normals.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     As in :meth:`NurbsSurface.tessellate`.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [4, 0, 0], [0, 4, 0])
    /// >>> circle = neurbs.NurbsCurve.arc([0.5, 0.5, 0], [0.25, 0, 0], [0, 0.25, 0])
    /// >>> mesh = neurbs.Face(plane, [[circle]]).tessellate(0.01)
    /// >>> mesh.max_deviation <= 0.01, mesh.euler_characteristic()
    /// (True, 1)
    #[pyo3(
        signature = (
            tolerance=None, *, relative=false, max_angle=None, max_edge=None, max_aspect=None,
            max_triangles=None, progress=None
        ),
        text_signature = "(self, tolerance=None, *, relative=False, max_angle=None, \
                          max_edge=None, max_aspect=None, max_triangles=100_000_000, \
                          progress=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn tessellate(
        &self,
        py: Python<'_>,
        tolerance: Option<&Bound<'_, PyAny>>,
        relative: bool,
        max_angle: Option<&Bound<'_, PyAny>>,
        max_edge: Option<&Bound<'_, PyAny>>,
        max_aspect: Option<&Bound<'_, PyAny>>,
        max_triangles: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<TriangleMesh> {
        let limits = [tolerance, max_angle, max_edge, max_aspect];
        let options = options(limits, (relative, false), max_triangles)?;
        let mesh = call::run(py, progress, |watcher| self.core().tessellate(&options, watcher))?;
        TriangleMesh::of_core(py, mesh, None)
    }

    /// Write the face to a file: `neurbs.save(face, path, ...)`.
    ///
    /// Parameters
    /// ----------
    /// path : str or path-like
    ///     The suffix selects the format.
    /// **options
    ///     As for :func:`neurbs.save`.
    #[pyo3(signature = (path, **options))]
    fn save(
        slf: &Bound<'_, Self>,
        path: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        save(slf, path, options)
    }
}

#[pymethods]
impl Shell {
    /// The area of all faces, in the square of the points' unit.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Largest relative error, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the accuracy is not from 1e-14 to 1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 1)).area(), 6)
    /// 12.566371
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn area(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(DEFAULT_ACCURACY);
        call::run(py, None, |watcher| self.core().area(accuracy, watcher))
    }

    /// The enclosed volume, in the cube of the points' unit: an integral over the faces, not over
    /// a mesh. It is negative if the normals point inward.
    ///
    /// Parameters
    /// ----------
    /// accuracy : float, default 1e-9
    ///     Largest error relative to the volume, from 1e-14 to 1.
    ///
    /// Returns
    /// -------
    /// float
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If the shell is not closed, or the accuracy is not from 1e-14 to 1.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> round(neurbs.Shell(neurbs.NurbsSurface.sphere([0, 0, 0], 1)).volume(), 6)
    /// 4.18879
    #[pyo3(signature = (*, accuracy=None), text_signature = "($self, *, accuracy=1e-09)")]
    fn volume(&self, py: Python<'_>, accuracy: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let accuracy = optional_real("accuracy", accuracy)?.unwrap_or(DEFAULT_ACCURACY);
        call::run(py, None, |watcher| self.core().volume(accuracy, watcher))
    }

    /// The axis-aligned bounding box.
    ///
    /// Returns
    /// -------
    /// low, high : ndarray of shape (3,)
    ///     Smallest and largest coordinates, in the points' unit.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> neurbs.Shell(neurbs.NurbsSurface.torus([0, 0, 0], 3, 1)).bounding_box()[1].round(9)
    /// array([4., 4., 1.])
    fn bounding_box<'py>(&self, py: Python<'py>) -> PyResult<(Array<'py>, Array<'py>)> {
        corners(py, call::run(py, None, |watcher| self.core().bounding_box(watcher))?)
    }

    /// Project points onto the faces: the globally closest points.
    ///
    /// The first call prepares the faces; the shell keeps that.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Points in space; z is 0 if there are two columns.
    ///
    /// Returns
    /// -------
    /// FacePoints
    ///     ``face_index``, ``uv``, ``points`` and ``distances``.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> balls = [neurbs.NurbsSurface.sphere([x, 0, 0], 1) for x in (0, 5)]
    /// >>> closest = neurbs.Shell(balls).closest_points([[0, 3, 0], [7, 0, 0]])
    /// >>> closest.face_index, closest.distances.round(9)
    /// (array([0, 1], dtype=uint32), array([2., 1.]))
    fn closest_points(&self, points: &Bound<'_, PyAny>) -> PyResult<FacePoints> {
        let py = points.py();
        let numbers = Numbers::points(points, "points")?;
        let points: &[glam::DVec3] = numbers.as_slice()?;
        let found =
            call::run(py, None, |watcher| self.search(watcher)?.closest_points(points, watcher))?;
        FacePoints::new(py, &found)
    }

    /// Triangulate the faces within a certified tolerance.
    ///
    /// Each edge is divided once, and both faces take its points. So the mesh has no cracks, and
    /// that of a closed shell is watertight.
    ///
    /// Parameters
    /// ----------
    /// tolerance, relative, max_angle, max_edge, max_aspect, max_triangles, progress
    ///     As in :meth:`NurbsSurface.tessellate`; `relative` to the diagonal of the box around all
    ///     control points.
    ///
    /// Returns
    /// -------
    /// TriangleMesh
    ///     With `face_index`, the face of each triangle, and the faces' normals. A vertex on an
    ///     edge has the normal and the parameters of the first face there.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     As in :meth:`NurbsSurface.tessellate`.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> halves = neurbs.NurbsSurface.sphere([0, 0, 0], 1).split(v=0.5)
    /// >>> mesh = neurbs.Shell(halves).tessellate(0.01)
    /// >>> mesh.max_deviation <= 0.01, mesh.euler_characteristic()
    /// (True, 2)
    #[pyo3(
        signature = (
            tolerance=None, *, relative=false, max_angle=None, max_edge=None, max_aspect=None,
            max_triangles=None, progress=None
        ),
        text_signature = "(self, tolerance=None, *, relative=False, max_angle=None, \
                          max_edge=None, max_aspect=None, max_triangles=100_000_000, \
                          progress=None)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn tessellate(
        &self,
        py: Python<'_>,
        tolerance: Option<&Bound<'_, PyAny>>,
        relative: bool,
        max_angle: Option<&Bound<'_, PyAny>>,
        max_edge: Option<&Bound<'_, PyAny>>,
        max_aspect: Option<&Bound<'_, PyAny>>,
        max_triangles: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<TriangleMesh> {
        let limits = [tolerance, max_angle, max_edge, max_aspect];
        let options = options(limits, (relative, false), max_triangles)?;
        let found = call::run(py, progress, |watcher| self.core().tessellate(&options, watcher))?;
        TriangleMesh::of_core(py, found.mesh, Some(found.faces))
    }

    /// Write the shell to a file: `neurbs.save(shell, path, ...)`.
    ///
    /// Parameters
    /// ----------
    /// path : str or path-like
    ///     The suffix selects the format.
    /// **options
    ///     As for :func:`neurbs.save`.
    #[pyo3(signature = (path, **options))]
    fn save(
        slf: &Bound<'_, Self>,
        path: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        save(slf, path, options)
    }
}
