//! The class `neurbs.TriangleMesh`.

use std::sync::OnceLock;

use numpy::ndarray::{Ix1, Ix2};
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::{self, Numbers};
use super::call;
use super::errors::NeurbsError;
use super::save::save;
use crate::error::Result;
use crate::mesh::{
    self, DistanceSearch, MeshSlices, MeshView, TessellateOptions, Tessellation, UniformGrid,
};
use crate::numeric::Short;
use crate::nurbs::NurbsSurface;

/// A triangle mesh of a surface, with a normal and surface parameters at each vertex.
///
/// Returned by :meth:`NurbsSurface.tessellate` and :func:`neurbs.tessellate`. All arrays are
/// read-only.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
/// >>> mesh = surface.tessellate(shape=(3, 4))
/// >>> mesh
/// TriangleMesh(12 vertices, 12 triangles, grid 3 × 4)
/// >>> mesh.vertices[-1]
/// array([1., 1., 1.])
#[pyclass(frozen, module = "neurbs")]
pub(super) struct TriangleMesh {
    grid: Option<(usize, usize)>,
    max_deviation: Option<f64>,
    vertices: Py<PyArray2<f64>>,
    triangles: Py<PyArray2<u32>>,
    normals: Py<PyArray2<f64>>,
    uv: Py<PyArray2<f64>>,
    face_index: Option<Py<PyArray1<u32>>>,
    /// Built by the first measurement of distances.
    search: OnceLock<DistanceSearch>,
}

/// A mesh's arrays, borrowed for reading.
pub(super) struct Arrays<'py> {
    vertices: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, u32>,
    normals: PyReadonlyArray2<'py, f64>,
    uv: PyReadonlyArray2<'py, f64>,
}

impl Arrays<'_> {
    pub(super) fn view(&self) -> PyResult<MeshView<'_>> {
        Ok(MeshView {
            vertices: bytemuck::cast_slice(self.vertices.as_slice()?),
            triangles: bytemuck::cast_slice(self.triangles.as_slice()?),
            normals: bytemuck::cast_slice(self.normals.as_slice()?),
            uv: bytemuck::cast_slice(self.uv.as_slice()?),
        })
    }
}

impl TriangleMesh {
    /// The mesh of a surface on this grid, in arrays allocated by NumPy.
    pub(super) fn of_surface(
        py: Python<'_>,
        surface: &NurbsSurface,
        grid: UniformGrid,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let counts = (grid.vertices(), grid.triangles());
        let mesh = Self::written(py, counts, progress, |slices, watcher| {
            grid.tessellate_into(surface, slices, watcher)
        })?;
        Ok(Self { grid: Some(grid.shape()), ..mesh })
    }

    /// The mesh of a surface within these limits, in arrays allocated by NumPy.
    pub(super) fn adaptive(
        py: Python<'_>,
        surface: &NurbsSurface,
        options: &TessellateOptions,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let again = progress.as_ref().map(|progress| progress.clone_ref(py));
        let plan = call::run(py, again, |watcher| Tessellation::new(surface, options, watcher))?;
        let counts = (plan.vertices(), plan.triangles());
        let mesh =
            Self::written(py, counts, progress, |slices, watcher| plan.write(slices, watcher))?;
        Ok(Self { max_deviation: Some(plan.max_deviation()), ..mesh })
    }

    /// A mesh with these numbers of vertices and triangles, written by a job of the core.
    fn written(
        py: Python<'_>,
        (vertex_count, triangle_count): (usize, usize),
        progress: Option<Py<PyAny>>,
        job: impl FnOnce(MeshSlices<'_>, &mut call::Watcher) -> Result<()> + Send,
    ) -> PyResult<Self> {
        let vertices = arrays::empty::<f64, Ix2>(py, &[vertex_count, 3])?;
        let triangles = arrays::empty::<u32, Ix2>(py, &[triangle_count, 3])?;
        let normals = arrays::empty::<f64, Ix2>(py, &[vertex_count, 3])?;
        let uv = arrays::empty::<f64, Ix2>(py, &[vertex_count, 2])?;
        let mut held =
            (vertices.readwrite(), triangles.readwrite(), normals.readwrite(), uv.readwrite());
        let slices = MeshSlices {
            vertices: bytemuck::cast_slice_mut(held.0.as_slice_mut()?),
            triangles: bytemuck::cast_slice_mut(held.1.as_slice_mut()?),
            normals: bytemuck::cast_slice_mut(held.2.as_slice_mut()?),
            uv: bytemuck::cast_slice_mut(held.3.as_slice_mut()?),
        };
        call::run(py, progress, |watcher| job(slices, watcher))?;
        // The arrays are read-only from here on.
        held.0.make_nonwriteable();
        held.1.make_nonwriteable();
        held.2.make_nonwriteable();
        held.3.make_nonwriteable();
        Ok(Self {
            grid: None,
            max_deviation: None,
            vertices: vertices.unbind(),
            triangles: triangles.unbind(),
            normals: normals.unbind(),
            uv: uv.unbind(),
            face_index: None,
            search: OnceLock::new(),
        })
    }

    /// A mesh that the core has made, with the face of each triangle if it is of a shell.
    pub(super) fn of_core(
        py: Python<'_>,
        mesh: mesh::TriangleMesh,
        faces: Option<Vec<u32>>,
    ) -> PyResult<Self> {
        let counts = (mesh.vertices.len(), mesh.triangles.len());
        let written = Self::written(py, counts, None, |slices, _| {
            slices.vertices.copy_from_slice(&mesh.vertices);
            slices.triangles.copy_from_slice(&mesh.triangles);
            slices.normals.copy_from_slice(&mesh.normals);
            slices.uv.copy_from_slice(&mesh.uv);
            Ok(())
        })?;
        let constant = |faces: Vec<u32>| arrays::constant::<u32, Ix1>(py, &[faces.len()], &faces);
        let face_index = faces.map(constant).transpose()?;
        Ok(Self { max_deviation: mesh.max_deviation, face_index, ..written })
    }

    pub(super) fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Arrays<'py>> {
        let readonly = |array: &Py<PyArray2<f64>>| array.bind(py).try_readonly();
        let held = |error: numpy::BorrowError| NeurbsError::new_err(error.to_string());
        Ok(Arrays {
            vertices: readonly(&self.vertices).map_err(held)?,
            triangles: self.triangles.bind(py).try_readonly().map_err(held)?,
            normals: readonly(&self.normals).map_err(held)?,
            uv: readonly(&self.uv).map_err(held)?,
        })
    }
}

#[pymethods]
impl TriangleMesh {
    /// Vertex positions, float64 of shape (n, 3), in the points' unit.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.vertices)
    }

    /// Vertex indices, uint32 of shape (m, 3), counter-clockwise seen from the side of the normals.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.triangles)
    }

    /// Unit normals of the surface at the vertices, float64 of shape (n, 3).
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.normals)
    }

    /// Surface parameters of the vertices, float64 of shape (n, 2).
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.uv)
    }

    /// The face of each triangle, uint32 of shape (m,); None unless it is a mesh of a shell.
    #[getter]
    fn face_index<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.face_index.as_ref().map(|faces| arrays::view(py, faces)).transpose()
    }

    /// Upper bound of the distance between surface and triangles, in both directions, in the
    /// points' unit; None for a uniform grid.
    #[getter]
    fn max_deviation(&self) -> Option<f64> {
        self.max_deviation
    }

    /// Numbers of vertices (n_u, n_v) of a uniform grid, which is numbered row by row, v fastest;
    /// None for an adaptive mesh.
    #[getter]
    fn shape(&self) -> Option<(usize, usize)> {
        self.grid
    }

    /// Vertex indices of the cells of a uniform grid, uint32 of shape (m, 4), counter-clockwise
    /// seen from the side of the normals; None for an adaptive mesh.
    #[getter]
    fn quads<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u32>>>> {
        let Some((n_u, n_v)) = self.grid else { return Ok(None) };
        let grid = UniformGrid::new(n_u, n_v)?;
        let quads = arrays::empty::<u32, Ix2>(py, &[grid.triangles() / 2, 4])?;
        {
            let mut out = quads.readwrite();
            let out: &mut [[u32; 4]] = bytemuck::cast_slice_mut(out.as_slice_mut()?);
            call::without_gil(py, || {
                out.iter_mut().zip(grid.quads()).for_each(|(out, quad)| *out = quad);
            })?;
        }
        Ok(Some(quads))
    }

    /// The total area of the triangles, in the square of the points' unit.
    ///
    /// Returns
    /// -------
    /// float
    fn area(&self, py: Python<'_>) -> PyResult<f64> {
        let arrays = self.arrays(py)?;
        let view = arrays.view()?;
        call::without_gil(py, || view.area())
    }

    /// The enclosed volume of a closed mesh, in the cube of the points' unit.
    ///
    /// Returns
    /// -------
    /// float or None
    ///     Negative if the normals point inward; None if the mesh has boundaries.
    fn volume(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        let arrays = self.arrays(py)?;
        let view = arrays.view()?;
        call::without_gil(py, || view.volume())
    }

    /// Vertices - edges + triangles: 1 for a sheet, 0 for a tube or a torus, 2 for a sphere.
    ///
    /// Returns
    /// -------
    /// int
    fn euler_characteristic(&self, py: Python<'_>) -> PyResult<i64> {
        let arrays = self.arrays(py)?;
        let view = arrays.view()?;
        call::without_gil(py, || view.euler_characteristic())
    }

    /// The boundary loops of the mesh.
    ///
    /// Returns
    /// -------
    /// list of ndarray of shape (n,)
    ///     Vertex indices along each boundary, with the mesh to the left seen from the side of the
    ///     normals. Empty for a closed mesh.
    fn boundary_loops<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray1<u32>>>> {
        let arrays = self.arrays(py)?;
        let view = arrays.view()?;
        let loops = call::without_gil(py, || view.boundary_loops())?;
        Ok(loops.iter().map(|border| PyArray1::from_slice(py, border)).collect())
    }

    /// Exact distances from points to the mesh.
    ///
    /// The first call builds a tree over the triangles, which the mesh keeps.
    ///
    /// Parameters
    /// ----------
    /// points : array_like of shape (n, 3) or (n, 2)
    ///     Points in space; z is 0 if there are two columns.
    /// out : ndarray of shape (n,), optional
    ///     Where to write the result: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (n,)
    ///     Distances in the points' unit: ``out``, or a new array.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a point is not finite, or an array has the wrong shape or dtype.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [1, 0, 0], [0, 1, 0])
    /// >>> plane.tessellate().deviation([[0.3, 0.4, 2.0], [1.0, 2.0, 0.0]])
    /// array([2., 1.])
    #[pyo3(signature = (points, *, out=None))]
    fn deviation<'py>(
        &self,
        points: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let py = points.py();
        let points = Numbers::points(points, "points")?;
        let out = arrays::output(py, out, &points.shape()[..1])?;
        {
            let mesh = self.arrays(py)?;
            let (view, points) = (mesh.view()?, points.as_slice()?);
            let mut out = arrays::writable(&out)?;
            let out = out.as_slice_mut()?;
            call::run(py, None, |watcher| {
                let search = self.search.get_or_init(|| DistanceSearch::new(view));
                search.distances(points, out, watcher)
            })?;
        }
        Ok(out)
    }

    /// Write the mesh to a file; see :func:`neurbs.save`.
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

    /// Convert to a trimesh mesh with vertex normals. Nothing is merged or reordered.
    ///
    /// Returns
    /// -------
    /// trimesh.Trimesh
    fn to_trimesh<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let copy = |array: Bound<'py, PyAny>| array.call_method0("copy");
        let keywords = PyDict::new(py);
        keywords.set_item("vertices", copy(self.vertices(py)?)?)?;
        keywords.set_item("faces", copy(self.triangles(py)?)?)?;
        keywords.set_item("vertex_normals", copy(self.normals(py)?)?)?;
        keywords.set_item("process", false)?;
        py.import("trimesh")?.call_method("Trimesh", (), Some(&keywords))
    }

    /// Convert to a PyVista mesh with the point data ``"Normals"`` and ``"uv"``.
    ///
    /// Returns
    /// -------
    /// pyvista.PolyData
    fn to_pyvista<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let copy = |array: Bound<'py, PyAny>| array.call_method0("copy");
        let faces = self.triangles(py)?.call_method1("astype", ("int64",))?;
        let kind = py.import("pyvista")?.getattr("PolyData")?;
        let mesh = kind.call_method1("from_regular_faces", (copy(self.vertices(py)?)?, faces))?;
        let data = mesh.getattr("point_data")?;
        data.set_item("Normals", copy(self.normals(py)?)?)?;
        data.set_item("uv", copy(self.uv(py)?)?)?;
        Ok(mesh)
    }

    /// Make a mesh from its arrays, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_arrays")]
    #[expect(clippy::too_many_arguments, reason = "one for each array and number of a mesh")]
    fn of_arrays(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        normals: &Bound<'_, PyAny>,
        uv: &Bound<'_, PyAny>,
        triangles: PyReadonlyArray2<'_, u32>,
        face_index: Option<PyReadonlyArray1<'_, u32>>,
        max_deviation: Option<f64>,
        grid: Option<(usize, usize)>,
    ) -> PyResult<Self> {
        let vertices = Numbers::points(vertices, "vertices")?;
        let count = vertices.shape()[0];
        let of_vertices = |width| format!("real numbers of shape ({count}, {width})");
        let shape = |width| [Some(count), Some(width)];
        let normals = Numbers::new(normals, "normals", &of_vertices(3), &[&shape(3)])?;
        let uv = Numbers::new(uv, "uv", &of_vertices(2), &[&shape(2)])?;
        let triangles: &[[u32; 3]] = bytemuck::cast_slice(triangles.as_slice()?);
        if triangles.as_flattened().iter().any(|&vertex| vertex as usize >= count) {
            return Err(NeurbsError::new_err("triangles must have indices of vertices"));
        }
        let mesh = mesh::TriangleMesh {
            vertices: vertices.as_slice()?.to_vec(),
            triangles: triangles.to_vec(),
            normals: normals.as_slice()?.to_vec(),
            uv: uv.as_slice()?.to_vec(),
            max_deviation,
        };
        let faces =
            face_index.map(|faces| Ok::<_, PyErr>(faces.as_slice()?.to_vec())).transpose()?;
        Ok(Self { grid, ..Self::of_core(py, mesh, faces)? })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, mesh) = (slf.py(), slf.get());
        let (normals, uv) = (mesh.normals(py)?, mesh.uv(py)?);
        let (triangles, faces) = (mesh.triangles(py)?, mesh.face_index(py)?);
        let (deviation, grid) = (mesh.max_deviation, mesh.grid);
        let arguments = (mesh.vertices(py)?, normals, uv, triangles, faces, deviation, grid);
        (slf.get_type().getattr("_of_arrays")?, arguments).into_bound_py_any(py)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (vertices, triangles) = (self.vertices.bind(py).len()?, self.triangles.bind(py).len()?);
        let deviation = match (self.grid, self.max_deviation) {
            (Some((rows, cols)), _) => format!(", grid {rows} × {cols}"),
            (None, Some(deviation)) => format!(", max deviation {}", Short(deviation)),
            (None, None) => String::new(),
        };
        Ok(format!("TriangleMesh({vertices} vertices, {triangles} triangles{deviation})"))
    }
}
