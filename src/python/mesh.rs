//! `neurbs.TriangleMesh`.

use numpy::ndarray::Ix2;
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use super::{arrays, call};
use crate::error::Result;
use crate::mesh::{MeshSlices, MeshView, TessellateOptions, Tessellation, UniformGrid};
use crate::nurbs::NurbsSurface;

/// Triangles of a surface, with a normal and the surface's parameters at each vertex.
///
/// Made by :meth:`NurbsSurface.tessellate`; all arrays are read-only.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> surface = neurbs.NurbsSurface([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]], degree=1)
/// >>> mesh = surface.tessellate(shape=(3, 4))
/// >>> mesh
/// TriangleMesh(12 vertices, 12 triangles)
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
}

/// A mesh's arrays, held for reading.
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
    /// The mesh of a surface on this grid, in arrays that NumPy allocates.
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

    /// The mesh of a surface within these limits, in arrays that NumPy allocates.
    pub(super) fn adaptive(
        py: Python<'_>,
        surface: &NurbsSurface,
        options: &TessellateOptions,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let again = progress.as_ref().map(|progress| progress.clone_ref(py));
        let plan =
            call::run(py, again, |watcher| Tessellation::new(surface, options, watcher))?;
        let counts = (plan.vertices(), plan.triangles());
        let mesh =
            Self::written(py, counts, progress, |slices, watcher| plan.write(slices, watcher))?;
        Ok(Self { max_deviation: Some(plan.max_deviation()), ..mesh })
    }

    /// A mesh of so many vertices and triangles, which a job of the core writes.
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
        {
            let mut vertices = vertices.readwrite();
            let mut triangles = triangles.readwrite();
            let mut normals = normals.readwrite();
            let mut uv = uv.readwrite();
            let slices = MeshSlices {
                vertices: bytemuck::cast_slice_mut(vertices.as_slice_mut()?),
                triangles: bytemuck::cast_slice_mut(triangles.as_slice_mut()?),
                normals: bytemuck::cast_slice_mut(normals.as_slice_mut()?),
                uv: bytemuck::cast_slice_mut(uv.as_slice_mut()?),
            };
            call::run(py, progress, |watcher| job(slices, watcher))?;
        }
        Ok(Self {
            grid: None,
            max_deviation: None,
            vertices: arrays::freeze(&vertices)?,
            triangles: arrays::freeze(&triangles)?,
            normals: arrays::freeze(&normals)?,
            uv: arrays::freeze(&uv)?,
        })
    }

    pub(super) fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Arrays<'py>> {
        let readonly = |array: &Py<PyArray2<f64>>| array.bind(py).try_readonly();
        let held =
            |error: numpy::BorrowError| super::errors::NeurbsError::new_err(error.to_string());
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

    /// Vertex numbers, uint32 of shape (m, 3), counter-clockwise seen from the normals' side.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.triangles)
    }

    /// Unit normals of the surface at the vertices, float64 of shape (n, 3).
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.normals)
    }

    /// Parameters of the vertices on the surface, float64 of shape (n, 2).
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::view(py, &self.uv)
    }

    /// An upper bound of the distance between the surface and the triangles, in both directions.
    #[getter]
    fn max_deviation(&self) -> Option<f64> {
        self.max_deviation
    }

    /// Vertices along u and v, (n_u, n_v); they are numbered row by row, v fastest.
    #[getter]
    fn shape(&self) -> Option<(usize, usize)> {
        self.grid
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (vertices, triangles) = (self.vertices.bind(py).len()?, self.triangles.bind(py).len()?);
        Ok(format!("TriangleMesh({vertices} vertices, {triangles} triangles)"))
    }
}
