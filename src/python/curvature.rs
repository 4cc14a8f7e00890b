//! The class `neurbs.Curvatures`, and the methods of `neurbs.NurbsSurface` that return it.

use numpy::PyArrayDyn;
use numpy::ndarray::IxDyn;
use pyo3::prelude::*;

use super::arrays::{self, Numbers};
use super::call;
use super::evaluation::{self, outside};
use super::pickling::{Reduced, reduced};
use super::surface::NurbsSurface;
use crate::error::Result;
use crate::nurbs::{self, CurvatureSlices};

type Array = Py<PyArrayDyn<f64>>;

/// Curvatures of a surface, at scattered parameters or on a grid.
///
/// Arrays have the shape ``(n, ...)`` or ``(n, m, ...)``.
/// Returned by :meth:`NurbsSurface.curvatures` and :meth:`NurbsSurface.curvatures_grid`. A
/// curvature is positive where the surface bends toward its normal.
///
/// Examples
/// --------
/// >>> import neurbs
/// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 2)
/// >>> sphere.curvatures([[0.3, 0.4]]).gaussian.round(12)
/// array([0.25])
#[pyclass(frozen, module = "neurbs")]
pub(super) struct Curvatures {
    /// The points of the surface, float64 of shape (..., 3).
    #[pyo3(get)]
    points: Array,
    /// The unit normals, float64 of shape (..., 3).
    #[pyo3(get)]
    normals: Array,
    /// Gaussian curvature, the product of the principal curvatures, in 1 / unit².
    #[pyo3(get)]
    gaussian: Array,
    /// Mean curvature, half the sum of the principal curvatures, in 1 / unit.
    #[pyo3(get)]
    mean: Array,
    /// The principal curvatures, float64 of shape (..., 2), largest first, in 1 / unit.
    #[pyo3(get)]
    principal: Array,
    /// Unit tangents in the principal directions, float64 of shape (..., 2, 3).
    #[pyo3(get)]
    directions: Array,
}

impl Curvatures {
    /// Fills the caller's arrays, which must fit, or new ones, without the GIL.
    fn filled(
        py: Python<'_>,
        shape: &[usize],
        out: Option<&Bound<'_, Self>>,
        fill: impl FnOnce(CurvatureSlices<'_>, &mut call::Watcher) -> Result<()> + Send,
    ) -> PyResult<Py<Self>> {
        let array = |of: fn(&Self) -> &Array, more: &[usize]| {
            let given = out.map(|out| of(out.get()).bind(py).as_any());
            arrays::output(py, given, &[shape, more].concat())
        };
        let points = array(|of| &of.points, &[3])?;
        let normals = array(|of| &of.normals, &[3])?;
        let gaussian = array(|of| &of.gaussian, &[])?;
        let mean = array(|of| &of.mean, &[])?;
        let principal = array(|of| &of.principal, &[2])?;
        let directions = array(|of| &of.directions, &[2, 3])?;
        {
            let mut points = arrays::writable(&points)?;
            let mut normals = arrays::writable(&normals)?;
            let mut gaussian = arrays::writable::<f64, IxDyn>(&gaussian)?;
            let mut mean = arrays::writable(&mean)?;
            let mut principal = arrays::writable(&principal)?;
            let mut directions = arrays::writable(&directions)?;
            let slices = CurvatureSlices {
                points: bytemuck::cast_slice_mut(points.as_slice_mut()?),
                normals: bytemuck::cast_slice_mut(normals.as_slice_mut()?),
                gaussian: gaussian.as_slice_mut()?,
                mean: mean.as_slice_mut()?,
                principal: bytemuck::cast_slice_mut(principal.as_slice_mut()?),
                directions: bytemuck::cast_slice_mut(directions.as_slice_mut()?),
            };
            call::run(py, None, |watcher| fill(slices, watcher))?;
        }
        if let Some(out) = out {
            return Ok(out.clone().unbind());
        }
        let [points, normals, gaussian, mean, principal, directions] =
            [points, normals, gaussian, mean, principal, directions].map(Bound::unbind);
        Py::new(py, Self { points, normals, gaussian, mean, principal, directions })
    }
}

#[pymethods]
impl Curvatures {
    /// Make the object from its attributes, for pickles and copies.
    #[staticmethod]
    #[pyo3(name = "_of_parts")]
    fn of_parts(
        points: Array,
        normals: Array,
        gaussian: Array,
        mean: Array,
        principal: Array,
        directions: Array,
    ) -> Self {
        Self { points, normals, gaussian, mean, principal, directions }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        reduced(slf, &["points", "normals", "gaussian", "mean", "principal", "directions"])
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Curvatures(shape {})", self.gaussian.bind(py).as_any().getattr("shape")?))
    }
}

#[pymethods]
impl NurbsSurface {
    /// Points, normals and curvatures at scattered parameters.
    ///
    /// At a pole, values are taken at a small distance from it (1e-4 of the domain).
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : Curvatures, optional
    ///     An earlier result for the same number of parameters, to be overwritten.
    ///
    /// Returns
    /// -------
    /// Curvatures
    ///     ``points``, ``normals``, ``gaussian``, ``mean``, ``principal`` and ``directions``. This
    ///     is ``out`` if given.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// See Also
    /// --------
    /// NurbsSurface.curvatures_grid : The same on a grid, in one pass.
    ///
    /// Notes
    /// -----
    /// By the first and second fundamental forms [1]_. A curvature is positive where the surface
    /// bends toward its normal. The curvatures of a sphere are negative, because its normals point
    /// outward.
    ///
    /// References
    /// ----------
    /// .. [1] M. do Carmo, *Differential Geometry of Curves and Surfaces*, section 3.3.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> bends = neurbs.NurbsSurface.torus([0, 0, 0], 3, 1).curvatures([[0.3, 0]])
    /// >>> bends.principal.round(12)
    /// array([[-0.25, -1.  ]])
    #[pyo3(signature = (uv, *, extrapolate=false, out=None))]
    fn curvatures(
        &self,
        uv: &Bound<'_, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'_, Curvatures>>,
    ) -> PyResult<Py<Curvatures>> {
        let numbers = Numbers::parameters(uv)?;
        let (core, outside, uv_slice) = (self.core(), outside(extrapolate), numbers.as_slice()?);
        Curvatures::filled(uv.py(), &numbers.shape()[..1], out, |slices, watcher| {
            core.curvatures(uv_slice, slices, outside, watcher)
        })
    }

    /// Points, normals and curvatures on the grid of all pairs of ``u`` and ``v``, in one pass.
    ///
    /// Parameters
    /// ----------
    /// u, v : array_like of shape (n,) and (m,)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : Curvatures, optional
    ///     An earlier result for a grid of this shape, to be overwritten.
    ///
    /// Returns
    /// -------
    /// Curvatures
    ///     As in :meth:`curvatures`, with arrays of shape (n, m, ...).
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// Each row contracts the net once, so a point costs O(degree) instead of O(degree²).
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 2)
    /// >>> sphere.curvatures_grid([0, 0.5], [0.25, 0.5, 0.75]).mean.round(9)
    /// array([[-0.5, -0.5, -0.5],
    ///        [-0.5, -0.5, -0.5]])
    #[pyo3(signature = (u, v, *, extrapolate=false, out=None))]
    fn curvatures_grid(
        &self,
        u: &Bound<'_, PyAny>,
        v: &Bound<'_, PyAny>,
        extrapolate: bool,
        out: Option<&Bound<'_, Curvatures>>,
    ) -> PyResult<Py<Curvatures>> {
        let py = u.py();
        let (u, v) = (Numbers::sequence(u, "u")?, Numbers::sequence(v, "v")?);
        let shape = [u.shape()[0], v.shape()[0]];
        let (core, outside) = (self.core(), outside(extrapolate));
        let (u, v) = (u.as_slice()?, v.as_slice()?);
        Curvatures::filled(py, &shape, out, |slices, watcher| {
            core.curvature_grid(u, v, slices, outside, watcher)
        })
    }

    /// First and second fundamental forms at scattered parameters.
    ///
    /// Parameters
    /// ----------
    /// uv : array_like of shape (n, 2)
    ///     Parameters inside the domain.
    /// extrapolate : bool, default False
    ///     Whether to extend the outermost patches to parameters outside the domain.
    /// out : (ndarray, ndarray) of shape (n, 2, 2) each, optional
    ///     Where to write the results: float64, C-contiguous.
    ///
    /// Returns
    /// -------
    /// first : ndarray of shape (n, 2, 2)
    ///     [[E, F], [F, G]]: the scalar products of the tangents.
    /// second : ndarray of shape (n, 2, 2)
    ///     [[L, M], [M, N]]: the normal components of the second derivatives.
    ///
    /// Raises
    /// ------
    /// NeurbsError
    ///     If a parameter lies outside the domain, or an array has the wrong shape or dtype.
    ///
    /// Notes
    /// -----
    /// The area element is the square root of the first form's determinant. The Gaussian curvature
    /// is the ratio of the second form's determinant to the first's.
    ///
    /// Examples
    /// --------
    /// >>> import neurbs
    /// >>> plane = neurbs.NurbsSurface.plane([0, 0, 0], [2, 0, 0], [1, 1, 0])
    /// >>> first, second = plane.fundamental_forms([[0.5, 0.5]])
    /// >>> first[0]
    /// array([[4., 2.],
    ///        [2., 2.]])
    #[pyo3(signature = (uv, *, extrapolate=false, out=None))]
    fn fundamental_forms<'py>(
        &self,
        uv: &Bound<'py, PyAny>,
        extrapolate: bool,
        out: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<(evaluation::Array<'py>, evaluation::Array<'py>)> {
        let py = uv.py();
        let uv = Numbers::parameters(uv)?;
        let shape = [uv.shape()[0], 2, 2];
        let (out_first, out_second) = out.unzip();
        let first = arrays::output(py, out_first.as_ref(), &shape)?;
        let second = arrays::output(py, out_second.as_ref(), &shape)?;
        let (core, uv) = (self.core(), uv.as_slice()?);
        {
            let (mut first, mut second) = (arrays::writable(&first)?, arrays::writable(&second)?);
            let to_first: &mut [nurbs::Form] = bytemuck::cast_slice_mut(first.as_slice_mut()?);
            let to_second = bytemuck::cast_slice_mut(second.as_slice_mut()?);
            let outside = outside(extrapolate);
            call::run(py, None, |watcher| {
                core.fundamental_form_arrays(uv, to_first, to_second, outside, watcher)
            })?;
        }
        Ok((first, second))
    }
}
